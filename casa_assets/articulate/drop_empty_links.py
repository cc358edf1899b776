"""Drop parts that no surface belongs to: a link of an asset has to have something that is seen and that weighs."""

from __future__ import annotations

from casa_assets.articulate.plan import Articulation, PartPlan
from casa_assets.articulate.segment.welded_mesh import WeldedMesh


def drop_empty_links(articulation: Articulation, mesh: WeldedMesh) -> Articulation:
    """Return the articulation without parts that have no area, and with a body that has some.

    A part loses its faces where another one takes them, or where cuts along its border leave none. Where all faces
    belong to parts, the largest of those that hang on the body is the body. What a dropped part carried hangs on what
    carried that part.

    Args:
        mesh: in the frame; the faces of the parts are those of this mesh.
    """
    area = {part.name: float(mesh.areas[part.faces].sum()) for part in articulation.parts}
    parts = _without(articulation.parts, {name for name, share in area.items() if share <= 0.0})
    owner = articulation.replace(parts=parts).face_owner(len(mesh.faces))
    if parts and float(mesh.areas[owner < 0].sum()) <= 0.0:
        largest = max((p for p in parts if not p.parent), key=lambda p: area[p.name])
        parts = _without(parts, {largest.name})
    return articulation if len(parts) == len(articulation.parts) else articulation.replace(parts=parts)


def _without(parts: tuple[PartPlan, ...], names: set[str]) -> tuple[PartPlan, ...]:
    """Return parts without some of them; their children hang on the nearest part that is left, else on the body."""
    carrier = {part.name: part.parent for part in parts}

    def kept_carrier(name: str) -> str:
        while name in names:
            name = carrier[name]
        return name

    return tuple(p.replace(parent=kept_carrier(p.parent)) for p in parts if p.name not in names)
