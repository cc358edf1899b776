"""Material or colour of each primitive of a batch form: reduced pictures of the parts it represents, or one colour."""

from __future__ import annotations

import io
from collections import defaultdict
from collections.abc import Iterator
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from lxml import etree
from PIL import Image

from casa_assets.core.typing import Floats, Mask
from casa_assets.export.mjcf import material, number
from casa_assets.export.mjcf.scene.kitchen import light_colors
from casa_assets.export.mjcf.scene.resources import SceneResources, add_all
from casa_assets.export.mjcf.scene.room import scene_bounds
from casa_assets.geometry.collider_colors import mean_color
from casa_assets.geometry.shown_materials import ShownMaterials, open_sides
from casa_assets.model.asset.asset import Asset, Collider
from casa_assets.model.asset.joint import joint_positions
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.asset.shape import Box, Shape
from casa_assets.model.kitchen.batch_scene import PICTURE_PX, BatchScene
from casa_assets.model.kitchen.scene import Layer, LightScene, Placement
from casa_assets.model.pose import Pose

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
        pictures = {material.path(image): image for image in images if image is not None}
        return SceneResources({}, pictures, dict(sorted(self._materials.items())))

    def add_resources(self, assets: etree._Element, folder: str) -> None:
        """Add the pictures and materials below `<asset>`; `folder`: path to the folder that scenes share."""
        add_all(assets, self.resources, folder)
        for element in assets.iterchildren("material"):
            tile = self._materials[element.get("name", "")].tile_m
            assert tile is not None, "only pictures that repeat are shown"
            # MuJoCo counts how often a picture is there on half of the length of a box.
            element.set("texuniform", "true")
            element.set("texrepeat", number.numbers(2 / side for side in tile))

    def _look(self, asset: str, collider: Collider, shown: ShownMaterials, is_open: Mask) -> Look:
        found = shown.on(collider.shape, collider.pose, is_open)
        if found is None:
            return Look(collider, {"rgba": self._mean(asset, collider.name)})
        picture = found.material.base_color_texture
        if found.turn is None or picture is None or not isinstance(collider.shape, Box):
            return Look(collider, {"rgba": number.numbers(round(c, 3) for c in mean_color(found.material))})
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
    return Texture(
        name=picture.name, png=data.getvalue(), width_px=width, height_px=height, color_space=picture.color_space
    )
