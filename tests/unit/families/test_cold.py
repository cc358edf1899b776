"""What keeps cold and what washes: every preset and two draws keep their contract, doors and racks their ways."""

from __future__ import annotations

import re

import pytest

from casa_assets.families.parts.appliance.front import AppliancePull, appliance_pull
from casa_assets.geometry.solid.primitive import shape_bounds
from casa_assets.layouts.plan.standard_sizes import FRIDGE_SIDE
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.registry.families import family_groups
from tests.family_members import drawn, known, made, preset, unmet

pytestmark = pytest.mark.content("code", "families", keep=0)

BY_NAME = {f.name: f for f in family_groups()["cold"]}
PRESETS = [(f.name, p) for f in BY_NAME.values() for p in f.presets]


def test_a_pull_has_room_beside_an_open_refrigerator(subtests: pytest.Subtests) -> None:
    """A door that is open by a right angle points its pull to the side, before the drawers of the unit there."""
    for kind in AppliancePull:
        with subtests.test(kind=kind):
            reach = max(-float(shape_bounds(*placed)[0, 1]) for placed in appliance_pull(kind, 0.7).shapes)
            assert reach <= FRIDGE_SIDE + 0.001


def way(joint: Joint) -> float:
    """How far a joint goes, rad or m."""
    return joint.range[1] - joint.range[0]


def plausible(asset: Asset) -> None:
    """Doors swing wide or fold flat, drawers and racks come out within the depth, no door is most of the weight."""
    low, high = asset.bounds
    depth = float(high[1] - low[1])
    for joint in asset.joints:
        if joint.kind is JointKind.HINGE and "door" in joint.name:
            assert 1.3 <= way(joint) <= 2.4, joint.name
            assert asset.link(joint.child).inertial.mass < 0.35 * asset.mass, joint.name
        if joint.kind is JointKind.SLIDE and re.search("drawer|basket|rack|freezer_door", joint.name):
            assert 0.15 <= way(joint) <= depth, joint.name


def holds(family: str, asset: Asset) -> None:
    """What everything here keeps: the names of its contract, grips, few shapes, a usual mass."""
    category = known().fixtures[BY_NAME[family].category]
    contract = known().contracts[str(asset.contract)]
    assert unmet(asset, contract) == []
    for joint in asset.joints:
        assert joint.range[0] == 0 or joint.range[1] == 0
        if joint.grip is not None:
            assert joint.grip in [c.name for c in asset.link(joint.child).colliders]
    assert not asset.exclusions
    assert all(len(k.colliders) <= 32 for k in asset.links)
    assert all(k.inertial.mass > 0 for k in asset.links)
    assert category.mass_kg.low <= asset.mass <= category.mass_kg.high
    labels = {c.label for k in asset.links for c in k.colliders}
    assert set(contract.labels) <= labels
    plausible(asset)


@pytest.mark.content("family", "{family}")
@pytest.mark.parametrize(("family", "name"), PRESETS)
def test_every_preset_is_built_to_its_contract(family: str, name: str) -> None:
    holds(family, preset(family, name))


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", list(BY_NAME))
@pytest.mark.parametrize("seed", [1, 2])
def test_draws_are_built_to_their_contract(family: str, seed: int) -> None:
    params = drawn(family, seed)
    holds(family, made(family, params))
    assert drawn(family, seed) == params
    assert type(params).from_json(params.to_json()) == params


@pytest.mark.content("family", "{family}", keep=0)
@pytest.mark.parametrize("family", list(BY_NAME))
def test_presets_are_many_and_have_meshes_of_their_own(family: str) -> None:
    found = BY_NAME[family]
    assert len(found.presets) >= 8
    seen = set()
    for name in found.presets:
        asset = preset(family, name)
        seen.add(tuple((v.name, v.mesh.vertices.tobytes()) for k in asset.links for v in k.visuals))
    assert len(seen) == len(found.presets)


FRIDGES = [f for f in BY_NAME if f.startswith("fridge")]


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", FRIDGES)
def test_a_fridge_has_a_shelf_where_things_are_put(subtests: pytest.Subtests, family: str) -> None:
    """A shelf that tasks use is 0.20 m high and 0.50 to 1.50 m over the floor. Ref: robocasa v1.0, Fridge."""
    for name in BY_NAME[family].presets:
        with subtests.test(name=name):
            asset = preset(family, name)
            shelves = [r for r in asset.regions if re.fullmatch(r"fridge_([a-z]+_)?shelf[0-9]+", r.name)]
            floors = [(asset.asset_from_link(r.link) @ r.pose).position[2] - r.size[2] / 2 for r in shelves]
            assert any(r.size[2] >= 0.2 and 0.5 <= z <= 1.5 for r, z in zip(shelves, floors, strict=True))


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", FRIDGES)
def test_a_fridge_is_as_large_as_one(family: str) -> None:
    for name in BY_NAME[family].presets:
        low, high = preset(family, name).bounds
        width, depth, height = (float(v) for v in high - low)
        assert 0.5 <= width <= 1.0, name
        assert 0.55 <= depth <= 0.95, name
        assert 1.35 <= height <= 2.2, name


@pytest.mark.content("family", "dishwasher", keep=0)
def test_racks_of_a_dishwasher_wait_for_its_door() -> None:
    for name in BY_NAME["dishwasher"].presets:
        asset = preset("dishwasher", name)
        racks = [j for j in asset.joints if re.fullmatch("rack[01]_joint", j.name)]
        assert len(racks) == 2
        assert all(j.behind == "door_joint" for j in racks)
        lower, upper = (next(r for r in asset.regions if r.name == f"rack{k}") for k in range(2))
        heights = [float((asset.asset_from_link(r.link) @ r.pose).position[2]) for r in (lower, upper)]
        assert abs(heights[1] - heights[0]) > 0.2


@pytest.mark.content("family", "fridge_side_by_side", keep=0)
def test_an_arm_on_wheels_gets_to_the_lowest_crispers(subtests: pytest.Subtests) -> None:
    for name in BY_NAME["fridge_side_by_side"].presets:
        with subtests.test(name=name):
            asset = preset("fridge_side_by_side", name)
            for link in ("freezer_drawer0", "fridge_drawer0"):
                grip = next(c for c in asset.link(link).colliders if c.name == f"{link}_handle_main")
                assert (asset.asset_from_link(link) @ grip.pose).position[2] > 0.33
