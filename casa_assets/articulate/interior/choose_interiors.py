"""Apply user decisions on interiors: which cavities are built, and which stay as the mesh has them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.decisions import GIVEN_REASON, LENGTH_TOLERANCE_M, CavityDecision, Decisions
from casa_assets.articulate.plan import Articulation, Cavity, InteriorKind
from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.core.typing import Floats
from casa_assets.errors import UnknownId
from casa_assets.model.record import Vec3

# A room of one's own size takes away this much more of the body than itself, on every side, by its walls.
CUT_SHARE = 0.5
# A liner takes this part of the least side of a room that is lined all the same.
LINER_SHARE = 0.04


def apply_cavity_decisions(
    rooms: Sequence[Cavity], found: Articulation, soup: WeldedMesh, said: Decisions, build: bool
) -> tuple[Cavity, ...]:
    """Return the cavities with the user's decisions applied.

    Args:
        soup: in the frame. build: whether what is missing is built where nothing is said.
    Raises:
        UnknownId: a room is named after a part that closes none.
    """
    names = [r.parts[0] for r in rooms]
    for name in said.rooms:
        if name not in names:
            raise UnknownId("room", name, names)
    out = []
    for room in rooms:
        wanted = said.rooms.get(room.parts[0])
        room = _changed(room, wanted, found, soup) if wanted is not None else room
        chosen = build if wanted is None or wanted.build is None else wanted.build
        out.append(room if chosen or not room.built else room.replace(built=False, empty=True))
    return tuple(out)


def _changed(room: Cavity, wanted: CavityDecision, found: Articulation, soup: WeldedMesh) -> Cavity:
    """Return one cavity with the user's changes."""
    changed = room
    if wanted.build and not room.built:
        changed = _lined(room)
    if wanted.filling is not None and wanted.filling is not room.filling and room.filling is not InteriorKind.DRAWER:
        changed = changed.replace(filling=wanted.filling, confidence=1.0, reason=GIVEN_REASON)
    if wanted.furnish is not None and wanted.furnish is not room.furnish:
        changed = changed.replace(furnish=wanted.furnish, confidence=1.0, reason=GIVEN_REASON)
    if wanted.box_m is not None:
        changed = _boxed(changed, wanted.box_m, found, soup)
    return changed


def _lined(room: Cavity) -> Cavity:
    """Return a cavity of the mesh with walls to be built inside its own."""
    low, high = np.array(room.low), np.array(room.high)
    wall = LINER_SHARE * float((high - low).min())
    inner = np.array([low[0] + wall, low[1], low[2] + wall]), high - wall
    return room.replace(
        low=_vec(inner[0]),
        high=_vec(inner[1]),
        wall=wall,
        built=True,
        furnish=False,
        confidence=1.0,
        reason=GIVEN_REASON,
    )


def _boxed(room: Cavity, box: tuple[Vec3, Vec3], found: Articulation, soup: WeldedMesh) -> Cavity:
    """Return a cavity between other corners, with walls as thick as before."""
    metres = found.frame.metres or 1.0
    corners = np.array(box) / metres + asset_origin(soup)
    low, high = corners.min(axis=0), corners.max(axis=0)
    if float(np.abs(np.array([low - room.low, high - room.high])).max()) * metres <= LENGTH_TOLERANCE_M:
        return room
    grown = np.array(room.low) - np.array(room.outer[0]), np.array(room.outer[1]) - np.array(room.high)
    a, b = low - np.maximum(grown[0], 0.0), high + np.maximum(grown[1], 0.0)
    cut = room.cut
    if cut is not None:
        start = low - CUT_SHARE * np.maximum(grown[0], 0.0)
        start[1] = cut[0][1]
        cut = (_vec(start), _vec(high + CUT_SHARE * np.maximum(grown[1], 0.0)))
    return room.replace(
        low=_vec(low), high=_vec(high), outer=(_vec(a), _vec(b)), cut=cut, confidence=1.0, reason=GIVEN_REASON
    )


def asset_origin(soup: WeldedMesh) -> Floats:
    """Return the (3,) origin of the asset in the frame: under the middle, on the ground."""
    low, high = soup.points.min(axis=0), soup.points.max(axis=0)
    return np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])


def _vec(values: Floats) -> Vec3:
    """Return three numbers."""
    x, y, z = (float(v) for v in values)
    return (x, y, z)
