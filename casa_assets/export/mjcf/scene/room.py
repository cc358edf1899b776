"""Scene -> view settings, sky, lights and cameras."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.export.mjcf.site import collision_bounds
from casa_assets.model.kitchen.scene import Camera, Layer, Light, LightKind, Scene

# Clipping distances: a camera at a wrist sees the fingers, and what lies beyond a window is not cut off.
NEAR_M, FAR_M = 0.015, 60.0
# Specular light as a share of a light's colour. Chosen by eye, as in the scene of a single asset.
SPECULAR_SHARE = 0.5
# The exponent with which a spot of full softness fades towards its edge. Chosen by eye.
MAX_SPOT_EXPONENT = 20.0
# Cutoff of a light that shines to all sides, degrees.
ALL_SIDES_DEG = "180"
# Largest picture that is rendered off screen.
OFFSCREEN_SIZE = {"offwidth": "1920", "offheight": "1440"}


def add_frame(root: etree._Element, scene: Scene) -> None:
    """`<statistic>` and `<visual>`: first view, rendering options and ambient light."""
    lower, upper = scene_bounds(scene)
    extent = max(float(np.linalg.norm(upper - lower)) / 2, 0.1)
    # The viewer starts 1.5 extents away.
    frame = {"center": number.numbers((lower + upper) / 2), "extent": number.number(extent), "meansize": "0.3"}
    etree.SubElement(root, "statistic", frame)
    view = etree.SubElement(root, "visual")
    etree.SubElement(view, "global", {"azimuth": "65", "elevation": "-30", "fovy": "50", **OFFSCREEN_SIZE})
    etree.SubElement(view, "quality", {"shadowsize": "4096", "offsamples": "4"})
    ambient = {"ambient": number.numbers(scene.ambient), "diffuse": "0 0 0", "specular": "0 0 0"}
    etree.SubElement(view, "headlight", ambient)
    near, far = number.number(NEAR_M / extent), number.number(FAR_M / extent)
    etree.SubElement(view, "map", {"znear": near, "zfar": far, "shadowclip": "1.2", "shadowscale": "0.8"})
    if scene.sky is not None:
        etree.SubElement(view, "rgba", {"haze": f"{number.srgb(scene.sky.horizon)} 1"})


def add_sky(assets: etree._Element, scene: Scene) -> None:
    """The skybox below `<asset>`, where there is a sky."""
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
    """(2, 3) corners of everything in the scene but a ceiling, joints at zero, world frame, metres."""
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
