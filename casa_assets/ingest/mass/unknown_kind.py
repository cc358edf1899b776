"""Mass of what nobody could name: by its size and form, and by the density of what its parts say they are made of."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import exp, log

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.measure import face_normals, signed_volume
from casa_assets.geometry.solid.coverage import surface_samples
from casa_assets.geometry.solid.hull import hull_volume
from casa_assets.ingest.mass.estimates import WALL_THICKNESS_M, CombinedMass, Estimate, EstimateMethod
from casa_assets.ingest.pose.evidence import rain_volume
from casa_assets.model.ingest.source import RawPart
from casa_assets.model.registry.category import MatterFill


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


def form_of(points: Floats, faces: Ints, solid: tuple[Floats, Ints] | None) -> MatterFill:
    """Whether an object in its pose, z up, is an open vessel, solid, or mostly air inside.

    Args:
        points: (P, 3) welded. faces: (F, 3). solid: `closed_solid` of them.
    """
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
        if (
            found is None
            and part.material.metallic >= MIN_METALNESS
            and part.material.metallic_roughness_texture is None
        ):
            found = SUBSTANCE_WORDS["steel"]
        if found is not None:
            areas[found] = areas.get(found, 0.0) + area
    best = max(areas, key=lambda name: areas[name], default=None)
    return best if best is not None and areas[best] >= MIN_SHARE * total else None


def combine_unknown(
    points: Floats, faces: Ints, solid: tuple[Floats, Ints] | None, parts: Sequence[RawPart]
) -> CombinedMass:
    """Mass of what nobody could name; it is bounded by nothing.

    Args:
        points: (P, 3) welded, metres, z up. faces: (F, 3). solid: `closed_solid` of them. parts: with their materials.
    """
    form = form_of(points, faces, solid)
    law = SIZE_LAWS[form]
    box_volume = float(np.maximum(np.ptp(points, axis=0), 1e-6).prod())
    kg = law.factor * box_volume**law.exponent
    estimates = [Estimate(EstimateMethod.USUAL, kg, law.spread, f"usual for a {form} thing of this size")]
    made_of = apparent_substance(parts)
    if made_of is not None and (measured := _by_substance(points, faces, solid, form, *made_of)) is not None:
        estimates.append(measured)
    weights = [1 / e.spread**2 for e in estimates]
    kg = exp(sum(w * log(e.kg) for w, e in zip(weights, estimates, strict=True)) / sum(weights))
    ratio = max(e.kg for e in estimates) / min(e.kg for e in estimates)
    message = "; ".join(f"{e.method} {e.kg:.3g} kg ({e.message})" for e in estimates)
    return CombinedMass(kg, CONFIDENCE if made_of is None else CONFIDENCE_WITH_SUBSTANCE, ratio, message)


def _by_substance(
    points: Floats, faces: Ints, solid: tuple[Floats, Ints] | None, form: MatterFill, name: str, density: float
) -> Estimate | None:
    """Mass by the volume within a closed mesh where that is solid matter, else by walls of the usual thickness."""
    if form is not MatterFill.HOLLOW and solid is not None and name not in ("steel", "brass", "copper"):
        volume = signed_volume(*solid)
        message = f"{volume * 1e6:.4g} cm^3 of {name} within the closed mesh"
        return Estimate(EstimateMethod.MATTER, volume * density, VOLUME_SPREAD, message) if volume > 0 else None
    wall_m = WALL_THICKNESS_M[name]
    area = float(face_normals(points, faces)[1].sum()) / (2 if solid is not None else 1)
    message = f"{area * 1e4:.4g} cm^2 of {name} {1000 * wall_m:.2g} mm thick"
    return Estimate(EstimateMethod.SHELL, area * wall_m * density, WALLS_SPREAD, message)
