"""Plain solids of which the tests build appliances: closed, outward, sharing no vertices; and what is found in them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from casa_assets.articulate.frame import given_frame
from casa_assets.articulate.infer import articulate_fragments
from casa_assets.articulate.plan import Articulation, Frame, JointPlan, PartKind, PartPlan
from casa_assets.articulate.run.build import load_models
from casa_assets.articulate.segment.fragments import (
    PIXELS,
    MeasuredFragments,
    WeldedMesh,
    measure_fragments,
    weld_triangles,
)
from casa_assets.articulate.segment.shell_segments import Fragmentation, fragment_mesh
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.record import Vec3

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Part = tuple[Floats, Ints]

_QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Part:
    """A box between two corners: 8 vertices, 12 faces."""
    corners = np.array(
        [[(low, high)[x][0], (low, high)[y][1], (low, high)[z][2]] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    )
    faces = [f for a, b, c, d in _QUADS for f in ((a, b, c), (a, c, d))]
    return corners.astype(np.float64), np.array(faces, dtype=np.int64)


def disc(middle: tuple[float, float, float], radius: float, depth: float, sides: int = 24) -> Part:
    """A cylinder along y whose front is at `middle`."""
    angle = np.arange(sides) / sides * 2 * np.pi
    ring = np.stack([np.cos(angle) * radius, np.zeros(sides), np.sin(angle) * radius], axis=1) + np.array(middle)
    back = ring + np.array([0.0, depth, 0.0])
    points = np.concatenate([ring, back, [middle], [np.array(middle) + np.array([0.0, depth, 0.0])]])
    faces, n = [], sides
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, j, 2 * n), (j, i, n + i), (j, n + i, n + j), (n + j, n + i, 2 * n + 1)]
    return points, np.array(faces, dtype=np.int64)


def lattice(rows: int, columns: int) -> Ints:
    """The faces between points that lie in rows."""
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    lower, upper = np.stack([a, a + 1, a + columns], 1), np.stack([a + 1, a + columns + 1, a + columns], 1)
    return np.concatenate([lower, upper])


def together(*parts: Part) -> tuple[Floats, Ints, Ints]:
    """Vertices, faces, and the part of each face."""
    starts = np.cumsum([0, *(len(p[0]) for p in parts[:-1])])
    faces = np.concatenate([f + s for (_, f), s in zip(parts, starts, strict=True)])
    owner = np.repeat(np.arange(len(parts)), [len(p[1]) for p in parts])
    return np.concatenate([p[0] for p in parts]), faces, owner


def carcass(width: float, depth: float, height: float, wall: float = 0.02) -> list[Part]:
    """Five boards round a cavity that is open at the front (y = 0)."""
    return [
        box((0, 0, 0), (wall, depth, height)),
        box((width - wall, 0, 0), (width, depth, height)),
        box((wall, 0, 0), (width - wall, depth, wall)),
        box((wall, 0, height - wall), (width - wall, depth, height)),
        box((wall, depth - wall, wall), (width - wall, depth, height - wall)),
    ]


def microwave() -> tuple[Floats, Ints, Ints]:
    """A door hinged at the left (its handle is at the right), and a control panel with a knob and four buttons.

    Parts: 0..4 carcass, 5 door, 6 handle, 7 control panel, 8 knob, 9..12 buttons.
    """
    return together(
        *carcass(0.5, 0.38, 0.3),
        box((0.0, -0.02, 0.0), (0.37, 0.0, 0.3)),
        box((0.335, -0.05, 0.05), (0.35, -0.02, 0.25)),
        box((0.375, -0.02, 0.0), (0.5, 0.0, 0.3)),
        disc((0.437, -0.04, 0.07), 0.022, 0.02),
        *(box((0.40 + dx, -0.0235, z), (0.43 + dx, -0.02, z + 0.02)) for dx in (0.0, 0.045) for z in (0.16, 0.2)),
    )


def drawers() -> tuple[Floats, Ints, Ints]:
    """A carcass with two drawers. Parts: 0..4 carcass; 5..10, 11..16: front, bar, two sides, floor, back."""
    parts = carcass(0.5, 0.5, 0.6)
    for z in (0.305, 0.005):
        parts += [
            box((0.002, -0.02, z), (0.498, 0.0, z + 0.29)),
            box((0.15, -0.06, z + 0.14), (0.35, -0.02, z + 0.155)),
            *(box((x, 0.0, z + 0.03), (x + 0.01, 0.45, z + 0.2)) for x in (0.03, 0.46)),
            box((0.04, 0.0, z + 0.03), (0.46, 0.45, z + 0.04)),
            box((0.04, 0.44, z + 0.04), (0.46, 0.45, z + 0.2)),
        ]
    return together(*parts)


AS_IT_IS = Frame(rotation=np.eye(3), origin=(0.0, 0.0, 0.0), scale=1.0, metres=1.0)


def slides(anchor: Vec3) -> JointPlan:
    """Comes out of its front by 0.3."""
    return JointPlan(kind=JointKind.SLIDE, axis=(0.0, -1.0, 0.0), anchor=anchor, range=(0.0, 0.3))


def plan_of(name: str, kind: PartKind, faces: Ints, joint: JointPlan, parent: str = "") -> PartPlan:
    """A part without a grip."""
    return PartPlan(name=name, kind=kind, parent=parent, faces=faces, grip=faces[:0], joint=joint)


def fragments_of(mesh: WeldedMesh) -> Fragmentation:
    """The welded fragments of a mesh in its frame, with the fronts of a shell as fragments of their own."""
    return fragment_mesh(mesh, mesh.fragment_labels, load_models())


def articulate_fragmentation(fragmentation: Fragmentation, frame: Frame, category: str = "") -> Articulation:
    """The moving parts of a mesh in its frame, which is split into these fragments."""
    measured = measure_fragments(fragmentation.mesh, fragmentation.labels)
    return articulate_fragments(measured, frame, category, known=fragmentation.fronts)


def in_its_frame(vertices: Floats, faces: Ints, tint: Ints | None = None) -> tuple[WeldedMesh, Frame]:
    """A mesh whose up is z and whose front faces -y, welded and in its frame."""
    mesh = weld_triangles(vertices, faces, tint)
    frame = given_frame(mesh, (0, 0, 1), (0, -1, 0))
    return mesh.in_frame(frame), frame


def pieces_in(*parts: Part, tint: Ints | None = None, pixels: int = PIXELS) -> MeasuredFragments:
    """The pieces of solids whose up is z and whose front faces -y."""
    placed, _ = in_its_frame(*together(*parts)[:2], tint)
    return measure_fragments(placed, placed.fragment_labels, pixels)


def found_on(vertices: Floats, faces: Ints, tint: Ints | None = None, category: str = "") -> Articulation:
    """What is found on a mesh whose up is z and whose front faces -y."""
    mesh, frame = in_its_frame(vertices, faces, tint)
    return articulate_fragmentation(fragments_of(mesh), frame, category)


def found_in(parts: Sequence[Part], category: str = "") -> tuple[Articulation, Ints]:
    """What is found in solids whose up is z and whose front faces -y, and the solid of each face."""
    vertices, faces, owner = together(*parts)
    return found_on(vertices, faces, category=category), owner
