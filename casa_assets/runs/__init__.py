"""Worker processes: a fork server, a pool, limits on memory and CPU time, retries."""
