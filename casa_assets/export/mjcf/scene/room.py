"""Scene -> view settings, sky, lights and cameras."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from lxml import etree

from casa_assets.core.typing import Floats
from casa_assets.export.mjcf import number
from casa_assets.export.mjcf.site import collision_bounds
from casa_assets.model.kitchen.scene import Camera, Layer, Light, LightKind, Scene

# Clipping distances: a camera at a wrist sees the fingers, and what lies beyond a window is not cut off.
NEAR_M, FAR_M = 0.015, 60.0
# The sun's map of shadows goes this many times as far as the scene. With less the upper parts of walls lie beyond its
# edge, and MuJoCo draws rows of dark specks there.
SHADOW_REACH = 2.0
# Specular light as a share of a light's colour. Chosen by eye, as in the scene of a single asset.
SPECULAR_SHARE = 0.5
# The exponent with which a spot of full softness fades towards its edge. Chosen by eye.
MAX_SPOT_EXPONENT = 20.0
# Cutoff of a light that shines to all sides, degrees.
ALL_SIDES_DEG = "180"
# The free camera starts this many extents from the middle. Ref: mjv_defaultFreeCamera.
FREE_CAMERA_EXTENTS = 1.5
# Camera of a kitchen that sees all of it.
OVERVIEW = "overview"
# Largest picture that is rendered off screen.
OFFSCREEN_SIZE = {"offwidth": "1920", "offheight": "1440"}


@dataclass(frozen=True, eq=False)
class FirstView:
    """Initial view of the free camera: (3,) target point and distance from it, metres; angles in degrees.

    `reach` is the distance of the corners of the scene from its middle, metres.
    """

    reach: float
    target: Floats
    distance: float
    azimuth_deg: float
    elevation_deg: float
    fov_y_deg: float


def add_frame(root: etree._Element, scene: Scene) -> None:
    """`<statistic>` and `<visual>`: first view, rendering options and ambient light."""
    first = _first_view(scene)
    extent = first.distance / FREE_CAMERA_EXTENTS
    frame = {"center": number.numbers(first.target), "extent": number.number(extent), "meansize": "0.3"}
    etree.SubElement(root, "statistic", frame)
    view = etree.SubElement(root, "visual")
    angles = {"azimuth": number.number(first.azimuth_deg), "elevation": number.number(first.elevation_deg)}
    etree.SubElement(view, "global", {**angles, "fovy": number.number(first.fov_y_deg), **OFFSCREEN_SIZE})
    etree.SubElement(view, "quality", {"shadowsize": "4096", "offsamples": "4"})
    ambient = {"ambient": number.numbers(scene.ambient), "diffuse": "0 0 0", "specular": "0 0 0"}
    etree.SubElement(view, "headlight", ambient)
    near, far = number.number(NEAR_M / extent), number.number(FAR_M / extent)
    shadows = {"shadowclip": number.number(SHADOW_REACH * first.reach / extent), "shadowscale": "0.8"}
    etree.SubElement(view, "map", {"znear": near, "zfar": far, **shadows})
    if scene.sky is not None:
        etree.SubElement(view, "rgba", {"haze": f"{number.srgb(scene.sky.horizon)} 1"})


def _first_view(scene: Scene) -> FirstView:
    """View of the camera `overview` if it exists, so that the free camera starts where our pictures are taken."""
    lower, upper = scene_bounds(scene)
    middle, reach = (lower + upper) / 2, max(float(np.linalg.norm(upper - lower)) / 2, 0.1)
    for camera in scene.cameras:
        if camera.name == OVERVIEW:
            eye, forward = np.array(camera.pose.position), -camera.pose.rotation[:, 2]
            distance = round(max(float((middle - eye) @ forward), 0.1), 3)
            x, y, z = (float(v) for v in forward)
            # Rounded: arc functions differ between processors in their last bit.
            angles = round(math.degrees(math.atan2(y, x)), 2), round(math.degrees(math.asin(z)), 2)
            return FirstView(reach, eye + distance * forward, distance, *angles, camera.fov_y_deg)
    return FirstView(reach, middle, FREE_CAMERA_EXTENTS * reach, 65.0, -30.0, 50.0)


def add_sky(assets: etree._Element, scene: Scene) -> None:
    """Add the skybox below `<asset>` if the scene has a sky."""
    if scene.sky is None:
        return
    colors = {"rgb1": number.srgb(scene.sky.zenith), "rgb2": number.srgb(scene.sky.horizon)}
    sky = {"name": "sky", "type": "skybox", "builtin": "gradient", **colors, "width": "256", "height": "1536"}
    etree.SubElement(assets, "texture", sky)


def add_lights_and_cameras(world: etree._Element, scene: Scene) -> None:
    """`<light>` and `<camera>` elements below `<worldbody>`."""
    for light in scene.lights:
        etree.SubElement(world, "light", _light(light))
    for camera in scene.cameras:
        etree.SubElement(world, "camera", _camera(camera))


def scene_bounds(scene: Scene) -> npt.NDArray[np.float64]:
    """(2, 3) corners of everything in the scene except a ceiling, joints at zero, world frame, metres."""
    boxes = {asset.id: collision_bounds(asset) for asset in scene.assets}
    corners = []
    for place in scene.placements:
        if place.layer is not Layer.CEILING or len(scene.placements) == 1:
            bounds = boxes[place.asset]
            grid = np.array([[bounds[k >> i & 1][i] for i in range(3)] for k in range(8)])
            corners.append(place.pose.apply(grid))
    points = np.concatenate(corners) if corners else np.zeros((1, 3))
    return np.array([points.min(axis=0), points.max(axis=0)])


def _light(light: Light) -> dict[str, str]:
    length = float(np.linalg.norm(light.direction))
    attributes = {
        "name": light.name,
        # `type`, which says the same, is newer than MuJoCo 3.3.1.
        "directional": "true" if light.kind is LightKind.DIRECTIONAL else "false",
        "pos": number.numbers(light.position),
        "dir": number.numbers(d / length for d in light.direction),
        # Linear, unlike other colours: MuJoCo adds up light without converting it from sRGB.
        "diffuse": number.numbers(light.color),
        "specular": number.numbers(SPECULAR_SHARE * c for c in light.color),
        "castshadow": "true" if light.castshadow else "false",
        "bulbradius": number.number(light.radius),
    }
    if light.kind is LightKind.DIRECTIONAL:
        return attributes
    attributes["attenuation"] = number.numbers(light.attenuation)
    if light.kind is LightKind.SPOT:
        return attributes | {
            "cutoff": number.number(light.cone_deg),
            "exponent": number.number(MAX_SPOT_EXPONENT * light.softness),
        }
    return attributes | {"cutoff": ALL_SIDES_DEG, "exponent": "0"}


def _camera(camera: Camera) -> dict[str, str]:
    return {"name": camera.name, **number.place(camera.pose), "fovy": number.number(camera.fov_y_deg)}
