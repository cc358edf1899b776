"""Asset -> model.xml of an object for RoboCasa's loaders of both generations, with its meshes and images.

One file serves both: v0.2 reads sizes from three sites next to the body `object`, v1.0 from the geom `reg_bbox` in it.
Elements that the loaders drop (exclusions, keyframes, options) are not written; attributes that they need on every geom
(group, pos, and size of three or two numbers) are written on the geom itself. Lids are always shut: RoboCasa sets the
pose of an object through its first joint, and robosuite adds the free joint after those in the file.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from lxml import etree

from casa_assets.export.mjcf import document, shapes
from casa_assets.export.mujoco_values import ROBOSUITE_GROUPS
from casa_assets.export.robocasa import upright
from casa_assets.export.robocasa.kitchens.centering import moved
from casa_assets.export.robocasa.mesh_volume import has_volume, thickened
from casa_assets.model.asset.asset import Asset
from casa_assets.model.files import Files

# Ref: robocasa, folders beside the model.xml of an object.
# Ref: robocasa v1.0, add_obj_liquid_site: the categories whose objects it is called for.
HOLD_LIQUID = ("cup", "glass_cup", "mug", "bowl", "pot", "pan", "saucepan")
LIQUID_SHARE = 0.8  # of width and height of such a vessel
VISUAL_FOLDER, COLLISION_FOLDER = "visual", "collision"
FILE, UPRIGHT_FILE = "model.xml", "model_upright.xml"


def write(asset: Asset, stood_up: bool = False) -> Files:
    """Return the files of one object; the same asset gives the same bytes.

    Args:
        asset: free to move; z up, origin under the middle of its footprint.
        stood_up: also write `model_upright.xml`, the same object turned upright onto its end or its edge.
    Returns:
        `model.xml`, `visual/*.obj`, `visual/*.png`, `collision/*.obj`; paths are relative to the XML. The origin is at
        half the height: RoboCasa tests only the origin to decide whether an object is in a sink or on a shelf, and an
        origin at the foot would sink slightly out of it.
    """
    asset = moved(_without_joints(asset), np.array((0.0, 0.0, asset.bounds[:, 2].mean())))
    thick = thickened(asset)
    meshes = _gather(thick)
    entries = {file.path: file.data for file in meshes.files}
    images = shapes.texture_files(asset).values()
    entries |= {f"{VISUAL_FOLDER}/{image.file_name}": image.png for image in images}
    root = _document(thick, meshes)
    outer = root.find("worldbody/body")
    assert outer is not None, "the document has one"
    shapes.add_size_sites(outer, asset)
    entries[FILE] = _text(root)
    if stood_up:
        upright.stand_up(root, asset)
        entries[UPRIGHT_FILE] = _text(root)
    return Files.of(entries)


def _without_joints(asset: Asset) -> Asset:
    """The asset with all joints fixed at zero, as one rigid object."""
    return asset.replace(joints=(), states=(), keyframes=(), exclusions=(), behavior=None)


def _gather(asset: Asset) -> shapes.Meshes:
    """The mesh files of an asset in the folders that RoboCasa uses."""
    meshes = shapes.gather_meshes(asset)
    visual_paths = {meshes.of[v.name].path for link in asset.links for v in link.visuals}
    moved = {}
    for file in meshes.files:
        name = file.path.rpartition("/")[2]
        moved[file.name, file.use] = replace(
            file, path=f"{VISUAL_FOLDER if file.path in visual_paths else COLLISION_FOLDER}/{name}"
        )
    return shapes.Meshes(
        files=tuple(moved[file.name, file.use] for file in meshes.files),
        of={name: moved[file.name, file.use] for name, file in meshes.of.items()},
    )


def _document(asset: Asset, meshes: shapes.Meshes) -> etree._Element:
    root = etree.Element("mujoco", {"model": asset.id})
    etree.SubElement(root, "compiler", {"angle": "radian", "autolimits": "true"})
    assets = etree.SubElement(root, "asset")
    for image in shapes.texture_files(asset).values():
        shapes.add_texture(assets, image, f"{VISUAL_FOLDER}/{image.file_name}")
    names = shapes.material_names(asset)
    for look in asset.materials:
        shapes.add_material(assets, look, names[look.id])
    with_volume = {meshes.of[name].name for name, shape, _ in shapes.mesh_uses(asset) if has_volume(shape)}
    for file in meshes.files:
        shapes.add_mesh(assets, file)
        if file.use is shapes.MeshUse.SURFACE and file.name in with_volume:
            assets[-1].set("inertia", "legacy")  # MuJoCo 3.2.6 does not know `shell`
    world = etree.SubElement(root, "worldbody")
    outer = etree.SubElement(world, "body")
    root_body = document.add_body(outer, asset.root, document.BodyContext(asset, meshes, names, ROBOSUITE_GROUPS))
    _add_bbox_region(root_body, asset)
    _add_liquid_site(root_body, asset)
    document.add_labels(root, asset)
    return root


def _add_bbox_region(root_body: etree._Element, asset: Asset) -> None:
    """Add the region `bbox` as the last geom, if the asset has another name for its outer volume."""
    if root_body.find(f"geom[@name='reg_{shapes.OUTER_REGIONS[0]}']") is None:
        outer = next(region for region in asset.regions if region.name in shapes.OUTER_REGIONS)
        shapes.add_region(root_body, outer.replace(name=shapes.OUTER_REGIONS[0]), ROBOSUITE_GROUPS.regions)


def _add_liquid_site(root_body: etree._Element, asset: Asset) -> None:
    """Add the site `liquid` of a vessel, which tasks colour: an upright cylinder inside it, invisible until then."""
    if asset.labels.category not in HOLD_LIQUID:
        return
    lower, upper = asset.bounds
    radius, half_height = LIQUID_SHARE * min(upper[:2] - lower[:2]) / 2, LIQUID_SHARE * (upper[2] - lower[2]) / 2
    at, size = shapes.numbers((0.0, 0.0, (lower[2] + upper[2]) / 2)), shapes.numbers((radius, half_height))
    etree.SubElement(
        root_body, "site", {"name": "liquid", "type": "cylinder", "pos": at, "size": size, "rgba": "0 0 0 0"}
    )


def _text(root: etree._Element) -> bytes:
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)
