"""Colours there and back, rotations that agree with scipy's, rounding without a negative zero."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from casa_assets.core import numeric
from casa_assets.core.numeric import about_axis, decimals, significant


def test_there_and_back() -> None:
    shown = np.arange(256) / 255
    linear = numeric.linear_from_srgb_array(shown)
    np.testing.assert_allclose(numeric.srgb_from_linear_array(linear), shown, atol=1e-7)
    assert linear[0] == 0.0
    assert linear[-1] == 1.0
    assert linear[128] == pytest.approx(0.21586, abs=1e-5)  # half of the way on a screen is a fifth of the light
    assert [numeric.linear_from_srgb(float(v)) for v in shown] == pytest.approx(linear.tolist(), abs=1e-15)
    assert [numeric.srgb_from_linear(float(v)) for v in linear] == pytest.approx(shown.tolist(), abs=1e-7)


def test_precision_stays_and_nothing_is_warned_of() -> None:
    with np.errstate(all="raise"):
        assert numeric.srgb_from_linear_array(np.array([-0.1, 0.0, 1.0], dtype=np.float32)).dtype == np.float32
    assert numeric.linear_from_srgb_array(np.zeros((2, 3), dtype=np.float32)).dtype == np.float32


def test_rotation_agrees_with_scipy(subtests: pytest.Subtests) -> None:
    for angle in [-7.0, -0.3, 0.0, 1e-9, math.pi / 2, math.pi, 5.0]:
        with subtests.test(angle=angle):
            for axis in (np.array([1.0, 0.0, 0.0]), np.array([2.0, -3.0, 6.0]) / 7):
                assert np.abs(about_axis(axis, angle) - Rotation.from_rotvec(axis * angle).as_matrix()).max() < 1e-15


def test_digits() -> None:
    assert significant(0.000123456, 3) == 0.000123
    assert decimals(1.23456, 2) == 1.23
    assert math.copysign(1.0, decimals(-1e-9, 4)) == 1.0
