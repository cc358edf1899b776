"""Checks of whole kitchens: rules of kitchen design, ways of a robot, and the tasks that a scene has to afford."""
