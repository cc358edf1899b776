"""Asset or Scene -> GLB: nodes with joints, visuals, colliders and regions in layers that a viewer shows or hides."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np

from casa_assets.formats.gltf.mesh import Binary, Materials, Meshes, glb, placed, rounded
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.model.asset.asset import Asset, Joint, Link, Region, Visual
from casa_assets.model.asset.parts import Box, Cylinder, Shape, Sphere, joint_positions
from casa_assets.model.kitchen.scene import CLOSED_POSE, OUTER_FACE, Layer, Placement, Scene, key_positions
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

# Layer ----------------------------------------------------------------------------------------------------------------
# Colliders and regions of a link -> separate nodes, each in a layer that a viewer shows or hides.

STEPS = 24  # corners of a circle


class LayerName(StrEnum):
    """Value of `extras.layer` of a node that shows something."""

    VISUAL = "visual"
    OUTSIDE = "outside"  # faces of walls that look out of the room; a viewer leaves them out, to look in
    CEILING = "ceiling"  # likewise
    COLLIDER = "collider"
    REGION = "region"


@dataclass(frozen=True)
class Layers:
    """Layers of a file in addition to the visuals: collision shapes, regions. A viewer hides both at first."""

    colliders: bool = False
    regions: bool = False


SEEN_ALONE, EVERYTHING = Layers(), Layers(colliders=True, regions=True)


# Linear RGBA; colliders take these in turn, so that neighbours are told apart.
COLLIDER_COLORS = (
    (0.90, 0.20, 0.12, 0.55),
    (0.08, 0.42, 0.75, 0.55),
    (0.95, 0.62, 0.05, 0.55),
    (0.12, 0.55, 0.22, 0.55),
    (0.48, 0.20, 0.70, 0.55),
    (0.02, 0.55, 0.58, 0.55),
)
REGION_COLOR = (0.05, 0.65, 0.30, 0.22)


def layer_nodes(link: Link, regions: tuple[Region, ...], meshes: Meshes, wanted: Layers) -> Iterator[dict[str, Any]]:
    """Yield a node for each collider and region of a link, if they are wanted.

    Args:
        regions: all regions of the asset.
    """
    if wanted.colliders:
        for number, collider in enumerate(link.colliders):
            turn = number % len(COLLIDER_COLORS)
            material = meshes.materials.plain(f"collider_{turn}", COLLIDER_COLORS[turn])
            facts = {"name": collider.name, "kind": collider.shape.kind, "substance": collider.substance}
            extras = {"layer": LayerName.COLLIDER.value, "collider": facts}
            shown = _shown(collider.shape, collider.pose, meshes, material)
            yield {"name": collider.name, "extras": extras, **shown}
    if wanted.regions:
        for region in (region for region in regions if region.link == link.name):
            material = meshes.materials.plain("region", REGION_COLOR)
            width, depth, height = region.size
            # A cylinder whose box is not square is an ellipse; the scale of its node makes it one.
            shape: Shape = Box(size=region.size) if region.kind == "box" else Cylinder(radius=0.5, height=1.0)
            shown = _shown(shape, region.pose, meshes, material)
            if region.kind == "cylinder":
                shown["scale"] = rounded((width / 2, depth / 2, height))
            extras = {"layer": LayerName.REGION.value, "region": {"name": region.name, "kind": region.kind}}
            yield {"name": region.name, "extras": extras, **shown}


def _shown(shape: Shape, pose: Pose, meshes: Meshes, material: int) -> dict[str, Any]:
    """Mesh, pose and scale of a shape: primitives share one mesh of unit size, scaled by their nodes."""
    unit, scale = _unit(shape)
    points, faces = tessellate(unit, Pose(), STEPS)
    used = np.unique(faces)
    mesh = meshes.bare(points[used], np.searchsorted(used, faces), material)
    sized = {} if scale == (1.0, 1.0, 1.0) else {"scale": rounded(scale)}
    return {"mesh": mesh, **placed(pose), **sized}


def _unit(shape: Shape) -> tuple[Shape, Vec3]:
    """A shape of unit size, and the scale that turns it into the given one."""
    if isinstance(shape, Box):
        return Box(size=(1.0, 1.0, 1.0)), shape.size
    if isinstance(shape, Sphere):
        return Sphere(radius=1.0), (shape.radius, shape.radius, shape.radius)
    if isinstance(shape, Cylinder):
        return Cylinder(radius=1.0, height=1.0), (shape.radius, shape.radius, shape.height)
    return shape, (1.0, 1.0, 1.0)


# Body -----------------------------------------------------------------------------------------------------------------
# Links of an asset -> nodes below each other, with their joints, visuals, colliders and regions.


@dataclass
class Nodes:
    """Nodes as glTF lists them."""

    rows: list[dict[str, Any]] = field(default_factory=list)

    def add(self, row: dict[str, Any], below: int | None = None) -> int:
        """Add a node as a child of the node `below`, and return its index."""
        self.rows.append(row)
        index = len(self.rows) - 1
        if below is not None:
            self.rows[below].setdefault("children", []).append(index)
        return index


@dataclass(frozen=True)
class Copy:
    """One copy of an asset in a document.

    Attributes:
        prefix: prefix of the names of its nodes and joints: empty, or the placement's name and a slash.
        layer: layer of its visuals.
        positions: joint name -> position in the file, rad or m; joints that are not named are at zero.
    """

    asset: Asset
    prefix: str = ""
    layer: LayerName = LayerName.VISUAL
    positions: Mapping[str, float] = field(default_factory=dict)


def add_nodes(nodes: Nodes, meshes: Meshes, copy: Copy, below: int, wanted: Layers) -> dict[str, int]:
    """Add a node for each link below the node `below`; return link name -> index of its node."""
    asset = copy.asset
    looks = {material.id: material for material in asset.materials}
    found: dict[str, int] = {}
    for link in asset.links:
        moved_by = asset.joint_of(link.name)
        extras: dict[str, Any] = {"link": link.name}
        if moved_by is not None:
            extras["joint"] = joint_facts(asset, moved_by, copy)
        pose = asset.parent_from_link(link.name, copy.positions)
        row = {"name": copy.prefix + link.name, "extras": extras, **placed(pose)}
        found[link.name] = nodes.add(row, below if link.parent is None else found[link.parent])
        _add_visuals(nodes, meshes, link, looks, copy, found[link.name])
        for part in layer_nodes(link, asset.regions, meshes, wanted):
            nodes.add({**part, "name": f"{copy.prefix}{link.name}/{part['name']}"}, found[link.name])
    return found


def joint_facts(asset: Asset, joint: Joint, copy: Copy) -> dict[str, Any]:
    """`extras.joint` of the link that a joint moves; `rest` is the position of the joint in the file."""
    states = {s.value: rounded(s.interval) for s in asset.states if s.joint == joint.name}
    return {
        "name": copy.prefix + joint.name,
        "type": joint.kind.value,
        "axis": rounded(joint.axis),
        "anchor": rounded(joint.anchor),
        "range": rounded(joint.range),
        "rest": rounded([copy.positions.get(joint.name, 0.0)])[0],
        **({"states": states} if states else {}),
        **({} if joint.behind is None else {"behind": copy.prefix + joint.behind}),
    }


def _add_visuals(nodes: Nodes, meshes: Meshes, link: Link, looks: dict[str, Any], copy: Copy, below: int) -> None:
    """Add one node for the visuals of a link, and another for faces that look out of the room."""
    groups: dict[LayerName, list[Visual]] = {}
    for visual in link.visuals:
        group = LayerName.OUTSIDE if visual.label == OUTER_FACE else copy.layer
        groups.setdefault(group, []).append(visual)
    for group, visuals in groups.items():
        mesh = meshes.of_visuals(visuals, looks)
        if mesh is not None:
            labels = sorted({v.label for v in visuals if v.label is not None})
            extras = {"layer": group.value, **({"labels": labels} if labels else {})}
            name = f"{copy.prefix}{link.name}/{group.value}"
            nodes.add({"name": name, "mesh": mesh, "extras": extras}, below)


# Document -------------------------------------------------------------------------------------------------------------
# Asset -> GLB.
#
# Metres. One root node turns our z up into glTF's y up; below it all frames are those of the record. `extras`:
#
# | node | `extras` |
# |---|---|
# | root | `casa_assets` (version of this table), `id`, `kind` (`asset`, `scene`), `poses`: name -> joint -> position |
# | copy of an asset in a scene | `placement`: `name`, `asset`, `category`, `layer` |
# | link | `link`, and if a joint moves it `joint`: `name`, `type` (`hinge` or `slide`), `axis` and `anchor` in the |
# | | frame of the link, `range`, `rest` (position in the file), `states` (value -> share of the range), `behind` |
# | drawn node | `layer` (see LayerName); for a collider or a region also its name and kind |
#
# A link moves by `motion(position - rest)` after the pose of its node: about the axis through the anchor (rad), or
# along the axis (m). Names are paths: `door`, or in a scene `fridge/door`; the name of its joint is
# `fridge/door_joint`.

EXTRAS_VERSION = 1
PICTURE_PX = 512
# Turns z up into y up.
Y_UP = Pose(quaternion=(0.5**0.5, -(0.5**0.5), 0.0, 0.0))


class Document:
    """A GLB while it is being built: one root node, and the nodes below it."""

    def __init__(self, name: str, kind: str, picture_px: int) -> None:
        """Start with the root node; `kind`: `asset` or `scene`; `picture_px`: maximum pixels along a picture's side."""
        self.binary = Binary()
        self.meshes = Meshes(self.binary, Materials(self.binary, picture_px))
        self.nodes = Nodes()
        self.extras: dict[str, Any] = {"casa_assets": EXTRAS_VERSION, "id": name, "kind": kind}
        self.root = self.nodes.add({"name": name, "extras": self.extras, **placed(Y_UP)})
        self.cameras: list[dict[str, Any]] = []

    def bytes(self) -> bytes:
        """Return the file."""
        members: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "casa-assets"},
            "scene": 0,
            "scenes": [{"name": self.extras["id"], "nodes": [self.root]}],
            "nodes": self.nodes.rows,
            **({"meshes": self.meshes.rows} if self.meshes.rows else {}),
            **({"cameras": self.cameras} if self.cameras else {}),
            **self.meshes.materials.document(),
        }
        return glb(members, self.binary)


def asset_glb(asset: Asset, layers: Layers = SEEN_ALONE, picture_px: int = PICTURE_PX) -> bytes:
    """Return the GLB of an asset; the same asset gives the same bytes.

    Its joints are in the first of its named poses, or at zero.

    Args:
        layers: layers in addition to the visuals.
        picture_px: maximum pixels along a side of a picture.
    """
    document = Document(asset.id, "asset", picture_px)
    document.extras["poses"] = {key.name: values(joint_positions(key.joints)) for key in asset.keyframes}
    document.extras["category"] = asset.labels.category
    start = joint_positions(asset.keyframes[0].joints) if asset.keyframes else {}
    add_nodes(document.nodes, document.meshes, Copy(asset, positions=start), document.root, layers)
    return document.bytes()


def values(positions: Mapping[str, float], prefix: str = "") -> dict[str, float]:
    """Name of a joint in the file -> position, rad or m."""
    return {prefix + name: rounded([at])[0] for name, at in positions.items()}


# Scene ----------------------------------------------------------------------------------------------------------------
# A node for each placement (below a moving link for objects that rest in a drawer), and the cameras.

NEAR_M = 0.01


def scene_glb(scene: Scene, layers: Layers = SEEN_ALONE, picture_px: int = PICTURE_PX) -> bytes:
    """Return the GLB of a scene as it begins; the same scene gives the same bytes.

    Content that the assets of several placements have in common is written once. Named poses are those of the scene
    (`start`, `closed`, `open`) and any others that an asset has (`on`), in which all other assets are closed.

    Args:
        layers: layers in addition to the visuals.
        picture_px: maximum pixels along a side of a picture.
    """
    document = Document(scene.id, "scene", picture_px)
    document.extras["poses"] = _poses(scene)
    if scene.sky is not None:
        document.extras["sky"] = {"zenith": rounded(scene.sky.zenith), "horizon": rounded(scene.sky.horizon)}
    assets, links = scene.asset_of, dict[str, dict[str, int]]()
    places = {place.name: place for place in scene.placements}
    for place in scene.placements:
        if place.name not in links:
            _add(document, place, places, assets, links, layers)
    for camera in scene.cameras:
        lens = {"yfov": rounded([math.radians(camera.fov_y_deg)])[0], "znear": NEAR_M}
        document.cameras.append({"name": camera.name, "type": "perspective", "perspective": lens})
        seen = {"camera": len(document.cameras) - 1, **placed(camera.pose)}
        document.nodes.add({"name": f"camera/{camera.name}", **seen}, document.root)
    return document.bytes()


def _add(
    document: Document,
    place: Placement,
    places: dict[str, Placement],
    assets: dict[str, Asset],
    links: dict[str, dict[str, int]],
    layers: Layers,
) -> None:
    """Add a placement, after the placement that carries it; `links` gets the nodes of its links by name."""
    asset, below, pose = assets[place.name], document.root, place.pose
    rest = place.resting
    if rest is not None and assets[rest.placement].is_moved(rest.link):
        holder = places[rest.placement]
        if holder.name not in links:
            _add(document, holder, places, assets, links, layers)
        carrier = holder.pose @ assets[holder.name].asset_from_link(rest.link, joint_positions(holder.joints))
        below, pose = links[holder.name][rest.link], carrier.inverse() @ place.pose
    extras = {"name": place.name, "asset": asset.id, "category": asset.labels.category, "layer": place.layer.value}
    row: dict[str, Any] = {"name": place.name, "extras": {"placement": extras}, **placed(pose)}
    node = document.nodes.add(row, below)
    shown = LayerName.CEILING if place.layer is Layer.CEILING else LayerName.VISUAL
    copy = Copy(asset, f"{place.name}/", shown, joint_positions(place.joints))
    links[place.name] = add_nodes(document.nodes, document.meshes, copy, node, layers)


def _poses(scene: Scene) -> dict[str, dict[str, float]]:
    """Pose name -> joint name in the file -> position; joints that are not named are at zero."""
    found: dict[str, dict[str, float]] = {}
    assets = scene.asset_of
    extra = dict.fromkeys(key.name for asset in scene.assets for key in asset.keyframes)
    for place in scene.placements:
        asset = assets[place.name]
        own = key_positions(place, asset)
        named = {key.name: joint_positions(key.joints) for key in asset.keyframes}
        for pose in dict.fromkeys([*own, *extra]):
            at = own.get(pose) if pose in own else named.get(pose, own[CLOSED_POSE])
            found.setdefault(pose, {}).update(values(at or {}, f"{place.name}/"))
    return found
