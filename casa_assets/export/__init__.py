"""Writers: each takes an Asset and returns Files, without making any choices."""
