"""Link -> `<body>` with explicit mass properties; bodies are nested like the links that carry each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from lxml import etree

from casa_assets.export.mjcf import collider, joint, number, site, visual
from casa_assets.export.mjcf.visual import Meshes
from casa_assets.export.mujoco_values import ROBOSUITE_GROUPS, Groups
from casa_assets.model.asset.asset import Asset, Inertial, Link
from casa_assets.model.kitchen.scene import OUTER_FACE

# Share of the trace that is added to the moments of a flat plate, so that nine digits cannot break A + B >= C.
PLATE_MARGIN = 1e-8


@dataclass(frozen=True)
class BodyContext:
    """Names, meshes and groups that every body of a document shares.

    Attributes:
        asset: asset whose links are written.
        meshes: its mesh files.
        materials: material id -> name in the document.
        groups: groups of geoms.
        placement: name of the copy in a document that holds several: the name of its root body, and with `__` the
            prefix of all other names. None to keep the names unchanged.
        collider_colors: collider name -> `rgba`, if colliders are drawn instead of visuals.
    """

    asset: Asset
    meshes: Meshes
    materials: dict[str, str]
    groups: Groups = ROBOSUITE_GROUPS
    placement: str | None = None
    collider_colors: Mapping[str, str] = field(default_factory=dict)

    @property
    def prefix(self) -> str:
        """Prefix of all names except that of the root body."""
        return "" if self.placement is None else f"{self.placement}__"

    def body_name(self, link: str) -> str:
        """Name of the body of a link."""
        if self.placement is not None and link == self.asset.root.name:
            return self.placement
        return self.prefix + link


def add(parent: etree._Element, link: Link, context: BodyContext) -> etree._Element:
    """`<body>` of a link and of all links that it carries, without a free joint.

    Order inside a body: mass, joint, colliders, visuals, regions, sites, carried bodies.
    """
    asset, prefix = context.asset, context.prefix
    body = etree.SubElement(parent, "body", {"name": context.body_name(link.name), **number.place(link.pose)})
    etree.SubElement(body, "inertial", _inertial(link.inertial))
    link_joint = asset.joint_of(link.name)
    if link_joint is not None:
        joint.add(body, link_joint, prefix)
    for shape in link.colliders:
        substance = asset.substance(shape.substance)
        geom = collider.add(body, shape, substance, context.meshes, context.groups.colliders, prefix)
        if shape.name in context.collider_colors:
            geom.set("rgba", context.collider_colors[shape.name])
    for shown in link.visuals:
        material = context.materials[shown.material]
        group = context.groups.shell if shown.label == OUTER_FACE else context.groups.visuals
        visual.add(body, shown, context.meshes.of[shown.name], material, group, prefix)
    outer = site.outer_region(asset) if link.parent is None else None
    for region in [*([outer] if outer else []), *asset.regions]:
        if region.link == link.name:
            site.add_region(body, region, context.groups.regions, prefix)
            if asset.contract:
                site.add_corners(body, region, prefix)
    for point in asset.sites:
        if point.link == link.name:
            site.add(body, point, prefix)
    for carried in asset.links:
        if carried.parent == link.name:
            add(body, carried, context)
    return body


def full_inertia(inertial: Inertial) -> list[float]:
    """(xx, yy, zz, xy, xz, yz), kg*m^2, adjusted so that nine digits of it are still a valid inertia."""
    moments = np.linalg.eigvalsh(inertial.tensor)
    trace = float(moments.sum())
    is_plate = moments[0] + moments[1] - moments[2] < 2 * PLATE_MARGIN * trace
    diagonal = [m + PLATE_MARGIN * trace if is_plate else m for m in inertial.inertia[:3]]
    return [*diagonal, *inertial.inertia[3:]]


def _inertial(inertial: Inertial) -> dict[str, str]:
    return {
        "pos": number.numbers(inertial.center_of_mass),
        "mass": number.number(inertial.mass),
        "fullinertia": number.numbers(full_inertia(inertial)),
    }
