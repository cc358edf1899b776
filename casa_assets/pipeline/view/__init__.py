"""Look at one asset or kitchen: what a name stands for, its model and facts, and the server of its page."""
