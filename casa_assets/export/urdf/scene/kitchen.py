"""Scene -> `scene.urdf` with all fixed objects, a URDF of every asset, and `scene.json` with all placements.

Names in `scene.urdf`: the root link of a placement has the placement's name, everything else in it
`<placement>__<name>`. Loose objects are not in `scene.urdf`: they would need floating joints, which few programs read.
"""

from __future__ import annotations

from typing import Any

from lxml import etree

from casa_assets.export.mjcf.scene.kitchen import world_from_root
from casa_assets.export.urdf import body, document, joint, label, visual
from casa_assets.export.urdf.number import roll_pitch_yaw
from casa_assets.export.urdf.visual import Meshes
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.joint import joint_positions
from casa_assets.model.files import Files
from casa_assets.model.kitchen.scene import WORLD, Camera, PlacedLink, Placement, Scene

FILE, LIST = "scene.urdf", "scene.json"


def write(scene: Scene) -> Files:
    """Return the URDF files of a scene, flat in one folder; the same scene gives the same bytes.

    Returns:
        `scene.urdf`, `scene.json`, `<asset>.urdf` and `<asset>.json` of every asset, and `meshes/`.
    """
    meshes = {asset.id: visual.gather_meshes(asset) for asset in scene.assets}
    entries = {FILE: _document(scene, meshes), LIST: label.json_text(_list(scene))}
    for asset in scene.assets:
        entries |= document.texts(asset, meshes[asset.id])
        entries |= meshes[asset.id].entries
    return Files.of(entries)


def _document(scene: Scene, meshes: dict[str, Meshes]) -> bytes:
    root = document.robot(scene.id)
    etree.SubElement(root, "link", {"name": WORLD})
    for place in scene.placements:
        asset = scene.asset_of[place.name]
        if asset.base is Base.FIXED:
            body.add_all(root, body.BodyContext(asset, meshes[asset.id], place.name))
            joint.add(root, None, WORLD, place.name, world_from_root(place, asset))
    return document.document_text(root)


def _list(scene: Scene) -> dict[str, Any]:
    asset_of = scene.asset_of

    def link_name(end: PlacedLink) -> str:
        return body.link_name(asset_of[end.placement], end.link, end.placement)

    return {
        "schema_version": label.SCHEMA_VERSION,
        "id": scene.id,
        "urdf": FILE,
        "gravity": list(scene.gravity),
        "placements": [_placement(place, asset_of[place.name]) for place in scene.placements],
        "exclusions": [[link_name(first), link_name(second)] for first, second in scene.exclusions],
        "cameras": [_camera(camera) for camera in scene.cameras],
    }


def _placement(place: Placement, asset: Asset) -> dict[str, Any]:
    """One row of the list; the pose is that of the root link in the world."""
    pose = world_from_root(place, asset)
    return {
        "name": place.name,
        "asset": asset.id,
        "urdf": document.urdf_name(asset.id),
        "base": asset.base.value,
        "layer": place.layer.value,
        "joints": joint_positions(place.joints),
        **label.pose(pose),
        "rpy": label.rounded(roll_pitch_yaw(pose)),
    }


def _camera(camera: Camera) -> dict[str, Any]:
    """One camera; it looks along its -z, y up."""
    return {"name": camera.name, "fov_y_deg": camera.fov_y_deg, **label.pose(camera.pose)}
