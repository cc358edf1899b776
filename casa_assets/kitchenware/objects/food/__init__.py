"""Food that was made: bread and pastry, cuts of meat, dishes of several layers."""
