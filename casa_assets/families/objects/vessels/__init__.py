"""What holds something and is open: dishes, pots, trays; their lids, and boards."""
