"""Checks of joints as MuJoCo simulates them: range, clearance, force of a hand, drop and rest."""
