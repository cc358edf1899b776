"""Compute mass, centre of mass and inertia: by volume, hull, walls and usual mass, which are combined."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import exp, log
from typing import Literal

import numpy as np

from casa_assets.core.numeric import Floats, Ints, significant
from casa_assets.ingest.draft import Draft, warning
from casa_assets.ingest.up_axis import rain_volume
from casa_assets.mesh.solid.deviation import surface_samples
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.solid.solids import Surface as ClosedSurface
from casa_assets.mesh.solid.solids import closed_solid, convex_hull, hull_volume, union
from casa_assets.mesh.surface import face_normals, signed_volume, solid_moments
from casa_assets.mesh.voxels import voxelise
from casa_assets.model.asset.asset import Inertial
from casa_assets.model.asset.material import Substance
from casa_assets.model.issue import Issue
from casa_assets.model.registry.category import FALLBACK, Category, MatterFill, RestingPose
from casa_assets.model.source import RawPart

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
# by a factor of twenty (popcorn, a candy bar), so it follows from the usual size and mass of the category.
BULK_DENSITY_SUBSTANCES = frozenset({"water_filled", "dry_goods", "electronics", "mixed", "sponge_foam", "unknown"})
# Mass of such things over the volume to this power, a fit over the categories: what is larger holds more air.
BULK_EXPONENT = 0.8
# Spread of the estimate by volume of such things, from which on it is an estimate among others; a choice.
VAGUE, SURE_OF_VAGUE = 0.5, 0.8
# Share of the box around a thing of its usual size that its outline fills; choices.
OUTLINE_FILL = {MatterFill.FILLED: 0.85, MatterFill.SOLID: 0.6, MatterFill.HOLLOW: 0.7}
# How often the usual mass counts where all estimates together are no mass that the category has; a choice.
USUAL_COUNTS = 2
# A closed mesh of something solid that fills less than this share of its outline is only its shell; a choice.
SHELL_SHARE = 0.6
# An open surface with more area than this, over that of its hull, has an inner and an outer wall; a choice.
DOUBLE_WALL_AREA_RATIO = 1.25
# Share of its hull that something solid fills, and the spread of that (log), larger for long and bent things.
HULL_FILL, HULL_FILL_SPREAD, BENT_FILL_SPREAD = 0.9, 0.25, 0.6

# How sure a mass is whose estimates differ by up to the agreed ratio to the power of the first number, and beyond.
SURE = ((0.6, 0.9), (1.0, 0.85), (1.6, 0.75))
UNSURE = 0.6
# Ratio to the nearer end of a category's range from which on the estimates speak of another thing, or another size.
FAR_OFF = 5.0

EstimateMethod = Literal["matter", "hull", "shell", "usual"]
# What rain would fill of the hull of a vessel, and what a solid thing fills of it; choices.
VESSEL_SHARE, SOLID_SHARE = 0.15, 0.6
SAMPLES = 16_000
# Words in the names of materials and meshes, and the substance and density (kg/m^3) that they speak of; the densities
# are those of registry/substances.yaml.
SUBSTANCE_WORDS: Mapping[str, tuple[str, float]] = {
    **dict.fromkeys(("wood", "wooden", "oak", "walnut", "pine", "plywood", "birch", "teak"), ("wood", 680.0)),
    **dict.fromkeys(("metal", "steel", "iron", "chrome", "metallic"), ("steel", 7850.0)),
    **dict.fromkeys(("aluminium", "aluminum"), ("aluminium", 2700.0)),
    **dict.fromkeys(("brass", "gold", "bronze"), ("brass", 8500.0)),
    "copper": ("copper", 8960.0),
    "glass": ("glass", 2500.0),
    **dict.fromkeys(("ceramic", "clay", "terracotta"), ("ceramic", 2300.0)),
    "porcelain": ("porcelain", 2400.0),
    **dict.fromkeys(("plastic", "abs", "pvc"), ("plastic", 930.0)),
    "rubber": ("rubber", 1150.0),
    "leather": ("leather", 900.0),
    **dict.fromkeys(("fabric", "cloth", "textile", "cotton", "wool", "felt"), ("textile", 350.0)),
    "cardboard": ("cardboard", 690.0),
    "paper": ("paper", 800.0),
    **dict.fromkeys(("stone", "marble", "granite", "concrete"), ("stone", 2650.0)),
}
# Metalness from which on a surface is that of metal.
MIN_METALNESS = 0.5
# Share of the surface that has to speak of one substance.
MIN_SHARE = 0.5
# Spreads (log) of an estimate by volume and by walls where the substance is read from a word; choices.
VOLUME_SPREAD, WALLS_SPREAD = 0.5, 0.6
# Nobody knows what it is; a substance helps.
CONFIDENCE, CONFIDENCE_WITH_SUBSTANCE = 0.3, 0.4
# Smallest over largest variance of a body whose inertia stays valid when it is rounded to nine digits.
MIN_THICKNESS_RATIO = 1e-7
# Largest difference between the boxes of a mesh and of its closed part, as a share of the side, if it stands for all.
SAME_BOX_SHARE = 0.02
# Confidence below which there is a note; a choice.
DOUBTFUL_CONFIDENCE = 0.65


@dataclass(frozen=True)
class Estimate:
    """One mass, kg, with its spread (standard deviation of the logarithm), its method and its numbers in words."""

    method: EstimateMethod
    kg: float
    spread: float
    message: str


@dataclass(frozen=True)
class CombinedMass:
    """Mass after combining estimates, kg, with a confidence, the largest ratio of two, and all of them in words."""

    kg: float
    confidence: float
    ratio: float
    message: str


def estimate_masses(
    points: Floats, faces: Ints, solid: tuple[Floats, Ints] | None, category: Category, substance: Substance
) -> list[Estimate]:
    """All estimates that apply to welded points, metres, z up, with their `closed_solid`."""
    hull = convex_hull(points)
    surface_area, hull_area = float(face_normals(points, faces)[1].sum()), float(face_normals(*hull)[1].sum())
    estimates = (
        _by_volume(points, faces, solid, category, substance),
        _by_hull(hull, hull_area, category, substance),
        _by_walls(surface_area, hull_area, solid is not None, category, substance),
        _by_usual_mass(np.ptp(points, axis=0), category),
    )
    return [e for e in estimates if e is not None and np.isfinite(e.kg) and e.kg > 0]


def _by_volume(
    points: Floats, ids: Ints, solid: tuple[Floats, Ints] | None, category: Category, substance: Substance
) -> Estimate | None:
    density = _density(np.ptp(points, axis=0), category, substance)
    solid_volume = None if solid is None else signed_volume(*solid)
    if category.build is MatterFill.VESSEL:
        if solid_volume is None:
            return None
        message, spread = f"{solid_volume * 1e6:.4g} cm^3 of walls", 0.25
        return Estimate("matter", solid_volume * density, spread, message)
    if category.build is MatterFill.HOLLOW and substance.id not in BULK_DENSITY_SUBSTANCES:
        return None
    outline_volume = voxelise(points, ids, bridge=True).volume
    if category.build is MatterFill.SOLID and solid_volume is not None and solid_volume > SHELL_SHARE * outline_volume:
        message, spread = f"{solid_volume * 1e6:.4g} cm^3 within the closed mesh", 0.12
        return Estimate("matter", solid_volume * density, spread, message)
    spread = VAGUE if _is_bulk(category, substance) else 0.3 if category.build is MatterFill.SOLID else 0.4
    message = f"{outline_volume * 1e6:.4g} cm^3 within the outline"
    return Estimate("matter", outline_volume * density, spread, message)


def _is_bulk(category: Category, substance: Substance) -> bool:
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
        spread += 0.1 * (category.build is not MatterFill.SOLID)
        kg = HULL_FILL * volume * _density(np.ptp(hull[0], axis=0), category, substance)
        return Estimate("hull", kg, spread, f"hull {volume * 1e6:.4g} cm^3")
    wall_m = WALL_THICKNESS_M.get(substance.id)
    if wall_m is None:
        return None
    message = f"skin of the hull {hull_area * 1e4:.4g} cm^2"
    return Estimate("hull", hull_area * wall_m * substance.density, 0.5, message)


def _by_walls(
    surface_area: float, hull_area: float, is_closed: bool, category: Category, substance: Substance
) -> Estimate | None:
    wall_m = WALL_THICKNESS_M.get(substance.id)
    if wall_m is None or category.build in (MatterFill.SOLID, MatterFill.FILLED):
        return None
    one_side_area = surface_area / 2 if is_closed or surface_area > DOUBLE_WALL_AREA_RATIO * hull_area else surface_area
    spread = 0.35 if category.build is MatterFill.VESSEL else 0.6
    message = f"{one_side_area * 1e4:.4g} cm^2 of {substance.id} {1000 * wall_m:.2g} mm thick"
    return Estimate("shell", one_side_area * wall_m * substance.density, spread, message)


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
    return Estimate("usual", kg, spread, f"usual for a {category.id} of this size")


def combine_estimates(estimates: Sequence[Estimate], category: Category, agreement_ratio: float) -> CombinedMass:
    """Combine estimates into one mass.

    The mass by volume is taken as it is if it is usual for the category and the others agree with it. Otherwise the
    result is the mean of the logarithms of all estimates, weighted by the inverse squares of their spreads. If that
    mean lies outside the mass range of the category, it counts one third, and the usual mass of an object of this size
    two thirds; if the result is still outside, volumes and walls are ignored and the usual mass is taken. The
    confidence is low if the mean lies outside.

    `estimates`: at least the usual one. `agreement_ratio`: up to which two estimates agree, > 1.
    """
    by_method = {e.method: e for e in estimates}
    mass_range, measured = category.mass_kg, by_method.get("matter")
    is_usual = measured is not None and mass_range.low <= measured.kg <= mass_range.high
    is_vague = measured is not None and measured.spread >= VAGUE
    # A measured mass within the usual range need not agree with the typical mass.
    ratio = _disagreement([e for e in estimates if e.method != "usual" or not is_usual])
    counts = is_usual and not is_vague and category.build is not MatterFill.HOLLOW
    kg = measured.kg if measured is not None and counts and ratio <= agreement_ratio else _mean(estimates)
    message = _in_words(estimates)
    off = mass_range.beyond(kg)
    if off > 1:
        message += f"; together {kg:.3g} kg, but a {category.id} weighs {mass_range.low:g} to {mass_range.high:g} kg"
        usual = by_method["usual"].kg
        kg = exp((log(kg) + USUAL_COUNTS * log(usual)) / (1 + USUAL_COUNTS))
        if not mass_range.low <= kg <= mass_range.high:
            kg = usual
    confidence = next((sure for most, sure in SURE if ratio <= agreement_ratio**most), UNSURE)
    if is_vague:
        confidence = min(confidence, SURE_OF_VAGUE)
    if off > 1:  # things of one kind differ less in mass than volumes and walls of their meshes do
        confidence = min(confidence, 0.7 if off < agreement_ratio else 0.6 if off < FAR_OFF else 0.4)
    return CombinedMass(kg, confidence, ratio, message)


def _mean(estimates: Sequence[Estimate]) -> float:
    """Mean of the logarithms, weighted by the inverse squares of the spreads, as a mass, kg."""
    weights = [1 / e.spread**2 for e in estimates]
    return exp(sum(w * log(e.kg) for w, e in zip(weights, estimates, strict=True)) / sum(weights))


def _in_words(estimates: Sequence[Estimate]) -> str:
    return "; ".join(f"{e.method} {e.kg:.3g} kg ({e.message})" for e in estimates)


def _disagreement(estimates: Sequence[Estimate]) -> float:
    """Largest ratio between two estimates, reduced by what the larger of their spreads explains."""
    worst = 1.0
    for i, first in enumerate(estimates):
        for second in estimates[i + 1 :]:
            log_gap = abs(log(first.kg / second.kg)) - max(0.0, max(first.spread, second.spread) - 0.25)
            worst = max(worst, exp(log_gap))
    return worst


@dataclass(frozen=True)
class SizeLaw:
    """kg = factor * (volume of the box around it, m^3) ** exponent; `spread` of the logarithm around that."""

    factor: float
    exponent: float
    spread: float


# Fits over the typical sizes and masses of the categories of the registry, by their build.
SIZE_LAWS: Mapping[MatterFill, SizeLaw] = {
    MatterFill.SOLID: SizeLaw(31.8, 0.704, 0.83),
    MatterFill.VESSEL: SizeLaw(19.8, 0.620, 0.48),
    MatterFill.HOLLOW: SizeLaw(61.8, 0.822, 0.76),
}


def form_of(points: Floats, faces: Ints, solid: tuple[Floats, Ints] | None) -> MatterFill:
    """Whether an object in its pose, z up, is an open vessel, solid, or mostly air; `solid`: its `closed_solid`."""
    volume = max(hull_volume(points), 1e-12)
    if rain_volume(surface_samples(points, faces, SAMPLES)) > VESSEL_SHARE * volume:
        return MatterFill.VESSEL
    is_solid = solid is not None and signed_volume(*solid) > SOLID_SHARE * volume
    return MatterFill.SOLID if is_solid else MatterFill.HOLLOW


def apparent_substance(parts: Sequence[RawPart]) -> tuple[str, float] | None:
    """Substance, and its density, that most of the surface seems to be of; None if there is no sign of one."""
    areas: dict[tuple[str, float], float] = {}
    total = 0.0
    for part in parts:
        area = float(face_normals(part.mesh.vertices, part.mesh.faces.astype(np.int64))[1].sum())
        total += area
        words = re.findall(r"[a-z]+", f"{part.material.id} {part.name}".casefold())
        found = next((SUBSTANCE_WORDS[word] for word in words if word in SUBSTANCE_WORDS), None)
        material = part.material
        if found is None and material.metallic >= MIN_METALNESS and material.metallic_roughness_texture is None:
            found = SUBSTANCE_WORDS["steel"]
        if found is not None:
            areas[found] = areas.get(found, 0.0) + area
    best = max(areas, key=lambda name: areas[name], default=None)
    return best if best is not None and areas[best] >= MIN_SHARE * total else None


def combine_unknown(
    points: Floats, faces: Ints, solid: tuple[Floats, Ints] | None, parts: Sequence[RawPart]
) -> CombinedMass:
    """Mass of an object of unknown kind, without bounds; points: welded, metres, z up; `solid`: `closed_solid`."""
    form = form_of(points, faces, solid)
    law = SIZE_LAWS[form]
    box_volume = float(np.maximum(np.ptp(points, axis=0), 1e-6).prod())
    kg = law.factor * box_volume**law.exponent
    estimates = [Estimate("usual", kg, law.spread, f"usual for a {form} thing of this size")]
    made_of = apparent_substance(parts)
    if made_of is not None and (measured := _by_substance(points, faces, solid, form, *made_of)) is not None:
        estimates.append(measured)
    ratio = max(e.kg for e in estimates) / min(e.kg for e in estimates)
    confidence = CONFIDENCE if made_of is None else CONFIDENCE_WITH_SUBSTANCE
    return CombinedMass(_mean(estimates), confidence, ratio, _in_words(estimates))


def _by_substance(
    points: Floats, faces: Ints, solid: tuple[Floats, Ints] | None, form: MatterFill, name: str, density: float
) -> Estimate | None:
    """Mass by the volume within a closed mesh where that is solid matter, else by walls of the usual thickness."""
    if form is not MatterFill.HOLLOW and solid is not None and name not in ("steel", "brass", "copper"):
        volume = signed_volume(*solid)
        message = f"{volume * 1e6:.4g} cm^3 of {name} within the closed mesh"
        return Estimate("matter", volume * density, VOLUME_SPREAD, message) if volume > 0 else None
    wall_m = WALL_THICKNESS_M[name]
    area = float(face_normals(points, faces)[1].sum()) / (2 if solid is not None else 1)
    message = f"{area * 1e4:.4g} cm^2 of {name} {1000 * wall_m:.2g} mm thick"
    return Estimate("shell", area * wall_m * density, WALLS_SPREAD, message)


def mass(
    draft: Draft, category: Category, substance: Substance, agreement_ratio: float, override_kg: float = 0.0
) -> Draft:
    """Compute mass, centre of mass and inertia of the whole, asset frame.

    `draft`: metres, with colliders. `agreement_ratio`: up to which two estimates agree, > 1. `category`: mass_kg is the
    prior and the range, build says what the volume means. `override_kg`: as a person decided, or 0.
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
    # Nine digits, which the writers carry and which hide differences between machines.
    x, y, z = (significant(v, 9) if abs(v) > 1e-9 else 0.0 for v in center)
    size = float(np.trace(tensor))
    picked = (tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2])
    a, b, c, d, e, f = (significant(v, 9) if abs(v) > 1e-9 * size else 0.0 for v in picked)
    inertial = Inertial(mass=kg, center_of_mass=(x, y, z), inertia=(a, b, c, d, e, f))
    return draft.replace(
        inertial=inertial,
        guesses=draft.guessed("mass", f"{kg:.6g} kg, spread over {measured_over}", confidence, reason),
        notes=draft.noted(*notes),
    )


def _moments(draft: Draft, solid: ClosedSurface | None, category: Category) -> tuple[float, Floats, Floats, str]:
    """Volume, centre, inertia at density 1, and what they were measured of; `solid`: of the mesh, if it is closed."""
    surfaces = [tessellate(p.shape, p.pose) for p in draft.colliders]
    hulls = union(surfaces) or convex_hull(np.concatenate([s[0] for s in surfaces]))
    may_stand = category.build in (MatterFill.SOLID, MatterFill.VESSEL)
    if solid is not None and may_stand and signed_volume(*solid) > 0.02 * signed_volume(*hulls):
        # The closed part has to have the box of the mesh: that of a knife whose blade is a sheet is its handle only.
        points, part = draft.surface.points, solid[0]
        gap = np.abs([part.min(axis=0) - points.min(axis=0), part.max(axis=0) - points.max(axis=0)])
        if float(gap.max()) <= SAME_BOX_SHARE * float(np.ptp(points, axis=0).max()):
            return (*solid_moments(*solid), "the closed mesh")
    return (*solid_moments(*hulls), "the collision shapes")


def _thick_enough(inertia: Floats) -> Floats:
    """The inertia of a body that is thick enough for its tensor to stay valid when it is rounded."""
    variances, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    if variances[0] > MIN_THICKNESS_RATIO * variances[2]:
        return inertia
    covariance = (axes * np.maximum(variances, MIN_THICKNESS_RATIO * variances[2])) @ axes.T
    return np.asarray(np.trace(covariance) * np.eye(3) - covariance)
