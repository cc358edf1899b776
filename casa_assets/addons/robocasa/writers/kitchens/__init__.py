"""Scenes -> fixtures, arenas and descriptions of kitchens that RoboCasa's classes operate."""
