"""Scene -> scene.usda, which refers to the layers of its assets in a folder that many scenes share."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom

from casa_assets.core.numeric import arc_from_z
from casa_assets.formats.usd import document, isaac_lab, shapes
from casa_assets.formats.usd.document import BASE_TO_WORLD, JOINTS
from casa_assets.formats.usd.shapes import put
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import (
    CLOSED_POSE,
    OPEN_POSE,
    START_POSE,
    Layer,
    Light,
    LightKind,
    Placement,
    Scene,
    carried_pose,
    key_positions,
    own_pose,
)
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

# /World                         kind assembly; variant sets pose (start, closed, open), room, ceiling (shown, hidden)
#   /physicsScene /ambientLight
#   /<light> /<camera>
#   /<placement>                 a reference to ../assets/usd/<asset>/<asset>.usda, with the pose of the placement

FILE = "scene.usda"
NESTED_FILE = "scene_nested.usda"
WORLD = Sdf.Path("/World")
# The folder that scenes share, in the paths that the writer returns, and the folder of layers in it.
FOLDER = "assets"
LAYERS = "usd"
SHOWN, HIDDEN = "shown", "hidden"
# camelCase, which no placement is.
AMBIENT, PHYSICS = "ambientLight", "physicsScene"
# USD's lights fade with the square of the distance. At this distance, that of a worktop under the ceiling, one is as
# bright as the scene's own attenuation makes it.
REFERENCE_M = 1.5
# Size of the sensor, millimetres; the defaults of USD. Ref: UsdGeomCamera, verticalAperture, horizontalAperture.
SENSOR_HEIGHT_MM, SENSOR_WIDTH_MM = 15.2908, 20.955
CLIPPING_RANGE_M = (0.015, 60.0)


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
        NESTED_FILE: document.nested_scene_text(scene, FILE, WORLD.name).encode("utf-8"),
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
            _fix_base(layer, spec.path, WORLD, place.pose @ asset.root.pose)
    for pair in scene.exclusions:
        first, second = (WORLD.AppendChild(end.placement).AppendChild(end.link) for end in pair)
        _filter_pair(layer, first, second)
    _add_pose_variants(layer, scene)
    for kind in (Layer.ROOM, Layer.CEILING):
        _add_visibility_variants(layer, kind.value, [place for place in scene.placements if place.layer is kind])
    return str(layer.ExportToString())


def _define(stage: Usd.Stage, scene: Scene) -> None:
    """Everything but what assets are referred to for."""
    root = UsdGeom.Xform.Define(stage, WORLD).GetPrim()
    document.set_stage(stage, root)
    Usd.ModelAPI(root).SetKind(Kind.Tokens.assembly)
    strength = float(np.linalg.norm(scene.gravity))
    down = [g / strength for g in scene.gravity] if strength else (0.0, 0.0, -1.0)
    physics = stage.DefinePrim(WORLD.AppendChild(PHYSICS), "PhysicsScene")
    put(physics, {"physics:gravityDirection": tuple(down), "physics:gravityMagnitude": strength})
    define_lights_and_cameras(stage, WORLD, scene)
    for place in scene.placements:
        prim = stage.DefinePrim(WORLD.AppendChild(place.name), "Xform")
        shapes.place(put(prim, {"casa:layer": place.layer.value}), place.pose)


def _filter_pair(layer: Sdf.Layer, first: Sdf.Path, second: Sdf.Path) -> None:
    """Filter the contacts of two bodies of referenced assets, in addition to the assets' own filters."""
    spec = Sdf.CreatePrimInLayer(layer, first)
    if not spec.HasInfo("apiSchemas"):
        spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["PhysicsFilteredPairsAPI"]))
    path = first.AppendProperty("physics:filteredPairs")
    pairs = layer.GetRelationshipAtPath(path) or Sdf.RelationshipSpec(spec, "physics:filteredPairs", custom=False)
    pairs.targetPathList.prependedItems = [*pairs.targetPathList.prependedItems, second]


def _fix_base(layer: Sdf.Layer, root: Sdf.Path, world: Sdf.Path, world_from_base: Pose) -> None:
    """Write the joint that holds a fixed base, from the world of the scene to the base of the copy at `root`.

    An asset by itself fixes its base to its own root prim. In a scene that prim is not the default prim of the stage,
    so MuJoCo would not treat it as the world and would let the base float.
    """
    spec = Sdf.CreatePrimInLayer(layer, root.AppendChild(JOINTS).AppendChild(BASE_TO_WORLD))
    Sdf.RelationshipSpec(spec, "physics:body0", custom=False).targetPathList.explicitItems = [world]
    kinds = Sdf.ValueTypeNames
    position, rotation = Gf.Vec3f(*world_from_base.position), Gf.Quatf(*world_from_base.quaternion)
    Sdf.AttributeSpec(spec, "physics:localPos0", kinds.Point3f).default = position
    Sdf.AttributeSpec(spec, "physics:localRot0", kinds.Quatf).default = rotation


def _add_pose_variants(layer: Sdf.Layer, scene: Scene) -> None:
    """Add the variant set `pose`, `closed` selected: each asset's own variant, and the start pose, which no asset has.

    Objects that rest in a drawer move along with it.
    """
    poses = (START_POSE, CLOSED_POSE, OPEN_POSE)
    document.add_variants(layer, WORLD, document.VARIANT_SET, poses, CLOSED_POSE)
    placements, assets = {place.name: place for place in scene.placements}, scene.asset_of
    for pose in poses:
        for place in scene.placements:
            asset = assets[place.name]
            carried = carried_pose(place, placements, assets, pose)
            if carried is not None:
                # The placement itself has its pose outside of variants, which is stronger: its links are moved, each
                # by itself, since they are side by side.
                path, shift = _over(layer, document.VARIANT_SET, pose, place).path, place.pose.inverse() @ carried
                positions = key_positions(place, asset)[pose]
                for link in asset.links:
                    moved = shift @ asset.asset_from_link(link.name, positions)
                    document.set_pose(layer, path.AppendChild(link.name), moved)
            if asset.keyframes:
                # Its variant that is nearest to the pose.
                own = own_pose(place, pose)
                is_there = own in {key.name for key in asset.keyframes} and own != START_POSE
                _over(layer, document.VARIANT_SET, pose, place).variantSelections[document.VARIANT_SET] = (
                    own if is_there else CLOSED_POSE
                )
            # The start pose, if it differs from the closed one, is stronger than a variant of the asset.
            positions = joint_positions(place.joints)
            closed = next((joint_positions(key.joints) for key in asset.keyframes if key.name == CLOSED_POSE), {})
            if pose == START_POSE and any(positions.get(j.name, 0.0) != closed.get(j.name, 0.0) for j in asset.joints):
                document.set_joints(layer, _over(layer, document.VARIANT_SET, pose, place).path, asset, positions)


def _add_visibility_variants(layer: Sdf.Layer, name: str, places: list[Placement]) -> None:
    """Add a variant set that makes some placements invisible; they still collide."""
    if not places:
        return
    document.add_variants(layer, WORLD, name, (SHOWN, HIDDEN), SHOWN)
    for place in places:
        spec = _over(layer, name, HIDDEN, place)
        attribute = Sdf.AttributeSpec(spec, UsdGeom.Tokens.visibility, Sdf.ValueTypeNames.Token)
        attribute.default = UsdGeom.Tokens.invisible


def _over(layer: Sdf.Layer, variants: str, option: str, place: Placement) -> Sdf.PrimSpec:
    """Override of a placement in a variant of the world."""
    return Sdf.CreatePrimInLayer(layer, WORLD.AppendVariantSelection(variants, option).AppendChild(place.name))


# Lights and cameras ---------------------------------------------------------------------------------------------------


def define_lights_and_cameras(stage: Usd.Stage, world: Sdf.Path, scene: Scene) -> None:
    """Define lights, ambient light and cameras below the prim of the world."""
    if any(scene.ambient):
        dome = stage.DefinePrim(world.AppendChild(AMBIENT), "DomeLight")
        put(dome, {"inputs:color": scene.ambient, "inputs:intensity": 1.0})
    for light in scene.lights:
        _light(stage, world.AppendChild(light.name), light)
    for camera in scene.cameras:
        values = {
            "verticalAperture": SENSOR_HEIGHT_MM,
            "horizontalAperture": SENSOR_WIDTH_MM,
            "focalLength": SENSOR_HEIGHT_MM / 2 / math.tan(math.radians(camera.fov_y_deg) / 2),
            "clippingRange": CLIPPING_RANGE_M,
        }
        shapes.place(put(stage.DefinePrim(world.AppendChild(camera.name), "Camera"), values), camera.pose)


def _light(stage: Usd.Stage, path: Sdf.Path, light: Light) -> None:
    """Define a light, normalised, so that its brightness does not depend on its size.

    A white surface with irradiance E has radiance E / pi. A directional light of intensity I gives E = I; a sphere of
    radiance I / (4 pi r^2) gives E = I / (4 d^2) at a distance of d.
    """
    values = {"inputs:normalize": True, "inputs:color": light.color, "inputs:shadow:enable": light.castshadow}
    if light.kind is LightKind.DIRECTIONAL:
        prim = put(stage.DefinePrim(path, "DistantLight"), {"inputs:intensity": math.pi})
    else:
        prim, corner = stage.DefinePrim(path, "SphereLight"), np.full(3, light.radius)
        a, b, c = light.attenuation
        attenuation = 1.0 / (a + b * REFERENCE_M + c * REFERENCE_M**2)
        values["inputs:intensity"] = 4.0 * math.pi * REFERENCE_M**2 * attenuation
        put(prim, {"inputs:radius": light.radius, "extent": shapes.points(np.array([-corner, corner]))})
    if light.kind is LightKind.SPOT:
        cone = {"inputs:shaping:cone:angle": light.cone_deg, "inputs:shaping:cone:softness": light.softness}
        put(prim, cone, "ShapingAPI")
    put(prim, values, "ShadowAPI")
    shapes.place(prim, pose_looking_along(light.direction).replace(position=light.position))


def pose_looking_along(direction: Vec3) -> Pose:
    """Rotation by the shortest arc from -z, along which lights shine, to a direction."""
    length = math.hypot(*direction)
    x, y, z = (-d / length for d in direction)
    return Pose(quaternion=arc_from_z((x, y, z)))
