"""Drop parts that no surface belongs to: a link of an asset has to have something that is seen and that weighs."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.plan import Articulation, FaceIndex, PartPlan
from casa_assets.articulate.segment.welded_mesh import WeldedMesh


def drop_empty_links(articulation: Articulation, mesh: WeldedMesh) -> Articulation:
    """Return the articulation without parts that have no area, and with a body that has some.

    A face that two parts claim belongs to the later one. A part loses all faces if others take them, or if cuts along
    its border leave it without any. If all faces belong to parts, the largest part on the body becomes the body. Parts
    carried by a dropped part are then carried by the parent of that part.

    Args:
        mesh: in the frame; the faces of the parts are those of this mesh.
    """
    owner = articulation.face_owner(len(mesh.faces))
    parts = tuple(_with_own_faces(part, np.flatnonzero(owner == i)) for i, part in enumerate(articulation.parts))
    area = {part.name: float(mesh.areas[part.faces].sum()) for part in parts}
    parts = _without(parts, {name for name, share in area.items() if share <= 0.0})
    if parts and float(mesh.areas[owner < 0].sum()) <= 0.0:
        largest = max((p for p in parts if not p.parent), key=lambda p: area[p.name])
        parts = _without(parts, {largest.name})
    return articulation.replace(parts=parts)


def _with_own_faces(part: PartPlan, own: FaceIndex) -> PartPlan:
    """Return a part with the faces that no later part takes."""
    if len(own) == len(np.unique(part.faces)):
        return part
    return part.replace(faces=own, grip=np.intersect1d(part.grip, own))


def _without(parts: tuple[PartPlan, ...], names: set[str]) -> tuple[PartPlan, ...]:
    """Return parts without some of them; their children hang on the nearest part that is left, else on the body."""
    carrier = {part.name: part.parent for part in parts}

    def kept_carrier(name: str) -> str:
        while name in names:
            name = carrier[name]
        return name

    return tuple(p.replace(parent=kept_carrier(p.parent)) for p in parts if p.name not in names)
