"""Sites, and regions: named volumes that robocasa reads from massless geoms with names `reg_...`."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.export.mujoco_values import SITE_GROUP, site_group
from casa_assets.geometry.solid.bounds import link_bounds
from casa_assets.model.asset.asset import Asset, Region, Site
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

REGION_COLOR = "0 1 0 0"
# Names under which robocasa looks for the bounding region. Ref: robocasa v1.0, fixtures and objects.
OUTER_REGIONS = ("bbox", "main")
# Site of an asset -> name under which robocasa v1.0 looks for its place beside `object`.
BESIDE_OBJECT = {"lid_site": "anchor_site"}
SIZE_SITE_RADIUS_M = 0.005
# Region whose corners robocasa v0.2 reads from sites -> prefix of the names of these sites.
CORNER_PREFIXES = {"main": "ext", "int": "int"}


def add(body: etree._Element, site: Site, prefix: str = "") -> None:
    """`<site>` below the body of its link; its name begins with `prefix`."""
    size = number.number(site.radius) if site.size is None else _half_size(site.kind, site.size)
    attributes = {"name": prefix + site.name, "type": site.kind, **number.place(site.pose), "size": size}
    etree.SubElement(body, "site", attributes | {"group": str(site_group(site)), "rgba": number.srgb(site.color)})


def _half_size(kind: str, size: Vec3) -> str:
    """MuJoCo's `size`: half sizes of a box; radius and half the height of a cylinder."""
    x, y, z = (s / 2 for s in size)
    return number.numbers((x, y, z) if kind == "box" else (x, z))


def add_corners(body: etree._Element, region: Region, prefix: str = "") -> None:
    """Add the four sites from which robocasa v0.2 reads a fixture's outer (`main`) and inner (`int`) size.

    `p0` is a corner; `px`, `py` and `pz` are its neighbours along each axis.
    """
    corner_prefix = CORNER_PREFIXES.get(region.name)
    if corner_prefix is None or region.kind != "box":
        return
    half = np.array(region.size) / 2
    for end, signs in (("p0", (-1, -1, -1)), ("px", (1, -1, -1)), ("py", (-1, 1, -1)), ("pz", (-1, -1, 1))):
        point = region.pose.apply((half * np.array(signs))[None])[0]
        name, size = f"{prefix}{corner_prefix}_{end}", number.number(SIZE_SITE_RADIUS_M)
        attributes = {"name": name, "pos": number.numbers(point), "size": size}
        etree.SubElement(body, "site", attributes | {"group": str(SITE_GROUP), "rgba": "0 0 0 0"})


def add_region(body: etree._Element, region: Region, group: int, prefix: str = "") -> None:
    """`<geom name="<prefix>reg_...">` below the body of its link: invisible, without contacts or mass."""
    attributes = {
        "name": f"{prefix}reg_{region.name}",
        "type": region.kind,
        **number.place(region.pose),
        "size": _half_size(region.kind, region.size),
        "group": str(group),
        "contype": "0",
        "conaffinity": "0",
        "mass": "0",
        "rgba": REGION_COLOR,
    }
    etree.SubElement(body, "geom", attributes)


def outer_region(asset: Asset) -> Region | None:
    """Bounding box of all colliders (of visuals if there are no colliders).

    None if the asset already has such a region.
    """
    if any(region.name in OUTER_REGIONS for region in asset.regions):
        return None
    lower, upper = collision_bounds(asset)
    return Region(name=OUTER_REGIONS[0], pose=Pose(position=_vec3((lower + upper) / 2)), size=_vec3(upper - lower))


def collision_bounds(asset: Asset) -> npt.NDArray[np.float64]:
    """(2, 3) corners of all colliders, asset frame, joints at zero, metres.

    If the asset has no colliders, the corners of its visuals.
    """
    boxes = [b for k in asset.links if (b := link_bounds(k, asset.asset_from_link(k.name))) is not None]
    return np.array([np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]]) if boxes else asset.bounds


def add_size_sites(outer: etree._Element, asset: Asset) -> None:
    """Add the three sites from which robocasa v0.2 reads an object's size, and BESIDE_OBJECT; in the object's frame."""
    lower, upper = asset.bounds
    half_x, half_y = (upper[:2] - lower[:2]) / 2
    points = {
        "bottom_site": (0.0, 0.0, lower[2]),
        "top_site": (0.0, 0.0, upper[2]),
        "horizontal_radius_site": (half_x, half_y, 0.0),
    }
    on_root = [site for site in asset.sites if site.link == asset.root.name]
    points |= {BESIDE_OBJECT[site.name]: site.pose.position for site in on_root if site.name in BESIDE_OBJECT}
    own = {site.name for site in asset.sites}
    for name, point in points.items():
        if name not in own:
            attributes = {"name": name, "pos": number.numbers(point), "size": number.number(SIZE_SITE_RADIUS_M)}
            etree.SubElement(outer, "site", attributes | {"rgba": "0 0 0 0"})


def _vec3(values: npt.NDArray[np.float64]) -> Vec3:
    x, y, z = (float(v) for v in values)
    return x, y, z
