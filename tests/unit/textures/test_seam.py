"""Borders are found where they are, and repaired."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core.numeric import rng_for
from casa_assets.textures import canvas
from casa_assets.textures.check import Picture, jump, repair, seam


def clouds(seed: int = 1, size: int = 192) -> Picture:
    """A picture that repeats: coloured noise."""
    rng = rng_for(seed, "clouds")
    planes = [0.5 + 0.35 * canvas.fbm((size, size), (6, 6), rng, 4) for _ in range(3)]
    return np.clip(np.stack(planes, axis=-1), 0.0, 1.0).astype(np.float32)


def bricks(size: int = 240) -> Picture:
    """Running bond of 8 by 6 with a joint on the border, which is as it should be."""
    rng = rng_for(3, "bricks")
    y, x = np.mgrid[0:size, 0:size] / size
    row = np.floor(y * 8).astype(int)
    along = x * 6 + 0.5 * (row % 2)
    tone = rng.uniform(0.4, 0.7, (8, 6))[row, np.floor(along).astype(int) % 6]
    joint = (np.abs(np.mod(y * 8 + 0.5, 1) - 0.5) < 0.06) | (np.abs(np.mod(along + 0.5, 1) - 0.5) < 0.045)
    return np.repeat(np.where(joint, 0.9, tone)[..., None], 3, axis=2).astype(np.float32)


def test_what_repeats_has_no_seam() -> None:
    assert seam(clouds()).worst < 1.2
    assert seam(bricks()).worst < 1.2
    assert jump(clouds()).worst < 1.5


@pytest.mark.parametrize("axis", [0, 1])
def test_a_cut_is_found_in_its_direction(axis: int) -> None:
    cut = np.take(clouds(), range(130), axis=axis)
    found = seam(cut)
    across, along = (found.y, found.x) if axis == 0 else (found.x, found.y)
    assert across > 2.5
    assert along < 1.2
    assert seam(cut[..., 0]).worst == pytest.approx(seam(cut[..., :1]).worst)  # grey pictures have seams too


@pytest.mark.parametrize("lit", [False, True])
def test_repair_leaves_a_picture_that_repeats(lit: bool) -> None:
    cut = clouds()[:150, :140]
    if lit:
        cut = cut * np.linspace(0.8, 1.15, 140, dtype=np.float32)[None, :, None]
    repaired = repair(cut)
    assert seam(cut).worst > 2.5
    assert seam(repaired).worst < 1.2
    assert repaired.dtype == np.float32
    assert 0.0 <= repaired.min() <= repaired.max() <= 1.0
    assert repaired.mean(axis=(0, 1)) == pytest.approx(cut.mean(axis=(0, 1)), abs=0.03)
    assert np.array_equal(repaired, repair(cut))
    assert all(0.55 * old <= new <= old for new, old in zip(repaired.shape[:2], cut.shape[:2], strict=True))


def test_repair_keeps_whole_bricks() -> None:
    """Cut amid a brick, the bond goes on over the repaired border: it still has the period of the wall."""
    cut = bricks()[:220, :225]  # 7.3 rows, 5.6 bricks
    repaired = repair(cut)
    rows, columns = repaired.shape[:2]
    assert rows / 30 == pytest.approx(6, abs=0.25)  # an even number of rows, or the bond would break
    assert columns / 40 == pytest.approx(round(columns / 40), abs=0.15)
