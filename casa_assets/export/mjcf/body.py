"""Link -> `<body>` with explicit mass properties; links nest as they are carried."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from lxml import etree

from casa_assets.export.mjcf import collider, joint, number, site, visual
from casa_assets.export.mjcf.mesh import Meshes
from casa_assets.model.asset.asset import Asset, Inertial, Link

# Share of the trace that is added to the moments of a flat plate, so that nine digits cannot break A + B >= C.
PLATE_MARGIN = 1e-8


@dataclass(frozen=True)
class BodyContext:
    """Names, meshes and groups that every body of a document shares.

    Attributes:
        asset: whose links are written.
        meshes: its mesh files.
        materials: material id -> name in the document.
        touched, seen: groups of colliders and of visuals.
        placement: name of the copy in a document that holds several: that of its root body, and with `__` what the
            names of everything else in it begin with. None where the names stay as they are.
        tints: collider name -> `rgba`, where colliders are what is seen.
    """

    asset: Asset
    meshes: Meshes
    materials: dict[str, str]
    touched: int
    seen: int
    placement: str | None = None
    tints: Mapping[str, str] = field(default_factory=dict)

    @property
    def prefix(self) -> str:
        """Prefix of all names."""
        return "" if self.placement is None else f"{self.placement}__"

    def body_name(self, link: str) -> str:
        """Name of the body of a link."""
        root = self.placement is not None and link == self.asset.root.name
        return str(self.placement) if root else self.prefix + link


def add(parent: etree._Element, link: Link, draft: BodyContext) -> etree._Element:
    """`<body>` of a link and of all links that it carries, without a free joint.

    Order inside a body: mass, joint, colliders, visuals, regions, sites, carried bodies.
    """
    asset, prefix = draft.asset, draft.prefix
    body = etree.SubElement(parent, "body", {"name": draft.body_name(link.name), **number.place(link.pose)})
    etree.SubElement(body, "inertial", _inertial(link.inertial))
    moved_by = asset.joint_of(link.name)
    if moved_by is not None:
        joint.add(body, moved_by, prefix)
    for item in link.colliders:
        geom = collider.add(body, item, asset.substance(item.substance), draft.meshes, draft.touched, prefix)
        if item.name in draft.tints:
            geom.set("rgba", draft.tints[item.name])
    for shown in link.visuals:
        look = draft.materials[shown.material]
        visual.add(body, shown, draft.meshes.of[shown.name], look, draft.seen, prefix)
    outer = site.outer_region(asset) if link.parent is None else None
    for region in [*([outer] if outer else []), *asset.regions]:
        if region.link == link.name:
            site.add_region(body, region, prefix)
            if asset.contract:
                site.add_corners(body, region, prefix)
    for point in asset.sites:
        if point.link == link.name:
            site.add(body, point, prefix)
    for carried in asset.links:
        if carried.parent == link.name:
            add(body, carried, draft)
    return body


def _inertial(inertial: Inertial) -> dict[str, str]:
    moments = np.linalg.eigvalsh(inertial.tensor)
    trace = float(moments.sum())
    flat = moments[0] + moments[1] - moments[2] < 2 * PLATE_MARGIN * trace
    grown = [m + PLATE_MARGIN * trace if flat else m for m in inertial.inertia[:3]]
    return {
        "pos": number.numbers(inertial.center_of_mass),
        "mass": number.number(inertial.mass),
        "fullinertia": number.numbers((*grown, *inertial.inertia[3:])),
    }
