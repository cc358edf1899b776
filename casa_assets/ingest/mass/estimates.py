"""Estimate mass in four ways: volume, skin of the hull, walls of usual thickness, the usual mass at this size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import exp, log

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.grid.voxel import voxelise
from casa_assets.geometry.mesh.measure import face_normals, signed_volume
from casa_assets.geometry.solid.hull import convex_hull
from casa_assets.model.asset.material import Substance
from casa_assets.model.registry.category import Category, MatterFill, RestingPose

# Usual walls of household things, metres: a mug 3.5 to 5 mm, drinking glasses 2 to 3 mm, pots 0.8 to 3 mm, moulded
# plastic 1.5 to 2.5 mm. Our estimates, good to a third; what is not here is no material that walls are made of.
WALL_THICKNESS_M: Mapping[str, float] = {
    "aluminium": 0.0025,
    "bamboo": 0.005,
    "brass": 0.0015,
    "cardboard": 0.001,
    "cast_iron": 0.004,
    "ceramic": 0.0045,
    "copper": 0.0015,
    "glass": 0.003,
    "hard_plastic": 0.0022,
    "leather": 0.002,
    "paper": 0.0005,
    "plastic": 0.0018,
    "porcelain": 0.0032,
    "rubber": 0.003,
    "silicone": 0.0025,
    "stainless_steel": 0.001,
    "steel": 0.0012,
    "stone": 0.012,
    "textile": 0.003,
    "wood": 0.01,
}
# Substances whose density is that of the whole thing, air and all.
BULK_DENSITY_SUBSTANCES = frozenset({"water_filled", "dry_goods", "electronics", "mixed", "unknown"})
# Matter that fills less than this share of what it outlines, in a thing that is full, is a shell that stands for it.
SHELL_SHARE = 0.6
# An open surface with more area than this, over that of its hull, has an inner wall and an outer one.
DOUBLE_WALL_AREA_RATIO = 1.25
# Share of its hull that a full thing fills, and how far that goes; less is known of what is long and bent.
CONVEX, CONVEX_SPREAD, BENT_SPREAD = 0.9, 0.25, 0.6


class EstimateMethod(StrEnum):
    """Method of an estimate."""

    MATTER = "matter"
    HULL = "hull"
    SHELL = "shell"
    USUAL = "usual"


@dataclass(frozen=True)
class Estimate:
    """One mass, kg, with its spread (log) and how it was made."""

    way: EstimateMethod
    kg: float
    spread: float
    message: str


@dataclass(frozen=True)
class CombinedMass:
    """Mass after combining estimates, kg; confidence 0..1; the largest ratio between two; all in words."""

    kg: float
    confidence: float
    ratio: float
    message: str


def estimates(
    points: Floats, faces: Ints, solid: tuple[Floats, Ints] | None, category: Category, substance: Substance
) -> list[Estimate]:
    """All estimates that apply.

    Args:
        points: (P, 3) welded, metres, z up. faces: (F, 3). solid: `closed_solid` of them.
        category: how matter fills it, and its usual size and mass. substance: what it is made of.
    """
    shell = convex_hull(points)
    area, skin = float(face_normals(points, faces)[1].sum()), float(face_normals(*shell)[1].sum())
    found = []
    for one in (
        _matter(points, faces, solid, category, substance),
        _hull(signed_volume(*shell), skin, category, substance),
        _shell(area, skin, solid is not None, category, substance),
        _usual(np.ptp(points, axis=0), category),
    ):
        if one is not None and np.isfinite(one.kg) and one.kg > 0:
            found.append(one)
    return found


def _matter(
    points: Floats, ids: Ints, solid: tuple[Floats, Ints] | None, category: Category, substance: Substance
) -> Estimate | None:
    density = substance.density
    inside = None if solid is None else signed_volume(*solid)
    if category.build is MatterFill.VESSEL:
        if inside is None:
            return None
        return Estimate(EstimateMethod.MATTER, inside * density, 0.25, f"{inside * 1e6:.4g} cm^3 of walls")
    if category.build is MatterFill.HOLLOW and substance.id not in BULK_DENSITY_SUBSTANCES:
        return None
    outline = voxelise(points, ids, bridge=True).volume
    if category.build is MatterFill.SOLID and inside is not None and inside > SHELL_SHARE * outline:
        return Estimate(
            EstimateMethod.MATTER, inside * density, 0.12, f"{inside * 1e6:.4g} cm^3 within the closed mesh"
        )
    spread = 0.3 if category.build is MatterFill.SOLID else 0.4
    return Estimate(EstimateMethod.MATTER, outline * density, spread, f"{outline * 1e6:.4g} cm^3 within the outline")


def _hull(volume: float, skin: float, category: Category, substance: Substance) -> Estimate | None:
    if category.build in (MatterFill.SOLID, MatterFill.FILLED) or substance.id in BULK_DENSITY_SUBSTANCES:
        spread = BENT_SPREAD if category.upright is RestingPose.LIES else CONVEX_SPREAD
        kg = CONVEX * volume * substance.density
        return Estimate(
            EstimateMethod.HULL,
            kg,
            spread + 0.1 * (category.build is not MatterFill.SOLID),
            f"hull {volume * 1e6:.4g} cm^3",
        )
    wall = WALL_THICKNESS_M.get(substance.id)
    if wall is None:
        return None
    return Estimate(
        EstimateMethod.HULL, skin * wall * substance.density, 0.5, f"skin of the hull {skin * 1e4:.4g} cm^2"
    )


def _shell(area: float, skin: float, closed: bool, category: Category, substance: Substance) -> Estimate | None:
    wall = WALL_THICKNESS_M.get(substance.id)
    if wall is None or category.build in (MatterFill.SOLID, MatterFill.FILLED):
        return None
    one_side = area / 2 if closed or area > DOUBLE_WALL_AREA_RATIO * skin else area
    spread = 0.35 if category.build is MatterFill.VESSEL else 0.6
    message = f"{one_side * 1e4:.4g} cm^2 of {substance.id} {1000 * wall:.2g} mm thick"
    return Estimate(EstimateMethod.SHELL, one_side * wall * substance.density, spread, message)


def _usual(extents: Floats, category: Category) -> Estimate:
    box = float(np.maximum(extents, 1e-9).prod())
    typical = float(np.prod([side.typical for side in category.extents]))
    grows = 1.0 if category.build in (MatterFill.SOLID, MatterFill.FILLED) else 2 / 3
    span = category.mass_kg
    kg = float(np.clip(span.typical * (box / typical) ** grows, span.low, span.high))
    spread = max(log(span.high / span.low) / 4, 0.2)
    return Estimate(EstimateMethod.USUAL, kg, spread, f"usual for a {category.id} of this size")


def combine_estimates(found: Sequence[Estimate], category: Category, agree: float) -> CombinedMass:
    """Combine estimates into one mass within the range of the category.

    What was measured counts as it is where it is usual and the others bear it out; else all are weighed by how far
    each can be trusted.

    Args:
        found: at least the usual one. agree: ratio up to which two estimates say the same.
    """
    by = {e.way: e for e in found}
    span, matter = category.mass_kg, by.get(EstimateMethod.MATTER)
    usual_mass = matter is not None and span.low <= matter.kg <= span.high
    # A measured mass within the usual range need not be that of the average one.
    ratio = _disagreement([e for e in found if e.way is not EstimateMethod.USUAL or not usual_mass])
    if matter is not None and usual_mass and category.build is not MatterFill.HOLLOW and ratio <= agree:
        kg = matter.kg
    else:
        weights = [1 / e.spread**2 for e in found]
        kg = exp(sum(w * log(e.kg) for w, e in zip(weights, found, strict=True)) / sum(weights))
    kept = min(max(kg, span.low), span.high)
    message = "; ".join(f"{e.way} {e.kg:.3g} kg ({e.message})" for e in found)
    if kept != kg:
        message += f"; a {category.id} weighs {span.low:g} to {span.high:g} kg"
    confidence = 0.9 if ratio <= 1.5 else 0.75 if ratio <= agree else 0.55 if ratio <= agree**1.6 else 0.35
    if kept != kg:
        confidence = min(confidence, 0.55 if max(kg / kept, kept / kg) < agree else 0.35)
    if category.id == "object":
        confidence = min(confidence, 0.2)
    return CombinedMass(kept, confidence, ratio, message)


def _disagreement(found: Sequence[Estimate]) -> float:
    """Largest ratio between two estimates, each brought nearer by one standard deviation of the less sure one."""
    worst = 1.0
    for i, one in enumerate(found):
        for other in found[i + 1 :]:
            gap = abs(log(one.kg / other.kg)) - max(0.0, max(one.spread, other.spread) - 0.25)
            worst = max(worst, exp(gap))
    return worst
