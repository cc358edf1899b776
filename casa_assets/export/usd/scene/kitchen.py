"""Scene -> scene.usda, which refers to the layers of its assets in a folder that many scenes share.

/World                         kind assembly; variant sets pose (start, closed, open), room and ceiling (shown, hidden)
  /physicsScene /ambientLight
  /<light> /<camera>
  /<placement>                 a reference to ../assets/usd/<asset>/<asset>.usda, with the pose of the placement
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdPhysics

from casa_assets.export.usd import contact, document, keyframe, nested, number
from casa_assets.export.usd.scene import isaac_lab, lights_and_cameras, placement
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.joint import joint_positions
from casa_assets.model.files import Files
from casa_assets.model.kitchen.named_poses import carried_pose, key_positions, own_pose
from casa_assets.model.kitchen.scene import CLOSED_POSE, OPEN_POSE, START_POSE, Layer, Placement, Scene

FILE = "scene.usda"
NESTED_FILE = "scene_nested.usda"
WORLD = Sdf.Path("/World")
# camelCase, which no placement is.
PHYSICS = "physicsScene"
# The folder that scenes share, in the paths that the writer returns, and the folder of layers in it.
FOLDER = "assets"
LAYERS = "usd"
SHOWN, HIDDEN = "shown", "hidden"
LAYER = "casa:layer"


def write(
    scene: Scene, shared: str = "../assets", layer_text: Callable[[Asset, str], str] = document.layer_text
) -> Files:
    """Return the USD of a scene; the same scene gives the same bytes.

    Args:
        scene: the scene.
        shared: path from the folder of scene.usda to the shared folder.
        layer_text: `document.layer_text`, or a faster function with the same result.
    Returns:
        `scene.usda`, `scene_nested.usda`, `isaac_lab.py`, and the files of the shared folder as
        `assets/usd/<asset>/<asset>.usda` and `assets/textures/<name>_<hash>.png`, the same pictures that the MJCF of
        the scene uses.
    """
    entries = {
        FILE: scene_text(scene, shared).encode("utf-8"),
        NESTED_FILE: nested.scene_text(scene, FILE, WORLD.name).encode("utf-8"),
        isaac_lab.FILE: isaac_lab.scene_text(scene, FILE).encode("utf-8"),
    }
    for asset in scene.assets:
        layer = layer_text(asset, f"../../{document.TEXTURES}")
        entries[f"{FOLDER}/{LAYERS}/{asset.id}/{asset.id}.usda"] = layer.encode("utf-8")
        for material in asset.materials:
            entries |= {f"{FOLDER}/{document.TEXTURES}/{t.file_name}": t.png for t in material.textures}
    return Files.of(entries)


def scene_text(scene: Scene, shared: str = "../assets") -> str:
    """Return the root layer as usda text; no content of assets is copied into it."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    _define(Usd.Stage.Open(layer), scene)
    # Below this line without a stage, which would look for layers that are not on disk yet.
    assets = scene.asset_of
    for place in scene.placements:
        spec = layer.GetPrimAtPath(WORLD.AppendChild(place.name))
        spec.referenceList.prependedItems = [Sdf.Reference(f"{shared}/{LAYERS}/{place.asset}/{place.asset}.usda")]
        asset = assets[place.name]
        if asset.base is Base.FIXED:
            placement.fix_base(layer, spec.path, WORLD, place.pose @ asset.root.pose)
    for pair in scene.exclusions:
        first, second = (WORLD.AppendChild(end.placement).AppendChild(end.link) for end in pair)
        contact.filter_pair(layer, first, second)
    _add_pose_variants(layer, scene)
    for kind in (Layer.ROOM, Layer.CEILING):
        _add_visibility_variants(layer, kind.value, [place for place in scene.placements if place.layer is kind])
    text: str = layer.ExportToString()
    return text


def _define(stage: Usd.Stage, scene: Scene) -> None:
    """Define everything that refers to no other layer."""
    root = UsdGeom.Xform.Define(stage, WORLD).GetPrim()
    document.set_stage(stage, root)
    Usd.ModelAPI(root).SetKind(Kind.Tokens.assembly)
    physics = UsdPhysics.Scene.Define(stage, WORLD.AppendChild(PHYSICS))
    strength = float(np.linalg.norm(scene.gravity))
    down = [g / strength for g in scene.gravity] if strength else (0.0, 0.0, -1.0)
    physics.CreateGravityDirectionAttr(Gf.Vec3f(*down))
    physics.CreateGravityMagnitudeAttr(strength)
    lights_and_cameras.define_all(stage, WORLD, scene)
    for place in scene.placements:
        prim = UsdGeom.Xform.Define(stage, WORLD.AppendChild(place.name)).GetPrim()
        number.place(prim, place.pose)
        prim.CreateAttribute(LAYER, Sdf.ValueTypeNames.Token, True, Sdf.VariabilityUniform).Set(place.layer.value)


def _add_pose_variants(layer: Sdf.Layer, scene: Scene) -> None:
    """Add the variant set `pose`, `closed` selected: each asset's own variant, and the start pose, which no asset has.

    Objects that rest in a drawer move along with it.
    """
    poses = (START_POSE, CLOSED_POSE, OPEN_POSE)
    variants = _variants(layer, keyframe.VARIANT_SET, poses, CLOSED_POSE)
    placements, assets = {place.name: place for place in scene.placements}, scene.asset_of
    for pose in poses:
        for place in scene.placements:
            asset = assets[place.name]
            carried = carried_pose(place, placements, assets, pose)
            if carried is not None:
                # The placement itself has its pose outside of variants, which is stronger: its links are moved, each
                # by itself, since they stand side by side.
                path, shift = _over(layer, variants, pose, place).path, place.pose.inverse() @ carried
                positions = key_positions(place, asset)[pose]
                for link in asset.links:
                    spec = Sdf.CreatePrimInLayer(layer, path.AppendChild(link.name))
                    placement.set_pose(spec, shift @ asset.asset_from_link(link.name, positions))
            own = placement.variant(asset, own_pose(place, pose))
            if own is not None:
                _over(layer, variants, pose, place).variantSelections[keyframe.VARIANT_SET] = own
            if pose == START_POSE:
                _set_start_pose(layer, variants, place, asset)


def _set_start_pose(layer: Sdf.Layer, variants: str, place: Placement, asset: Asset) -> None:
    """Write the start pose if it differs from the closed pose, stronger than a variant of the asset."""
    positions = joint_positions(place.joints)
    closed = next((joint_positions(key.joints) for key in asset.keyframes if key.name == CLOSED_POSE), {})
    if all(positions.get(joint.name, 0.0) == closed.get(joint.name, 0.0) for joint in asset.joints):
        return
    root = _over(layer, variants, START_POSE, place).path
    placement.set_joints(layer, root, asset, positions)


def _add_visibility_variants(layer: Sdf.Layer, name: str, places: list[Placement]) -> None:
    """Add a variant set that makes some placements invisible; they still collide."""
    if not places:
        return
    variants = _variants(layer, name, (SHOWN, HIDDEN), SHOWN)
    for place in places:
        spec = _over(layer, variants, HIDDEN, place)
        attribute = Sdf.AttributeSpec(spec, UsdGeom.Tokens.visibility, Sdf.ValueTypeNames.Token)
        attribute.default = UsdGeom.Tokens.invisible


def _variants(layer: Sdf.Layer, name: str, options: tuple[str, ...], chosen: str) -> str:
    """Add a variant set to the world, and return its name."""
    world = layer.GetPrimAtPath(WORLD)
    world.variantSetNameList.prependedItems = [*world.variantSetNameList.prependedItems, name]
    world.variantSelections[name] = chosen
    found = Sdf.VariantSetSpec(world, name)
    for option in options:
        Sdf.VariantSpec(found, option)
    return name


def _over(layer: Sdf.Layer, variants: str, option: str, place: Placement) -> Sdf.PrimSpec:
    """Override of a placement in a variant of the world."""
    return Sdf.CreatePrimInLayer(layer, WORLD.AppendVariantSelection(variants, option).AppendChild(place.name))
