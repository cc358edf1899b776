"""Checks of what a robot's arms can do: which handles it reaches from its parking places, and what it opens."""
