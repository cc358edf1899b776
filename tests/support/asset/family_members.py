"""Members of families for tests: presets and seeded draws, built with plain finishes instead of pictures."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from casa_assets import registry
from casa_assets.asset.assemble import Family
from casa_assets.asset.family import AvailableFinishes, Params, Supplies
from casa_assets.checks.runtime.contract import (
    links_and_joints,
    missing_requirements,
    regions,
    shapes,
    site_faults,
    variables,
)
from casa_assets.formats import mjcf
from casa_assets.model.asset.asset import Asset, Labels
from casa_assets.model.asset.material import Material
from casa_assets.model.registry.contract import Contract
from casa_assets.model.registry.rows import Finish, Surface
from casa_assets.registry.families import family, look_samplers
from tests.support.asset.assets import write_to

WOODS = ("oak_natural", "walnut_natural")
MANY = ("cherry", "oak_natural", "paint_navy", "walnut_natural")
TILE_M = (0.9, 1.8)  # size of the picture that a finish of a recipe would have, metres
_NAMES = (links_and_joints, site_faults, shapes, regions, variables)


@lru_cache(maxsize=1)
def known() -> registry.Registry:
    return registry.load()


def supplies(found: Family[Any], params: Params) -> Supplies:
    """Finishes without pictures under the ids that the numbers name; those of recipes are of wood."""
    category = known().fixtures[found.category]
    finishes = {}
    for name in (*known().materials, *params.finishes):
        row = known().materials.get(name)
        substance = known().substances[row.substance if row else "wood"]
        material = Material(id=name, tile_m=None if row else TILE_M)
        finishes[name] = Finish(id=name, material=material, substance=substance)
    labels = Labels(category=category.id, classes=known().classes_of(category), qcode=category.qcode)
    return Supplies(finishes, labels, known().densities)


def made(name: str, params: Params) -> Asset:
    """The asset of a family's numbers."""
    found = family(name)
    asset: Asset = found.build(params, supplies(found, params))
    return asset


@lru_cache(maxsize=300)
def preset(name: str, which: str) -> Asset:
    """A preset of a family, built once."""
    return made(name, family(name).presets[which])


def available(surfaces: Sequence[str] = WOODS) -> AvailableFinishes:
    """All plain finishes, and the same few recipes for every surface."""
    return AvailableFinishes(dict.fromkeys(Surface, tuple(surfaces)), tuple(sorted(known().materials)), look_samplers())


def drawn(name: str, seed: int, surfaces: Sequence[str] = WOODS) -> Params:
    """The numbers of a seeded draw."""
    params: Params = family(name).draw(np.random.default_rng(seed), available(surfaces))
    return params


def unmet(asset: Asset, contract: Contract) -> list[str]:
    """What the names of an asset's parts lack of its contract."""
    return [f"{look.__name__}: {wanting}" for look in _NAMES for wanting in missing_requirements(asset, contract, look)]


def spec_of(asset: Asset, folder: Path) -> mujoco.MjSpec:
    """An asset in MuJoCo, out of the files that are written of it."""
    return mujoco.MjSpec.from_file(str(write_to(mjcf.write(asset), folder) / "model.xml"))
