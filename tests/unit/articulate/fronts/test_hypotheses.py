"""Fronts of a shell whose gaps are closed: what speaks for a rectangle, and which rectangles are chosen."""

import numpy as np

from casa_assets.articulate.fronts.front_hypotheses import FrontHypotheses, choose_fronts, propose_fronts
from casa_assets.articulate.fronts.relief import LINE_MEASURES, FrontRectangle, find_lines, line_table, seam_maps
from casa_assets.articulate.interior.inner_parts import find_drawer_box
from casa_assets.articulate.segment.orthographic import FRONT, SIDES, measure_relief
from casa_assets.articulate.segment.welded_mesh import WeldedMesh, weld_triangles


def _wall(groove: float, noise: float) -> WeldedMesh:
    """A wall of 0.6 x 0.6 that faces -y, bumpy, with a level groove in its middle."""
    count = 121
    x, z = np.meshgrid(np.linspace(-0.3, 0.3, count), np.linspace(-0.3, 0.3, count))
    depth = np.random.default_rng(0).normal(0.0, noise, x.shape)
    depth[count // 2] += groove
    points = np.stack([x, depth, z], axis=-1).reshape(-1, 3)
    a = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + count], 1), np.stack([a + 1, a + count + 1, a + count], 1)])
    return weld_triangles(points, faces)


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


def _hypotheses(boxes: list[tuple[int, int, int, int]]) -> FrontHypotheses:
    ends = np.array(boxes, dtype=np.int64)
    return FrontHypotheses(ends[:, :2], ends[:, 2:], np.zeros((len(ends), 1)), 100.0, 0.01)


def test_two_leaves_go_before_the_whole_where_they_explain_more_together() -> None:
    """The sum over a set counts, and no two of it overlap."""
    found = _hypotheses([(0, 100, 0, 100), (0, 100, 0, 50), (0, 100, 50, 100)])
    assert choose_fronts(found, np.array([2.0, 1.5, 1.5]), 0.0) == [1, 2]
    assert choose_fronts(found, np.array([4.0, 1.5, 1.5]), 0.0) == [0]
    assert choose_fronts(found, np.array([-1.0, -2.0, 1.5]), 0.0) == [2]


def _panel(lower: list[float], upper: list[float], axis: int, sign: int) -> tuple[np.ndarray, np.ndarray]:
    """A rectangle of 8 x 8 cells at lower[axis], facing along an axis of (right, up, depth)."""
    a, b = (k for k in range(3) if k != axis)
    s, t = np.meshgrid(np.linspace(lower[a], upper[a], 9), np.linspace(lower[b], upper[b], 9))
    points = np.full((81, 3), lower[axis])
    points[:, a], points[:, b] = s.ravel(), t.ravel()
    corner = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
    faces = np.concatenate(
        [np.stack([corner, corner + 1, corner + 9], 1), np.stack([corner + 1, corner + 10, corner + 9], 1)]
    )
    points = points @ SIDES[FRONT]
    normal = np.cross(points[1] - points[0], points[9] - points[0])
    return points, faces if normal @ SIDES[FRONT][axis] * sign > 0 else faces[:, ::-1]


def _inside(panels: list[tuple[list[float], list[float], int, int]]) -> int:
    """How many of the faces are the box behind a front from (-0.2, -0.1) to (0.2, 0.1)."""
    made = [_panel(*p) for p in panels]
    starts = np.cumsum([0, *(len(p) for p, _ in made)])
    mesh = weld_triangles(
        np.concatenate([p for p, _ in made]), np.concatenate([f + s for (_, f), s in zip(made, starts, strict=False)])
    )
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
