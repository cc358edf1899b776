"""Export to RoboCasa."""
