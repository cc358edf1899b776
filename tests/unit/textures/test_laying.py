"""Noise, pieces and their joints, and wood: true to size, without a seam, the same at any resolution."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from casa_assets.core.numeric import rng_for
from casa_assets.textures.canvas import Canvas, Layers, Map, blur, fbm, gradient, ridged, worley
from casa_assets.textures.laying import Laying, LayingPattern, lay
from casa_assets.textures.pieces import Joint, PieceMap, Slab, gap, inlay, whole
from casa_assets.textures.wood import GrowthRings, SawCut, WoodSpecies, grain_maps

pytestmark = pytest.mark.content("code", "textures", keep=0)

R2, R3 = float(np.sqrt(2.0)), float(np.sqrt(3.0))
# Pattern -> laying, picture in metres, area of one module in square metres, pieces in the picture.
TILINGS: dict[str, tuple[Laying, tuple[float, float], int]] = {
    "stacked": (Laying(pattern=LayingPattern.RUNNING, width_m=0.1, length_m=0.2), (0.8, 0.6), 24),
    "running": (Laying(pattern=LayingPattern.RUNNING, width_m=0.1, length_m=0.2, bond=0.5), (0.8, 0.6), 24),
    "upright third": (
        Laying(pattern=LayingPattern.RUNNING, width_m=0.1, length_m=0.2, bond=1 / 3, upright=True), (0.6, 0.8), 24),
    "basket": (Laying(pattern=LayingPattern.BASKET, width_m=0.1, length_m=0.3), (1.2, 0.6), 24),
    "herringbone": (Laying(pattern=LayingPattern.HERRINGBONE, width_m=0.1, length_m=0.3), (0.6, 0.6), 12),
    "herringbone slant": (
        Laying(pattern=LayingPattern.HERRINGBONE, width_m=0.1, length_m=0.3, diagonal=True), (0.6 * R2, 0.6 * R2), 24),
    "chevron": (Laying(pattern=LayingPattern.CHEVRON, width_m=0.1, length_m=0.4), (0.8 / R2, 0.4 * R2), 8),
    "ashlar": (Laying(pattern=LayingPattern.ASHLAR, width_m=0.1), (1.0, 0.8), 0),
    "panel": (Laying(pattern=LayingPattern.PANEL, width_m=0.05, length_m=0.6), (0.6, 0.6), 0),
    "hexagon": (Laying(pattern=LayingPattern.HEXAGON, width_m=0.1), (0.6, 0.1 * R3 * 3), 36),
    "picket": (Laying(pattern=LayingPattern.PICKET, width_m=0.1, length_m=0.3), (0.6, 0.5), 12),
    "diamond": (Laying(pattern=LayingPattern.DIAMOND, width_m=0.1, length_m=0.2), (0.6, 0.6), 36),
    "scale": (Laying(pattern=LayingPattern.SCALE, width_m=0.1), (0.6, 0.6), 72),
    "lantern": (Laying(pattern=LayingPattern.LANTERN, width_m=0.1, length_m=0.2), (0.6, 0.6), 36),
    "octagon": (Laying(pattern=LayingPattern.OCTAGON, width_m=0.1), (0.6, 0.6), 72),
    "star": (Laying(pattern=LayingPattern.STAR, width_m=0.2), (0.6, 0.6), 18),
    "cube": (Laying(pattern=LayingPattern.CUBE, width_m=0.2), (0.6, 0.2 * R3 * 2), 36),
    "planks": (Laying(pattern=LayingPattern.PLANKS, width_m=0.1, length_m=0.5, upright=True), (0.6, 1.0), 12),
    "ledge": (Laying(pattern=LayingPattern.LEDGE, width_m=0.09, length_m=0.3), (0.9, 0.9), 0),
}  # fmt: skip

UNEQUAL = {"octagon", "star", "planks", "ashlar", "panel", "ledge"}


def laid(name: str, px_per_m: int = 400) -> tuple[PieceMap, Canvas]:
    laying, tile, _ = TILINGS[name]
    canvas = Canvas((round(tile[1] * px_per_m), round(tile[0] * px_per_m)), tile)
    return lay(laying, canvas, rng_for(1, name)), canvas


def test_pieces_cover_the_picture_without_holes_and_go_on_over_the_border() -> None:
    """The distance to an edge changes by a pixel from one pixel to the next, on the border as well."""
    for name, (_, _, count) in TILINGS.items():
        pieces, canvas = laid(name)
        assert pieces.inside_m.min() > -1.5 * canvas.pixel_m, name
        used = np.unique(pieces.owner)
        assert len(used) == pieces.count or name == "panel"  # corners of a weave may be cut off altogether
        assert count in (0, pieces.count)
        if name not in UNEQUAL:
            shares = np.bincount(pieces.owner.ravel(), minlength=pieces.count) / pieces.owner.size * pieces.count
            assert 0.9 < shares.min() <= shares.max() < 1.1
        for axis in (0, 1):
            steps = np.abs(np.take(pieces.inside_m, 0, axis) - np.take(pieces.inside_m, -1, axis))
            assert steps.max() < 1.6 * canvas.pixel_m


def test_place_on_a_piece_is_true_to_size_and_a_level_one_has_its_length_along_x() -> None:
    pieces, canvas = laid("running")
    one = pieces.owner == 5
    assert np.ptp(pieces.v_m[one]) == pytest.approx(0.2, abs=2 * canvas.pixel_m)
    assert np.ptp(pieces.u_m[one]) == pytest.approx(0.1, abs=2 * canvas.pixel_m)
    assert pieces.inside_m[one].max() == pytest.approx(0.05, abs=canvas.pixel_m)
    slanting, canvas = laid("chevron")
    for number in range(slanting.count):
        assert np.ptp(slanting.u_m[slanting.owner == number]) == pytest.approx(0.1, abs=3 * canvas.pixel_m), "across it"
    level = np.argwhere(laid("stacked")[0].owner == 0)
    assert np.ptp(level[:, 1]) > np.ptp(level[:, 0])


def test_a_picture_that_holds_no_whole_number_and_rows_that_do_not_close_are_errors() -> None:
    for length, module, even in [(1.0, 0.3, False), (0.9, 0.3, True), (0.05, 0.1, False)]:
        with pytest.raises(ValueError, match="no whole number of modules"):
            whole(length, module, even)
    laying = Laying(pattern=LayingPattern.RUNNING, width_m=0.1, length_m=0.2, bond=0.5)
    with pytest.raises(ValueError, match="do not close"):
        lay(laying, Canvas((50, 40), (0.4, 0.5)), rng_for(1, "x"))


def test_a_joint_covers_its_width_at_any_resolution() -> None:
    joint = Joint(width_m=0.003)
    for pixel in (0.0005, 0.002, 0.01):
        count = round(0.1 / pixel)
        x = (np.arange(count) + 0.5) * pixel
        inside = np.minimum(x, 0.1 - x)[None, :].astype(np.float32)  # half a joint at each end
        share = gap(joint, inside - np.float32(0.0015), Canvas((1, count), (0.1, pixel)))
        assert share.sum() * pixel == pytest.approx(0.003, rel=0.02)


def test_every_piece_shows_its_own_place_of_the_slab() -> None:
    pieces, _ = laid("stacked", 100)
    ramp = np.broadcast_to(np.linspace(0, 1, 64, endpoint=False, dtype=np.float32)[None, :], (64, 64))
    slab = Slab(Layers(np.stack([ramp] * 3, axis=2), ramp, ramp), (6.4, 6.4))
    places = np.linspace(0.5, 5.5, pieces.count)
    face = inlay(pieces, (slab,), np.zeros(pieces.count, dtype=np.int64), places, places, np.ones(pieces.count))
    means = [float(face.height_m[pieces.owner == n].mean()) for n in range(pieces.count)]
    np.testing.assert_allclose(means, (places - 0.05) / 6.4, atol=0.002)


SIZE, CELLS = (96, 128), (6, 4)
MAKERS: dict[str, Callable[[tuple[int, int]], Map]] = {
    "gradient": lambda size: gradient(size, CELLS, rng_for(1, "n")),
    "fbm": lambda size: fbm(size, CELLS, rng_for(1, "n"), 3),
    "ridged": lambda size: ridged(size, CELLS, rng_for(1, "n"), 2),
    "worley": lambda size: worley(size, CELLS, rng_for(1, "n"))[0],
}


def test_noise_closes_repeats_by_its_seed_and_shows_the_same_design_in_any_size() -> None:
    for name, maker in MAKERS.items():
        coarse, fine = maker(SIZE), maker((SIZE[0] * 2, SIZE[1] * 2))
        for axis in (0, 1):
            # The border is a place like any other.
            steps = np.abs(coarse - np.roll(coarse, 1, axis)).max(axis=1 - axis)
            assert 0.0 < steps[0] <= steps[1:].max()
        halved = fine.reshape(SIZE[0], 2, SIZE[1], 2).mean(axis=(1, 3))
        assert np.corrcoef(coarse.ravel(), halved.ravel())[0, 1] > 0.99
        assert coarse.tobytes() == maker(SIZE).tobytes(), name


def test_blur_keeps_the_mean_and_goes_round_the_border() -> None:
    image = np.zeros((32, 32), dtype=np.float32)
    image[0, 0] = 1.0
    soft = blur(image, 2.0)
    assert soft.sum() == pytest.approx(1.0, abs=1e-4)
    assert soft[-1, -1] == pytest.approx(soft[1, 1], rel=1e-4)


def test_a_straight_cut_has_the_years_of_its_species() -> None:
    """0.8 m of years of 0.02 m are 40 years, on every row."""
    even = {"unevenness": 0.0, "contrast": 1.0, "pores": 0.0, "fibre": 0.0, "clouds": 0.0}
    species = WoodSpecies(rings=GrowthRings.BANDED, ring_m=0.02, **even)
    ring = grain_maps(Canvas((240, 240), (0.8, 0.8)), species, SawCut.QUARTER, 1, rng_for(3, "board")).ring
    for row in ring[::40]:
        starts = np.sum((row < 0.5) & (np.roll(row, -1) >= 0.5))
        assert starts == pytest.approx(40, abs=2)
