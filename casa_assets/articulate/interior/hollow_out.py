"""Choose which cavities are built, and cut them into a solid body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.decisions import GIVEN_REASON, LENGTH_TOLERANCE_M, CavityDecision, Decisions
from casa_assets.articulate.plan import Articulation, Cavity, Frame, InteriorKind, to_vec3
from casa_assets.articulate.segment.cutting import CutPlane, cut_triangles
from casa_assets.articulate.segment.orthographic import FRONT
from casa_assets.articulate.segment.welded_mesh import WeldedMesh, weld_model
from casa_assets.core.numeric import Ints
from casa_assets.errors import UnknownId
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.record import Vec3
from casa_assets.model.source import RawModel

# Choose interiors -----------------------------------------------------------------------------------------------------
# Apply user decisions on interiors: which cavities are built, and which stay as the mesh has them.

# A cavity of a given size cuts the body this share of its wall thickness beyond itself, on every side.
CUT_SHARE = 0.5
# Thickness of a liner that is built into a cavity that the mesh has, as a share of its smallest side.
LINER_SHARE = 0.04


def apply_cavity_decisions(
    cavities: Sequence[Cavity],
    articulation: Articulation,
    mesh: WeldedMesh,
    decisions: Decisions,
    build: bool,
    least_sure: float,
) -> tuple[Cavity, ...]:
    """Return the cavities with the user's decisions applied.

    Args:
        mesh: in the frame. build: whether what is missing is built where nothing is said.
        least_sure: behind a front whose confidence is less, nothing is built where nothing is said.
    Raises:
        UnknownId: a cavity is named after a part that closes none.
    """
    names = [r.parts[0] for r in cavities]
    for name in decisions.cavities:
        if name not in names:
            raise UnknownId("cavity", name, names)
    out = []
    for cavity in cavities:
        decision = decisions.cavities.get(cavity.parts[0])
        cavity = _with_decision(cavity, decision, articulation, mesh) if decision is not None else cavity
        is_built = build if decision is None or decision.build is None else decision.build
        if not cavity.built:
            out.append(cavity)
        elif not is_built:
            out.append(cavity.replace(built=False, empty=True))
        else:
            front = min((p for p in articulation.parts if p.name in cavity.parts), key=lambda p: p.confidence)
            if (decision is None or decision.build is None) and front.confidence < least_sure:
                reason = f"not built: {front.name} is {front.confidence:.0%} sure"
                cavity = cavity.replace(built=False, empty=True, in_doubt=True, reason=reason)
            out.append(cavity)
    return tuple(out)


def _with_decision(cavity: Cavity, decision: CavityDecision, articulation: Articulation, mesh: WeldedMesh) -> Cavity:
    """Return one cavity with the user's changes."""
    changed = cavity
    if decision.build and not cavity.built:
        lower, upper = np.array(cavity.lower), np.array(cavity.upper)
        wall = LINER_SHARE * float((upper - lower).min())
        inner = np.array([lower[0] + wall, lower[1], lower[2] + wall]), upper - wall
        changed = cavity.replace(
            lower=to_vec3(inner[0]),
            upper=to_vec3(inner[1]),
            wall=wall,
            built=True,
            furnish=False,
            confidence=1.0,
            reason=GIVEN_REASON,
        )
    if (
        decision.interior is not None
        and decision.interior is not cavity.interior
        and cavity.interior is not InteriorKind.DRAWER
    ):
        changed = changed.replace(interior=decision.interior, confidence=1.0, reason=GIVEN_REASON)
    if decision.furnish is not None and decision.furnish is not cavity.furnish:
        changed = changed.replace(furnish=decision.furnish, confidence=1.0, reason=GIVEN_REASON)
    if decision.box_m is not None:
        changed = _with_box(changed, decision.box_m, articulation, mesh)
    return changed


def _with_box(cavity: Cavity, box: tuple[Vec3, Vec3], articulation: Articulation, mesh: WeldedMesh) -> Cavity:
    """Return a cavity between other corners, with walls as thick as before."""
    metres = articulation.frame.metres or 1.0
    corners = np.array(box) / metres + mesh.footprint_center
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    if float(np.abs(np.array([lower - cavity.lower, upper - cavity.upper])).max()) * metres <= LENGTH_TOLERANCE_M:
        return cavity
    grown = np.array(cavity.lower) - np.array(cavity.outer[0]), np.array(cavity.outer[1]) - np.array(cavity.upper)
    a, b = lower - np.maximum(grown[0], 0.0), upper + np.maximum(grown[1], 0.0)
    cut = cavity.cut
    if cut is not None:
        start = lower - CUT_SHARE * np.maximum(grown[0], 0.0)
        start[1] = cut[0][1]
        cut = (to_vec3(start), to_vec3(upper + CUT_SHARE * np.maximum(grown[1], 0.0)))
    return cavity.replace(
        lower=to_vec3(lower),
        upper=to_vec3(upper),
        outer=(to_vec3(a), to_vec3(b)),
        cut=cut,
        confidence=1.0,
        reason=GIVEN_REASON,
    )


# Hollow out -----------------------------------------------------------------------------------------------------------
# Cut holes into a solid body where cavities have to be, and remove what lies in them.

Box = tuple[Vec3, Vec3]

# Cut planes reach through whatever crosses a cavity, diagonals.
PLANE_EXTENT = 10.0


def hollow_out(
    model: RawModel, placed: WeldedMesh, articulation: Articulation, holes: Sequence[Box]
) -> tuple[RawModel, WeldedMesh, Articulation]:
    """Remove all of the body that lies in some boxes of the frame.

    Args:
        model: its faces, part by part, are those of `placed`.
    """
    if not holes:
        return model, placed, articulation
    body = np.ones(len(placed.faces), dtype=bool)
    for part in articulation.parts:
        body[part.faces] = False
    parts, parents = [], []
    start = 0
    for raw in model.parts:
        count = len(raw.mesh.faces)
        mesh, parent = _carved(raw.mesh, np.flatnonzero(body[start : start + count]), articulation.frame, holes)
        if len(parent):
            parts.append(raw.replace(mesh=mesh))
            parents.append(parent + start)
        start += count
    model = model.replace(parts=tuple(parts))
    kept = np.concatenate(parents)
    hollow = weld_model(model, by_material=False).in_frame(articulation.frame)
    return model, hollow, _renumbered(articulation, kept, len(placed.faces))


def _carved(mesh: Mesh, rows: Ints, frame: Frame, holes: Sequence[Box]) -> tuple[Mesh, Ints]:
    """Return a mesh without what lies in the boxes, and the face that each of its faces was part of."""
    parent = np.arange(len(mesh.faces))
    free = np.zeros(len(mesh.faces), dtype=bool)
    free[rows] = True
    for lower, upper in ((np.array(a), np.array(b)) for a, b in holes):
        place = (mesh.vertices - np.array(frame.origin)) @ frame.rotation.T * frame.scale
        corners = place[mesh.faces]
        near = free & ((corners.min(axis=1) < upper) & (corners.max(axis=1) > lower)).all(axis=1)
        if not near.any():
            continue
        least, most = np.full(3, -PLANE_EXTENT), np.full(3, PLANE_EXTENT)
        # A cut plane on the front counts right, up and depth: x, z and y.
        done = cut_triangles(
            place,
            mesh.faces[near].astype(np.int64),
            [
                CutPlane(FRONT, k, float(end[axis]), least, most)
                for k, axis in ((0, 0), (1, 2), (2, 1))
                for end in (lower, upper)
            ],
        )
        middle = done.interpolate(place)[done.faces].mean(axis=1)
        out = ~((middle > lower) & (middle < upper)).all(axis=1)
        faces = np.concatenate([mesh.faces[~near].astype(np.int64), done.faces[out]])
        mesh = done.interpolate_mesh(mesh, faces)
        cut = np.flatnonzero(near)[done.parent[out]]
        parent, free = np.concatenate([parent[~near], parent[cut]]), np.concatenate([free[~near], free[cut]])
    return mesh, parent


def _renumbered(articulation: Articulation, kept: Ints, count: int) -> Articulation:
    """Return the parts over the remaining faces; `kept` is the old index of each."""
    place = np.full(count, -1, dtype=np.int64)
    place[kept] = np.arange(len(kept))
    parts = tuple(p.replace(faces=place[p.faces], grip=place[p.grip]) for p in articulation.parts)
    return articulation.replace(parts=parts)
