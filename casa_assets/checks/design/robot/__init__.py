"""Checks of what a robot can do: where its base gets to, where it parks, which tasks a kitchen affords."""
