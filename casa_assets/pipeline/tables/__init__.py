"""The entries of libraries as rows of one table: in SQLite for one library, in Parquet parts for any number of them."""
