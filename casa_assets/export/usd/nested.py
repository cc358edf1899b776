"""Asset or scene -> a second layer, in which every body is below the body that carries it.

The flat layer has all content, with bodies side by side, as SimReady requires. Newton and MuJoCo use trees of bodies.
The nested layer refers to the flat one and relocates bodies: `/oven/door` becomes `/oven/object/door`, and everything
that refers to it (joints, filters) follows. Only the pose of each body relative to its parent has to be written again.

Needs OpenUSD 25.11: older versions do not parse bodies below bodies.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pxr import Sdf

from casa_assets.export.usd import keyframe, number
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.joint import joint_positions
from casa_assets.model.kitchen.named_poses import key_positions
from casa_assets.model.kitchen.scene import CLOSED_POSE, Scene

# In the folder of the flat layer of an asset, where SimReady allows no second layer.
FOLDER = "nested"
# Positions of the joints of an asset, by the name of a pose.
Poses = Mapping[str, Mapping[str, float]]


def asset_text(asset: Asset) -> str:
    """Return the nested layer of an asset with several links as usda text, for `FOLDER` next to the flat layer."""
    root = Sdf.Path.absoluteRootPath.AppendChild(asset.id)
    layer = _layer(root, f"../{asset.id}.usda")
    poses: Poses = {CLOSED_POSE: {}, **{key.name: joint_positions(key.joints) for key in asset.keyframes}}
    _nest(layer, root, [(root, asset, poses if asset.keyframes else {})])
    text: str = layer.ExportToString()
    return text


def scene_text(scene: Scene, flat: str, world: str) -> str:
    """Return the nested layer of a scene as usda text, for the folder of its flat layer.

    Args:
        scene: the scene of the flat layer.
        flat: file name of the flat layer.
        world: name of the prim that contains everything.
    """
    root = Sdf.Path.absoluteRootPath.AppendChild(world)
    layer = _layer(root, f"./{flat}")
    assets = scene.asset_of
    copies = [(root.AppendChild(p.name), assets[p.name], key_positions(p, assets[p.name])) for p in scene.placements]
    _nest(layer, root, copies)
    text: str = layer.ExportToString()
    return text


def nested_path(root: Sdf.Path, asset: Asset, link: str) -> Sdf.Path:
    """Path of a link below the prim of its asset: through all links that carry it."""
    parent = asset.link(link).parent
    return (root if parent is None else nested_path(root, asset, parent)).AppendChild(link)


def _layer(root: Sdf.Path, flat: str) -> Sdf.Layer:
    """A layer whose default prim refers to that of the flat one, in the same units and axes."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    prim = Sdf.CreatePrimInLayer(layer, root)
    prim.specifier, prim.typeName = Sdf.SpecifierDef, "Xform"
    prim.referenceList.prependedItems = [Sdf.Reference(flat)]
    layer.defaultPrim = root.name
    for name, value in (("upAxis", "Z"), ("metersPerUnit", 1.0), ("kilogramsPerUnit", 1.0)):
        layer.pseudoRoot.SetInfo(name, value)
    return layer


def _nest(layer: Sdf.Layer, root: Sdf.Path, copies: Iterable[tuple[Sdf.Path, Asset, Poses]]) -> None:
    """Relocate the links of assets below the links that carry them, and set their poses there.

    Args:
        layer: layer that refers to the flat one.
        root: the prim that has the variants of poses.
        copies: prim of an asset, the asset, its named poses.
    """
    moves = []
    for prim, asset, poses in copies:
        for link in asset.links[1:]:
            path = nested_path(prim, asset, link.name)
            moves.append((prim.AppendChild(link.name), path))
            spec = Sdf.CreatePrimInLayer(layer, path)
            order = Sdf.AttributeSpec(spec, "xformOpOrder", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform)
            order.default = list(keyframe.XFORM_OPS)
            if not poses or not asset.is_moved(link.name):
                _place(spec, asset, link.name, {})
                continue
            for pose, positions in poses.items():
                variant = _variant(layer, root, pose)
                _place(Sdf.CreatePrimInLayer(layer, path.ReplacePrefix(root, variant)), asset, link.name, positions)
    layer.relocates = moves


def _variant(layer: Sdf.Layer, root: Sdf.Path, pose: str) -> Sdf.Path:
    """Return the path of a variant of `pose`, created if missing; the flat layer selects the variant."""
    prim = layer.GetPrimAtPath(root)
    if keyframe.VARIANT_SET not in prim.variantSets:
        prim.variantSetNameList.prependedItems = [keyframe.VARIANT_SET]
        Sdf.VariantSetSpec(prim, keyframe.VARIANT_SET)
    found = prim.variantSets[keyframe.VARIANT_SET]
    if pose not in found.variants:
        Sdf.VariantSpec(found, pose)
    return root.AppendVariantSelection(keyframe.VARIANT_SET, pose)


def _place(spec: Sdf.PrimSpec, asset: Asset, link: str, positions: Mapping[str, float]) -> None:
    """Write the pose of a link in the frame of the link that carries it."""
    pose, kinds = asset.parent_from_link(link, positions), Sdf.ValueTypeNames
    translate, orient = keyframe.XFORM_OPS
    Sdf.AttributeSpec(spec, translate, kinds.Double3).default = number.vec3d(pose.position)
    Sdf.AttributeSpec(spec, orient, kinds.Quatd).default = number.quatd(pose.quaternion)
