"""View one asset or kitchen: find it by name, make its model and facts, and serve its page."""
