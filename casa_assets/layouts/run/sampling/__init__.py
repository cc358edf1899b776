"""Kitchens drawn at random: what is drawn, the run that makes them, what it cost, and how diverse they are."""
