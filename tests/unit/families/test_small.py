"""Small appliances: every preset and two draws keep their contract; what moves goes as far as it does at home."""

from __future__ import annotations

import re

import pytest

from casa_assets.geometry.solid.primitive import link_bounds
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.registry.families import family_groups
from tests.family_members import drawn, known, made, preset, unmet

pytestmark = pytest.mark.content("code", "families", keep=0)

BY_NAME = {f.name: f for f in family_groups()["small"]}
PRESETS = [(f.name, p) for f in BY_NAME.values() for p in f.presets]


def way(joint: Joint) -> float:
    """How far a joint goes, rad or m."""
    return joint.range[1] - joint.range[0]


# Joints by name: their kind, and how far such parts go, rad or m. None: either kind.
WAYS: tuple[tuple[str, JointKind | None, float, float], ...] = (
    (r".*(lid|head)_joint(?<!button_lid_joint)", JointKind.HINGE, 0.4, 2.1),
    (r".*button.*", JointKind.SLIDE, 0.001, 0.008),
    (r".*knob.*", JointKind.HINGE, 0.5, 6.3),
    (r"(side_[lr]_)?lever_joint", JointKind.SLIDE, 0.03, 0.12),
    (r"switch_joint", None, 0.002, 0.9),
)
MASSES = {"coffee_machine": 2.0, "toaster": 0.9, "kettle": 0.6, "blender": 1.2, "blender_lid": 0.03, "stand_mixer": 4.0}


def plausible(asset: Asset) -> None:
    """Lids, levers, keys and knobs go as far as real ones, and none of them outweighs the body."""
    for joint in asset.joints:
        for pattern, kind, low, high in WAYS:
            if re.fullmatch(pattern, joint.name):
                assert kind in (None, joint.kind), joint.name
                assert low <= way(joint) <= high, joint.name
    root = asset.root.inertial.mass
    for link in asset.links[1:]:
        if re.search("button|knob|lever|switch", link.name):
            assert link.inertial.mass < 0.25 * root, link.name


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


@pytest.mark.content("family", "{family}")
@pytest.mark.parametrize(("family", "name"), [(f, p) for f, p in PRESETS if f != "blender_lid"])
def test_what_is_touched_begins_where_it_stands(family: str, name: str) -> None:
    """What stands on shapes that begin higher than its foot falls when a kitchen starts."""
    bounds = link_bounds(preset(family, name).root)
    assert bounds is not None
    assert bounds[0, 2] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.content("family", "toaster", keep=0)
def test_slots_of_a_toaster_run_from_front_to_back(subtests: pytest.Subtests) -> None:
    for name in BY_NAME["toaster"].presets:
        with subtests.test(name=name):
            slots = [r.size for r in preset("toaster", name).regions if "slot" in r.name]
            assert slots
            assert all(width < depth for width, depth, _ in slots)


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", list(BY_NAME))
@pytest.mark.parametrize("seed", [1, 2])
def test_draws_are_built_to_their_contract(family: str, seed: int) -> None:
    params = drawn(family, seed)
    holds(family, made(family, params))
    assert drawn(family, seed) == params
    assert type(params).from_json(params.to_json()) == params


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", list(BY_NAME))
def test_presets_are_many_and_have_meshes_of_their_own(family: str) -> None:
    found = BY_NAME[family]
    assert len(found.presets) >= 8
    seen = set()
    for name in found.presets:
        asset = preset(family, name)
        seen.add(tuple((v.name, v.mesh.vertices.tobytes()) for k in asset.links for v in k.visuals))
    assert len(seen) == len(found.presets)


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", list(BY_NAME))
def test_the_lightest_and_the_heaviest_are_of_their_kind(family: str) -> None:
    weights = [preset(family, name).mass for name in BY_NAME[family].presets]
    assert MASSES[family] <= min(weights) <= max(weights) < 12 * min(weights)


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize(
    ("family", "patterns"),
    [
        ("toaster", (r"(side_[lr]_)?lever_joint",)),
        ("kettle", ("lid_joint", "switch_joint")),
        ("stand_mixer", ("head_joint", "knob_speed_joint")),
    ],
)
def test_every_member_has_what_its_kind_is_worked_by(family: str, patterns: tuple[str, ...]) -> None:
    for name in BY_NAME[family].presets:
        joints = [joint.name for joint in preset(family, name).joints]
        for pattern in patterns:
            assert any(re.fullmatch(pattern, joint) for joint in joints), (name, pattern)


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", list(BY_NAME))
def test_all_are_small_enough_for_a_worktop(family: str) -> None:
    for name in BY_NAME[family].presets:
        low, high = preset(family, name).bounds
        width, depth, height = (float(v) for v in high - low)
        assert max(width, depth) < 0.6
        assert (0.03 if family == "blender_lid" else 0.12) < height < 0.6
