"""What a robot can do in a kitchen: the joints that it reaches and opens, certified in robots.json."""
