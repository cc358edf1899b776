"""Asset -> scene.xml: the asset on a floor under a soft light, for viewing and drop tests."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from lxml import etree

from casa_assets.export.mjcf import body, number, site
from casa_assets.export.mujoco_values import VIEWER_GROUPS
from casa_assets.model.asset.asset import Asset, Base

# Pale floor, pale sky: neutral for any colour of object.
SKY = {
    "name": "scene__sky",
    "type": "skybox",
    "builtin": "gradient",
    "rgb1": "0.92 0.94 0.96",
    "rgb2": "0.62 0.66 0.7",
    "width": "256",
    "height": "1536",
}
FLOOR_MATERIAL = {"name": "scene__floor", "rgba": "0.78 0.78 0.76 1", "specular": "0.1", "shininess": "0.1"}
# What stands on a plane creeps in MuJoCo 3.3: a mesh touches it with neighbours of its lowest vertex alone, and rocks.
# On a box it has contacts all around its foot, also where that is ten micrometres above the floor. The box is deep: a
# shape that a fall drives into it is pushed out along the line between the two middles, which has to be upright.
FLOOR_BOX = {"type": "box", "size": "25 25 10", "pos": "0 0 -10", "margin": "0.00001"}
HEADLIGHT = {"ambient": "0.38 0.38 0.38", "diffuse": "0.3 0.3 0.3", "specular": "0.1 0.1 0.1"}
LIGHT_DISTANCE = 1.5  # diagonals of the asset
LIGHTS = (
    ((0.4, 0.5, -0.8), {"diffuse": "0.45 0.44 0.42", "specular": "0.4 0.4 0.4", "castshadow": "true"}),
    ((-0.7, 0.3, -0.8), {"diffuse": "0.12 0.13 0.15", "specular": "0.1 0.1 0.1", "castshadow": "false"}),
)


def add_frame(root: etree._Element, asset: Asset) -> None:
    """`<statistic>` and `<visual>`: initial view of the viewer, and its light."""
    center, diagonal = _center_and_diagonal(asset)
    etree.SubElement(root, "statistic", {"center": number.numbers(center), "extent": number.number(diagonal)})
    view = etree.SubElement(root, "visual")
    etree.SubElement(
        view, "global", {"azimuth": "60", "elevation": "-22", "fovy": "40", "offwidth": "1280", "offheight": "960"}
    )
    etree.SubElement(view, "quality", {"shadowsize": "4096", "offsamples": "8"})
    etree.SubElement(view, "headlight", HEADLIGHT)
    etree.SubElement(view, "map", {"znear": "0.02", "zfar": "80", "shadowclip": "2"})
    etree.SubElement(view, "rgba", {"haze": "0.92 0.94 0.96 1"})


def add_stage(assets: etree._Element, world: etree._Element, asset: Asset) -> None:
    """Add sky, floor and lights. The floor is a plane for viewing and a box for contacts."""
    etree.SubElement(assets, "texture", SKY)
    etree.SubElement(assets, "material", FLOOR_MATERIAL)
    center, diagonal = _center_and_diagonal(asset)
    for i, (direction, light) in enumerate(LIGHTS):
        # A directional light shines from everywhere, but its shadows are drawn from here: near means sharp.
        position = number.numbers(center - LIGHT_DISTANCE * diagonal * np.array(direction))
        attributes = {
            "name": f"scene__light_{i}",
            "directional": "true",
            "pos": position,
            "dir": number.numbers(direction),
        }
        etree.SubElement(world, "light", attributes | light)
    # MuJoCo takes the larger of two frictions. The least of the asset's own lets each collider's value act.
    names = ("dynamic_friction", "torsional_friction", "rolling_friction")
    friction = [min(getattr(s, name) for s in asset.substances) for name in names]
    seen = {"name": "scene__ground", "type": "plane", "size": "0 0 0.05", "material": "scene__floor"}
    seen |= {"group": str(VIEWER_GROUPS.visuals), "mass": "0", "contype": "0", "conaffinity": "0"}
    etree.SubElement(world, "geom", seen)
    floor = {"name": "scene__floor", "group": str(VIEWER_GROUPS.colliders), **FLOOR_BOX}
    floor |= {"contype": "1", "conaffinity": "1", "condim": "3", "friction": number.numbers(friction)}
    etree.SubElement(world, "geom", floor)


def add_object(world: etree._Element, context: body.BodyContext) -> tuple[float, ...]:
    """Put the asset on the floor: with a free joint if its base is free, else welded to the world.

    Returns:
        Position of the free joint (x, y, z, w, x, y, z); empty if it is welded.
    """
    asset = context.asset
    object_body = body.add(world, asset.root, context)
    x, y, z = asset.root.pose.position
    object_body.set("pos", number.numbers((x, y, z + _lift(asset))))
    if asset.base is Base.FREE:
        object_body.insert(0, etree.Element("freejoint", {"name": "scene__free"}))
        return (x, y, z + _lift(asset), *asset.root.pose.quaternion)
    return ()


def _center_and_diagonal(asset: Asset) -> tuple[npt.NDArray[np.float64], float]:
    """Centre of the visuals in the pose of the scene, and the diagonal of their bounds, metres."""
    lower, upper = asset.bounds
    center = (lower + upper) / 2
    center[2] += _lift(asset)
    return center, float(np.linalg.norm(upper - lower))


def _lift(asset: Asset) -> float:
    """Height by which to raise the asset so that its lowest collider touches z = 0, metres."""
    return -float(site.collision_bounds(asset)[0, 2])
