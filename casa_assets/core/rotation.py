"""Rotation matrices by axis and angle.

Rodrigues' formula is used and not scipy's Rotation, because the last bits differ and asset files must stay identical.
"""

from __future__ import annotations

import math

import numpy as np

from casa_assets.core.typing import Floats


def about_axis(axis: Floats, angle: float) -> Floats:
    """(3, 3) right-handed rotation about a (3,) unit axis, angle in rad. Ref: Rodrigues' rotation formula."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    found: Floats = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return found
