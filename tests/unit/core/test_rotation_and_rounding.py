"""Rotation matrices agree with scipy's, and rounding leaves no negative zero."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from casa_assets.core.numeric import about_axis, decimals, significant


def test_rotation_agrees_with_scipy(subtests: pytest.Subtests) -> None:
    for angle in [-7.0, -0.3, 0.0, 1e-9, math.pi / 2, math.pi, 5.0]:
        with subtests.test(angle=angle):
            for axis in (np.array([1.0, 0.0, 0.0]), np.array([2.0, -3.0, 6.0]) / 7):
                assert np.abs(about_axis(axis, angle) - Rotation.from_rotvec(axis * angle).as_matrix()).max() < 1e-15


def test_digits() -> None:
    assert significant(0.000123456, 3) == 0.000123
    assert decimals(1.23456, 2) == 1.23
    assert math.copysign(1.0, decimals(-1e-9, 4)) == 1.0
