"""What is alike in a library: signatures of assets, pairs of one form or one look, twins, and search by words."""
