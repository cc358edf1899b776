"""Scene -> scene.usda, which refers to the layers of its assets in a folder that many scenes share."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics

from casa_assets.formats.usd import document, isaac_lab, shapes
from casa_assets.formats.usd.document import BASE_TO_WORLD, JOINTS
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

# Placement ------------------------------------------------------------------------------------------------------------


def set_joints(layer: Sdf.Layer, root: Sdf.Path, asset: Asset, positions: dict[str, float]) -> None:
    """Override link poses and joint states below `root`; `positions` in rad or m, joints not named are at zero."""
    for link in asset.links:
        if asset.is_moved(link.name):
            _set_pose(layer, root.AppendChild(link.name), asset.asset_from_link(link.name, positions))
    for joint in asset.joints:
        spec = Sdf.CreatePrimInLayer(layer, root.AppendChild(JOINTS).AppendChild(joint.name))
        schema, attribute, position = document.joint_state(joint, positions.get(joint.name, 0.0))
        spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=[schema]))
        Sdf.AttributeSpec(spec, attribute, Sdf.ValueTypeNames.Float).default = position


def _set_pose(layer: Sdf.Layer, path: Sdf.Path, pose: Pose) -> None:
    """Override the pose of a link in the frame of its asset."""
    spec = Sdf.CreatePrimInLayer(layer, path)
    document.write_pose(spec, pose)
    document.write_ops(spec)


def fix_base(layer: Sdf.Layer, root: Sdf.Path, world: Sdf.Path, world_from_base: Pose) -> None:
    """Write the joint that holds a fixed base, from the world of the scene to the base of the copy at `root`.

    An asset by itself fixes its base to its own root prim. In a scene that prim is not the default prim of the stage,
    so MuJoCo would not treat it as the world and would let the base float.
    """
    spec = Sdf.CreatePrimInLayer(layer, root.AppendChild(JOINTS).AppendChild(BASE_TO_WORLD))
    Sdf.RelationshipSpec(spec, "physics:body0", custom=False).targetPathList.explicitItems = [world]
    kinds = Sdf.ValueTypeNames
    position, rotation = shapes.vec3f(world_from_base.position), shapes.quatf(world_from_base.quaternion)
    Sdf.AttributeSpec(spec, "physics:localPos0", kinds.Point3f).default = position
    Sdf.AttributeSpec(spec, "physics:localRot0", kinds.Quatf).default = rotation


# Lights and cameras ---------------------------------------------------------------------------------------------------

# camelCase, which no placement is.
AMBIENT = "ambientLight"
# USD's lights fade with the square of the distance. At this distance, that of a worktop under the ceiling, one is as
# bright as the scene's own attenuation makes it.
REFERENCE_M = 1.5
# Size of the sensor, millimetres; the defaults of USD. Ref: UsdGeomCamera, verticalAperture, horizontalAperture.
SENSOR_HEIGHT_MM, SENSOR_WIDTH_MM = 15.2908, 20.955
CLIPPING_RANGE_M = (0.015, 60.0)


def define_lights_and_cameras(stage: Usd.Stage, world: Sdf.Path, scene: Scene) -> None:
    """Define lights, ambient light and cameras below the prim of the world."""
    if any(scene.ambient):
        dome = UsdLux.DomeLight.Define(stage, world.AppendChild(AMBIENT))
        dome.CreateColorAttr(Gf.Vec3f(*scene.ambient))
        dome.CreateIntensityAttr(1.0)
    for light in scene.lights:
        _light(stage, world.AppendChild(light.name), light)
    for camera in scene.cameras:
        prim = UsdGeom.Camera.Define(stage, world.AppendChild(camera.name))
        prim.CreateVerticalApertureAttr(SENSOR_HEIGHT_MM)
        prim.CreateHorizontalApertureAttr(SENSOR_WIDTH_MM)
        prim.CreateFocalLengthAttr(SENSOR_HEIGHT_MM / 2 / math.tan(math.radians(camera.fov_y_deg) / 2))
        prim.CreateClippingRangeAttr(Gf.Vec2f(*CLIPPING_RANGE_M))
        shapes.place(prim.GetPrim(), camera.pose)


def _light(stage: Usd.Stage, path: Sdf.Path, light: Light) -> None:
    """Define a light, normalised, so that its brightness does not depend on its size.

    A white surface with irradiance E has radiance E / pi. A directional light of intensity I gives E = I; a sphere of
    radiance I / (4 pi r^2) gives E = I / (4 d^2) at a distance of d.
    """
    if light.kind is LightKind.DIRECTIONAL:
        lamp = UsdLux.DistantLight.Define(stage, path)
        lamp.CreateIntensityAttr(math.pi)
    else:
        lamp = UsdLux.SphereLight.Define(stage, path)
        a, b, c = light.attenuation
        attenuation = 1.0 / (a + b * REFERENCE_M + c * REFERENCE_M**2)
        lamp.CreateIntensityAttr(4.0 * math.pi * REFERENCE_M**2 * attenuation)
        lamp.CreateRadiusAttr(light.radius)
        lamp.CreateExtentAttr(shapes.points(np.array([[-light.radius] * 3, [light.radius] * 3])))
    lamp.CreateNormalizeAttr(True)
    lamp.CreateColorAttr(Gf.Vec3f(*light.color))
    if light.kind is LightKind.SPOT:
        shaping = UsdLux.ShapingAPI.Apply(lamp.GetPrim())
        shaping.CreateShapingConeAngleAttr(light.cone_deg)
        shaping.CreateShapingConeSoftnessAttr(light.softness)
    UsdLux.ShadowAPI.Apply(lamp.GetPrim()).CreateShadowEnableAttr(light.castshadow)
    turned = pose_looking_along(light.direction)
    shapes.place(lamp.GetPrim(), turned.replace(position=light.position))


def pose_looking_along(direction: Vec3) -> Pose:
    """Rotation by the shortest arc from -z, along which lights shine, to a direction."""
    length = math.sqrt(sum(d * d for d in direction))
    x, y, z = (d / length for d in direction)
    if z > 1.0 - 1e-12:  # straight up: any axis in the plane will do
        return Pose(quaternion=(0.0, 1.0, 0.0, 0.0))
    # The half-way quaternion between a = (0, 0, -1) and b: (1 + a . b, a x b).
    return Pose(quaternion=(1.0 - z, y, -x, 0.0))


# Kitchen --------------------------------------------------------------------------------------------------------------
# /World                         kind assembly; variant sets pose (start, closed, open), room, ceiling (shown, hidden)
#   /physicsScene /ambientLight
#   /<light> /<camera>
#   /<placement>                 a reference to ../assets/usd/<asset>/<asset>.usda, with the pose of the placement

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
            fix_base(layer, spec.path, WORLD, place.pose @ asset.root.pose)
    for pair in scene.exclusions:
        first, second = (WORLD.AppendChild(end.placement).AppendChild(end.link) for end in pair)
        _filter_pair(layer, first, second)
    _add_pose_variants(layer, scene)
    for kind in (Layer.ROOM, Layer.CEILING):
        _add_visibility_variants(layer, kind.value, [place for place in scene.placements if place.layer is kind])
    text: str = layer.ExportToString()
    return text


def _filter_pair(layer: Sdf.Layer, first: Sdf.Path, second: Sdf.Path) -> None:
    """Filter the contacts of two bodies of referenced assets, in addition to the assets' own filters."""
    spec = Sdf.CreatePrimInLayer(layer, first)
    if not spec.HasInfo("apiSchemas"):
        spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["PhysicsFilteredPairsAPI"]))
    path = first.AppendProperty("physics:filteredPairs")
    pairs = layer.GetRelationshipAtPath(path) or Sdf.RelationshipSpec(spec, "physics:filteredPairs", custom=False)
    pairs.targetPathList.prependedItems = [*pairs.targetPathList.prependedItems, second]


def _define(stage: Usd.Stage, scene: Scene) -> None:
    root = UsdGeom.Xform.Define(stage, WORLD).GetPrim()
    document.set_stage(stage, root)
    Usd.ModelAPI(root).SetKind(Kind.Tokens.assembly)
    physics = UsdPhysics.Scene.Define(stage, WORLD.AppendChild(PHYSICS))
    strength = float(np.linalg.norm(scene.gravity))
    down = [g / strength for g in scene.gravity] if strength else (0.0, 0.0, -1.0)
    physics.CreateGravityDirectionAttr(Gf.Vec3f(*down))
    physics.CreateGravityMagnitudeAttr(strength)
    define_lights_and_cameras(stage, WORLD, scene)
    for place in scene.placements:
        prim = UsdGeom.Xform.Define(stage, WORLD.AppendChild(place.name)).GetPrim()
        shapes.place(prim, place.pose)
        prim.CreateAttribute(LAYER, Sdf.ValueTypeNames.Token, True, Sdf.VariabilityUniform).Set(place.layer.value)


def _add_pose_variants(layer: Sdf.Layer, scene: Scene) -> None:
    """Add the variant set `pose`, `closed` selected: each asset's own variant, and the start pose, which no asset has.

    Objects that rest in a drawer move along with it.
    """
    poses = (START_POSE, CLOSED_POSE, OPEN_POSE)
    variants = _variants(layer, document.VARIANT_SET, poses, CLOSED_POSE)
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
                    _set_pose(layer, path.AppendChild(link.name), shift @ asset.asset_from_link(link.name, positions))
            if asset.keyframes:
                # Its variant that is nearest to the pose.
                own = own_pose(place, pose)
                is_there = own in {key.name for key in asset.keyframes} and own != START_POSE
                _over(layer, variants, pose, place).variantSelections[document.VARIANT_SET] = (
                    own if is_there else CLOSED_POSE
                )
            # The start pose, if it differs from the closed one, is stronger than a variant of the asset.
            positions = joint_positions(place.joints)
            closed = next((joint_positions(key.joints) for key in asset.keyframes if key.name == CLOSED_POSE), {})
            if pose == START_POSE and any(positions.get(j.name, 0.0) != closed.get(j.name, 0.0) for j in asset.joints):
                set_joints(layer, _over(layer, variants, pose, place).path, asset, positions)


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
