"""Noise closes over the border and hangs on the seed, not on the number of pixels."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from casa_assets.core.numeric import rng_for
from casa_assets.textures.canvas import Map, blur, fbm, gradient, ridged, worley

SIZE, CELLS = (96, 128), (6, 4)
MAKERS: dict[str, Callable[[tuple[int, int]], Map]] = {
    "gradient": lambda size: gradient(size, CELLS, rng_for(1, "n")),
    "fbm": lambda size: fbm(size, CELLS, rng_for(1, "n"), 3),
    "ridged": lambda size: ridged(size, CELLS, rng_for(1, "n"), 2),
    "worley": lambda size: worley(size, CELLS, rng_for(1, "n"))[0],
}


def test_noise_closes_repeats_by_its_seed_and_shows_the_same_design_in_any_size(subtests: pytest.Subtests) -> None:
    for name, maker in MAKERS.items():
        with subtests.test(name=name):
            coarse, fine = maker(SIZE), maker((SIZE[0] * 2, SIZE[1] * 2))
            for axis in (0, 1):
                # The border is a place like any other.
                steps = np.abs(coarse - np.roll(coarse, 1, axis)).max(axis=1 - axis)
                assert 0.0 < steps[0] <= steps[1:].max()
            halved = fine.reshape(SIZE[0], 2, SIZE[1], 2).mean(axis=(1, 3))
            assert np.corrcoef(coarse.ravel(), halved.ravel())[0, 1] > 0.99
            assert coarse.tobytes() == maker(SIZE).tobytes()


def test_blur_keeps_the_mean_and_goes_round_the_border() -> None:
    image = np.zeros((32, 32), dtype=np.float32)
    image[0, 0] = 1.0
    soft = blur(image, 2.0)
    assert soft.sum() == pytest.approx(1.0, abs=1e-4)
    assert soft[-1, -1] == pytest.approx(soft[1, 1], rel=1e-4)
