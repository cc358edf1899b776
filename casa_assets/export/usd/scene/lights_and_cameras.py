"""Lights and cameras of a scene -> UsdLux and UsdGeom.Camera."""

from __future__ import annotations

import math

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from casa_assets.export.usd import number
from casa_assets.model.kitchen.scene import Camera, Light, LightKind, Scene
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

# camelCase, which no placement is.
AMBIENT = "ambientLight"
# USD's lights fade with the square of the distance. At this distance, that of a worktop under the ceiling, one is as
# bright as the scene's own attenuation makes it.
REFERENCE_M = 1.5
# Size of the sensor, millimetres; the defaults of USD. Ref: UsdGeomCamera, verticalAperture, horizontalAperture.
SENSOR_HEIGHT_MM, SENSOR_WIDTH_MM = 15.2908, 20.955
CLIPPING_RANGE_M = (0.015, 60.0)


def define_all(stage: Usd.Stage, world: Sdf.Path, scene: Scene) -> None:
    """Define lights, ambient light and cameras below the prim of the world."""
    if any(scene.ambient):
        dome = UsdLux.DomeLight.Define(stage, world.AppendChild(AMBIENT))
        dome.CreateColorAttr(Gf.Vec3f(*scene.ambient))
        dome.CreateIntensityAttr(1.0)
    for light in scene.lights:
        _light(stage, world.AppendChild(light.name), light)
    for camera in scene.cameras:
        _camera(stage, world.AppendChild(camera.name), camera)


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
        lamp.CreateExtentAttr(number.extent(np.array([[-light.radius] * 3, [light.radius] * 3])))
    lamp.CreateNormalizeAttr(True)
    lamp.CreateColorAttr(Gf.Vec3f(*light.color))
    if light.kind is LightKind.SPOT:
        shaping = UsdLux.ShapingAPI.Apply(lamp.GetPrim())
        shaping.CreateShapingConeAngleAttr(light.cone_deg)
        shaping.CreateShapingConeSoftnessAttr(light.softness)
    UsdLux.ShadowAPI.Apply(lamp.GetPrim()).CreateShadowEnableAttr(light.castshadow)
    number.place(
        lamp.GetPrim(), Pose(position=light.position, quaternion=pose_looking_along(light.direction).quaternion)
    )


def _camera(stage: Usd.Stage, path: Sdf.Path, camera: Camera) -> None:
    prim = UsdGeom.Camera.Define(stage, path)
    prim.CreateVerticalApertureAttr(SENSOR_HEIGHT_MM)
    prim.CreateHorizontalApertureAttr(SENSOR_WIDTH_MM)
    prim.CreateFocalLengthAttr(SENSOR_HEIGHT_MM / 2 / math.tan(math.radians(camera.fov_y_deg) / 2))
    prim.CreateClippingRangeAttr(Gf.Vec2f(*CLIPPING_RANGE_M))
    number.place(prim.GetPrim(), camera.pose)


def pose_looking_along(direction: Vec3) -> Pose:
    """Rotation by the shortest arc from -z, along which lights shine, to a direction."""
    length = math.sqrt(sum(d * d for d in direction))
    x, y, z = (d / length for d in direction)
    if z > 1.0 - 1e-12:  # straight up: any axis in the plane will do
        return Pose(quaternion=(0.0, 1.0, 0.0, 0.0))
    # The half-way quaternion between a = (0, 0, -1) and b: (1 + a . b, a x b).
    return Pose(quaternion=(1.0 - z, y, -x, 0.0))
