"""What a kitchen would fail its checks by, told before it is built, with mends that were tried."""
