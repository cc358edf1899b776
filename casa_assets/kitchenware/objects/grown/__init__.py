"""Food that grew: fruit, vegetables, nuts, eggs."""
