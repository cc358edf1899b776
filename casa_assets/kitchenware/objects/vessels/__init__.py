"""Open vessels: dishes, pots, trays; their lids, and boards."""
