"""The entries of libraries as rows of one table in Parquet parts, and conditions on entries."""
