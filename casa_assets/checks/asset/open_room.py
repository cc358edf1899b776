"""Find open rooms of what is seen that collision shapes fill or close off (AST018)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.asset.applicability import is_loose_mesh, merged_mesh
from casa_assets.checks.check import Measurement, largest, not_applicable
from casa_assets.geometry.grid.open_room import closed_shares, open_rooms
from casa_assets.geometry.mesh.topology import weld
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.model.asset.asset import Asset

NOT_LOOSE = "it did not come as one loose mesh; what is built or taken apart gives each part its own shapes"
NO_ROOM = "no open room takes a share of its hull that matters"


def open_rooms_stay_open(asset: Asset, limit: float) -> Measurement:
    """AST018: largest share of an open room that collision shapes fill or close off, 0..1, whatever the category.

    Rooms into which only the backs of faces look are gaps in a surface and do not count.
    """
    if not is_loose_mesh(asset):
        return not_applicable(NOT_LOOSE)
    link = asset.root
    if not link.visuals or not link.colliders:
        return not_applicable("it is not both seen and touched")
    vertices, faces = merged_mesh(link.visuals)
    used, compact = np.unique(faces, return_inverse=True)
    points, places = weld(vertices[used])
    rooms = open_rooms(points, places[compact.reshape(-1, 3)])
    kept = rooms.kept(with_gaps=False)
    if not kept:
        return not_applicable(NO_ROOM)
    shapes = [tessellate(c.shape, c.pose) for c in link.colliders]
    starts = np.cumsum([0, *(len(p) for p, _ in shapes)])
    shape_faces = np.concatenate([f + start for (_, f), start in zip(shapes, starts, strict=False)])
    shares = closed_shares(rooms, np.concatenate([p for p, _ in shapes]), shape_faces)
    message = "collision shapes fill or close off {:.0%} of an open room that takes {:.0%} of the hull; fit them again"
    problems = [
        (f"links/{link.name}/colliders", message.format(shares[k], rooms.shares[k])) for k in kept if shares[k] > limit
    ]
    return largest([shares[k] for k in kept], problems, NO_ROOM)
