"""Find things that reach outside the room: beyond walls, below the floor, above the ceiling."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from casa_assets.checks.check import Measurement, not_applicable
from casa_assets.checks.motion.simulation import box_around, geom_boxes, turned_vertices_of, vertices_of
from casa_assets.checks.scene.placement.support import CEILING, FLOOR, RECESS, ROOM, WALL
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.core.typing import Floats

MM_PER_M = 1000.0
# How far handles and sills of doors and windows may stand out of the outer face of a wall, metres.
ALLOWED_BESIDE_M = {"door": 0.08, "window": 0.08}


def things_are_inside_room(subject: SceneSubject, limit: float) -> Measurement:
    """SCN009: farthest that a shape lies outside floor, walls and ceiling, metres."""
    categories = {p.name: subject.category(p.name) for p in subject.scene.placements}
    if FLOOR not in categories.values():
        return not_applicable("it has no floor, and so no room to leave")
    outlines = [
        # Normals and offsets of the edges of a floor or wall seen from above.
        ConvexHull(vertices_of(subject.model, subject.data, int(geom))[:, :2]).equations
        for name, category in categories.items()
        if category in (FLOOR, WALL, RECESS)
        for geom in subject.geoms_of[name]
    ]
    low, high = _heights(subject, categories)
    worst, problems = 0.0, []
    for name, category in categories.items():
        if category in ROOM:
            continue
        geoms = subject.geoms_of[name]
        points = np.concatenate([turned_vertices_of(subject.model, subject.data, int(g)) for g in geoms])
        beside = float(np.min([_distance_outside(edges, points) for edges in outlines], axis=0).max())
        distances = {
            "beside the room": max(0.0, beside - ALLOWED_BESIDE_M.get(category, 0.0)),
            "below the floor": low - points[:, 2].min(),
            "above the ceiling": points[:, 2].max() - high,
        }
        for where, distance in distances.items():
            worst = max(worst, float(distance))
            if distance > limit:
                message = f"reaches {distance * MM_PER_M:.0f} mm {where}; move it in"
                problems.append((f"placements/{name}", message))
    return Measurement(worst, tuple(problems))


def _distance_outside(edges: Floats, points: Floats) -> Floats:
    """(N,) how far points are beyond the farthest edge, metres; 0 inside."""
    distances: Floats = np.maximum(0.0, (points[:, :2] @ edges[:, :2].T + edges[:, 2]).max(axis=1))
    return distances


def _heights(subject: SceneSubject, categories: dict[str, str]) -> tuple[float, float]:
    """Underside of the floor and upper side of the ceiling, or of the walls where it has none; metres."""

    def z_ranges(category: str) -> list[Floats]:
        names = [name for name, of in categories.items() if of == category]
        return [box_around(geom_boxes(subject.model, subject.data, subject.geoms_of[n]))[:, 2] for n in names]

    tops = [float(z[1]) for z in z_ranges(CEILING) or z_ranges(WALL)]
    return min(float(z[0]) for z in z_ranges(FLOOR)), max(tops, default=np.inf)
