"""Writers: each takes an Asset and returns Files, deciding nothing."""
