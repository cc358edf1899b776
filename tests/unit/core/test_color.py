"""sRGB and linear light: there and back, the two pieces meet, and precision stays."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core import numeric


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
