"""Jobs in processes of their own: a fork server, a pool, limits, retries."""
