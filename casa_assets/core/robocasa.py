"""Lengths by which RoboCasa v1.0 decides what a fixture is for, in metres; checks and the export use the same."""

from __future__ import annotations

# Heights between which it looks for shelves of a wall cabinet. Ref: robocasa v1.0, fixture_is_type.
SHELF_HEIGHTS_M = (1.0, 1.5)
# Smaller surfaces of a worktop are none to it: width and depth. Ref: robocasa v1.0, Counter.get_reset_regions.
MIN_SURFACE_M = (0.40, 0.25)
# Depth before a deep appliance that is enough for the plate that it puts there.
PLATE_DEPTH_M = 0.25
