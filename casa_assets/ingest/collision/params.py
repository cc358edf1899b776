"""Limits that collision shapes are held to."""

from __future__ import annotations

from casa_assets.model.record import Record


class CollideParams(Record):
    """Limits of the stage.

    Attributes:
        hull_count: most shapes. hull_vertices: most vertices of a hull.
        primitive_ratio: smallest share of a primitive that the hull has to fill.
        hull_ratio: smallest share of the hull that the mesh has to fill for one shape.
        error_m: distance from the shapes up to which the mesh counts as covered.
        box_m, box_ratio: how far the boxes around shapes and mesh may be apart: metres, and where that is more a share
            of the longest side (AST009).
        closed_share: largest share of an open room that shapes may fill or close off (AST018).
    """

    hull_count: int = 32
    hull_vertices: int = 64
    primitive_ratio: float = 0.95
    hull_ratio: float = 0.95
    error_m: float = 0.004
    box_m: float = 0.004
    box_ratio: float = 0.02
    closed_share: float = 0.35

    def box_bound(self, longest: float) -> float:
        """How far the bounding box of the shapes may be from that of a mesh of this longest side, metres."""
        return max(self.box_m, self.box_ratio * longest)
