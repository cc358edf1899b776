"""What has no moving part: boxes with creases, furniture without doors, books, garbage. None is given one."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.frame import guess_frame
from casa_assets.articulate.segment.shell_segments import fragment_mesh
from casa_assets.articulate.segment.welded_mesh import weld_triangles
from tests.unit.articulate.blocks import Part, box, disc, together
from tests.unit.articulate.fragmented import articulate_fragmentation

pytestmark = pytest.mark.content("code", "articulate", keep=0)

Shape = tuple[np.ndarray, np.ndarray]


def parts_of(shape: Shape) -> list[str]:
    mesh = weld_triangles(*shape)
    frame = guess_frame(mesh)
    placed = mesh.in_frame(frame)
    return [p.name for p in articulate_fragmentation(fragment_mesh(placed), frame).parts]


def plain(*parts: Part) -> Shape:
    points, faces, _ = together(*parts)
    return points, faces


def carton(crease: float, seed: int = 3) -> Shape:
    """A scanned box: one skin, uneven by a millimetre or two, with a step round it where its lid ends."""
    count = 28
    rng = np.random.default_rng(seed)
    u, v = np.meshgrid(np.linspace(-1, 1, count), np.linspace(-1, 1, count), indexing="ij")
    points, faces = [], []
    size = np.array([0.11, 0.07, 0.09])
    for axis in range(3):
        for side in (-1.0, 1.0):
            cloud = np.zeros((count, count, 3))
            cloud[..., axis] = side
            cloud[..., (axis + 1) % 3], cloud[..., (axis + 2) % 3] = u * side, v
            start = len(points) * count * count
            points.append(cloud.reshape(-1, 3))
            for i in range(count - 1):
                for j in range(count - 1):
                    a, b, c, d = (start + k * count + m for k, m in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
                    faces += [(a, b, c), (a, c, d)]
    every = np.concatenate(points)
    _, place = np.unique(np.round(every, 6), axis=0, return_inverse=True)
    bump = rng.normal(0.0, 0.006, (int(place.max()) + 1, 3))[place.reshape(-1)]
    lid = np.where(every[:, 2:] > 0.6, crease, 0.0) * np.array([1.0, 1.0, 0.0])
    return (every * (1.0 + lid) + bump) * size, np.array(faces, dtype=np.int64)


def table() -> Shape:
    legs = [box((x, y, 0.0), (x + 0.05, y + 0.05, 0.7)) for x in (0.05, 1.1) for y in (0.05, 0.6)]
    return plain(box((0, 0, 0.7), (1.2, 0.7, 0.74)), *legs)


def chair() -> Shape:
    legs = [box((x, y, 0.0), (x + 0.04, y + 0.04, 0.43)) for x in (0.0, 0.36) for y in (0.0, 0.36)]
    back = [box((0.0, 0.36, 0.45), (0.04, 0.4, 0.9)), box((0.36, 0.36, 0.45), (0.4, 0.4, 0.9))]
    return plain(box((0, 0, 0.43), (0.4, 0.4, 0.45)), *legs, *back, box((0.04, 0.37, 0.7), (0.36, 0.39, 0.88)))


def bookcase() -> Shape:
    boards = [box((0.02, 0, z), (0.78, 0.28, z + 0.02)) for z in np.linspace(0.0, 1.7, 6)]
    sides = [box((x, 0, 0), (x + 0.02, 0.28, 1.72)) for x in (0.0, 0.78)]
    return plain(*sides, box((0.02, 0.27, 0.02), (0.78, 0.28, 1.7)), *boards)


def book() -> Shape:
    covers = [box((0, 0, 0), (0.15, 0.21, 0.003)), box((0, 0, 0.027), (0.15, 0.21, 0.03))]
    return plain(*covers, box((0, 0, 0.003), (0.003, 0.21, 0.027)), box((0.003, 0.003, 0.003), (0.147, 0.207, 0.027)))


def can() -> Shape:
    points, faces = disc((0, 0, 0), 0.033, 0.115, 32)
    rim, top = disc((0, -0.002, 0), 0.03, 0.002, 32)
    points, faces, _ = together((points, faces), (rim, top))
    return points[:, [0, 2, 1]] * np.array([1, 1, -1]), faces


def rubble() -> Shape:
    """Triangles that make nothing."""
    rng = np.random.default_rng(5)
    middles = rng.uniform(-1, 1, (300, 1, 3))
    return (middles + rng.normal(0, 0.1, (300, 3, 3))).reshape(-1, 3), np.arange(900).reshape(-1, 3)


@pytest.mark.parametrize(
    "shape",
    [
        plain(box((0, 0, 0), (1, 1, 1))),
        plain(box((0, 0, 0), (1, 1, 0.6)), box((0, 0, 0.6), (1, 1, 1))),
        carton(0.0),
        carton(0.03),
        table(),
        chair(),
        bookcase(),
        book(),
        can(),
        rubble(),
    ],
    ids=["cube", "two_blocks", "carton", "carton_with_a_lid", "table", "chair", "bookcase", "book", "can", "rubble"],
)
def test_what_does_not_move_is_given_no_part(shape: Shape) -> None:
    assert parts_of(shape) == []
