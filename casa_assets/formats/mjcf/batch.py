"""Batch form of a scene -> one flat scene_batch.xml of primitives that sleep at rest."""

from __future__ import annotations

import io
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from lxml import etree
from PIL import Image

from casa_assets.asset.shown_materials import ShownMaterials, mean_color, open_sides
from casa_assets.core.numeric import Floats, Mask
from casa_assets.formats.mjcf import shapes
from casa_assets.formats.mjcf.document import BodyContext
from casa_assets.formats.mjcf.kitchen import (
    SceneResources,
    add_exclusions,
    add_placement,
    add_poses,
    add_shared_resources,
    add_texts,
    begin_document,
    light_colors,
    scene_bounds,
)
from casa_assets.formats.mjcf.shapes import Meshes
from casa_assets.formats.values import VIEWER_GROUPS, numbers
from casa_assets.model.asset.asset import Asset, Base, Collider
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.asset.parts import Box, Shape, joint_positions
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import PICTURE_PX, BatchScene, Layer, LightScene, Placement
from casa_assets.model.pose import Pose

# Appearance -----------------------------------------------------------------------------------------------------------
# Material or colour of each primitive of a batch form: reduced pictures of the parts it represents, or one colour.

# Pictures to keep: as many as a kitchen has, and to spare.
KEPT_PICTURES = 64


class Look(NamedTuple):
    """Appearance of a primitive.

    Attributes:
        collider: the same solid; a box with a picture is described so that the side which shows the picture is its top.
        attributes: attributes of its geom.
    """

    collider: Collider
    attributes: dict[str, str]


class Appearance:
    """Looks of the primitives of a kitchen, and the pictures and materials that they use.

    Attributes:
        world: looks of the static primitives, in the order of the batch form.
        parts: (placement, collider) -> look of each other primitive.
    """

    def __init__(self, batch: BatchScene) -> None:
        self._colors: dict[str, dict[str, str]] = {}
        self._materials: dict[str, Material] = {}
        self._assets = {asset.id: asset for asset in batch.scene.assets}
        self.parts: dict[tuple[str, str], Look] = {}
        middle = scene_bounds(batch.scene).mean(axis=0)
        standing = defaultdict(list)
        for index, item in enumerate(batch.world):
            standing[item.placement].append(index)
        sides = open_sides(list(_solids(batch)))
        world: dict[int, Look] = {}
        of_parts = iter(sides[len(batch.world) :])
        for place, form in zip(batch.scene.placements, batch.forms, strict=True):
            visuals = _PlacedVisuals(place, self._assets[place.asset], middle)
            for index in standing[place.name]:
                world[index] = self._look(form.id, batch.world[index].collider, visuals.in_world, sides[index])
            for link in form.links:
                for collider in link.colliders:
                    look = self._look(form.id, collider, visuals.of_link(link.name), next(of_parts))
                    self.parts[place.name, collider.name] = look
        self.world = [world[index] for index in range(len(batch.world))]

    @property
    def resources(self) -> SceneResources:
        """Every picture and material that is used."""
        images = [item.base_color_texture for _, item in sorted(self._materials.items())]
        pictures = {shapes.texture_path(image): image for image in images if image is not None}
        return SceneResources({}, pictures, dict(sorted(self._materials.items())))

    def add_resources(self, assets: etree._Element, folder: str) -> None:
        """Add the pictures and materials below `<asset>`; `folder`: path to the folder that scenes share."""
        add_shared_resources(assets, self.resources, folder)
        for element in assets.iterchildren("material"):
            tile = self._materials[element.get("name", "")].tile_m
            assert tile is not None, "only pictures that repeat are shown"
            # MuJoCo counts how often a picture is there on half of the length of a box.
            element.set("texuniform", "true")
            element.set("texrepeat", numbers(2 / side for side in tile))

    def _look(self, asset: str, collider: Collider, shown: ShownMaterials, is_open: Mask) -> Look:
        found = shown.on(collider.shape, collider.pose, is_open)
        if found is None:
            return Look(collider, {"rgba": self._mean(asset, collider.name)})
        picture = found.material.base_color_texture
        if found.turn is None or picture is None or not isinstance(collider.shape, Box):
            return Look(collider, {"rgba": numbers(round(c, 3) for c in mean_color(found.material))})
        small = found.material.replace(base_color_texture=_reduced(picture))
        name = f"{small.id}_{small.digest[:12]}"
        self._materials[name] = small
        sizes = abs(found.turn.T) @ collider.shape.size
        box = Box(size=(float(sizes[0]), float(sizes[1]), float(sizes[2])))
        pose = collider.pose @ Pose.from_matrix(found.turn)
        return Look(collider.replace(shape=box, pose=pose), {"material": name})

    def _mean(self, asset: str, name: str) -> str:
        """Mean colour of the visuals that a collider represents; a further piece has the colour of its collider."""
        if asset not in self._colors:
            self._colors[asset] = light_colors(self._assets[asset], self._assets[asset])
        known = self._colors[asset]
        return known[name] if name in known else known[LightScene.collider_of(name)]


class _PlacedVisuals:
    """Materials shown by the visuals of a placement, in the world and in its links, as the kitchen begins."""

    def __init__(self, place: Placement, asset: Asset, middle_of_room: Floats) -> None:
        positions = joint_positions(place.joints)
        self._asset, self._is_room = asset, place.layer is not Layer.THINGS
        self._poses = {link.name: place.pose @ asset.asset_from_link(link.name, positions) for link in asset.links}
        has_visuals = any(link.visuals for link in asset.links)
        own = place.pose.apply(asset.bounds) if has_visuals else np.array([place.pose.position])
        self._middle = middle_of_room if self._is_room else own.mean(axis=0)
        self._links: dict[str, ShownMaterials] = {}

    @cached_property
    def in_world(self) -> ShownMaterials:
        """Materials of all links, in the world frame."""
        visuals = [(visual, self._poses[link.name]) for link in self._asset.links for visual in link.visuals]
        return ShownMaterials.of(visuals, self._asset.materials, self._middle, self._is_room)

    def of_link(self, name: str) -> ShownMaterials:
        """Materials of one link, in its frame."""
        if name not in self._links:
            visuals = [(visual, Pose()) for visual in self._asset.link(name).visuals]
            middle = self._poses[name].inverse().apply(self._middle[None])[0]
            self._links[name] = ShownMaterials.of(visuals, self._asset.materials, middle, self._is_room)
        return self._links[name]


def _solids(batch: BatchScene) -> Iterator[tuple[Shape, Pose]]:
    """Yield every primitive in the world as the kitchen begins: static ones, then the parts of each placement."""
    for item in batch.world:
        yield item.collider.shape, item.collider.pose
    for place, form in zip(batch.scene.placements, batch.forms, strict=True):
        positions = joint_positions(place.joints)
        for link in form.links:
            world_from_link = place.pose @ form.asset_from_link(link.name, positions)
            for collider in link.colliders:
                yield collider.shape, world_from_link @ collider.pose


@lru_cache(maxsize=KEPT_PICTURES)
def _reduced(picture: Texture) -> Texture:
    """A picture scaled down to at most PICTURE_PX along a side."""
    longer = max(picture.width_px, picture.height_px)
    if longer <= PICTURE_PX:
        return picture
    width, height = (max(1, round(side * PICTURE_PX / longer)) for side in (picture.width_px, picture.height_px))
    with Image.open(io.BytesIO(picture.png)) as image:
        small = image.convert("RGB").resize((width, height), Image.Resampling.BOX)
    data = io.BytesIO()
    small.save(data, "PNG")
    return picture.replace(png=data.getvalue(), width_px=width, height_px=height)


# Batch ----------------------------------------------------------------------------------------------------------------
# Names are those of the other forms. Two geoms can touch if the contype of one has a bit of the conaffinity of the
# other. The bits of `contype` and `conaffinity` are:
#
# | | contype | conaffinity |
# |---|---|---|
# | added robots and objects, with MuJoCo's defaults | 1 | 1 |
# | static parts | 1, THINGS | |
# | static parts overhead | 1 | |
# | loose objects | 1, THINGS | THINGS |
# | moving parts of fixtures | 1, THINGS, bit of the set of parts that can meet | bit of that set |

FILE = "scene_batch.xml"
# Bits of contype and conaffinity: of everything by default, of loose things, and the first of fixtures that can meet.
DEFAULT, THINGS, FIRST_MEETING = 1, 2, 2
# MuJoCo has 32 bits, the last of which is a sign.
LAST_MEETING = 30
# Everything that touches is seen.
GROUPS = replace(VIEWER_GROUPS, colliders=VIEWER_GROUPS.visuals)


def write(batch: BatchScene, sleeps: bool = True, shared: str = "../assets") -> Files:
    """Return the MJCF of the batch form of a scene; the same form gives the same bytes.

    Args:
        sleeps: let the engine skip bodies at rest until something touches or drives them. False for engines without
            sleep. No body is asleep in the file itself: mujoco_warp 4.0 rejects a model that begins so.
        shared: path from the folder of scene_batch.xml to the one that scenes share.
    Returns:
        `scene_batch.xml`, and the pictures of the shared folder as `assets/textures/<name>_<hash>.png`.
    """
    scene = batch.scene
    root, assets, world = begin_document(scene, is_fused=True, **({"sleep": "enable"} if sleeps else {}))
    full = {asset.id: asset for asset in scene.assets}
    appearance = Appearance(batch)
    _add_world(world, batch, full, appearance)
    contexts = []
    # (placement, link) -> bit of the set of links that it can meet; if there are too many, sets share the last bit.
    meeting = {
        (ref.placement, ref.link): 1 << min(FIRST_MEETING + number, LAST_MEETING)
        for number, group in enumerate(batch.meeting)
        for ref in group
    }
    for place, form in zip(scene.placements, batch.forms, strict=True):
        looks = {c.name: appearance.parts[place.name, c.name] for link in form.links for c in link.colliders}
        # Boxes are described as their looks require.
        links = [k.replace(colliders=tuple(looks[c.name].collider for c in k.colliders)) for k in form.links]
        form = form.replace(links=tuple(links))
        context = BodyContext(form, Meshes((), {}), {}, GROUPS, place.name)
        body = add_placement(world, place, context)
        geoms = {geom.get("name"): geom for geom in body.iter("geom")}
        for name, look in looks.items():
            _paint(geoms[f"{place.name}__{name}"], look)
        if form.base is Base.FREE:
            _set_bits(body, DEFAULT | THINGS, THINGS)
        else:
            for link in form.links:
                bit = meeting.get((place.name, link.name), 0)
                name = context.body_name(link.name)
                own = next(below for below in body.iter("body") if below.get("name") == name)
                _set_bits(own, DEFAULT | THINGS | bit, bit)
        contexts.append(context)
    add_exclusions(root, contexts)
    add_texts(root, scene, contexts)
    add_poses(root, scene, contexts)
    appearance.add_resources(assets, shared)
    text = etree.tostring(root, encoding="us-ascii", pretty_print=True)
    return Files.of({FILE: text, **appearance.resources.entries})


def _paint(geom: etree._Element, look: Look) -> None:
    """Apply a look to a geom. Its colour is removed, since MuJoCo would use it instead of the material's."""
    del geom.attrib["rgba"]
    for name, value in look.attributes.items():
        geom.set(name, value)


def _add_world(world: etree._Element, batch: BatchScene, assets: Mapping[str, Asset], appearance: Appearance) -> None:
    places = {place.name: place for place in batch.scene.placements}
    for item, look in zip(batch.world, appearance.world, strict=True):
        place = places[item.placement]
        substance = assets[place.asset].substance(item.collider.substance)
        group = VIEWER_GROUPS.shell if item.is_overhead else VIEWER_GROUPS.visuals
        geom = shapes.add_collider(world, look.collider, substance, Meshes((), {}), group, f"{item.placement}__")
        _paint(geom, look)
        geom.set("contype", str(DEFAULT if item.is_overhead else DEFAULT | THINGS))
        geom.set("conaffinity", "0")


def _set_bits(body: etree._Element, contype: int, conaffinity: int) -> None:
    """Set the bits of the colliding geoms of a body; for a loose object, also of all bodies that it carries."""
    everything = conaffinity == THINGS
    for geom in body.iter("geom") if everything else body.findall("geom"):
        if geom.get("contype") == "1":
            geom.set("contype", str(contype))
            geom.set("conaffinity", str(conaffinity))
