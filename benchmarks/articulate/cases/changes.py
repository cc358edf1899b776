"""The changes of a labelled case, by name."""

from __future__ import annotations

import copy
import zlib
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np

from benchmarks.articulate.cases import parts, surfaces
from benchmarks.articulate.cases.labelled import LabelledMesh
from benchmarks.articulate.cases.pose import turned

Change = Callable[[LabelledMesh, np.random.Generator], LabelledMesh]


def axes(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Another up axis, yaw, unit and place, and the truth with it."""
    truth = copy.deepcopy(mesh.truth)
    moving = [row for row in truth["parts"] if "joint" in row]
    for row in moving:
        row.setdefault("bbox", [[0.0] * 3] * 2)  # measured again when the case is written
    case = SimpleNamespace(V=mesh.points, A=mesh.areas, diag=mesh.diagonal, J=truth, parts=moving)
    turned(case, rng)
    return LabelledMesh(case.V, mesh.faces, mesh.part, mesh.handle, truth)


def one_shell(mesh: LabelledMesh, rng: np.random.Generator) -> LabelledMesh:
    """Parts that touch the body, with one vertex at each position: one component."""
    return surfaces.by_position(parts.touching(mesh, rng))


CHANGES: dict[str, Change] = {
    "double_faces": surfaces.double_faces,
    "touching": parts.touching,
    "coincident": parts.coincident,
    "no_handles": parts.no_handles,
    "flat_controls": parts.flat_controls,
    "one_shell": one_shell,
    "split_groups": surfaces.split_groups,
    "loose_pieces": surfaces.loose_pieces,
    "box_drawers": parts.box_drawers,
    "empty_inside": surfaces.empty_inside,
    "decimated": surfaces.decimated,
    "axes": axes,
    "holes": surfaces.holes,
    "noise": surfaces.noise,
}
# Those that make sense on a fused shell, which has neither components nor an inside.
FUSED = ("double_faces", "decimated", "axes", "holes", "noise")


def changed(mesh: LabelledMesh, name: str, seed: int) -> LabelledMesh:
    """A case under a change; the same for the same name of the case, change and seed, whichever the variant."""
    key = zlib.crc32(f"{mesh.truth['name']} {name}".encode())
    return CHANGES[name](mesh, np.random.default_rng([seed, key]))
