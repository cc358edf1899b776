"""What is found in a mesh that is split in one way only."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

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
from tests.unit.articulate.blocks import Floats, Ints, Part, together

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
