"""Sources on stores: what an address names, its listing, and reads of objects with bounds and retries."""
