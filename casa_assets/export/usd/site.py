"""Site and region -> guide gprims that physics ignores and MuJoCo reads as sites."""

from __future__ import annotations

from pxr import Sdf, Usd, UsdGeom

from casa_assets.export.usd import collider, number
from casa_assets.model.asset import Asset, Region, Site
from casa_assets.model.pose import Pose
from casa_assets.model.shape import Box, Cylinder, Shape, Sphere

GROUP = 3  # not shown unless asked for, as in model.xml


def define_all(stage: Usd.Stage, root: Sdf.Path, asset: Asset) -> None:
    """Sites and regions below `<root>/<link>/sites`."""
    for site in asset.sites:
        _define(stage, _path(stage, root, site), Sphere(radius=site.radius), site.pose)
    for region in asset.regions:
        _define(stage, _path(stage, root, region), _volume(region), region.pose)


def _path(stage: Usd.Stage, root: Sdf.Path, item: Site | Region) -> Sdf.Path:
    return (
        UsdGeom.Scope.Define(stage, root.AppendChild(item.link).AppendChild("sites")).GetPath().AppendChild(item.name)
    )


def _volume(region: Region) -> Shape:
    if region.kind == "box":
        return Box(size=region.size)
    return Cylinder(radius=region.size[0] / 2, height=region.size[2])


def _define(stage: Usd.Stage, path: Sdf.Path, shape: Shape, pose: Pose) -> None:
    prim = collider.define_shape(stage, path, shape)
    number.place(prim, pose, shape.size if isinstance(shape, Box) else None)
    UsdGeom.Imageable(prim).CreatePurposeAttr(UsdGeom.Tokens.guide)
    for schema in ("NewtonSiteAPI", "MjcSiteAPI"):
        prim.AddAppliedSchema(schema)
    number.author(prim, "mjc:group", Sdf.ValueTypeNames.Int, GROUP)
