"""Apply user decisions on interiors: which cavities are built, and which stay as the mesh has them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.decisions import GIVEN_REASON, LENGTH_TOLERANCE_M, CavityDecision, Decisions
from casa_assets.articulate.plan import Articulation, Cavity, InteriorKind
from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.articulate.vectors import to_vec3
from casa_assets.errors import UnknownId
from casa_assets.model.record import Vec3

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
        elif decision is None or decision.build is None:
            out.append(_unless_in_doubt(cavity, articulation, least_sure))
        else:
            out.append(cavity)
    return tuple(out)


def _unless_in_doubt(cavity: Cavity, articulation: Articulation, least_sure: float) -> Cavity:
    """Return a cavity that is to be built, as one that is left closed where one of its fronts is not sure enough."""
    front = min((p for p in articulation.parts if p.name in cavity.parts), key=lambda p: p.confidence)
    if front.confidence >= least_sure:
        return cavity
    reason = f"not built: {front.name} is {front.confidence:.0%} sure"
    return cavity.replace(built=False, empty=True, in_doubt=True, reason=reason)


def _with_decision(cavity: Cavity, decision: CavityDecision, articulation: Articulation, mesh: WeldedMesh) -> Cavity:
    """Return one cavity with the user's changes."""
    changed = cavity
    if decision.build and not cavity.built:
        changed = _with_liner(cavity)
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


def _with_liner(cavity: Cavity) -> Cavity:
    """Return a cavity of the mesh with walls to be built inside its own."""
    lower, upper = np.array(cavity.lower), np.array(cavity.upper)
    wall = LINER_SHARE * float((upper - lower).min())
    inner = np.array([lower[0] + wall, lower[1], lower[2] + wall]), upper - wall
    return cavity.replace(
        lower=to_vec3(inner[0]),
        upper=to_vec3(inner[1]),
        wall=wall,
        built=True,
        furnish=False,
        confidence=1.0,
        reason=GIVEN_REASON,
    )


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
