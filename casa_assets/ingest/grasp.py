"""Choose where a hand takes an ingested mesh."""

from __future__ import annotations

from casa_assets.geometry.mesh.hand_grasps import choose_grasps
from casa_assets.ingest.draft import Draft
from casa_assets.model.registry.category import Category


def grasp(draft: Draft, category: Category, opening_m: float) -> Draft:
    """The best grasp of each kind that is possible.

    Args:
        draft: metres, z up, as it rests, with its mass.
        category: vessels have a rim; some categories have a handle.
        opening_m: largest opening of the gripper.
    """
    assert draft.inertial is not None, "the mass stage ran"
    surface, center = draft.surface, draft.inertial.center_of_mass
    return draft.replace(grasps=choose_grasps(surface.points, surface.welded_faces, center, category, opening_m))
