"""Fronts (bulging, closed by seams, parted between their pulls) and controls (typed in groups, levers, burners)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.articulate.controls.classify import classify_with_dials
from casa_assets.articulate.controls.controls import Control, find_controls, group_controls
from casa_assets.articulate.controls.levers_and_buttons import Lever, find_levers
from casa_assets.articulate.frame import given_frame
from casa_assets.articulate.fronts.front_hypotheses import FrontHypotheses, choose_fronts, propose_fronts
from casa_assets.articulate.fronts.opening_panels import select_opening_panels
from casa_assets.articulate.fronts.panels import Panel, find_panels
from casa_assets.articulate.fronts.pull_partition import Item, part_between_pulls
from casa_assets.articulate.fronts.relief import (
    LINE_MEASURES,
    FrontRectangle,
    find_lines,
    line_table,
    merge_stairs,
    seam_maps,
)
from casa_assets.articulate.interior.inner_parts import find_drawer_box
from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.run.build import load_models, load_plan_models
from casa_assets.articulate.search.choose import choose_plan
from casa_assets.articulate.segment.fragments import MeasuredFragments, WeldedMesh, measure_fragments, weld_triangles
from casa_assets.articulate.segment.orthographic import FRONT, SIDES, DepthImage, SideRelief, measure_relief
from casa_assets.core.numeric import forest_from_dict
from tests.unit.articulate.blocks import Part, box, carcass, disc, in_its_frame, lattice, pieces_in, together

COLUMNS = ((0, 20), (20, 40), (40, 160), (160, 180), (180, 200))


def fallen(planes: tuple[float, ...], rows: tuple[int, int] = (0, 100)) -> tuple[SideRelief, list[FrontRectangle]]:
    """A front of strips that lie so deep, and the rectangles that it falls into."""
    depth = np.zeros((100, 200))
    for (a, b), plane in zip(COLUMNS, planes, strict=True):
        depth[:, a:b] = plane
    # Nothing stands out, and nothing is an edge.
    none, blob = np.zeros(depth.shape, dtype=bool), np.full(depth.shape, -1, dtype=np.int64)
    picture = DepthImage(np.zeros(depth.shape, dtype=np.int64), depth, np.zeros(2), 0.002)
    relief = SideRelief(picture, depth, depth, blob, (), none, none)
    return relief, [FrontRectangle(rows, c, p) for c, p in zip(COLUMNS, planes, strict=True)]


def test_the_stairs_of_a_bulge_are_one_front_and_what_is_none_stays_apart() -> None:
    side, leaves = fallen((0.012, 0.006, 0.0, 0.006, 0.012))
    (one,) = merge_stairs(side, leaves)
    assert (one.rows, one.columns) == ((0, 100), (0, 200))
    assert one.plane == pytest.approx(0.0)
    for planes in [
        (0.006, 0.0, 0.006, 0.0, 0.006),  # it rises again
        (0.06, 0.03, 0.0, 0.03, 0.06),  # steps, and no stairs
        (0.0, 0.006, 0.0, 0.006, 0.0),  # a panel in a frame
        (0.024, 0.018, 0.0, 0.0, 0.0),  # it goes down to one side only
    ]:
        side, leaves = fallen(planes)
        assert merge_stairs(side, leaves) == leaves, planes


def wedge(low: tuple[float, float, float], high: tuple[float, float, float], back: float) -> Part:
    """A box of which the front falls back to both sides by `back` from its middle."""
    points, faces = box(low, high)
    points[[0, 1, 4, 5], 1] += back
    ridge = np.array([[(low[0] + high[0]) / 2, low[1], z] for z in (low[2], high[2])])
    corners = np.concatenate([points, ridge])
    kept = [f for f in faces.tolist() if not set(f) <= {0, 1, 4, 5}]
    more = [(0, 8, 9), (0, 9, 4), (8, 1, 5), (8, 5, 9), (0, 1, 8), (4, 9, 5)]
    return corners, np.array([*kept, *more], dtype=np.int64)


@pytest.mark.parametrize("stands", [0.03, 0.004])
def test_a_stout_bar_at_the_edge_of_a_bulging_front_is_no_part_of_its_leaf(stands: float) -> None:
    """It stands out of what is round it, though not far before the middle of the front; a rail does not."""
    front = wedge((0.0, 0.0, 0.0), (0.6, 0.06, 1.0), 0.02)
    bar = box((0.03, 0.018 - stands, 0.4), (0.08, 0.02, 0.6))
    pieces = pieces_in(*[box((0.0, 0.06, 0.0), (0.6, 0.6, 1.0)), front, bar])
    (panel,) = [p for p in find_panels(pieces) if len(p.members) > 0 and p.width > 0.4]
    assert (len(panel.members) > 1) is (stands < 0.01)


def _wall(groove: float, noise: float) -> WeldedMesh:
    """A wall of 0.6 x 0.6 that faces -y, bumpy, with a level groove in its middle."""
    count = 121
    x, z = np.meshgrid(np.linspace(-0.3, 0.3, count), np.linspace(-0.3, 0.3, count))
    depth = np.random.default_rng(0).normal(0.0, noise, x.shape)
    depth[count // 2] += groove
    return weld_triangles(np.stack([x, depth, z], axis=-1).reshape(-1, 3), lattice(count, count))


def test_a_groove_as_shallow_as_the_bumps_around_it_is_the_loudest_line() -> None:
    """It is long and straight, so that its mean stands out where none of its pixels does."""
    mesh = _wall(groove=0.002, noise=0.001)
    relief = measure_relief(mesh, FRONT)
    maps = seam_maps(mesh, relief, FRONT, upright=False)
    height, width = relief.depth.shape
    at = find_lines(maps, relief.image.pixel, [])
    table = line_table(maps, at, np.array([0, width]), relief.image.pixel)
    groove = table.values[:, 0, 1, LINE_MEASURES.index("groove")]
    assert abs(at[groove.argmax()] - height / 2) <= 4
    assert groove.max() > 2 * np.sort(groove)[-2]


def test_lines_that_are_given_are_kept_however_near_they_are_to_each_other() -> None:
    """The seam between two doors lies a pixel beside the middle of the outline: the doors are among the hypotheses."""
    mesh = _wall(groove=0.0, noise=0.0)
    relief = measure_relief(mesh, FRONT)
    maps = seam_maps(mesh, relief, FRONT, upright=False)
    assert {100, 101}.issubset(find_lines(maps, relief.image.pixel, [100, 101]).tolist())
    height, width = relief.depth.shape
    doors = [FrontRectangle((0, height), (0, width // 2 + 1)), FrontRectangle((0, height), (width // 2 + 1, width))]
    found = propose_fronts(mesh, relief, FRONT, doors)
    proposed = {(*rows, *columns) for rows, columns in zip(found.rows.tolist(), found.columns.tolist(), strict=True)}
    assert {(*d.rows, *d.columns) for d in doors} <= proposed


def test_two_leaves_go_before_the_whole_where_they_explain_more_together() -> None:
    """The sum over a set counts, and no two of it overlap."""
    columns = np.array([(0, 100), (0, 50), (50, 100)])
    found = FrontHypotheses(np.array([(0, 100)] * 3), columns, np.zeros((3, 1)), 100.0, 0.01)
    assert choose_fronts(found, np.array([2.0, 1.5, 1.5]), 0.0) == [1, 2]
    assert choose_fronts(found, np.array([4.0, 1.5, 1.5]), 0.0) == [0]
    assert choose_fronts(found, np.array([-1.0, -2.0, 1.5]), 0.0) == [2]


def _panel(lower: list[float], upper: list[float], axis: int, sign: int) -> tuple[np.ndarray, np.ndarray]:
    """A rectangle of 8 x 8 cells at lower[axis], facing along an axis of (right, up, depth)."""
    a, b = (k for k in range(3) if k != axis)
    s, t = np.meshgrid(np.linspace(lower[a], upper[a], 9), np.linspace(lower[b], upper[b], 9))
    points = np.full((81, 3), lower[axis])
    points[:, a], points[:, b] = s.ravel(), t.ravel()
    points, faces = points @ SIDES[FRONT], lattice(9, 9)
    normal = np.cross(points[1] - points[0], points[9] - points[0])
    return points, faces if normal @ SIDES[FRONT][axis] * sign > 0 else faces[:, ::-1]


def _inside(panels: list[tuple[list[float], list[float], int, int]]) -> int:
    """How many of the faces are the box behind a front from (-0.2, -0.1) to (0.2, 0.1)."""
    mesh = weld_triangles(*together(*(_panel(*p) for p in panels))[:2])
    flat = mesh.points[mesh.faces].mean(axis=1) @ SIDES[FRONT].T
    rows = np.arange(len(mesh.faces))
    return len(find_drawer_box(mesh, flat, rows, np.array([-0.2, -0.1]), np.array([0.2, 0.1])))


def test_walls_that_look_at_the_body_are_the_box_of_a_drawer() -> None:
    """The outside of a tub within the walls of the body; walls of the body alone are no box, nor are double walls."""
    body = [
        ([-0.19, -0.1, 0.0], [-0.19, 0.1, 0.5], 0, 1),
        ([0.19, -0.1, 0.0], [0.19, 0.1, 0.5], 0, -1),
        ([-0.19, -0.1, 0.5], [0.19, 0.1, 0.5], 2, -1),
    ]

    def tub(top: float) -> list[tuple[list[float], list[float], int, int]]:
        return [
            ([-0.17, -0.08, 0.0], [-0.17, top, 0.45], 0, -1),
            ([0.17, -0.08, 0.0], [0.17, top, 0.45], 0, 1),
            ([-0.17, -0.08, 0.0], [0.17, -0.08, 0.45], 1, -1),
            ([-0.17, -0.08, 0.45], [0.17, top, 0.45], 2, 1),
        ]

    assert _inside(body) == 0
    assert _inside([*body, *tub(0.05)]) == 4 * 128
    assert _inside([*body, *tub(0.1)]) == 0


def split_box(triangles: int) -> MeasuredFragments:
    """A box of which so many of the two triangles of its front are a fragment of their own."""
    mesh, _ = in_its_frame(*box((-0.4, -0.3, -0.2), (0.4, 0.3, 0.2)))
    label = np.zeros(len(mesh.faces), dtype=np.int64)
    label[np.flatnonzero(mesh.normals[:, 1] < -0.9)[:triangles]] = 1
    return measure_fragments(mesh, label)


def panels_of_front(measured: MeasuredFragments) -> list[Panel]:
    return [p for p in find_panels(measured) if 1 in p.members]


def test_half_a_face_is_no_panel_and_the_face_of_a_case_with_controls_does_not_open() -> None:
    assert not panels_of_front(split_box(1))
    (panel,) = panels_of_front(split_box(2))
    panel.controls = 2
    assert not select_opening_panels(split_box(2), [panel], [])


Box = tuple[int, int, int, int]


def pull(row: int, column: int, height: int, width: int) -> Item:
    """A pull around a middle, in pixels."""
    rows, columns = (row - height // 2, row + height // 2), (column - width // 2, column + width // 2)
    return Item(rows, columns, rows, columns)


def room(a: int, b: int, c: int, d: int) -> Item:
    """An open room."""
    return Item((a, b), (c, d), (a, b), (c, d), is_room=True)


def boxes(rows: tuple[int, int], columns: tuple[int, int], items: list[Item]) -> list[Box]:
    """The cells as (first and last row, first and last column)."""
    return [(*c.rows, *c.columns) for c in part_between_pulls(rows, columns, items)]


# Name: size, pulls and rooms, the cells that people would make, and how many pixels they may be off.
PARTED: dict[str, tuple[tuple[int, int], list[Item], list[Box], int]] = {
    "three drawers whose pulls are 20 below their tops": (
        (600, 300),
        [pull(20, 150, 10, 60), pull(120, 150, 10, 60), pull(320, 150, 10, 60)],
        [(0, 100, 0, 300), (100, 300, 0, 300), (300, 600, 0, 300)],
        12,
    ),
    "a wide drawer with a lying pull below a pair of doors with standing ones": (
        (600, 600),
        [pull(150, 30, 100, 14), pull(150, 570, 100, 14), pull(450, 300, 14, 100)],
        [(0, 300, 0, 300), (0, 300, 300, 600), (300, 600, 0, 600)],
        25,
    ),
    "two pairs of doors whose pulls face each other": (
        (400, 600),
        [pull(200, c, 80, 12) for c in (130, 170, 430, 470)],
        [(0, 400, c, c + 150) for c in (0, 150, 300, 450)],
        12,
    ),
    "three drawers, and a room that is no front": (
        (200, 200),
        [pull(50, 50, 10, 40), pull(50, 150, 10, 40), pull(150, 150, 10, 40), room(100, 200, 0, 100)],
        [(0, 100, 0, 100), (0, 100, 100, 200), (100, 200, 100, 200)],
        3,
    ),
}


@pytest.mark.parametrize("name", PARTED)
def test_a_front_is_parted_between_its_pulls(name: str) -> None:
    (height, width), items, wanted, slack = PARTED[name]
    found = boxes((0, height), (0, width), items)
    assert len(found) == len(wanted)
    assert np.abs(np.array(found) - np.array(wanted)).max() <= slack


def test_what_is_where_no_pull_would_be_is_not_parted() -> None:
    """Standing things in the middle of narrow strips far from any usual place: nothing is guessed."""
    assert boxes((0, 100), (0, 100), [pull(50, 50, 10, 10)]) == []
    scattered = [pull(20, 40, 8, 8), pull(37, 46, 8, 8), pull(90, 55, 8, 8), pull(71, 61, 8, 8)]
    assert boxes((0, 100), (0, 400), scattered) == []


def control(x: float, z: float, width: float, height: float, stands: float = 0.01) -> Control:
    half = np.array([width, height]) / 2
    low, high = np.append(np.array([x, z]) - half, 0.0), np.append(np.array([x, z]) + half, stands)
    return Control([0], low, high, stands, width == height)


def test_a_grid_is_one_group_and_a_wide_key_below_it_another() -> None:
    grid = [control(0.05 * a, 0.05 * b, 0.03, 0.03) for a in range(3) for b in range(4)]
    groups = group_controls([*grid, control(0.05, -0.06, 0.13, 0.03)])
    assert sorted((len(g.members), g.rows, g.columns) for g in groups) == [(1, 1, 1), (12, 4, 3)]
    assert groups[0].pitch == pytest.approx(0.05 / 0.03)


def test_round_keys_in_a_grid_beside_a_door_are_keys() -> None:
    door, panel = box((0.0, -0.02, 0.0), (0.37, -0.0005, 0.3)), box((0.375, -0.02, 0.0), (0.5, -0.0005, 0.3))
    keys = [disc((0.4 + 0.037 * a, -0.025, 0.08 + 0.032 * b), 0.011, 0.0049, 16) for a in range(3) for b in range(5)]
    bar = box((0.335, -0.05, 0.05), (0.35, -0.0205, 0.25))
    mesh = weld_triangles(*together(*carcass(0.5, 0.38, 0.3), door, panel, bar, *keys)[:2])
    frames = [given_frame(mesh, (0, 0, 1), (0, -1, 0))]
    found = choose_plan(mesh, frames, "", load_models(), load_plan_models()).plan.articulation.parts
    assert sorted(p.kind for p in found) == [PartKind.BUTTON] * 15 + [PartKind.DOOR]


def test_a_forest_gives_the_mean_of_its_trees(monkeypatch: pytest.MonkeyPatch) -> None:
    leaf = [[[0, 100]]]
    trees = [[[0, 0.5, 1, 2], [[100, 0]], [[50, 50]]], leaf]
    forest = forest_from_dict({"features": ["a"], "classes": ["x", "y"], "trees": trees})
    assert forest.probabilities(np.array([[0.5], [0.6]])).tolist() == [[0.5, 0.5], [0.25, 0.75]]
    with pytest.raises(ValueError, match="points nowhere"):
        forest_from_dict({"features": ["a"], "classes": ["x", "y"], "trees": [[[0, 0.5, 1, 3], *leaf, *leaf]]})
    monkeypatch.setattr(registry, "learned_forest", lambda _: forest)
    with pytest.raises(ValueError, match="other features"):
        load_models.__wrapped__()


def test_round_things_that_are_smaller_than_the_dial_of_a_toaster_are_its_keys() -> None:
    def classify(_control: Control, _others: Sequence[Control]) -> tuple[PartKind | None, float, str]:
        return PartKind.KNOB, 0.6, "round"

    dial, key, lever = control(0.0, 0.0, 0.06, 0.06), control(0.08, 0.0, 0.04, 0.04), control(0.0, 0.1, 0.058, 0.058)
    told = [classify_with_dials(classify)(c, [dial, key, lever])[0] for c in (dial, key, lever)]
    assert told == [PartKind.KNOB, PartKind.BUTTON, PartKind.KNOB]


def levers_in(parts: list[Part]) -> tuple[list[Lever], float]:
    """Levers on the front of some parts, and metres in a unit of the frame."""
    pieces = pieces_in(*parts)
    size = float(np.linalg.norm(np.ptp(together(*parts)[0], axis=0)))
    return find_levers(pieces, find_controls(pieces, FRONT, [])), size


def test_a_pad_at_the_end_of_a_slot_is_a_lever_that_goes_along_it() -> None:
    parts = [box((0.0, 0.03, 0.0), (0.3, 0.3, 0.25)), box((0.13, -0.03, 0.18), (0.17, -0.005, 0.19))]
    parts += [box((x, 0.0, 0.0), (x + 0.145, 0.03, 0.25)) for x in (0.0, 0.155)]
    parts += [box((0.145, 0.0, low), (0.155, 0.03, high)) for low, high in ((0.0, 0.06), (0.2, 0.25))]
    (lever,), unit = levers_in(parts)
    assert lever.way == pytest.approx((0, -1, 0), abs=0.02)
    assert lever.length * unit == pytest.approx(0.12, abs=0.01)
    assert (lever.control.upper - lever.control.lower) * unit == pytest.approx((0.04, 0.01, 0.025), abs=1e-6)


def test_a_slot_that_falls_back_in_stairs_has_their_slope() -> None:
    steps = 20
    parts = [box((0.0, 0.06, 0.0), (0.3, 0.3, 0.3))]
    for k in range(steps):
        low, high, y = 0.3 * k / steps, 0.3 * (k + 1) / steps, 0.003 * k
        parts += [box((0.0, y, low), (0.145, 0.06, high)), box((0.155, y, low), (0.3, 0.06, high))]
    parts += [box((0.145, 0.0, 0.0), (0.155, 0.06, 0.06))]
    levers, _ = levers_in([*parts, box((0.13, 0.01, 0.24), (0.17, 0.044, 0.25))])
    lever = max(levers, key=lambda v: float(v.control.middle[1]))
    assert lever.way[2] / lever.way[1] == pytest.approx(0.2, abs=0.05)


def test_a_gap_between_two_fronts_is_no_slot_and_what_has_no_slot_is_no_lever() -> None:
    fronts = [box((0.0, 0.0, z), (0.3, 0.02, z + 0.12)) for z in (0.0, 0.13)]
    beside = [box((x, 0.0, 0.0), (x + 0.145, 0.02, 0.25)) for x in (0.0, 0.155)]
    pad = box((0.13, -0.03, 0.18), (0.17, -0.005, 0.19))
    assert levers_in([box((0.0, 0.05, 0.0), (0.3, 0.3, 0.25)), *fronts, pad])[0] == []
    assert levers_in([box((0.0, 0.05, 0.0), (0.3, 0.3, 0.25)), *beside, pad])[0] == []
    assert levers_in([box((0.0, 0.0, 0.0), (0.2, 0.3, 0.25)), box((0.07, -0.02, 0.05), (0.13, -1e-4, 0.08))])[0] == []


def test_a_sheet_that_a_knob_stands_on_stays() -> None:
    corners = [[x, -0.01, z] for x, z in ((0.1, 0.1), (0.18, 0.1), (0.18, 0.18), (0.1, 0.18))]
    sheet = np.array(corners), np.array([[0, 1, 2], [0, 2, 3]])
    parts = [box((0.0, 0.0, 0.0), (0.5, 0.3, 0.5)), sheet, disc((0.14, -0.035, 0.14), 0.025, 0.025)]
    (knob,) = find_controls(pieces_in(*parts), FRONT, [])
    assert knob.is_round
    assert len(knob.fragments) == 1
