"""Files that hold many inputs: archives, shards of WebDataset, tables."""
