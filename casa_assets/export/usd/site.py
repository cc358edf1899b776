"""Site and region -> guide gprims that physics ignores and MuJoCo reads as sites."""

from __future__ import annotations

from pxr import Gf, Sdf, Usd, UsdGeom

from casa_assets.export.mujoco_values import VIEWER_GROUPS, site_group
from casa_assets.export.usd import collider, number
from casa_assets.model.asset.asset import Asset, Region, Site
from casa_assets.model.asset.shape import Box, Cylinder, Shape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3


def define_all(stage: Usd.Stage, root: Sdf.Path, asset: Asset) -> None:
    """Sites and regions below `<root>/<link>/sites`."""
    for site in asset.sites:
        prim = _define(stage, _path(stage, root, site), _shape(site), site.pose)
        red, green, blue, alpha = site.color
        number.author(prim, "mjc:group", Sdf.ValueTypeNames.Int, site_group(site))
        UsdGeom.Gprim(prim).CreateDisplayColorAttr([Gf.Vec3f(red, green, blue)])
        UsdGeom.Gprim(prim).CreateDisplayOpacityAttr([alpha])
    for region in asset.regions:
        prim = _define(stage, _path(stage, root, region), _volume(region.kind, region.size), region.pose)
        number.author(prim, "mjc:group", Sdf.ValueTypeNames.Int, VIEWER_GROUPS.regions)


def _path(stage: Usd.Stage, root: Sdf.Path, item: Site | Region) -> Sdf.Path:
    return (
        UsdGeom.Scope.Define(stage, root.AppendChild(item.link).AppendChild("sites")).GetPath().AppendChild(item.name)
    )


def _shape(site: Site) -> Shape:
    return Sphere(radius=site.radius) if site.size is None else _volume(site.kind, site.size)


def _volume(kind: str, size: Vec3) -> Shape:
    if kind == "box":
        return Box(size=size)
    return Cylinder(radius=size[0] / 2, height=size[2])


def _define(stage: Usd.Stage, path: Sdf.Path, shape: Shape, pose: Pose) -> Usd.Prim:
    prim = collider.define_shape(stage, path, shape)
    number.place(prim, pose, shape.size if isinstance(shape, Box) else None)
    UsdGeom.Imageable(prim).CreatePurposeAttr(UsdGeom.Tokens.guide)
    for schema in ("NewtonSiteAPI", "MjcSiteAPI"):
        prim.AddAppliedSchema(schema)
    return prim
