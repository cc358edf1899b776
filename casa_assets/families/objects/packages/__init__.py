"""What food is packed in, and blocks, wrapped and bare."""
