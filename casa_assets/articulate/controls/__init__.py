"""Knobs, buttons, levers, taps and burners among the fragments."""
