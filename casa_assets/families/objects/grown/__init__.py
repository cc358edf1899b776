"""What grew: fruit, vegetables, nuts, eggs."""
