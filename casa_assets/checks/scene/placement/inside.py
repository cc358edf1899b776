"""Find things that reach outside the room: beyond walls, below the floor, above the ceiling."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.spatial import ConvexHull

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.scene.placement.support import CEILING, FLOOR, ROOM, WALL
from casa_assets.checks.scene.subject import SceneSubject, boxes, corners
from casa_assets.core.typing import Floats

MM = 1000.0
DOOR, WINDOW = "door", "window"
HANDLES_M = 0.08  # how far handles and sills stand out of the outer face


def things_are_inside_room(subject: SceneSubject, limit: float | None) -> Measurement:
    """SCN009: farthest that a shape lies outside floor, walls and ceiling, metres.

    A scene without a floor has no room to leave. What fills a hole in a wall is handled from both sides.
    """
    assert limit is not None
    handled = dict.fromkeys((DOOR, WINDOW), HANDLES_M)
    kinds = {p.name: subject.category(p.name) for p in subject.scene.placements}
    plans = [
        _edges(subject, geom)
        for name, kind in kinds.items()
        if kind in (FLOOR, WALL)
        for geom in subject.geoms_of[name]
    ]
    if FLOOR not in kinds.values():
        return not_applicable("it has no floor, and so no room to leave")
    low, high = _heights(subject, kinds)
    worst, problems = 0.0, []
    for name, kind in kinds.items():
        if kind in ROOM:
            continue
        points = np.concatenate([points_of(subject, int(g)) for g in subject.geoms_of[name]])
        beside = float(np.min([_outside(edges, points) for edges in plans], axis=0).max())
        beside = max(0.0, beside - handled.get(kind, 0.0))
        out = {
            "beside the room": beside,
            "below the floor": low - points[:, 2].min(),
            "above the ceiling": points[:, 2].max() - high,
        }
        for where, far in out.items():
            worst = max(worst, float(far))
            if far > limit:
                problems.append((f"placements/{name}", f"reaches {far * MM:.0f} mm {where}; move it in"))
    return Measurement(worst, tuple(problems))


def points_of(subject: SceneSubject, geom: int) -> Floats:
    """(N, 3) vertices of a geom, or corners of the box around it, world frame, metres."""
    model, data = subject.model, subject.data
    mesh = int(model.geom_dataid[geom])
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
        if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_BOX:
            return corners(boxes(model, data, np.array([geom])))
        own = corners(np.array([[-model.geom_size[geom], model.geom_size[geom]]]))
    else:
        start, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        own = model.mesh_vert[start : start + count].astype(np.float64)
    found: Floats = own @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
    return found


def _edges(subject: SceneSubject, geom: int) -> Floats:
    """(N, 3) outward normals and offsets of the edges of a geom seen from above."""
    found: Floats = ConvexHull(points_of(subject, geom)[:, :2]).equations
    return found


def _outside(edges: Floats, points: Floats) -> Floats:
    """(N,) how far points are beyond the farthest edge, metres; 0 inside."""
    away: Floats = np.maximum(0.0, (points[:, :2] @ edges[:, :2].T + edges[:, 2]).max(axis=1))
    return away


def _heights(subject: SceneSubject, kinds: dict[str, str]) -> tuple[float, float]:
    """Underside of the floor and upper side of the ceiling, or of the walls where it has none; metres."""
    tops = {kind: [_span(subject, n)[1] for n, k in kinds.items() if k == kind] for kind in (CEILING, WALL)}
    low = min(_span(subject, n)[0] for n, k in kinds.items() if k == FLOOR)
    return low, max(tops[CEILING] or tops[WALL] or [np.inf])


def _span(subject: SceneSubject, name: str) -> tuple[float, float]:
    found = boxes(subject.model, subject.data, subject.geoms_of[name])
    return float(found[:, 0, 2].min()), float(found[:, 1, 2].max())
