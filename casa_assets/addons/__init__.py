"""Uses of the package by others: RoboCasa, batches, robots."""
