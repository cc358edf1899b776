"""The room itself: walls have the holes they were given, floors and ceilings fill any outline, mouldings meet."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations, pairwise, product
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from pydantic import ValidationError

from casa_assets.asset.sweep import straight_moulding
from casa_assets.kitchenware.fixtures.room import (
    DENSITY,
    Column,
    Floor,
    Recess,
    Wall,
    WallOpening,
    WallSlope,
    WallStructure,
)
from casa_assets.kitchenware.fixtures.room_trim import (
    Beams,
    Ceiling,
    CovingProfile,
    Panelling,
    PanellingStyle,
    Skirting,
    SkirtingEnd,
    SkirtingProfile,
    wall_trim_section,
)
from casa_assets.kitchenware.parts.room_outline import LayDirection, Outline, room_slab, spans_inside
from casa_assets.mesh.surface import face_normals, is_closed, weld
from casa_assets.model.asset.asset import Asset, Visual
from casa_assets.model.asset.parts import Box
from tests.support.asset.family_members import TILE_M, known, made

pytestmark = pytest.mark.content("code", "families", keep=0)

Floats = npt.NDArray[np.float64]
BAY = WallOpening(left=1.0, bottom=0.9, width=1.2, height=1.1)
DOOR = WallOpening(left=2.6, width=0.9, height=2.1)
SLOPE = WallSlope(knee=1.5, run=1.2)


def visual(asset: Asset, name: str) -> Visual:
    return next(v for v in asset.root.visuals if v.name == f"{name}_visual")


def corners(middle: Sequence[float], size: Sequence[float]) -> Floats:
    """(2, 3) corners of an upright box."""
    return np.asarray(np.array(middle) + np.outer((-0.5, 0.5), size))


def main(asset: Asset) -> Floats:
    """(2, 3) corners of the region main."""
    region = next(r for r in asset.regions if r.name == "main")
    return corners(region.pose.position, region.size)


def boxes(asset: Asset, label: str) -> list[Floats]:
    """(2, 3) corners of each upright box that is touched."""
    found = [c for c in asset.root.colliders if c.label == label]
    assert all(isinstance(c.shape, Box) for c in found)
    return [corners(c.pose.position, c.shape.size) for c in found if isinstance(c.shape, Box)]


def volume(pieces: Sequence[Floats]) -> float:
    """Of boxes of which no two overlap."""
    for a, b in combinations(pieces, 2):
        common = np.minimum(a[1], b[1]) - np.maximum(a[0], b[0])
        assert common.min() < 1e-6, "two boxes overlap"
    return float(sum(np.prod(b[1] - b[0]) for b in pieces))


def hits(visuals: Sequence[Visual], points: Floats, axes: tuple[int, int], normal: Floats) -> npt.NDArray[np.int64]:
    """How many triangles that look along `normal` lie over each (N, 2) point."""
    count = np.zeros(len(points), dtype=np.int64)
    for each in visuals:
        fronts, _ = face_normals(each.mesh.vertices, each.mesh.faces.astype(np.int64))
        corners = each.mesh.vertices[each.mesh.faces[fronts @ normal > 0.99]][..., list(axes)]
        for t in corners:
            edges = np.roll(t, -1, axis=0) - t
            away = points[:, None] - t
            turns = edges[:, 0] * away[..., 1] - edges[:, 1] * away[..., 0]
            count += ((turns > 0).all(axis=1) | (turns < 0).all(axis=1)).astype(np.int64)
    return count


def phase_error(shown: Visual, expected: Floats, chosen: slice | npt.NDArray[np.int64] = slice(None)) -> float:
    """How far pictures are off (V, 2) metres from their corner at some vertices, whole pictures left out, metres."""
    assert shown.mesh.uv is not None
    off = (shown.mesh.uv - expected / np.array(TILE_M))[chosen]
    return float(np.abs(off - np.round(off)).max() * max(TILE_M))


# Walls ----------------------------------------------------------------------------------------------------------------

LOW_LEFT = WallOpening(left=0.2, bottom=0.4, width=0.8, height=0.8)
HIGH_RIGHT = WallOpening(left=0.6, bottom=1.4, width=0.9, height=0.9)
HOLES: dict[str, tuple[WallOpening, ...]] = {
    "none": (),
    "window": (BAY,),
    "door": (DOOR,),
    "both": (BAY, DOOR),
    "three": (LOW_LEFT, HIGH_RIGHT, WallOpening(left=1.6, width=0.7, height=2.0)),
    "at_the_left": (WallOpening(left=0.0, width=0.8, height=2.1),),
    "at_the_right": (WallOpening(left=3.2, bottom=0.9, width=0.8, height=1.0),),
    "to_the_top": (WallOpening(left=1.0, bottom=1.0, width=1.0, height=1.6),),
    "through": (WallOpening(left=1.0, width=1.0, height=2.6),),
}


@pytest.mark.parametrize("tile", [None, "zellige_snow"])
@pytest.mark.parametrize("more", [(0.0, 0.0), (0.12, 0.25)])
@pytest.mark.parametrize("holes", sorted(HOLES))
def test_a_wall_is_open_where_it_was_opened_and_nowhere_else(
    holes: str, more: tuple[float, float], tile: str | None
) -> None:
    p = Wall(length=4.0, openings=HOLES[holes], left_more=more[0], right_more=more[1], tile=tile, tiled_from=0.3)
    asset = made("room_wall", p)
    low, high = main(asset)
    assert high - low == pytest.approx((4.0, 0.12, 2.6), abs=1e-6)
    points = np.random.default_rng(1).uniform((-more[0], 0.0), (4.0 + more[1], p.height), (500, 2))
    free = np.zeros(len(points), dtype=bool)
    for hole in p.openings:
        (x0, z0), (x1, z1) = hole.corners
        free |= (points[:, 0] > x0) & (points[:, 0] < x1) & (points[:, 1] > z0) & (points[:, 1] < z1)
    placed = points + low[[0, 2]]
    for normal in ((0.0, -1.0, 0.0), (0.0, 1.0, 0.0)):
        assert (hits(asset.root.visuals, placed, (0, 2), np.array(normal)) == np.where(free, 0, 1)).all()
    pieces = boxes(asset, "wall")
    touched = sum(((placed > b[0][[0, 2]]) & (placed < b[1][[0, 2]])).all(axis=1).astype(np.int64) for b in pieces)
    assert (touched == np.where(free, 0, 1)).all()
    area = (4.0 + sum(more)) * p.height - sum(h.width * h.height for h in p.openings)
    assert volume(pieces) == pytest.approx(area * p.thickness, rel=1e-6)
    assert len(pieces) <= 4 * len(p.openings) + 1
    if tile is None:  # what is seen has no cracks
        starts = np.cumsum([0, *(len(v.mesh.vertices) for v in asset.root.visuals)])
        faces = np.concatenate([v.mesh.faces + s for v, s in zip(asset.root.visuals, starts, strict=False)])
        points, place = weld(np.concatenate([v.mesh.vertices for v in asset.root.visuals]))
        assert is_closed(place[faces.astype(np.int64)])
        assert face_normals(points, place[faces.astype(np.int64)])[1].min() > 1e-6


def test_pictures_begin_at_the_left_corner_on_the_floor_of_every_wall() -> None:
    for (length, more), (name, start) in product([(2.0, 0.0), (3.47, 0.2)], [("wall", 0.0), ("wall_tiles", 0.5)]):
        p = Wall(length=length, left_more=more, openings=(), tile="zellige_snow", tiled_from=0.5)
        asset = made("room_wall", p)
        low = main(asset)[0]
        shown = visual(asset, name)
        inwards = face_normals(shown.mesh.vertices, shown.mesh.faces.astype(np.int64))[0][:, 1] < -0.99
        expected = shown.mesh.vertices[:, [0, 2]] - low[[0, 2]] - (0.0, start)
        assert phase_error(shown, expected, np.unique(shown.mesh.faces[inwards])) < 1e-5


# Floors and ceilings --------------------------------------------------------------------------------------------------


def turned(outline: Outline, quarters: int, mirrored: bool) -> Outline:
    """An outline turned to the left and mirrored, begun at another corner."""
    out = [(-x if mirrored else x, y) for x, y in outline]
    for _ in range(quarters):
        out = [(-y, x) for x, y in out]
    return tuple(out[quarters:] + out[:quarters])


# Outlines of rooms, metres.
L_ROOM: Outline = ((0.0, 0.0), (4.2, 0.0), (4.2, -2.2), (2.4, -2.2), (2.4, -3.8), (0.0, -3.8))
U_ROOM: Outline = ((0.0, 0.0), (1.2, 0.0), (1.2, -0.8), (3.2, -0.8), (3.2, 0.0), (4.4, 0.0), (4.4, -3.4), (0.0, -3.4))
T_ROOM: Outline = ((0.0, 0.0), (4.4, 0.0), (4.4, -1.8), (3.2, -1.8), (3.2, -4.0), (1.2, -4.0), (1.2, -1.8), (0.0, -1.8))
# A room with a corner cut at 45 degrees, and a part taken out of another corner: 16 - 0.5 - 2 square metres.
CUT_ROOM: Outline = ((0.0, 0.0), (3.0, 0.0), (4.0, -1.0), (4.0, -3.0), (2.0, -3.0), (2.0, -4.0), (0.0, -4.0))
# With the fewest rectangles: one more than there are inner corners; in a T one cut serves two of them.
SHAPES: dict[str, tuple[Outline, int]] = {"l": (L_ROOM, 2), "t": (T_ROOM, 2), "u": (U_ROOM, 3)}


def has(outline: Outline, points: Floats) -> npt.NDArray[np.bool_]:
    """Whether (N, 2) points lie within, by crossings of a ray."""
    inner = np.zeros(len(points), dtype=bool)
    for a, b in pairwise([*outline, outline[0]]):
        if a[1] != b[1]:
            low, high = sorted((a[1], b[1]))
            cross = a[0] + (points[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            inner ^= (points[:, 1] > low) & (points[:, 1] < high) & (points[:, 0] < cross)
    return inner


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("shape", sorted(SHAPES))
def test_floors_and_ceilings_fill_their_outline(shape: str, mirrored: bool) -> None:
    for quarters in range(4):
        outline = turned(SHAPES[shape][0], quarters, mirrored)
        ends = np.array(outline)
        (x, y), (next_x, next_y) = ends.T, np.roll(ends, -1, axis=0).T
        area = abs(float((x * next_y - next_x * y).sum())) / 2
        points = np.random.default_rng(2).uniform(ends.min(axis=0), ends.max(axis=0), (300, 2))
        for label, params, up in (("floor", Floor(outline=outline), 1.0), ("ceiling", Ceiling(outline=outline), -1.0)):
            asset = made(f"room_{label}", params)
            low, high = main(asset)
            assert high - low == pytest.approx((*np.ptp(ends, axis=0), 0.05), abs=1e-6)
            placed = points - ends.min(axis=0) + low[:2]
            seen = hits([visual(asset, label)], placed, (0, 1), np.array([0.0, 0.0, up]))
            assert (seen == has(outline, points)).all()
            pieces = boxes(asset, label)
            assert volume(pieces) == pytest.approx(area * 0.05, rel=1e-6)
            assert len(pieces) == SHAPES[shape][1]
            face = visual(asset, label).mesh.bounds[:, 2]
            assert face == pytest.approx([high[2] if up > 0 else low[2]] * 2, abs=1e-6)


@pytest.mark.parametrize(("boards", "floor"), list(product(LayDirection, (True, False))))
def test_boards_run_as_asked_from_a_corner_of_the_room(boards: LayDirection, floor: bool) -> None:
    kind: Any = Floor if floor else Ceiling
    name = "floor" if floor else "ceiling"
    asset = made(f"room_{name}", kind(outline=L_ROOM, boards=boards, face="oak_natural"))
    shown = visual(asset, name)
    low, high = main(asset)
    at = shown.mesh.vertices
    left_out, back_out = at[:, 0] - low[0], at[:, 1] - low[1]
    if floor:  # seen from above; the picture's width runs to the right of its height
        expected = (high[1] - at[:, 1], left_out) if boards is LayDirection.X else (left_out, back_out)
    else:  # seen from below
        expected = (back_out, left_out) if boards is LayDirection.X else (high[0] - at[:, 0], back_out)
    assert phase_error(shown, np.column_stack(expected)) < 1e-5


@pytest.mark.parametrize("coving", [c for c in CovingProfile if c is not CovingProfile.NONE])
def test_coving_goes_round_the_room_without_a_gap(coving: CovingProfile) -> None:
    p = Ceiling(outline=L_ROOM[::-1], coving=coving, drop=0.08, out=0.06)
    asset = made("room_ceiling", p)
    mesh = visual(asset, "coving").mesh
    points, place = weld(mesh.vertices)
    assert is_closed(place[mesh.faces.astype(np.int64)])
    low, high = main(asset)
    assert mesh.bounds[0] == pytest.approx((low[0], low[1], low[2] - 0.08), abs=1e-6)
    assert mesh.bounds[1] == pytest.approx((high[0], high[1], low[2]), abs=1e-6)
    # No point of it is farther from the nearest wall than it may stand out, and none is outside the room.
    corners = points[:, :2] - low[:2] + np.array(L_ROOM).min(axis=0)
    reach = np.full(len(corners), np.inf)
    for a, b in pairwise([*map(np.array, L_ROOM), np.array(L_ROOM[0])]):
        share = np.clip((corners - a) @ (b - a) / float((b - a) @ (b - a)), 0.0, 1.0)
        reach = np.minimum(reach, np.linalg.norm(corners - (a + share[:, None] * (b - a)), axis=1))
    assert reach.max() <= 0.06 * math.sqrt(2) + 1e-6
    assert (has(L_ROOM, corners) | (reach < 1e-6)).all()
    assert sum(c.label == "coving" for c in asset.root.colliders) == 6


WALL = {"length": 4.0, "height": 2.6}
TILED = {**WALL, "tile": "zellige_snow"}


def opened(
    left: float, bottom: float, width: float, height: float, *others: WallOpening, **more: Any
) -> dict[str, Any]:
    """A wall with a hole, and others."""
    hole = WallOpening(left=left, bottom=bottom, width=width, height=height)
    return {**WALL, "openings": (*others, hole), **more}


REFUSED: list[tuple[str, list[Any], dict[str, Any]]] = [
    ("out of the wall at its right", [Wall], opened(3.5, 0.0, 0.8, 2.0)),
    ("out of the wall at its top", [Wall], opened(1.0, 1.0, 0.8, 2.0)),
    ("openings 0 and 1 overlap", [Wall], opened(1.5, 1.2, 1.0, 0.5, BAY)),
    ("openings 0 and 1 overlap", [Wall], opened(2.2, 2.0, 0.5, 0.4, BAY)),
    ("of wall at its left", [Wall], opened(0.01, 0.0, 0.8, 2.0)),
    ("leave nothing", [Wall], opened(0.0, 0.0, 4.0, 2.6)),
    ("at its slope", [Wall], opened(0.1, 1.0, 0.8, 0.9, left_slope=SLOPE)),
    (r"tiles from 1\.5 to 1\.2", [Wall], {**TILED, "tiled_from": 1.5, "tiled_to": 1.2}),
    (r"on a wall 2\.6 m high", [Wall], {**TILED, "tiled_to": 2.8}),
    ("is level between them", [Wall], {**WALL, "left_slope": WallSlope(knee=1.5, run=5.0)}),
    ("at an edge", [Recess], {"openings": (WallOpening(left=0.1, bottom=0.4, width=0.9, height=0.8),)}),
    ("meets itself", [Ceiling], {"outline": ((0, 0), (2, 0), (2, 0.3), (0, 0.3)), "coving": "cove", "out": 0.2}),
    ("runs aslant", [Ceiling], {"outline": CUT_ROOM, "coving": "cove"}),
    ("leave less than 10 mm", [Skirting], {"length": 0.05, "thickness": 0.03, "left": "inner", "right": "inner"}),
    *(
        (message, [Floor, Ceiling], {"outline": outline})
        for message, outline in (
            ("shorter than", ((0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.05, 2.0), (0.05, 2.0), (0.0, 2.0))),
            # a figure of eight, a side that runs out and back, twice round
            ("cross or touch", ((0, 0), (2, 0), (2, 2), (1, 2), (1, -1), (0, -1))),
            ("cross or touch", ((0, 0), (3, 0), (3, 2), (2, 2), (2, 3), (2, 2), (0, 2))),
            ("cross or touch", ((0, 0), (2, 0), (2, 2), (0, 2), (0, 0.5), (0, 0), (2, 0), (2, 2), (0, 2))),
            ("cross or touch", ((0.0, 0.0), (2.0, -2.0), (2.0, 0.0), (0.0, -2.5))),
        )
    ),
]


def test_what_does_not_fit_is_refused() -> None:
    for message, kinds, fields in REFUSED:
        for kind in kinds:
            with pytest.raises(ValidationError, match=message):
                kind(**fields)


@pytest.mark.parametrize("run", list(LayDirection))
def test_beams_run_from_wall_to_wall_and_stay_in_the_room(run: LayDirection) -> None:
    asset = made("room_ceiling", Ceiling(outline=T_ROOM, beams=Beams(count=5, run=run)))
    low = main(asset)[0]
    beams = boxes(asset, "beam")
    assert len(beams) >= 5
    for b in beams:
        flat = b[:, :2] - low[:2] + np.array(T_ROOM).min(axis=0)
        tips = np.array([(x, y) for x in flat[:, 0] for y in flat[:, 1]])
        assert has(T_ROOM, tips + 1e-4 * (flat.mean(axis=0) - tips)).all()
        end = flat[:, 0] if run is LayDirection.X else flat[:, 1]
        step = np.array((1.0, 0.0) if run is LayDirection.X else (0.0, 1.0)) * (float(np.ptp(end)) / 2 + 0.01)
        middle = flat.mean(axis=0)
        side = np.array((0.0, 0.069) if run is LayDirection.X else (0.069, 0.0))
        for way in (step, -step):  # a centimetre further one side of the beam is in the wall
            assert not has(T_ROOM, np.array([middle + way - side, middle + way + side])).all()
        assert b[0][2] == pytest.approx(low[2] - 0.16, abs=1e-6)


# Skirting and panelling -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", list(SkirtingProfile))
def test_two_mitres_meet_in_a_corner(profile: SkirtingProfile) -> None:
    outline = wall_trim_section(Skirting(profile=profile))
    for end, quarter in ((SkirtingEnd.INNER, -1), (SkirtingEnd.OUTER, 1)):
        one = straight_moulding(outline, 1.0, 0.0, end.slope)
        two = straight_moulding(outline, 1.0, end.slope, 0.0).rotated("z", quarter * math.pi / 2).translated(1.0)
        n = len(outline)
        assert one.points[n:] == pytest.approx(two.points[:n], abs=1e-9)
        assert is_closed(one.faces)
        assert one.volume > 0


def test_a_skirting_is_measured_at_the_wall_and_panelling_fills_its_length_and_height() -> None:
    for end, more in ((SkirtingEnd.SQUARE, 0.0), (SkirtingEnd.INNER, 0.0), (SkirtingEnd.OUTER, 0.015)):
        asset = made("skirting", Skirting(length=1.0, right=end))
        low, high = main(asset)
        assert high - low == pytest.approx((1.0 + more, 0.015, 0.1), abs=1e-6)
        assert asset.bounds == pytest.approx(np.array([low, high]), abs=1e-6)
    for panels in PanellingStyle:
        asset = made("wall_panelling", Panelling(length=1.83, height=0.95, panels=panels))
        low, high = main(asset)
        assert (high - low)[[0, 2]] == pytest.approx((1.83, 0.95), abs=1e-6)
        assert asset.bounds == pytest.approx(np.array([low, high]), abs=1e-6)
        points = np.random.default_rng(4).uniform((low[0], low[2]), (high[0], high[2]), (200, 2))
        assert (hits(asset.root.visuals, points, (0, 2), np.array([0.0, 1.0, 0.0])) >= 1).all()


# Slanting rooms, recesses, columns, gables ----------------------------------------------------------------------------


@pytest.mark.parametrize("outline", [CUT_ROOM, CUT_ROOM[::-1]])
def test_a_floor_fills_an_outline_with_a_slanting_side(outline: Outline) -> None:
    asset = made("room_floor", Floor(outline=outline))
    assert asset.mass == pytest.approx(13.5 * 0.05 * 2000.0, rel=1e-6)
    shell, shapes = room_slab(outline, -0.05, 0.0)
    whole = shell.solid()
    assert whole.volume == pytest.approx(13.5 * 0.05)
    assert is_closed(weld(whole.points)[1][whole.faces])
    assert len(shapes) == len(asset.root.colliders) == 2


def test_spans_are_where_the_whole_breadth_is_inside() -> None:
    for outline, direction, lower, upper, span in (
        (L_ROOM, LayDirection.X, -2.0, -1.0, (0.0, 4.2)),
        (L_ROOM, LayDirection.X, -2.4, -2.0, (0.0, 2.4)),
        (CUT_ROOM, LayDirection.X, -0.6, -0.5, (0.0, 3.5)),
        (CUT_ROOM, LayDirection.X, -3.6, -3.5, (0.0, 2.0)),
        (CUT_ROOM, LayDirection.Y, 3.4, 3.5, (-3.0, -0.5)),
    ):
        assert spans_inside(outline, direction, lower, upper) == [pytest.approx(span, abs=1e-4)]
    assert len(boxes(made("room_ceiling", Ceiling(outline=CUT_ROOM, beams=Beams(count=3))), "beam")) == 3


def test_a_recess_is_hollow_and_open_in_front() -> None:
    pane = WallOpening(left=0.3, bottom=0.4, width=0.6, height=0.8)
    asset = made("room_recess", Recess(width=1.2, depth=0.5, height=1.5, lip=0.12, openings=(pane,)))
    low, high = main(asset)
    assert high - low == pytest.approx((1.2 + 2 * 0.12, 0.12 + 0.5 + 0.12, 0.05 + 1.5 + 0.12))
    middle = (low[0] + high[0]) / 2
    for point in ((middle, low[1] + 0.3, low[2] + 0.05 + 0.7), (middle, high[1] - 0.06, low[2] + 0.05 + 0.8)):
        assert not any(((point > box[0]) & (point < box[1])).all() for box in boxes(asset, "recess"))


def test_a_wall_weighs_what_it_is_built_of_and_a_column_stands_from_floor_to_ceiling() -> None:
    for structure in WallStructure:
        asset = made("room_wall", Wall(length=2.0, height=2.5, thickness=0.1, structure=structure))
        assert asset.mass == pytest.approx(0.5 * known().densities[DENSITY[structure]], rel=1e-5)
    for is_round, area in ((False, 0.09), (True, math.pi * 0.15**2)):
        asset = made("room_column", Column(width=0.3, depth=0.3, height=2.6, is_round=is_round))
        low, high = main(asset)
        assert high - low == pytest.approx((0.33, 0.33, 2.6))
        assert asset.mass == pytest.approx(area * 2.6 * 700.0, rel=0.05)


def test_the_upper_edge_of_a_gable_follows_the_slopes() -> None:
    holes = (WallOpening(left=3.6, bottom=1.0, width=0.8, height=0.95), WallOpening(left=2.0, width=0.9, height=2.1))
    right = WallSlope(knee=1.6, run=1.1)
    p = Wall(length=5.8, height=2.7, right_more=0.12, openings=holes, left_slope=SLOPE, right_slope=right)
    asset = made("room_wall", p)
    area = 5.8 * 2.7 - 1.2 * 1.2 / 2 - 1.1 * 1.1 / 2 - 0.8 * 0.95 - 0.9 * 2.1
    assert asset.mass == pytest.approx((area * 0.12 + 0.12 * 0.12 * 1.6) * 250.0, rel=1e-6)
    low, high = main(asset)
    for x, z, is_there in ((0.3, 1.7, True), (0.3, 1.9, False), (5.5, 1.8, True), (5.5, 2.0, False), (4.0, 1.5, False)):
        seen = hits([visual(asset, "wall")], low[[0, 2]] + np.array([[x, z]]), (0, 2), np.array([0.0, -1.0, 0.0]))
        assert bool(seen[0]) is is_there, (x, z)
    assert (high - low)[0] == pytest.approx(5.8)
    # A wall without slopes has the digest that it had before there were any.
    assert "left_slope" not in Wall().model_dump(mode="json")
    assert p.digest != p.replace(left_slope=None).digest
