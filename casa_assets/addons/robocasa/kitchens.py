"""Kitchens in RoboCasa's form: their fixtures, documents and start states."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from lxml import etree

from casa_assets import Asset
from casa_assets.addons.robocasa import objects, parts
from casa_assets.addons.robocasa.parts import Part
from casa_assets.ext.arrays import Floats, decimals
from casa_assets.ext.kitchens import (
    FREE_JOINT,
    MIN_SURFACE_M,
    PLATE_DEPTH_M,
    SHELF_HEIGHTS_M,
    Layer,
    Placement,
    Scene,
    StateJoint,
    StoredStates,
)
from casa_assets.ext.mjcf import ROBOSUITE_GROUPS, VIEWER_GROUPS, add_lights_and_cameras, add_sky, numbers, write_mjcf
from casa_assets.ext.records import Base, Files, Pose, Region, Vec3

FILE, LAYOUT_FILE = "kitchen.json", "layout.yaml"
FORMAT = 1
# RoboCasa's own numbers are below this; ours fit into 32 bits.
FIRST_NUMBER, NUMBERS = 1_000_000_000, 1_000_000_000
# A thing is on a worktop where its foot is this close to the surface, metres.
MAX_GAP_M = 0.02
# Even what is open from its foot up is in the way of what is put beside it, up to this height, metres.
MIN_SOLID_M = 0.02
PLAIN, COUNTER, OPEN_CABINET = "Fixture", "Counter", "OpenCabinet"
FRIDGE = "Fridge"  # how the names of its classes begin
BLENDER, LID, LID_CONTRACT = "Blender", "BlenderLid", "blender_lid"
QUARTER_TURN = np.pi / 2
# RoboCasa parks a robot's base this far before the worktop that a fixture is over or under, metres. Its base has no
# room within 0.20 m of there, which counts as arrived, where another worktop is nearer than this to that place.
PARKED_M, MIN_ASIDE_M = 0.20, 0.15
# RoboCasa looks for counters of an island in the group of this name in the layout.
ISLAND_GROUP = "island_group"


@dataclass(frozen=True)
class Placed:
    """A fixture of a kitchen: a part of a placement's asset, centred, at `pose`; `type` is its class of RoboCasa."""

    name: str
    placement: Placement
    part: Part
    centered: Asset
    type: str
    pose: Pose

    @property
    def folder(self) -> str:
        """Name of its folder in the folder of all fixtures."""
        return f"{self.placement.asset}__{self.part.name}" if self.part.name else self.placement.asset


def number_of(scene_id: str) -> int:
    """Number by which RoboCasa identifies a kitchen, as layout and as style: a digest of its id."""
    digest = int(hashlib.sha256(scene_id.encode()).hexdigest()[:15], 16)
    return FIRST_NUMBER + digest % NUMBERS


def fixtures_of(scene: Scene, classes: Mapping[str, str]) -> tuple[Placed, ...]:
    """Fixtures of a scene, in the order of placements. `classes`: contract -> class of RoboCasa that reads it."""
    turned = {place.asset for place in scene.placements if _is_corner_of_side(scene, place)}
    divided = {a.id: parts.divide(_worktop_without_upstand(_with_main(a)), a.id in turned) for a in scene.assets}
    ready = {
        (asset, p.name): parts.moved(p.asset, np.array(_origin(p.asset)))
        for asset, found in divided.items()
        for p in found
    }
    out: list[Placed] = []
    for place in scene.placements:
        for part in divided[place.asset]:
            center = Pose(position=_origin(part.asset))
            asset = ready[place.asset, part.name]
            pose = place.pose @ part.whole_from_part @ center
            name = _fixture_name(place.name, part.name, asset, {p.name for p in out})
            out.append(Placed(name, place, part, asset, _class_of(asset, pose, classes), pose))
    worktops = [item for item in out if item.type == COUNTER]
    return tuple(replace(item, type=PLAIN) if _is_in_a_corner(item, worktops) else item for item in out)


def _origin(asset: Asset) -> Vec3:
    """Origin of a fixture's frame: the middle of `main`; a lid keeps its own frame, at a site of its blender."""
    return (0.0, 0.0, 0.0) if asset.contract == LID_CONTRACT else parts.main_center(asset)


def _is_in_a_corner(item: Placed, worktops: Collection[Placed]) -> bool:
    """Whether a robot that RoboCasa parks for open shelves would be inside another row of units.

    RoboCasa sends robots to the only shelves of a kitchen, wherever they are.
    """
    if item.type != OPEN_CABINET:
        return False
    for own in worktops:
        at = own.pose.inverse() @ item.pose
        if _outside(own, at) > 0:
            continue
        parked = own.pose @ Pose(position=(at.position[0], -_half_size(own)[1] - PARKED_M, 0.0))
        return any(_outside(other, other.pose.inverse() @ parked) < MIN_ASIDE_M for other in worktops if other != own)
    return False


def _half_size(item: Placed) -> Sequence[float]:
    return [length / 2 for length in parts.main_region(item.centered).size]


def _outside(item: Placed, at: Pose) -> float:
    """Distance of a point in the frame of a fixture from the fixture along x or y, the greater of both, metres."""
    return max(abs(place) - half for place, half in zip(at.position[:2], _half_size(item)[:2], strict=True))


def _is_corner_of_side(scene: Scene, worktop: Placement) -> bool:
    """Whether a cabinet in the corner of an L-shaped worktop faces the same way as the second arm.

    RoboCasa parks a robot in front of the worktop below or above a fixture, on that worktop's front side.
    """
    asset = scene.asset_of[worktop.name]
    side = next((region for region in asset.regions if region.name == parts.SIDE_TOP), None)
    if side is None:
        return False
    (x, y, _), (width, depth, _) = side.pose.position, side.size
    worktop_from_world = worktop.pose.inverse()
    back = parts.main_center(asset)[1] + parts.main_region(asset).size[1] / 2
    for place in scene.placements:
        cabinet = scene.asset_of[place.name]
        if cabinet.contract in parts.CABINETS:
            at = worktop_from_world @ place.pose @ Pose(position=parts.main_center(cabinet))
            is_within = abs(at.position[0] - x) <= width / 2 and y + depth / 2 <= at.position[1] <= back
            if is_within and abs(abs(yaw(at)) - QUARTER_TURN) < QUARTER_TURN / 2:
                return True
    return False


def _with_main(asset: Asset) -> Asset:
    """An asset with a region `main`; for objects, which do not have one, it is the bounding box."""
    if any(region.name == parts.MAIN for region in asset.regions):
        return asset
    low, high = asset.bounds
    return asset.replace(regions=(*asset.regions, parts.box_region(parts.MAIN, low, high)))


def _worktop_without_upstand(asset: Asset) -> Asset:
    """A worktop whose `main` ends at its surface.

    RoboCasa puts objects on the upper end of `main`, which must not be that of an upstand.
    """
    tops = [r for r in asset.regions if asset.contract == parts.COUNTER and r.name.startswith("top")]
    if not tops:
        return asset
    main = parts.main_region(asset)
    center, half = np.array(main.pose.position), np.array(main.size) / 2
    upper = center + half
    upper[2] = min(r.pose.position[2] - r.size[2] / 2 for r in tops)
    lower_main = parts.box_region(main.name, center - half, upper)
    return asset.replace(regions=tuple(lower_main if r.name == main.name else r for r in asset.regions))


def _fixture_name(placement: str, part: str, asset: Asset, taken: Collection[str]) -> str:
    """Return a name that RoboCasa can strip from the names of a fixture's regions, and that does not mislead it.

    RoboCasa splits names at `<fixture>_`, adds no prefix to names that begin so, leaves out counters with `corner` and
    cabinets with `stack` in their names, and pairs a `blender` or a `jar` with a lid of that name. Its tasks name their
    objects by kind, such as `kettle`, and an object must not have the name of a fixture.
    """
    name = f"{placement}_{part}" if part else placement
    if asset.contract == parts.COUNTER:
        name = name.replace("corner", "angle")
    name = name.replace("stack", "unit")
    is_paired = re.match(r"(blender|jar|oil_bottle|salt_shaker)", name)
    parts_named = [k.name for k in asset.links] + [j.name for j in asset.joints]
    parts_named += [s.name for s in asset.sites] + [r.name for r in asset.regions]
    for link in asset.links:
        parts_named += [v.name for v in link.visuals] + [c.name for c in link.colliders]
    if is_paired or name == asset.labels.category or any(f"{name}_" in one for one in parts_named):
        name = f"the_{name}"
    while name in taken:
        name = f"{name}_again"
    return name


def _class_of(asset: Asset, pose: Pose, classes: Mapping[str, str]) -> str:
    category, contract = asset.labels.category, asset.contract or ""
    if contract == "room":
        return {"floor": "Floor", "wall": "Wall"}.get(category, PLAIN)
    found = classes.get(contract, PLAIN)
    levels = [region for region in asset.regions if region.name.startswith("level")]
    bottoms = [float(pose.position[2] + level.pose.position[2] - level.size[2] / 2) for level in levels]
    if found == OPEN_CABINET and not any(SHELF_HEIGHTS_M[0] <= z <= SHELF_HEIGHTS_M[1] for z in bottoms):
        return PLAIN
    return found


def describe(scene: Scene, fixtures: Collection[Placed], folder: str) -> dict[str, Any]:
    """Content of kitchen.json; world frame, metres, radians, quaternions (w, x, y, z). `folder`: of the fixtures.

    Refrigerators come first: RoboCasa parks a robot in front of the first fixture that contains the middle of another,
    and a refrigerator protrudes from the housing around it. Lids come after what they may be placed next to.
    """
    counters = [item for item in fixtures if item.type == COUNTER]
    standing = [item for item in fixtures if item not in counters and any(_stands_on(item, c) for c in counters)]
    return {
        "format": FORMAT,
        "id": scene.id,
        "number": number_of(scene.id),
        "fixtures": [
            {
                "name": item.name,
                "placement": item.placement.name,
                "class": item.type,
                "model": f"{folder}/{item.folder}/model.xml",
                "position": [decimals(float(c), 9) for c in item.pose.position],
                "quaternion": [decimals(float(c), 12) for c in item.pose.quaternion],
                "is_free": is_free(item),
                "is_standing": item in standing,
                "solid_height": _solid_height(item),
                "facts": _facts(item, standing),
                "lid_of": _lid_of(item, fixtures),
                "start": {
                    at.joint: at.value
                    for at in item.placement.joints
                    if at.joint in {j.name for j in item.centered.joints}
                },
            }
            for item in sorted(fixtures, key=lambda item: (item.type == LID, not item.type.startswith(FRIDGE)))
        ],
    }


def _lid_of(item: Placed, fixtures: Collection[Placed]) -> str:
    """Name of the nearest blender, to which a lid belongs; empty if it is not a lid, or if there is no blender."""
    blenders = [other for other in fixtures if item.type == LID and other.type == BLENDER]
    return min(((math.dist(item.pose.position, b.pose.position), b.name) for b in blenders), default=(0.0, ""))[1]


def _solid_height(item: Placed) -> float:
    """Height above its foot below which nothing can be put into it, metres: up to its lowest shelf, tray or slot."""
    main = parts.main_region(item.centered)
    foot = main.pose.position[2] - main.size[2] / 2
    floors = [r.pose.position[2] - r.size[2] / 2 - foot for r in item.centered.regions if r.name != main.name]
    return decimals(min(max(MIN_SOLID_M, min(floors, default=main.size[2])), main.size[2]), 9)


def is_free(item: Placed) -> bool:
    """Whether it may be moved: RoboCasa's appliances are fixed in place, its accessories are not."""
    return item.centered.base is Base.FREE and item.type in (PLAIN, "Accessory")


def _stands_on(item: Placed, counter: Placed) -> bool:
    """Whether an item is on a worktop, so that nothing else may be put there."""
    if item.placement.layer is not Layer.THINGS:
        return False
    half = np.array(parts.main_region(counter.centered).size) / 2
    foot = item.pose.position[2] - parts.main_region(item.centered).size[2] / 2
    local = counter.pose.inverse().apply(np.array([item.pose.position]))[0]
    return bool(abs(foot - counter.pose.position[2] - half[2]) <= MAX_GAP_M and (np.abs(local[:2]) <= half[:2]).all())


def _facts(item: Placed, standing: Collection[Placed]) -> dict[str, Any]:
    """Attributes that RoboCasa's own classes would derive from the parts that they build."""
    if item.type in ("HingeCabinet", "SingleCabinet", "OpenCabinet", "HousingCabinet", "PanelCabinet", "Drawer"):
        levels = sum(bool(re.fullmatch(r"level\d+", region.name)) for region in item.centered.regions)
        is_corner = item.centered.labels.category == "corner_cabinet"
        facts: dict[str, Any] = {"num_levels": levels, "is_corner_cab": is_corner}
        if item.type == "SingleCabinet":
            opens_left = any(joint.range[0] < 0 for joint in item.centered.joints)
            facts["orientation"] = "left" if opens_left else "right"
        return facts
    if item.type == COUNTER:
        things = sorted(_footprint(one, item) for one in standing if _stands_on(one, item))
        tops = [region for region in item.centered.regions if region.name.startswith("top")]
        rows = [surface for top in tops for surface in _without(top, things)]
        return {"island_only": "island" in item.name, "base_opening": [False, False], "surfaces": rows}
    return {}


def _footprint(item: Placed, counter: Placed) -> Footprint:
    """Footprint of an item on a worktop: x and y of two corners in the frame of the worktop, metres."""
    x, y, _ = np.array(parts.main_region(item.centered).size) / 2
    corners = np.array([(i * x, j * y, 0.0) for i in (-1, 1) for j in (-1, 1)])
    local = counter.pose.inverse().apply(item.pose.apply(corners))
    low, high = local.min(axis=0), local.max(axis=0)
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))


def layout(fixtures: Collection[Placed]) -> dict[str, Any]:
    """Data that RoboCasa reads from a layout file: the counters of an island, and the directions that stools face."""
    suffix = f"_{ISLAND_GROUP}"
    islands = [item.name for item in fixtures if item.type == COUNTER and item.name.endswith(suffix)]
    stools = [item for item in fixtures if item.type == "Stool"]
    return {
        ISLAND_GROUP: {"counters": [{"name": name.removesuffix(suffix), "type": "counter"} for name in islands]},
        "room": {"floor_accessories": [{"type": "stool", "z_rot": decimals(yaw(item.pose), 9)} for item in stools]},
    }


def yaw(pose: Pose) -> float:
    """Rotation about the vertical axis, radians."""
    rotation = pose.rotation
    return float(np.arctan2(rotation[1, 0], rotation[0, 0]))


def excluded_bodies(scene: Scene, fixtures: Collection[Placed]) -> tuple[tuple[str, str], ...]:
    """Pairs of bodies that never collide, by their names in RoboCasa's model, each pair once."""
    body: dict[tuple[str, str], str] = {}
    for item in fixtures:
        for link, name in item.part.links.items():
            root = name == item.centered.root.name
            body[item.placement.name, link] = f"{item.name}_{'main' if root else name}"
    own = [(place.name, pair) for place in scene.placements for pair in scene.asset_of[place.name].exclusions]
    found = [(body[name, pair.first], body[name, pair.second]) for name, pair in own]
    found += [(body[one.placement, one.link], body[other.placement, other.link]) for one, other in scene.exclusions]
    pairs: dict[frozenset[str], tuple[str, str]] = {}
    for names in found:
        pairs.setdefault(frozenset(names), names)
    return tuple(pairs.values())


# Surfaces -------------------------------------------------------------------------------------------------------------
# RoboCasa v1.0 puts a task's plate in front of the microwave, as near to the front edge as it can, and gives up if
# there is no room. An area that is too shallow there is left out, so that RoboCasa uses the area next to it.

Corner = tuple[float, float]
Footprint = tuple[Corner, Corner]


def _without(region: Region, things: Iterable[Footprint]) -> list[dict[str, list[float]]]:
    """Cut a region at footprints that leave too little room; uncut if no large enough part would remain.

    Returns:
        Middle and full size of each rectangle in the frame of the worktop, whose front is at its minimum y, metres.
    """
    (x, y, z), (width, depth, height) = region.pose.position, region.size
    left, right, front, back = x - width / 2, x + width / 2, y - depth / 2, y + depth / 2
    spans = [(left, right)]
    for low, high in things:
        if low[1] < back and high[1] > front and low[1] - front < PLATE_DEPTH_M:
            parts = [part for a, b in spans for part in ((a, min(b, low[0])), (max(a, high[0]), b))]
            spans = [(a, b) for a, b in parts if b > a]
    kept = [(a, b) for a, b in spans if b - a >= MIN_SURFACE_M[0] and depth >= MIN_SURFACE_M[1]] or [(left, right)]
    return [
        {
            "position": [decimals((a + b) / 2, 9), decimals(y, 9), decimals(z, 9)],
            "size": [decimals(b - a, 9), depth, height],
        }
        for a, b in kept
    ]


# Document -------------------------------------------------------------------------------------------------------------

FIXTURES, KITCHENS = "fixtures", "kitchens"
MODEL = "model.xml"
ARENA_FILE = "arena.xml"
CEILING = "ceiling"


def write_kitchen(scene: Scene, fixtures: tuple[Placed, ...], tasks: Sequence[str] = ()) -> Files:
    """`kitchen.json`, `arena.xml` and `layout.yaml` of a scene. `tasks`: of RoboCasa v1.0 that the kitchen affords."""
    facts = {**describe(scene, fixtures, FIXTURES), "tasks": list(tasks)}
    return Files.of(
        {
            FILE: objects.json_bytes(facts),
            # JSON is YAML.
            LAYOUT_FILE: objects.json_bytes(layout(fixtures)),
            ARENA_FILE: arena(scene, excluded_bodies(scene, fixtures)),
        }
    )


def write_fixture(asset: Asset) -> Files:
    """Return `model.xml` of a centred fixture with its meshes and images.

    A ceiling and the outer faces of walls are in a group that robosuite's cameras do not show, so that the cameras see
    into the room from outside.
    """
    visuals = VIEWER_GROUPS.shell if asset.labels.category == CEILING else ROBOSUITE_GROUPS.visuals
    groups = replace(ROBOSUITE_GROUPS, visuals=visuals, shell=VIEWER_GROUPS.shell)
    files: Mapping[str, bytes] = write_mjcf(asset, groups).entries
    return Files.of(
        {path: data for path, data in files.items() if path == MODEL or path.startswith(("meshes/", "textures/"))}
    )


def arena(scene: Scene, exclusions: Iterable[tuple[str, str]]) -> bytes:
    """Sky, lights and cameras of a kitchen, and pairs of fixture bodies, by their merged names, that never collide.

    From fixtures RoboCasa merges only bodies and assets; from the arena it also merges `<contact>`.
    """
    root = etree.Element("mujoco", {"model": scene.id})
    etree.SubElement(root, "compiler", {"angle": "radian", "autolimits": "true"})
    add_sky(etree.SubElement(root, "asset"), scene)
    world = etree.SubElement(root, "worldbody")
    add_lights_and_cameras(world, scene)
    # Even light from all sides. In scene.xml it is the headlight's, which RoboCasa does not merge.
    light = world.find("light")
    if light is None:
        down = {"name": "ambient", "dir": "0 0 -1", "diffuse": "0 0 0", "specular": "0 0 0", "castshadow": "false"}
        light = etree.SubElement(world, "light", down)
    light.set("ambient", numbers(scene.ambient))
    pairs = etree.SubElement(root, "contact")
    for first, second in exclusions:
        etree.SubElement(pairs, "exclude", {"name": f"{first}__{second}", "body1": first, "body2": second})
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)


# Start states ---------------------------------------------------------------------------------------------------------

# robosuite numbers the joints that a model is given; those of a fixture out of a file keep their names.
FREE_SUFFIX = "joint0"


def translated(states: StoredStates, scene: Scene, fixtures: Collection[Placed]) -> StoredStates:
    """Convert states to a model of RoboCasa with `fixtures`, without joints that it does not have.

    Appliances that are loose in the scene are fixed in RoboCasa, at their pose in the scene.
    """
    columns: list[tuple[str, Floats]] = []
    for item in fixtures:
        whole = {joint.child: joint.name for joint in scene.asset_of[item.placement.name].joints}
        links = {name: link for link, name in item.part.links.items()}
        for joint in item.centered.joints:
            values = _values(states, f"{item.placement.name}__{whole[links[joint.child]]}")
            if values is not None:
                columns.append((f"{item.name}_{joint.name}", values))
    for item in fixtures:
        values = _values(states, f"{item.placement.name}__{FREE_JOINT}") if is_free(item) else None
        if values is None:
            continue
        asset_from_root = scene.asset_of[item.placement.name].root.pose
        # Into the frames that fixtures have in RoboCasa.
        root_from_fixture = asset_from_root.inverse() @ item.placement.pose.inverse() @ item.pose
        rows = []
        for x, y, z, *quaternion in values.tolist():
            turn = np.array(quaternion) / np.linalg.norm(quaternion)
            pose = Pose(position=(x, y, z), quaternion=turn.tolist()) @ root_from_fixture
            rows.append((*pose.position, *pose.quaternion))
        columns.append((f"{item.name}_{FREE_SUFFIX}", np.array(rows)))
    joints, address = [], 0
    for name, values in columns:
        joints.append(StateJoint.model_validate({"name": name, "address": address, "width": values.shape[1]}))
        address += values.shape[1]
    return states.replace(joints=tuple(joints), qpos=np.concatenate([values for _, values in columns], axis=1))


def _values(states: StoredStates, name: str) -> Floats | None:
    """(states, width) numbers of a joint of the scene, or None if the states do not have it."""
    found = next((joint for joint in states.joints if joint.name == name), None)
    return None if found is None else states.qpos[:, found.address : found.address + found.width].astype(np.float64)
