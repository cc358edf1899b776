"""Pictures, pages, views and exports for people."""
