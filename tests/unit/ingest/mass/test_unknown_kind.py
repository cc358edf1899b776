"""Mass of what nobody could name: as large things and small ones, open and full, usually weigh, never at a bound."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.ingest.mass import SIZE_LAWS, CombinedMass, apparent_substance, combine_unknown
from casa_assets.mesh.solid.solids import closed_solid
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.registry.category import MatterFill
from casa_assets.model.source import RawPart
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import moved
from tests.support.mesh.solids import welded

BLOCK = box_mesh((0.2, 0.1, 0.1), (0, 0, 0.05), shared=True)


def part(mesh: Mesh, name: str, **look: float) -> RawPart:
    return RawPart(name="mesh", mesh=mesh, material=Material(id=name, **look))


def weighed(mesh: Mesh, *parts: RawPart) -> CombinedMass:
    points, faces = welded(mesh)
    return combine_unknown(points, faces, closed_solid(points, faces), parts or (part(mesh, "look"),))


@pytest.mark.parametrize("build", list(SIZE_LAWS))
def test_the_laws_are_those_of_the_categories(build: MatterFill) -> None:
    kinds = [c for c in registry.load().categories.values() if c.build is build and c.id != registry.FALLBACK]
    volumes = np.log([np.prod([side.typical for side in c.extents]) for c in kinds])
    masses = np.log([c.mass_kg.typical for c in kinds])
    law = SIZE_LAWS[build]
    off = masses - np.log(law.factor) - law.exponent * volumes
    assert abs(float(off.mean())) < 0.1
    assert float(off.std()) == pytest.approx(law.spread, abs=0.1)


def test_no_mass_is_a_bound_and_nobody_is_sure() -> None:
    masses = [weighed(moved(BLOCK, scale=scale)) for scale in (0.1, 1.0, 3.0, 10.0, 20.0)]
    assert len({round(found.kg, 6) for found in masses}) == len(masses)
    assert [found.kg for found in masses] == sorted(found.kg for found in masses)
    assert all(found.confidence < 0.5 for found in masses)


def test_a_word_or_bare_metal_tells_the_substance() -> None:
    assert apparent_substance([part(BLOCK, "oak_wood_02")]) == ("wood", 680.0)
    assert apparent_substance([part(BLOCK, "look", metallic=1.0)]) == ("steel", 7850.0)
    assert apparent_substance([part(BLOCK, "look")]) is None
    assert apparent_substance([part(moved(BLOCK, scale=0.1), "steel"), part(BLOCK, "paint")]) is None
    assert weighed(BLOCK, part(BLOCK, "stone")).kg > weighed(BLOCK, part(BLOCK, "wood")).kg


def test_densities_are_those_of_the_registry() -> None:
    from casa_assets.ingest.mass import SUBSTANCE_WORDS

    known = registry.load().substances
    assert {name: known[name].density for name, _ in SUBSTANCE_WORDS.values()} == dict(SUBSTANCE_WORDS.values())
