"""Pictures, pages and views for people."""
