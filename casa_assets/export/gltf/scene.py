"""Scene -> GLB: a node for each placement (below a moving link for objects that rest in a drawer), and the cameras."""

from __future__ import annotations

import math
from typing import Any

from casa_assets.export.gltf import body
from casa_assets.export.gltf.body import Copy
from casa_assets.export.gltf.document import PICTURE_PX, Document, values
from casa_assets.export.gltf.layer import SEEN_ALONE, LayerName, Layers
from casa_assets.export.gltf.number import placed, rounded
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.joint import joint_positions
from casa_assets.model.kitchen.named_poses import key_positions
from casa_assets.model.kitchen.scene import CLOSED_POSE, Layer, Placement, Scene

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
    links[place.name] = body.add_all(document.nodes, document.meshes, copy, node, layers)


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
