"""Compute mass, centre of mass and inertia of an ingested mesh."""

from __future__ import annotations

import numpy as np

from casa_assets.core.rounding import significant
from casa_assets.core.typing import Floats
from casa_assets.geometry.mesh.measure import signed_volume, solid_moments
from casa_assets.geometry.solid.hull import convex_hull
from casa_assets.geometry.solid.manifold import Surface as ClosedSurface
from casa_assets.geometry.solid.manifold import closed_solid, union
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.ingest.draft import Draft, warning
from casa_assets.ingest.mass.estimates import combine_estimates, estimate_masses
from casa_assets.ingest.mass.unknown_kind import combine_unknown
from casa_assets.model.asset.asset import Inertial
from casa_assets.model.asset.material import Substance
from casa_assets.model.issue import Issue
from casa_assets.model.registry.category import FALLBACK, Category, MatterFill

# Smallest over largest variance of a body whose inertia stays valid when it is rounded to nine digits.
MIN_THICKNESS_RATIO = 1e-7
# Largest difference between the boxes of a mesh and of its closed part, as a share of the longest side, for that part
# to stand for all; a choice.
SAME_BOX_SHARE = 0.02
# Confidence below which there is a note; a choice.
DOUBTFUL_CONFIDENCE = 0.65


def mass(
    draft: Draft, category: Category, substance: Substance, agreement_ratio: float, override_kg: float = 0.0
) -> Draft:
    """Compute mass, centre of mass and inertia of the whole, asset frame.

    Args:
        draft: metres, with colliders.
        category: mass_kg is the prior and the range, build says what the volume means.
        substance: density of what it is made of.
        agreement_ratio: up to which two estimates agree, > 1.
        override_kg: as a person decided, 0 where nobody did.
    """
    points, faces = draft.surface.points, draft.surface.welded_faces
    solid = closed_solid(points, faces)
    volume, center, inertia, measured_over = _moments(draft, solid, category)
    notes: tuple[Issue, ...] = ()
    if override_kg > 0:
        kg, confidence, reason = override_kg, 1.0, "a person decided"
    else:
        if category.id == FALLBACK:
            combined = combine_unknown(points, faces, solid, draft.parts)
        else:
            estimates = estimate_masses(points, faces, solid, category, substance)
            combined = combine_estimates(estimates, category, agreement_ratio)
        kg, confidence, reason = combined.kg, combined.confidence, combined.message
        if confidence < DOUBTFUL_CONFIDENCE and category.id != FALLBACK:
            notes = (warning("MSH021", "mass", f"{kg:.3g} kg, but the estimates disagree: {reason}"),)
    kg = significant(kg, 6)
    tensor = _thick_enough(inertia) * (kg / volume)
    inertial = Inertial(
        mass=kg,
        center_of_mass=_vector(center),
        inertia=_unique_entries(tensor),
    )
    return draft.replace(
        inertial=inertial,
        guesses=draft.guessed("mass", f"{kg:.6g} kg, spread over {measured_over}", confidence, reason),
        notes=draft.noted(*notes),
    )


def _moments(draft: Draft, solid: ClosedSurface | None, category: Category) -> tuple[float, Floats, Floats, str]:
    """Volume, centre, inertia at density 1, and over what they were taken.

    Args:
        solid: of the mesh, where it is closed.
    """
    surfaces = [tessellate(p.shape, p.pose) for p in draft.colliders]
    hulls = union(surfaces) or convex_hull(np.concatenate([s[0] for s in surfaces]))
    if (
        solid is not None
        and category.build in (MatterFill.SOLID, MatterFill.VESSEL)
        and signed_volume(*solid) > 0.02 * signed_volume(*hulls)
        and _has_same_box(solid[0], draft.surface.points)
    ):
        return (*solid_moments(*solid), "the closed mesh")
    return (*solid_moments(*hulls), "the collision shapes")


def _has_same_box(solid: Floats, points: Floats) -> bool:
    """True if a solid has the bounding box of the mesh; that of a knife whose blade is a sheet is its handle only."""
    gap = np.abs([solid.min(axis=0) - points.min(axis=0), solid.max(axis=0) - points.max(axis=0)])
    return float(gap.max()) <= SAME_BOX_SHARE * float(np.ptp(points, axis=0).max())


def _thick_enough(inertia: Floats) -> Floats:
    """The inertia of a body that is thick enough for its tensor to stay valid when it is rounded."""
    variances, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    if variances[0] > MIN_THICKNESS_RATIO * variances[2]:
        return inertia
    covariance = (axes * np.maximum(variances, MIN_THICKNESS_RATIO * variances[2])) @ axes.T
    thickened: Floats = np.trace(covariance) * np.eye(3) - covariance
    return thickened


def _vector(values: Floats) -> tuple[float, float, float]:
    """The vector with nine digits, which the writers carry and which hide differences between machines."""
    x, y, z = (significant(v, 9) if abs(v) > 1e-9 else 0.0 for v in values)
    return (x, y, z)


def _unique_entries(tensor: Floats) -> tuple[float, float, float, float, float, float]:
    size = float(np.trace(tensor))
    picked = (tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2])
    a, b, c, d, e, f = (significant(v, 9) if abs(v) > 1e-9 * size else 0.0 for v in picked)
    return (a, b, c, d, e, f)
