"""Estimate mass by volume, by the hull, by walls of usual thickness and by the usual mass; combine the estimates."""

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

# Usual thickness of walls of household objects, metres: mugs 3.5 to 5 mm, drinking glasses 2 to 3 mm, pots 0.8 to 3 mm,
# moulded plastic 1.5 to 2.5 mm. Our estimates, good to a third. Substances that walls are not made of are not listed.
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
# Substances whose density is the mean over the whole object, with the air in it. Of those but water that mean differs
# by a factor of twenty (popcorn, a candy bar), so it is told from the usual size and mass of the category.
BULK_DENSITY_SUBSTANCES = frozenset({"water_filled", "dry_goods", "electronics", "mixed", "sponge_foam", "unknown"})
# Mass of such things over the volume to this power, a fit over the categories of the registry: a larger package or
# machine holds more air.
BULK_EXPONENT = 0.8
# Spread of what is told by the volume of such things, from which on it is an estimate among others; a choice.
VAGUE, SURE_OF_VAGUE = 0.5, 0.8
# Share of the box around a thing of its usual size that its outline fills; choices.
OUTLINE_FILL = {MatterFill.FILLED: 0.85, MatterFill.SOLID: 0.6, MatterFill.HOLLOW: 0.7}
# How often the usual mass counts where all estimates together are no mass that the category has; a choice.
USUAL_COUNTS = 2
# A closed mesh of something solid that fills less than this share of its outline is only its shell; a choice.
SHELL_SHARE = 0.6
# An open surface with more area than this, over that of its hull, has an inner and an outer wall; a choice.
DOUBLE_WALL_AREA_RATIO = 1.25
# Share of its hull that something solid fills, and the spread of that (log), which is larger for long and bent things;
# choices.
HULL_FILL, HULL_FILL_SPREAD, BENT_FILL_SPREAD = 0.9, 0.25, 0.6

# How sure a mass is whose estimates differ by up to the agreed ratio to the power of the first number, and beyond.
SURE = ((0.6, 0.9), (1.0, 0.85), (1.6, 0.75))
UNSURE = 0.6
# Ratio to the nearer end of a category's range from which on the estimates speak of another thing, or another size.
FAR_OFF = 5.0


class EstimateMethod(StrEnum):
    """Method of an estimate."""

    MATTER = "matter"
    HULL = "hull"
    SHELL = "shell"
    USUAL = "usual"


@dataclass(frozen=True)
class Estimate:
    """One mass, kg, with its spread (standard deviation of the logarithm), its method and its numbers in words."""

    method: EstimateMethod
    kg: float
    spread: float
    message: str


@dataclass(frozen=True)
class CombinedMass:
    """Mass after combining estimates, kg.

    Attributes:
        confidence: 0..1. ratio: largest ratio between two estimates. message: all estimates in words.
    """

    kg: float
    confidence: float
    ratio: float
    message: str


def estimate_masses(
    points: Floats, faces: Ints, solid: tuple[Floats, Ints] | None, category: Category, substance: Substance
) -> list[Estimate]:
    """All estimates that apply.

    Args:
        points: (P, 3) welded, metres, z up. faces: (F, 3). solid: `closed_solid` of them.
        category: how much of it is solid, and its usual size and mass. substance: what it is made of.
    """
    hull = convex_hull(points)
    surface_area, hull_area = float(face_normals(points, faces)[1].sum()), float(face_normals(*hull)[1].sum())
    out = []
    for estimate in (
        _by_volume(points, faces, solid, category, substance),
        _by_hull(hull, hull_area, category, substance),
        _by_walls(surface_area, hull_area, solid is not None, category, substance),
        _by_usual_mass(np.ptp(points, axis=0), category),
    ):
        if estimate is not None and np.isfinite(estimate.kg) and estimate.kg > 0:
            out.append(estimate)
    return out


def _by_volume(
    points: Floats, ids: Ints, solid: tuple[Floats, Ints] | None, category: Category, substance: Substance
) -> Estimate | None:
    density = _density(np.ptp(points, axis=0), category, substance)
    solid_volume = None if solid is None else signed_volume(*solid)
    if category.build is MatterFill.VESSEL:
        if solid_volume is None:
            return None
        return Estimate(EstimateMethod.MATTER, solid_volume * density, 0.25, f"{solid_volume * 1e6:.4g} cm^3 of walls")
    if category.build is MatterFill.HOLLOW and substance.id not in BULK_DENSITY_SUBSTANCES:
        return None
    outline_volume = voxelise(points, ids, bridge=True).volume
    if category.build is MatterFill.SOLID and solid_volume is not None and solid_volume > SHELL_SHARE * outline_volume:
        return Estimate(
            EstimateMethod.MATTER, solid_volume * density, 0.12, f"{solid_volume * 1e6:.4g} cm^3 within the closed mesh"
        )
    spread = VAGUE if _is_bulk(category, substance) else 0.3 if category.build is MatterFill.SOLID else 0.4
    return Estimate(
        EstimateMethod.MATTER, outline_volume * density, spread, f"{outline_volume * 1e6:.4g} cm^3 within the outline"
    )


def _is_bulk(category: Category, substance: Substance) -> bool:
    """True if the category determines the density."""
    return substance.id in BULK_DENSITY_SUBSTANCES - {"water_filled"} and category.build in OUTLINE_FILL


def _density(extents: Floats, category: Category, substance: Substance) -> float:
    """Density in kg/m^3 of the volume of a full or solid thing, with the air in it."""
    if not _is_bulk(category, substance):
        return substance.density
    typical_volume = float(np.prod([side.typical for side in category.extents]))
    larger = float(np.maximum(extents, 1e-9).prod()) / typical_volume
    air: float = larger ** (BULK_EXPONENT - 1)
    return category.mass_kg.typical / (OUTLINE_FILL[category.build] * typical_volume) * air


def _by_hull(hull: tuple[Floats, Ints], hull_area: float, category: Category, substance: Substance) -> Estimate | None:
    volume = signed_volume(*hull)
    if category.build in (MatterFill.SOLID, MatterFill.FILLED) or substance.id in BULK_DENSITY_SUBSTANCES:
        spread = BENT_FILL_SPREAD if category.upright is RestingPose.LIES else HULL_FILL_SPREAD
        kg = HULL_FILL * volume * _density(np.ptp(hull[0], axis=0), category, substance)
        return Estimate(
            EstimateMethod.HULL,
            kg,
            spread + 0.1 * (category.build is not MatterFill.SOLID),
            f"hull {volume * 1e6:.4g} cm^3",
        )
    wall_m = WALL_THICKNESS_M.get(substance.id)
    if wall_m is None:
        return None
    return Estimate(
        EstimateMethod.HULL, hull_area * wall_m * substance.density, 0.5, f"skin of the hull {hull_area * 1e4:.4g} cm^2"
    )


def _by_walls(
    surface_area: float, hull_area: float, is_closed: bool, category: Category, substance: Substance
) -> Estimate | None:
    wall_m = WALL_THICKNESS_M.get(substance.id)
    if wall_m is None or category.build in (MatterFill.SOLID, MatterFill.FILLED):
        return None
    one_side_area = surface_area / 2 if is_closed or surface_area > DOUBLE_WALL_AREA_RATIO * hull_area else surface_area
    spread = 0.35 if category.build is MatterFill.VESSEL else 0.6
    message = f"{one_side_area * 1e4:.4g} cm^2 of {substance.id} {1000 * wall_m:.2g} mm thick"
    return Estimate(EstimateMethod.SHELL, one_side_area * wall_m * substance.density, spread, message)


def _by_usual_mass(extents: Floats, category: Category) -> Estimate:
    box_volume = float(np.maximum(extents, 1e-9).prod())
    typical_volume = float(np.prod([side.typical for side in category.extents]))
    exponent = 1.0 if category.build in (MatterFill.SOLID, MatterFill.FILLED) else 2 / 3
    mass_range = category.mass_kg
    spread = max(log(mass_range.high / mass_range.low) / 4, 0.2)
    # A thing that is larger than usual is heavier, the less so the nearer it comes to the heaviest of its kind.
    beyond = exponent * log(box_volume / typical_volume)
    room = log(mass_range.high / mass_range.typical if beyond > 0 else mass_range.typical / mass_range.low)
    kg = mass_range.typical * exp(beyond / (1 + abs(beyond) / room)) if room > 0 else mass_range.typical
    return Estimate(EstimateMethod.USUAL, kg, spread, f"usual for a {category.id} of this size")


def combine_estimates(estimates: Sequence[Estimate], category: Category, agreement_ratio: float) -> CombinedMass:
    """Combine estimates into one mass.

    The mass by volume is taken as it is if it is usual for the category and the others agree with it. Otherwise the
    result is the mean of the logarithms of all estimates, weighted by the inverse squares of their spreads. If that
    mean lies outside the mass range of the category, it counts one third, and the usual mass of an object of this size
    two thirds; if the result is still outside, volumes and walls are ignored and the usual mass is taken. The
    confidence is low if the mean lies outside.

    Args:
        estimates: at least the usual one. agreement_ratio: up to which two estimates agree, > 1.
    """
    by_method = {e.method: e for e in estimates}
    mass_range, measured = category.mass_kg, by_method.get(EstimateMethod.MATTER)
    is_usual = measured is not None and mass_range.low <= measured.kg <= mass_range.high
    is_vague = measured is not None and measured.spread >= VAGUE
    # A measured mass within the usual range need not agree with the typical mass.
    ratio = _disagreement([e for e in estimates if e.method is not EstimateMethod.USUAL or not is_usual])
    counts = is_usual and not is_vague and category.build is not MatterFill.HOLLOW
    if measured is not None and counts and ratio <= agreement_ratio:
        kg = measured.kg
    else:
        weights = [1 / e.spread**2 for e in estimates]
        kg = exp(sum(w * log(e.kg) for w, e in zip(weights, estimates, strict=True)) / sum(weights))
    message = "; ".join(f"{e.method} {e.kg:.3g} kg ({e.message})" for e in estimates)
    off = mass_range.beyond(kg)
    if off > 1:
        message += f"; together {kg:.3g} kg, but a {category.id} weighs {mass_range.low:g} to {mass_range.high:g} kg"
        usual = by_method[EstimateMethod.USUAL].kg
        kg = exp((log(kg) + USUAL_COUNTS * log(usual)) / (1 + USUAL_COUNTS))
        if not mass_range.low <= kg <= mass_range.high:
            kg = usual
    confidence = next((sure for most, sure in SURE if ratio <= agreement_ratio**most), UNSURE)
    if is_vague:
        confidence = min(confidence, SURE_OF_VAGUE)
    if off > 1:  # things of one kind differ less in mass than volumes and walls of their meshes do
        confidence = min(confidence, 0.7 if off < agreement_ratio else 0.6 if off < FAR_OFF else 0.4)
    return CombinedMass(kg, confidence, ratio, message)


def _disagreement(estimates: Sequence[Estimate]) -> float:
    """Largest ratio between two estimates, reduced by what the larger of their spreads explains."""
    worst = 1.0
    for i, first in enumerate(estimates):
        for second in estimates[i + 1 :]:
            log_gap = abs(log(first.kg / second.kg)) - max(0.0, max(first.spread, second.spread) - 0.25)
            worst = max(worst, exp(log_gap))
    return worst
