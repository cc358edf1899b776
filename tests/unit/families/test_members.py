"""Members of all families: presets and draws keep their contract, move as such things do, and differ."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

import numpy as np
import pytest

from casa_assets.checks.asset.plausibility import fingers_have_room
from casa_assets.kitchenware.parts.doors import DOOR_TRAVEL
from casa_assets.mesh.solid.primitive import link_bounds
from casa_assets.model.asset.asset import Asset, Base, JointKind
from casa_assets.model.asset.behavior import Stimulus, start_behavior, step_behavior
from casa_assets.model.asset.parts import Joint
from casa_assets.registry.families import families, family_groups
from tests.support.asset.family_members import MANY, drawn, known, made, preset, unmet

pytestmark = pytest.mark.content("code", "families", keep=0)

GROUPS = {found.name: group for group, members in family_groups().items() for found in members}
FAMILIES = families()
PRESETS = [(name, preset_name) for name, found in FAMILIES.items() for preset_name in found.presets]
# By how much the mass may leave the range of its category, and most faces; by group.
MASS_SLACK = {"cabinets": 1.5, "decor": 1.5}
MAX_FACES = {"cabinets": 15_000, "room": 15_000, "cooking": 24_000}
SIZE_SLACK = 1.2  # as registry/limits.yaml allows a size to leave the range of its category
HANGS = {"wall_clock", "utensil_rack", "picture_frame", "pendant_light", "ceiling_light", "curtain"}
STANDS = ("dish_rack", "spice_rack", "vase", "candle", "jar", "bottle", "cutting_board", "cookbook_stack")
TURN_BOTH_WAYS = ("handle_temp_joint", "spout_joint", "swivel_joint", "roll_joint")
FRIDGES = [name for name in FAMILIES if name.startswith("fridge")]


def sides(asset: Asset) -> list[float]:
    """Width, depth, height of what is seen, metres."""
    return [float(v) for v in np.ptp(asset.bounds, axis=0)]


def height_of(asset: Asset, link: str, collider: str) -> float:
    """Height of the middle of a collider above the floor, metres."""
    found = next(c for c in asset.link(link).colliders if c.name == collider)
    return float((asset.asset_from_link(link) @ found.pose).position[2])


# What groups keep -----------------------------------------------------------------------------------------------------

# Ref: RoboCasa v1.0, HingeCabinet, SingleCabinet and Drawer; a word in front tells several apart.
NAMES = re.compile("([a-z0-9]+_)*((left|right)?doorhinge|slidejoint)")
# Joints of small appliances by name: their kind, and how far such parts go, rad or m. None: either kind.
WAYS: tuple[tuple[str, JointKind | None, float, float], ...] = (
    (r".*(lid|head)_joint(?<!button_lid_joint)", JointKind.HINGE, 0.4, 2.1),
    (r".*button.*", JointKind.SLIDE, 0.001, 0.008),
    (r".*knob.*", JointKind.HINGE, 0.5, 6.3),
    (r"(side_[lr]_)?lever_joint", JointKind.SLIDE, 0.03, 0.12),
    (r"switch_joint", None, 0.002, 0.9),
)
# Joints that every member of a family has.
WORKED_BY = {
    "toaster": (r"(side_[lr]_)?lever_joint",),
    "kettle": ("lid_joint", "switch_joint"),
    "stand_mixer": ("head_joint", "knob_speed_joint"),
}


def stays_in_its_width(asset: Asset, joint: Joint) -> bool:
    """Whether no visual vertex of a door, as far open as it goes, lies beyond its hinge's side of its own room."""
    angle = max(joint.range, key=abs)
    points = np.concatenate([visual.mesh.vertices for visual in asset.link(joint.child).visuals])
    x = points[:, 0] * np.cos(angle) - points[:, 1] * np.sin(angle)
    return float((x * (1.0 if angle < 0 else -1.0)).min()) >= -1e-4


def cabinet(_family: str, asset: Asset) -> None:
    """Names and signs of joints, doors within their width, handles as grips."""
    for joint in asset.joints:
        assert NAMES.fullmatch(joint.name), joint.name
        assert asset.link(joint.child).parent == "object"
        low, high = joint.range
        if joint.kind is JointKind.SLIDE:
            assert joint.name.endswith("slidejoint")
            assert joint.axis == (0.0, 1.0, 0.0)
            assert high == 0
            assert -0.7 <= low <= -0.15
        else:
            assert joint.axis == (0.0, 0.0, 1.0)
            assert 1.2 <= max(-low, high) <= DOOR_TRAVEL
            assert stays_in_its_width(asset, joint)
            assert not joint.name.endswith("leftdoorhinge") or high == 0
            assert not joint.name.endswith("rightdoorhinge") or low == 0
        assert next(c for c in asset.link(joint.child).colliders if c.name == joint.grip).label == "handle"
    assert "main" in [r.name for r in asset.regions]
    if asset.joints:
        assert [k.name for k in asset.keyframes] == ["closed", "open"]
        assert len(asset.keyframes[1].joints) == len(asset.joints)


def cooking(_family: str, asset: Asset) -> None:
    """Every joint has a grip that a hand can take."""
    for joint in asset.joints:
        grip = next(c for c in asset.link(joint.child).colliders if c.name == joint.grip)
        assert grip.label in ("handle", "knob", "button", "rack", "tray")
    assert fingers_have_room(asset, known().limits["finger_m"]).problems == ()


def cold(family: str, asset: Asset) -> None:
    """Doors swing wide or fold flat, drawers and racks come out within the depth, no door is most of the weight."""
    width, depth, height = sides(asset)
    for joint in asset.joints:
        if joint.kind is JointKind.HINGE and "door" in joint.name:
            assert 1.3 <= np.ptp(joint.range) <= 2.4, joint.name
            assert asset.link(joint.child).inertial.mass < 0.35 * asset.mass, joint.name
        if joint.kind is JointKind.SLIDE and re.search("drawer|basket|rack|freezer_door", joint.name):
            assert 0.15 <= np.ptp(joint.range) <= depth, joint.name
    if family in FRIDGES:
        assert 0.5 <= width <= 1.0
        assert 0.55 <= depth <= 0.95
        assert 1.35 <= height <= 2.2


def small(family: str, asset: Asset) -> None:
    """Lids, levers, keys and knobs go as far as real ones, and none of them outweighs the body; all suit a worktop."""
    for joint in asset.joints:
        for pattern, kind, low, high in WAYS:
            if re.fullmatch(pattern, joint.name):
                assert kind in (None, joint.kind), joint.name
                assert low <= np.ptp(joint.range) <= high, joint.name
        if family == "toaster" and "lever" in joint.name:
            weight = 9.81 * asset.link(joint.child).inertial.mass
            assert joint.drive is not None
            assert joint.drive.stiffness * (joint.drive.target - max(joint.range)) > weight, "it springs back up"
    for pattern in WORKED_BY.get(family, ()):
        assert any(re.fullmatch(pattern, joint.name) for joint in asset.joints), pattern
    for link in asset.links[1:]:
        if re.search("button|knob|lever|switch", link.name):
            assert link.inertial.mass < 0.25 * asset.root.inertial.mass, link.name
    width, depth, height = sides(asset)
    assert max(width, depth) < 0.6
    assert (0.03 if family == "blender_lid" else 0.12) < height < 0.6
    bounds = link_bounds(asset.root)
    assert bounds is not None
    # What stands on shapes that begin higher than its foot falls when a kitchen starts.
    assert family == "blender_lid" or bounds[0, 2] == pytest.approx(0.0, abs=1e-4)


def decor(family: str, asset: Asset) -> None:
    """A usual size."""
    usual = known().fixtures[FAMILIES[family].category].longest_m
    assert usual.low / SIZE_SLACK <= max(sides(asset)) <= usual.high * SIZE_SLACK
    if family in STANDS:
        assert asset.base is Base.FREE


def room(_family: str, asset: Asset) -> None:
    """Nothing moves, and nothing is longer than an asset may be."""
    assert asset.contract == "room"
    assert not asset.joints
    assert max(sides(asset)) <= known().limits["max_extent_m"]


OF_GROUP: Mapping[str, Callable[[str, Asset], None]] = {
    "cabinets": cabinet, "cooking": cooking, "cold": cold, "small": small, "decor": decor, "room": room,
}  # fmt: skip


def holds(family: str, asset: Asset) -> None:
    """The names and labels of its contract, grips, few shapes and faces, a usual mass, a place on the ground."""
    group, mass = GROUPS[family], known().fixtures[FAMILIES[family].category].mass_kg
    contract = known().contracts[str(asset.contract)]
    assert unmet(asset, contract) == []
    colliders = [c for link in asset.links for c in link.colliders]
    # Plates of ceramic and of induction hobs have no burners that are touched.
    assert group == "cooking" or set(contract.labels) <= {c.label for c in colliders}
    assert len({c.name for c in colliders}) == len(colliders)
    for joint in asset.joints:
        assert 0 in joint.range or joint.name in TURN_BOTH_WAYS
        assert joint.grip is None or joint.grip in [c.name for c in asset.link(joint.child).colliders]
    assert not asset.exclusions
    assert all(0 < len(link.colliders) <= 32 for link in asset.links)
    assert all(link.inertial.mass > 0 for link in asset.links)
    assert sum(len(v.mesh.faces) for link in asset.links for v in link.visuals) <= MAX_FACES.get(group, 26_000)
    slack = MASS_SLACK.get(group, 1.0)
    assert mass.low / slack <= asset.mass <= mass.high * slack
    low, high = asset.bounds
    np.testing.assert_allclose((*(low[:2] + high[:2]) / 2, low[2]), 0, atol=1e-5)
    if group in OF_GROUP:
        OF_GROUP[group](family, asset)


# Members --------------------------------------------------------------------------------------------------------------


@pytest.mark.content("family", "{family}")
@pytest.mark.parametrize(("family", "name"), PRESETS)
def test_every_preset_is_built_to_its_contract(family: str, name: str) -> None:
    holds(family, preset(family, name))


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", list(FAMILIES))
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_draws_are_built_to_their_contract_and_the_same_draw_is_the_same_thing(family: str, seed: int) -> None:
    params, again = (drawn(family, seed, MANY) for _ in range(2))
    asset = made(family, params)
    holds(family, asset)
    assert again == params == type(params).from_json(params.to_json())
    assert made(family, again).digest == asset.digest


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", list(FAMILIES))
def test_presets_are_many_and_have_meshes_of_their_own_and_a_hundred_draws_differ(family: str) -> None:
    assets = [preset(family, name) for name in FAMILIES[family].presets]
    assert len(assets) >= 6
    shown = [[v for link in asset.links for v in link.visuals] for asset in assets]
    meshes = {tuple((v.name, v.material, v.mesh.vertices.tobytes()) for v in visuals) for visuals in shown}
    assert len(meshes) == len(assets)
    if GROUPS[family] == "cooking":
        assert len({tuple(np.round(asset.bounds, 4).ravel()) for asset in assets}) >= 5
    if GROUPS[family] == "cooking" or family in STANDS:
        assert len({drawn(family, seed).digest for seed in range(100)}) > 95
    assert family not in HANGS or Base.FIXED in {asset.base for asset in assets}


@pytest.mark.content("family", "{family}", keep=1)
@pytest.mark.parametrize("family", FRIDGES)
def test_a_fridge_has_a_shelf_where_things_are_put(family: str) -> None:
    """A shelf that tasks use is 0.20 m high and 0.50 to 1.50 m over the floor. Ref: robocasa v1.0, Fridge."""
    for name in FAMILIES[family].presets:
        asset = preset(family, name)
        shelves = [r for r in asset.regions if re.fullmatch(r"fridge_([a-z]+_)?shelf[0-9]+", r.name)]
        floors = [(asset.asset_from_link(r.link) @ r.pose).position[2] - r.size[2] / 2 for r in shelves]
        assert any(r.size[2] >= 0.2 and 0.5 <= z <= 1.5 for r, z in zip(shelves, floors, strict=True)), name


@pytest.mark.content("family", "dishwasher", keep=0)
def test_racks_of_a_dishwasher_wait_for_its_door() -> None:
    for name in FAMILIES["dishwasher"].presets:
        asset = preset("dishwasher", name)
        assert [j.behind for j in asset.joints if re.fullmatch("rack[01]_joint", j.name)] == ["door_joint"] * 2, name
        lower, upper = (next(r for r in asset.regions if r.name == f"rack{k}") for k in range(2))
        heights = [float((asset.asset_from_link(r.link) @ r.pose).position[2]) for r in (lower, upper)]
        assert abs(heights[1] - heights[0]) > 0.2, name


@pytest.mark.content("family", "dishwasher", keep=0)
def test_a_dishwasher_washes_while_it_is_on_and_its_door_is_shut() -> None:
    behavior = preset("dishwasher", "white").behavior
    assert behavior is not None
    state, found = start_behavior(behavior), list[str]()
    for key, door in (("", 0.0), ("start_button", 0.0), ("", 0.0), ("", 1.0), ("", 0.0)):
        for _ in range(3):
            state = step_behavior(state, Stimulus({"door_joint": door}, frozenset({key})), 0.05)
        found.append(state.values["wash"])
    assert found == ["off", "on", "on", "off", "on"]


@pytest.mark.content("family", "fridge_side_by_side", keep=0)
def test_an_arm_on_wheels_gets_to_the_lowest_crispers() -> None:
    for name in FAMILIES["fridge_side_by_side"].presets:
        asset = preset("fridge_side_by_side", name)
        for link in ("freezer_drawer0", "fridge_drawer0"):
            assert height_of(asset, link, f"{link}_handle_main") > 0.33, name


@pytest.mark.content("family", "toaster", keep=0)
def test_slots_of_a_toaster_run_from_front_to_back() -> None:
    for name in FAMILIES["toaster"].presets:
        slots = [r.size for r in preset("toaster", name).regions if "slot" in r.name]
        assert slots, name
        assert all(width < depth for width, depth, _ in slots), name
