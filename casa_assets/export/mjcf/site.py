"""Sites, and regions: named volumes that robocasa reads from massless geoms called `reg_...`."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from lxml import etree

from casa_assets.export.mjcf import number
from casa_assets.export.mjcf.material import linear_to_srgb
from casa_assets.geometry.solid.bounds import link_bounds
from casa_assets.model.asset.asset import Asset, Region, Site
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

SITE_GROUP = 3  # hidden by the viewer until asked for
# Of flames and streams, which runtimes show by raising their alpha: a group that every camera sees.
EFFECT_GROUP = 1
REGION_GROUP = 1
REGION_COLOR = "0 1 0 0"
# Names under which robocasa looks for the outer volume. Ref: robocasa v1.0, fixtures and objects.
OUTER = ("bbox", "main")
MEASURE_RADIUS = 0.005
# Regions whose corners robocasa v0.2 reads from sites, and the prefix of their names.
CORNERS = {"main": "ext", "int": "int"}


def add(body: etree._Element, site: Site, prefix: str = "") -> None:
    """`<site>` below the body of its link; its name begins with `prefix`."""
    attributes = {"name": prefix + site.name, "type": site.kind, **number.place(site.pose), "size": _half_size(site)}
    red, green, blue, alpha = site.color
    shown = number.numbers((linear_to_srgb(red), linear_to_srgb(green), linear_to_srgb(blue), alpha))
    group = SITE_GROUP if alpha else EFFECT_GROUP
    etree.SubElement(body, "site", attributes | {"group": str(group), "rgba": shown})


def _half_size(site: Site) -> str:
    """MuJoCo's `size`: radius; half sizes of a box; radius and half the height of a cylinder."""
    if site.size is None:
        return number.number(site.radius)
    x, y, z = (s / 2 for s in site.size)
    return number.numbers((x, y, z) if site.kind == "box" else (x, z))


def add_corners(body: etree._Element, region: Region, prefix: str = "") -> None:
    """The four sites from which robocasa v0.2 takes a fixture's outer (`main`) and inner (`int`) size.

    `p0` is a corner; `px`, `py` and `pz` are the next ones along each axis.
    """
    corner = CORNERS.get(region.name)
    if corner is None or region.kind != "box":
        return
    half = np.array(region.size) / 2
    for end, signs in (("p0", (-1, -1, -1)), ("px", (1, -1, -1)), ("py", (-1, 1, -1)), ("pz", (-1, -1, 1))):
        point = region.pose.apply((half * np.array(signs))[None])[0]
        name, size = f"{prefix}{corner}_{end}", number.number(MEASURE_RADIUS)
        attributes = {"name": name, "pos": number.numbers(point), "size": size}
        etree.SubElement(body, "site", attributes | {"group": str(SITE_GROUP), "rgba": "0 0 0 0"})


def add_region(body: etree._Element, region: Region, prefix: str = "") -> None:
    """`<geom name="<prefix>reg_...">` below the body of its link: not seen, not touched, without mass."""
    x, y, z = (s / 2 for s in region.size)
    attributes = {
        "name": f"{prefix}reg_{region.name}",
        "type": region.kind,
        **number.place(region.pose),
        "size": number.numbers((x, y, z) if region.kind == "box" else (x, z)),
        "group": str(REGION_GROUP),
        "contype": "0",
        "conaffinity": "0",
        "mass": "0",
        "rgba": REGION_COLOR,
    }
    etree.SubElement(body, "geom", attributes)


def outer_region(asset: Asset) -> Region | None:
    """Bounding box of everything that collides (of what is seen, where nothing does), unless the asset names one."""
    if any(region.name in OUTER for region in asset.regions):
        return None
    lower, upper = touched_bounds(asset)
    center, size = _three((lower + upper) / 2), _three(upper - lower)
    return Region(name=OUTER[0], pose=Pose(position=center), size=size)


def touched_bounds(asset: Asset) -> npt.NDArray[np.float64]:
    """(2, 3) corners of all colliders, asset frame, joints at zero, metres; of what is seen where nothing collides."""
    corners = [b for k in asset.links if (b := link_bounds(k, asset.asset_from_link(k.name))) is not None]
    if not corners:
        return asset.bounds
    return np.array([np.min([c[0] for c in corners], axis=0), np.max([c[1] for c in corners], axis=0)])


def add_measures(outer: etree._Element, asset: Asset) -> None:
    """The three sites that robocasa v0.2 takes an object's size from, relative to its own frame."""
    lower, upper = asset.bounds
    half_x, half_y = (upper[:2] - lower[:2]) / 2
    points = {
        "bottom_site": (0.0, 0.0, lower[2]),
        "top_site": (0.0, 0.0, upper[2]),
        "horizontal_radius_site": (half_x, half_y, 0.0),
    }
    taken = {site.name for site in asset.sites}
    for name, point in points.items():
        if name not in taken:
            attributes = {"name": name, "pos": number.numbers(point), "size": number.number(MEASURE_RADIUS)}
            etree.SubElement(outer, "site", attributes | {"rgba": "0 0 0 0"})


def _three(values: npt.NDArray[np.float64]) -> Vec3:
    x, y, z = (float(v) for v in values)
    return x, y, z
