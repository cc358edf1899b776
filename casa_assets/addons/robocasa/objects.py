"""Objects in RoboCasa's form: their models, their entries in its tables, and what its tasks draw.

One model.xml serves both releases: v0.2 reads sizes from three sites next to the body `object`, v1.0 from the geom
`reg_bbox` in it. Elements that the loaders drop (exclusions, keyframes, options) are not written; attributes that they
need on every geom (group, pos, and size of three or two numbers) are written on the geom itself. Lids are always shut:
RoboCasa sets the pose of an object through its first joint, and robosuite adds the free joint after those in the file.
"""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from lxml import etree

from casa_assets import Asset
from casa_assets.addons.robocasa.casa_objects import GROUPS
from casa_assets.addons.robocasa.parts import moved
from casa_assets.ext.kitchens import RobocasaRelease
from casa_assets.ext.mjcf import (
    OUTER_REGIONS,
    ROBOSUITE_GROUPS,
    BodyContext,
    Meshes,
    MeshUse,
    add_body,
    add_labels,
    add_material,
    add_mesh,
    add_region,
    add_size_sites,
    add_texture,
    gather_meshes,
    material_names,
    mesh_uses,
    numbers,
    texture_files,
)
from casa_assets.ext.records import Affordance, Category, Files, Id, Mesh, Pose, Record, Split, Vec3

# Ref: robocasa v1.0, add_obj_liquid_site: the categories whose objects it is called for.
HOLD_LIQUID = ("cup", "glass_cup", "mug", "bowl", "pot", "pan", "saucepan")
LIQUID_SHARE = 0.8  # of width and height of such a vessel
# Ref: robocasa, folders beside the model.xml of an object.
VISUAL_FOLDER, COLLISION_FOLDER = "visual", "collision"
FILE, UPRIGHT_FILE = "model.xml", "model_upright.xml"


def write(asset: Asset, stood_up: bool = False) -> Files:
    """Files of a free object: `model.xml`, `visual/`, `collision/`; `stood_up`: also `model_upright.xml`, on its end.

    The origin is at half the height: RoboCasa tests only the origin to decide whether an object is in a sink or on a
    shelf, and an origin at the foot would sink slightly out of it.
    """
    rigid = asset.replace(joints=(), states=(), keyframes=(), exclusions=(), behavior=None)
    asset = moved(rigid, np.array((0.0, 0.0, asset.bounds[:, 2].mean())))
    thick = thickened(asset)
    meshes = _gather(thick)
    entries = {file.path: file.data for file in meshes.files}
    images = texture_files(asset).values()
    entries |= {f"{VISUAL_FOLDER}/{image.file_name}": image.png for image in images}
    root = _document(thick, meshes)
    (outer,) = root.findall("worldbody/body")
    add_size_sites(outer, asset)
    entries[FILE] = _text(root)
    if stood_up:
        stand_up(root, asset)
        entries[UPRIGHT_FILE] = _text(root)
    return Files.of(entries)


def _gather(asset: Asset) -> Meshes:
    meshes = gather_meshes(asset)
    visual_paths = {meshes.of[v.name].path for link in asset.links for v in link.visuals}
    placed = {}
    for file in meshes.files:
        folder = VISUAL_FOLDER if file.path in visual_paths else COLLISION_FOLDER
        placed[file.name, file.use] = replace(file, path=f"{folder}/{file.path.rpartition('/')[2]}")
    return Meshes(
        files=tuple(placed.values()),
        of={name: placed[file.name, file.use] for name, file in meshes.of.items()},
    )


def _document(asset: Asset, meshes: Meshes) -> etree._Element:
    root = etree.Element("mujoco", {"model": asset.id})
    etree.SubElement(root, "compiler", {"angle": "radian", "autolimits": "true"})
    assets = etree.SubElement(root, "asset")
    for image in texture_files(asset).values():
        add_texture(assets, image, f"{VISUAL_FOLDER}/{image.file_name}")
    names = material_names(asset)
    for look in asset.materials:
        add_material(assets, look, names[look.id])
    with_volume = {meshes.of[name].name for name, shape, _ in mesh_uses(asset) if has_volume(shape)}
    for file in meshes.files:
        add_mesh(assets, file)
        if file.use is MeshUse.SURFACE and file.name in with_volume:
            assets[-1].set("inertia", "legacy")  # MuJoCo 3.2.6 does not know `shell`
    world = etree.SubElement(root, "worldbody")
    outer = etree.SubElement(world, "body")
    root_body = add_body(outer, asset.root, BodyContext(asset, meshes, names, ROBOSUITE_GROUPS))
    if root_body.find(f"geom[@name='reg_{OUTER_REGIONS[0]}']") is None:
        found = next(region for region in asset.regions if region.name in OUTER_REGIONS)
        add_region(root_body, found.replace(name=OUTER_REGIONS[0]), ROBOSUITE_GROUPS.regions)
    if asset.labels.category in HOLD_LIQUID:
        # Tasks colour the site `liquid` of a vessel: an upright cylinder inside it, invisible until then.
        lower, upper = asset.bounds
        radius, half_height = LIQUID_SHARE * min(upper[:2] - lower[:2]) / 2, LIQUID_SHARE * (upper[2] - lower[2]) / 2
        at, size = numbers((0.0, 0.0, (lower[2] + upper[2]) / 2)), numbers((radius, half_height))
        attributes = {"name": "liquid", "type": "cylinder", "pos": at, "size": size, "rgba": "0 0 0 0"}
        etree.SubElement(root_body, "site", attributes)
    add_labels(root, asset)
    return root


def _text(root: etree._Element) -> bytes:
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)


# Meshes without volume ------------------------------------------------------------------------------------------------
# MuJoCo refuses a mesh without volume, even a visual one without mass, unless its `inertia` is `shell`. RoboCasa v0.2
# needs MuJoCo 3.2.6, which does not know that value.

# A hundred times what MuJoCo calls too small, m^3. Ref: MuJoCo 3.2, mjMINVAL in its compiler of meshes.
MIN_VOLUME_M3 = 1e-13
# Height of the pyramid behind a flat face: share of the face's width, and its bound in metres. A choice: too small
# to be seen.
DEPTH_SHARE, MAX_DEPTH_M = 0.1, 0.0005


def has_volume(mesh: Mesh) -> bool:
    """True if MuJoCo's oldest method finds a volume in a mesh (metres), closed or not.

    Ref: MuJoCo XML reference, asset/mesh/inertia, `legacy`: tetrahedra from the middle to all faces, without signs.
    """
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    if not areas.sum() > 0:
        return False
    a, b, c = np.moveaxis(corners - np.average(corners.mean(axis=1), axis=0, weights=areas), 1, 0)
    return float(np.abs(np.einsum("fd,fd->f", a, np.cross(b, c))).sum()) / 6 > MIN_VOLUME_M3


def thickened(asset: Asset) -> Asset:
    """The asset with a small pyramid behind the largest face of every flat visual (a label, a blade)."""
    links = []
    for link in asset.links:
        is_flat = [not has_volume(visual.mesh) for visual in link.visuals]
        visuals = [
            v.replace(mesh=_with_pyramid(v.mesh)) if f else v for v, f in zip(link.visuals, is_flat, strict=True)
        ]
        links.append(link.replace(visuals=tuple(visuals)) if any(is_flat) else link)
    return asset.replace(links=tuple(links))


def _with_pyramid(mesh: Mesh) -> Mesh:
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled_areas = np.linalg.norm(normals, axis=1)
    largest = int(np.argmax(np.round(doubled_areas, 12)))
    if not doubled_areas[largest] > 0:
        return mesh
    normal = normals[largest] / doubled_areas[largest]
    depth = min(DEPTH_SHARE * float(np.sqrt(doubled_areas[largest])), MAX_DEPTH_M)
    a, b, c = (int(i) for i in mesh.faces[largest])
    tip = len(mesh.vertices)
    return Mesh(
        vertices=np.vstack([mesh.vertices, corners[largest].mean(axis=0) - depth * normal]),
        faces=np.vstack([mesh.faces, [(b, a, tip), (c, b, tip), (a, c, tip)]]),
        uv=None if mesh.uv is None else np.vstack([mesh.uv, mesh.uv[[a, b, c]].mean(axis=0)]),
        normals=None if mesh.normals is None else np.vstack([mesh.normals, -normal]),
    )


# Upright --------------------------------------------------------------------------------------------------------------
# Ref: robocasa v1.0 reads `model_upright.xml` next to `model.xml` if a task asks for it (slices of bread, straws).

# Longer than this many times its width it is put on end (a straw), else on its edge (a slice of bread), whose thickness
# is along x: toasters have their slots beside each other along x, and tasks put bread into them without turning it.
MIN_SLENDERNESS = 2.5
ON_EDGE = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # y goes up; z, the thickness, goes along x
AROUND_Y = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])  # x goes up


def turn_of(asset: Asset) -> Pose:
    """stood_from_lying: quarter turns, and the translation that moves the middle of the object back to the origin.

    An object that is taller than wide is not turned.
    """
    lower, upper = asset.bounds
    x, y, z = upper - lower
    if z >= max(x, y):
        return Pose()
    rotation = AROUND_Y if x > MIN_SLENDERNESS * y else ON_EDGE
    corners = asset.bounds @ rotation.T
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = -(lower + upper) / 2
    return Pose.from_matrix(matrix)


def stand_up(root: etree._Element, asset: Asset) -> None:
    """Turn all elements in the document of an object in place; meshes and their files are not changed."""
    turn = turn_of(asset)
    if turn == Pose():
        return
    (outer,) = root.findall("worldbody/body")
    for element in outer.findall("body/*"):
        _turn(element, turn)
    corners = turn.apply(asset.bounds)
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    points = {
        "bottom_site": (0.0, 0.0, lower[2]),
        "top_site": (0.0, 0.0, upper[2]),
        "horizontal_radius_site": (*(upper[:2] - lower[:2]) / 2, 0.0),
    }
    for name, point in points.items():
        for site in outer.findall(f"site[@name='{name}']"):
            site.set("pos", _numbers_text(point))


def _turn(element: etree._Element, turn: Pose) -> None:
    """Turn an element of the body; a region stays a box along the axes, since runtimes ignore its rotation."""

    def values(name: str, default: str = "") -> list[float]:
        return [float(word) for word in element.get(name, default).split()]

    (x, y, z), (a, b, c, d) = values("pos", "0 0 0"), values("quat", "1 0 0 0")
    pose = turn @ Pose(position=(x, y, z), quaternion=(a, b, c, d))
    element.set("pos", _numbers_text(pose.position))
    is_region = element.get("name", "").startswith("reg_") and element.get("type") == "box"
    if element.tag == "inertial":
        xx, yy, zz, xy, xz, yz = values("fullinertia")
        quarter = np.rint(turn.rotation)  # a quarter turn only changes places and signs
        rotated = quarter @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ quarter.T
        inertia = (rotated[0, 0], rotated[1, 1], rotated[2, 2], rotated[0, 1], rotated[0, 2], rotated[1, 2])
        element.set("fullinertia", numbers(inertia))
    elif is_region:
        element.set("size", _numbers_text(np.abs(pose.rotation) @ np.array(values("size"))))
    if any(pose.quaternion[1:]) and not is_region and element.tag != "inertial":
        element.set("quat", _numbers_text(pose.quaternion))
    else:
        element.attrib.pop("quat", "")


def _numbers_text(values: Iterable[float]) -> str:
    """Text with twelve decimals: a quarter turn must not leave rounding errors such as 1e-17."""
    return numbers(round(float(value), 12) for value in values)


# Entries --------------------------------------------------------------------------------------------------------------
# One table of OBJ_CATEGORIES per release: types and attributes of a category and, per object registry, the folders of
# its models. We have three registries: all instances, those for training and those for testing. RoboCasa's own splits
# depend on the order of file names; ours depend on the digest of the source or shape of the instance.

FOLDER = "objects"
# Attributes of a category that a generation knows. Ref: robocasa v0.2 and v1.0, kitchen_object_utils.
_FIRST = tuple(Affordance(use) for use in ("graspable", "washable", "microwavable", "cookable", "freezable"))
ATTRIBUTES: Mapping[RobocasaRelease, tuple[Affordance, ...]] = {
    RobocasaRelease.V0_2: _FIRST,
    RobocasaRelease.V1_0: (*_FIRST, Affordance.FRIDGABLE, Affordance.DISHWASHABLE),
}


class Instance(Record):
    """One object of the export; its folder has the name of its id."""

    id: Id
    category: Id
    split: Split


def instance_folder(instance: Instance, registry: str) -> str:
    """Folder of an instance below the root of the export."""
    return f"{FOLDER}/{registry}/{instance.category}/{instance.id}"


def registry_splits(registry: str) -> dict[str, Split | None]:
    """Object registry -> split of its instances (None: all)."""
    return {registry: None, **{f"{registry}_{split.value}": split for split in Split}}


def category_tables(
    instances: Sequence[Instance], categories: Mapping[str, Category], registry: str
) -> dict[RobocasaRelease, dict[str, Any]]:
    """For each generation: category -> entry, sorted, without registries from which RoboCasa could draw nothing."""
    return {
        generation: {
            name: _entry(categories[name], [i for i in instances if i.category == name], registry, generation)
            for name in sorted({i.category for i in instances})
        }
        for generation in RobocasaRelease
    }


def _entry(
    category: Category, instances: Sequence[Instance], registry: str, generation: RobocasaRelease
) -> dict[str, Any]:
    entry: dict[str, Any] = {"types": [kind.value for kind in category.types]}
    entry |= {use.value: category.can(use) for use in ATTRIBUTES[generation]}
    for name, split in registry_splits(registry).items():
        if any(split in (None, i.split) for i in instances):
            entry[name] = {
                "model_folders": [f"{registry}/{category.id}"],
                "exclude": sorted(i.id for i in instances if split not in (None, i.split)),
                # Our models have their real size. It must be a float: RoboCasa takes an int for a list.
                "scale": 1.0,
            }
    return entry


def file_name(generation: RobocasaRelease) -> str:
    """Name of the file of a generation's entries."""
    return f"categories_{generation.value}.json"


def json_bytes(data: Any) -> bytes:
    """JSON for people and programs, sorted, ASCII."""
    return (json.dumps(data, sort_keys=True, indent=1, allow_nan=False) + "\n").encode("ascii")


# Objects of tasks -----------------------------------------------------------------------------------------------------
# Ref: robocasa v1.0.1, `_get_obj_cfgs` of the tasks, `create_obj` (env_utils.py) and `sample_kitchen_object`. If no
# category suits a draw, the reset fails with "a cannot be empty"; if no object is small enough, it never ends.

EVERYTHING = "all"
# Groups that are neither a category nor a type. Ref: robocasa v1.0, OBJ_GROUPS.
CUSTOM_GROUPS: Mapping[str, tuple[str, ...]] = {
    "container": ("plate",),
    "cookware": ("pan", "pot", "saucepan", "kettle_non_electric"),
    "oven_ready": (
        *("corn", "fish", "steak", "tray", "potato", "sweet_potato", "chicken_drumstick", "eggplant", "broccoli"),
    ),
}


@dataclass(frozen=True)
class Draw:
    """One object that a task asks for: of one of some groups, of none of others, with affordances; sizes in metres."""

    groups: tuple[str, ...] = (EVERYTHING,)
    uses: tuple[Affordance, ...] = ()
    without: tuple[str, ...] = ()
    max_size: Vec3 = (math.inf, math.inf, math.inf)

    def __str__(self) -> str:
        """Text such as `tool or utensil, graspable, at most 0.1 m high`."""
        parts = [" or ".join(self.groups).replace(EVERYTHING, "anything"), *(use.value for use in self.uses)]
        if self.without:
            parts.append(f"no {' or '.join(self.without)}")
        if self.max_size[0] < math.inf:
            parts.append(f"at most {self.max_size[0]:g} x {self.max_size[1]:g} m")
        if self.max_size[2] < math.inf:
            parts.append(f"at most {self.max_size[2]:g} m high")
        return ", ".join(parts)

    def suits(self, category: Category, size: Vec3) -> bool:
        """True if an object of this category and size (along x, y and z, metres) may be drawn."""
        return (
            any(_is_in(category, group) for group in self.groups)
            and not any(_is_in(category, group) for group in self.without)
            and all(category.can(use) for use in self.uses)
            and all(length <= most for length, most in zip(size, self.max_size, strict=True))
        )


def _is_in(category: Category, group: str) -> bool:
    types = {kind.value for kind in category.types}
    if group == EVERYTHING:  # RoboCasa's own categories, and ours that have a type (`casa_objects.py`)
        return bool(types) or RobocasaRelease.V1_0 in category.runtime
    if group in CUSTOM_GROUPS:
        return category.id in CUSTOM_GROUPS[group]
    return group == category.id or group in types or not types.isdisjoint(GROUPS.get(group, ()))


_GRASPED = (Affordance.GRASPABLE,)
_COLD = (Affordance.GRASPABLE, Affordance.FRIDGABLE)
_HEATED = (Affordance.GRASPABLE, Affordance.MICROWAVABLE)
_COOKED = (Affordance.GRASPABLE, Affordance.COOKABLE)
_WASHED = (Affordance.GRASPABLE, Affordance.WASHABLE)
_ANY, _IN_HAND, _IN_SINK = Draw(), Draw(uses=_GRASPED), Draw(uses=(Affordance.WASHABLE,))
_PLATE, _CONTAINER, _TRAY, _PAN = (Draw((name,)) for name in ("plate", "container", "oven_tray", "pan"))
_MUG, _SANDWICH_BREAD, _COOKWARE = (Draw((name,)) for name in ("mug", "sandwich_bread", "cookware"))
_HOT_CONTAINER = Draw(("container",), (Affordance.MICROWAVABLE,))
_PRODUCE = Draw(("vegetable", "fruit"), _COLD)
_BREAD = Draw(("bread_food",), _GRASPED)
_TOOL = Draw(("tool", "utensil"), _GRASPED, ("reamer", "strainer", "cheese_grater"))
_LOW_TOOL = Draw(("tool", "utensil"), _GRASPED, max_size=(math.inf, math.inf, 0.1))
_COOKED_FOOD = Draw(("food",), _COOKED)

# Task -> what a reset draws; a task that is not here draws nothing. What food is put into is among them: it is drawn
# together with the food.
TASK_DRAWS: Mapping[str, tuple[Draw, ...]] = {
    "CheesyBread": (Draw(("bread_flat",)), Draw(("cutting_board",)), Draw(("cheese",)), _ANY),
    **dict.fromkeys(("OpenCabinet", "CloseCabinet"), (_IN_HAND, _ANY)),
    **dict.fromkeys(("PickPlaceCounterToCabinet", "PickPlaceCabinetToCounter"), (_IN_HAND, _ANY)),
    **dict.fromkeys(("OpenDishwasher", "CloseDishwasher"), (_ANY,)),
    **dict.fromkeys(("OpenDrawer", "CloseDrawer"), (_LOW_TOOL, _ANY)),
    **dict.fromkeys(("OpenFridge", "CloseFridge"), (Draw(uses=_COLD), _ANY)),
    **dict.fromkeys(("OpenFridgeDrawer", "CloseFridgeDrawer"), (_PRODUCE, Draw(uses=_COLD))),
    **dict.fromkeys(("OpenMicrowave", "CloseMicrowave"), (Draw(uses=_HEATED), _ANY)),
    **dict.fromkeys(("OpenOven", "CloseOven"), (Draw(uses=_COOKED), _TRAY, _ANY)),
    **dict.fromkeys(("StartCoffeeMachine", "CoffeeSetupMug", "CoffeeServeMug"), (_MUG,)),
    "LowerHeat": (Draw(("kettle_non_electric",)),),
    "MakeIcedCoffee": (Draw(("bowl",)), Draw(("ice_cube",)), Draw(("glass_cup",))),
    "PackDessert": (
        Draw(("cooked_food",), _GRASPED),
        Draw(("tupperware",)),
        Draw(("sweets",), _GRASPED, ("sugar_cube",)),
    ),
    "PickPlaceCounterToBlender": (Draw(("fruit",), _GRASPED), Draw(without=("fruit", "vegetable"))),
    **dict.fromkeys(
        ("PickPlaceCounterToDrawer", "PickPlaceDrawerToCounter"), (_TOOL, Draw(without=("tool", "utensil")))
    ),
    "PickPlaceCounterToMicrowave": (
        Draw(("food",), _HEATED),
        _CONTAINER,
        Draw(("plate",), (Affordance.MICROWAVABLE,)),
        _ANY,
    ),
    "PickPlaceMicrowaveToCounter": (Draw(("food",), _HEATED), _HOT_CONTAINER, _CONTAINER, _ANY),
    "PickPlaceCounterToOven": (Draw(("oven_ready",), _GRASPED), _PLATE, _TRAY),
    "PickPlaceCounterToSink": (Draw(uses=_WASHED), _ANY, _IN_SINK),
    "PickPlaceSinkToCounter": (Draw(("food",), _WASHED), _CONTAINER, _ANY),
    "PickPlaceCounterToStandMixer": (Draw(("cheese", "bread", "cake"), _GRASPED),),
    "PickPlaceCounterToStove": (_PAN, _COOKED_FOOD, _CONTAINER),
    "PickPlaceStoveToCounter": (
        Draw(("food",), _COOKED, max_size=(0.15, 0.15, math.inf)),
        _PAN,
        Draw(("plate", "bowl")),
    ),
    **dict.fromkeys(("PickPlaceCounterToToasterOven", "PickPlaceToasterOvenToCounter"), (_BREAD, _PLATE)),
    "PickPlaceToasterToCounter": (_SANDWICH_BREAD, _PLATE),
    **dict.fromkeys(
        ("PickPlaceFridgeShelfToDrawer", "PickPlaceFridgeDrawerToShelf"),
        (_PRODUCE, Draw(uses=(Affordance.FRIDGABLE,), without=("vegetable", "fruit"))),
    ),
    **dict.fromkeys(("TurnOnMicrowave", "TurnOffMicrowave"), (Draw(uses=(Affordance.MICROWAVABLE,)), _HOT_CONTAINER)),
    **dict.fromkeys(("TurnOnSinkFaucet", "TurnOffSinkFaucet", "TurnSinkSpout"), (_IN_SINK, _ANY)),
    **dict.fromkeys(("TurnOnStove", "TurnOffStove"), (_COOKWARE,)),
    "TurnOnBlender": (Draw(("fruit",)),),
    "TurnOnToaster": (_SANDWICH_BREAD,),
}


def missing_draws(things: Collection[tuple[Category, Vec3]]) -> dict[str, tuple[Draw, ...]]:
    """Task -> its draws that none of the things, category and size (x, y, z, m), suits; only tasks that have some."""
    draws = {draw for wanted in TASK_DRAWS.values() for draw in wanted}
    lacking = {draw for draw in draws if not any(draw.suits(*thing) for thing in things)}
    found = {task: tuple(draw for draw in wanted if draw in lacking) for task, wanted in TASK_DRAWS.items()}
    return {task: wanted for task, wanted in sorted(found.items()) if wanted}


def categories_for(missing: Mapping[str, tuple[Draw, ...]], known: Collection[Category]) -> tuple[str, ...]:
    """A few of the known categories whose objects suit all missing draws that any suits, sorted.

    Greedy: each choice is the category that suits most of the remaining draws.
    """
    left = {draw for draws in missing.values() for draw in draws}
    chosen: list[str] = []
    while left:
        met = {c.id: {draw for draw in left if draw.suits(c, _usual(c))} for c in known}
        best = max(sorted(met), key=lambda name: len(met[name]), default="")
        if not best or not met[best]:
            break
        chosen.append(best)
        left -= met[best]
    return tuple(sorted(chosen))


def _usual(category: Category) -> Vec3:
    x, y, z = (side.typical for side in category.extents)
    return (x, y, z)
