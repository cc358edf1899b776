"""Mass, centre and inertia: of bodies known exactly, of estimates together, of what nobody could name."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.ingest.draft import Draft, PlacedShape
from casa_assets.ingest.mass import (
    SIZE_LAWS,
    SUBSTANCE_WORDS,
    CombinedMass,
    Estimate,
    apparent_substance,
    combine_estimates,
    combine_unknown,
    estimate_masses,
    mass,
)
from casa_assets.mesh.solid.solids import closed_solid
from casa_assets.model.asset.material import Material, Substance
from casa_assets.model.asset.parts import Box, Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import MatterFill
from casa_assets.model.source import RawPart
from tests.support.mesh.meshes import some
from tests.support.mesh.raw_models import category, codes, draft, flipped, joined, moved
from tests.support.mesh.solids import box, welded

SIZE = (0.06, 0.07, 0.055)
BLOCK = box(SIZE, (0.2, 0.1, 0.03))
FULL = 0.06 * 0.07 * 0.055 * 900
FLESH = Substance(id="fruit_flesh", density=900.0, static_friction=0.6, dynamic_friction=0.5)
CLAY = Substance(id="ceramic", density=2400.0, static_friction=0.6, dynamic_friction=0.5)
SLACK = 2.0


def with_shape(mesh: Mesh, size: Vec3, pose: Pose) -> Draft:
    return draft(mesh).replace(colliders=(PlacedShape(shape=Box(size=size), pose=pose),))


def boxed(mesh: Mesh) -> Draft:
    low, high = mesh.bounds
    return with_shape(mesh, tuple((high - low).tolist()), Pose(position=tuple(((low + high) / 2).tolist())))


def box_inertia(kg: float, x: float, y: float, z: float) -> list[float]:
    return [kg * (y * y + z * z) / 12, kg * (z * z + x * x) / 12, kg * (x * x + y * y) / 12, 0, 0, 0]


INNER = moved(box((0.04, 0.05, 0.035)), (0.2, 0.1, 0.03))
THIN = moved(box((0.056, 0.066, 0.051)), (0.2, 0.1, 0.03))
AIR = 0.04 * 0.05 * 0.035 * 900


class TestSolid:
    @pytest.mark.parametrize(
        ("mesh", "kg", "rel"),
        [
            pytest.param(BLOCK, FULL, 1e-5, id="volume times density"),
            pytest.param(Mesh(vertices=BLOCK.vertices, faces=BLOCK.faces[2:]), FULL, 0.15, id="open: its outline"),
            pytest.param(joined(BLOCK, moved(BLOCK, (0.001, 0.0, 0.0))), FULL * 61 / 60, 1e-4, id="overlaps once"),
            pytest.param(joined(BLOCK, flipped(INNER)), FULL - AIR, 1e-4, id="a wall inside is no matter"),
            pytest.param(joined(BLOCK, flipped(THIN)), FULL, 0.1, id="a shell that stands for a full thing"),
        ],
    )
    def test_mass(self, mesh: Mesh, kg: float, rel: float) -> None:
        assert some(mass(boxed(mesh), category("apple"), FLESH, SLACK).inertial).mass == pytest.approx(kg, rel=rel)

    @pytest.mark.parametrize(("mesh", "air"), [(BLOCK, 0.0), (joined(BLOCK, flipped(INNER)), AIR)])
    def test_tensor(self, mesh: Mesh, air: float) -> None:
        inertial = some(mass(boxed(mesh), category("apple"), FLESH, SLACK).inertial)
        assert inertial.center_of_mass == pytest.approx((0.2, 0.1, 0.03))
        wanted = np.subtract(box_inertia(FULL, *SIZE), box_inertia(air, 0.04, 0.05, 0.035))
        assert inertial.inertia == pytest.approx(wanted.tolist(), rel=1e-5 if not air else 1e-4, abs=1e-12)

    def test_an_implausible_volume_leaves_the_range_of_no_category(self) -> None:
        out = mass(boxed(BLOCK), category("apple"), FLESH.replace(density=90000.0), SLACK)
        span = category("apple").mass_kg
        assert span.low <= some(out.inertial).mass <= span.high
        assert codes(out.notes) == ["MSH021"]
        assert "matter 20.8 kg" in out.notes[0].message
        assert out.guesses[-1].confidence < 0.5


def test_the_thinnest_bodies_have_a_tensor_that_can_be(subtests: pytest.Subtests) -> None:
    poses = [Pose(), Pose(quaternion=(0.9, 0.1, 0.2, 0.3))]
    for needle, pose, thin in product([False, True], poses, [0.2e-2, 0.2e-4, 0.2e-6]):
        with subtests.test(thin=thin, pose=pose, needle=needle):
            size = (0.2, thin, thin) if needle else (0.2, 0.1, thin)
            shaped = with_shape(moved(box(size), matrix=pose.rotation), size, pose)
            inertial = some(mass(shaped, category("fork"), CLAY, SLACK).inertial)
            a, b, c = np.linalg.eigvalsh(inertial.tensor)
            assert 0 < a <= b <= c <= a + b
            assert c == pytest.approx(inertial.mass * (size[0] ** 2 + size[1] ** 2) / 12, rel=1e-3)


def estimated(mesh: Mesh, name: str) -> list[Estimate]:
    kind = category(name)
    points, faces = welded(mesh)
    return estimate_masses(points, faces, closed_solid(points, faces), kind, registry.load().substances[kind.substance])


def test_the_range_of_the_category_is_never_left(subtests: pytest.Subtests) -> None:
    for size, name in product([0.2, 1.0, 5.0], ["apple", "mug", "bottle", "microwave", "fork", "cheese"]):
        with subtests.test(name=name, size=size):
            kind = category(name)
            a, b, c = (side.typical * size for side in kind.extents)
            found = combine_estimates(estimated(box((a, b, c)), name), kind, 2.0)
            assert kind.mass_kg.low <= found.kg <= kind.mass_kg.high


@pytest.mark.parametrize(
    ("kilograms", "kg", "confidence"),
    [
        pytest.param((0.4, 0.3, 0.33), (0.4, 0.4), (0.7, 1.0), id="measured, and others bear it out"),
        pytest.param((0.48, 0.1, 0.34), (0.25, 0.48), (0.0, 0.6), id="they disagree: between them"),
        pytest.param((0.9, 0.8, 0.33), (0.33, 0.5), (0.0, 0.8), id="a little out of range: drawn back"),
        pytest.param((50.0, 40.0, 0.5), (0.5, 0.5), (0.0, 0.5), id="far out of range: the usual mass"),
    ],
)
def test_together(kilograms: tuple[float, ...], kg: tuple[float, float], confidence: tuple[float, float]) -> None:
    ways = zip(("matter", "shell", "usual"), kilograms, strict=True)
    found = combine_estimates([Estimate(way, value, 0.3, "") for way, value in ways], category("mug"), 2.0)
    assert kg[0] <= found.kg <= kg[1]
    assert confidence[0] <= found.confidence <= confidence[1]
    assert found.kg not in kg or kg[0] == kg[1]
    if kilograms[0] == 0.48:
        assert found.ratio > 3
    if kilograms[0] == 50.0:
        assert "a mug weighs 0.25 to 0.5 kg" in found.message


SOLID_BLOCK = box((0.2, 0.1, 0.1), (0, 0, 0.05))


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
    masses = [weighed(moved(SOLID_BLOCK, scale=scale)) for scale in (0.1, 1.0, 3.0, 10.0, 20.0)]
    assert len({round(found.kg, 6) for found in masses}) == len(masses)
    assert [found.kg for found in masses] == sorted(found.kg for found in masses)
    assert all(found.confidence < 0.5 for found in masses)


def test_a_word_or_bare_metal_tells_the_substance() -> None:
    assert apparent_substance([part(SOLID_BLOCK, "oak_wood_02")]) == ("wood", 680.0)
    assert apparent_substance([part(SOLID_BLOCK, "look", metallic=1.0)]) == ("steel", 7850.0)
    assert apparent_substance([part(SOLID_BLOCK, "look")]) is None
    assert apparent_substance([part(moved(SOLID_BLOCK, scale=0.1), "steel"), part(SOLID_BLOCK, "paint")]) is None
    assert weighed(SOLID_BLOCK, part(SOLID_BLOCK, "stone")).kg > weighed(SOLID_BLOCK, part(SOLID_BLOCK, "wood")).kg


def test_densities_are_those_of_the_registry() -> None:
    known = registry.load().substances
    assert {name: known[name].density for name, _ in SUBSTANCE_WORDS.values()} == dict(SUBSTANCE_WORDS.values())
