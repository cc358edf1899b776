"""Asset -> model.xml, scene.xml and the meshes and images that they name."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf import body, contact, keyframe, label, material, site, visual
from casa_assets.export.mjcf.scene import stage
from casa_assets.export.mujoco_values import ROBOSUITE_GROUPS, VIEWER_GROUPS, Groups
from casa_assets.model.asset.asset import Asset
from casa_assets.model.files import Files


def write(asset: Asset, groups: Groups = ROBOSUITE_GROUPS) -> Files:
    """Return the MJCF package of an asset; the same asset gives the same bytes.

    Args:
        groups: groups of the geoms of `model.xml`.
    Returns:
        `model.xml` (body `object` inside an unnamed body, no floor, no free joint, for robosuite and robocasa to
        merge), `scene.xml` (the same body on a floor, with a free joint if its base is free), `meshes/*.obj` and
        `textures/*.png`, and `behavior.json` if the asset has a behaviour. Paths are relative to the XML.
    """
    meshes = visual.gather_meshes(asset)
    entries = {file.path: file.data for file in meshes.files}
    entries |= {path: image.png for path, image in material.textures(asset).items()}
    entries["model.xml"] = _model(asset, meshes, groups)
    entries["scene.xml"] = _scene(asset, meshes)
    if asset.behavior is not None:
        entries["behavior.json"] = label.behavior_file(asset)
    return Files.of(entries)


def _model(asset: Asset, meshes: visual.Meshes, groups: Groups) -> bytes:
    root = _root(asset.id)
    _add_assets(root, asset, meshes)
    world = etree.SubElement(root, "worldbody")
    outer = etree.SubElement(world, "body")
    body.add(outer, asset.root, body.BodyContext(asset, meshes, material.names(asset), groups))
    site.add_size_sites(outer, asset)
    _add_exclusions_and_labels(root, asset)
    keyframe.add_all(root, asset)
    return _text(root)


def _scene(asset: Asset, meshes: visual.Meshes) -> bytes:
    root = _root(f"{asset.id}__scene")
    option = etree.SubElement(root, "option", {"timestep": "0.002", "integrator": "implicitfast"})
    # Several contacts between a pair of shapes, so that what stands does not rock. MuJoCo 4 does so by default, but its
    # own detection tilts their normals by up to four degrees, and what stands slides; libccd's are level on average.
    etree.SubElement(option, "flag", {"multiccd": "enable", "nativeccd": "disable"})
    stage.add_frame(root, asset)
    assets = _add_assets(root, asset, meshes)
    world = etree.SubElement(root, "worldbody")
    stage.add_stage(assets, world, asset)
    context = body.BodyContext(asset, meshes, material.names(asset), VIEWER_GROUPS)
    free_joint = stage.add_object(world, context)
    _add_exclusions_and_labels(root, asset)
    keyframe.add_all(root, asset, free_joint)
    return _text(root)


def _root(name: str) -> etree._Element:
    root = etree.Element("mujoco", {"model": name})
    etree.SubElement(root, "compiler", {"angle": "radian", "autolimits": "true"})
    return root


def _add_assets(root: etree._Element, asset: Asset, meshes: visual.Meshes) -> etree._Element:
    assets = etree.SubElement(root, "asset")
    material.add_all(assets, asset)
    for file in meshes.files:
        visual.add_mesh(assets, file)
    return assets


def _add_exclusions_and_labels(root: etree._Element, asset: Asset) -> None:
    if asset.exclusions:
        pairs = etree.SubElement(root, "contact")
        for exclusion in asset.exclusions:
            contact.add(pairs, exclusion)
    label.add_all(root, asset)


def _text(root: etree._Element) -> bytes:
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)
