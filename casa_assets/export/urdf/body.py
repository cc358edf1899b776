"""Link -> `<link>` with explicit mass properties, and the `<joint>` that ties it to the link that carries it."""

from __future__ import annotations

from dataclasses import dataclass

from lxml import etree

from casa_assets.export.mjcf.body import full_inertia
from casa_assets.export.mjcf.number import number as text
from casa_assets.export.urdf import collider, joint, number, visual
from casa_assets.export.urdf.visual import Meshes
from casa_assets.model.asset.asset import Asset, Inertial, Link
from casa_assets.model.pose import Pose

INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


@dataclass(frozen=True)
class BodyContext:
    """Data that all links of an asset share in a document.

    Attributes:
        asset: asset whose links are written.
        meshes: its mesh files.
        placement: name of the copy in a document that holds several: the name of its root link, and with `__` the
            prefix of all other names. None to keep the names unchanged.
    """

    asset: Asset
    meshes: Meshes
    placement: str | None = None

    @property
    def prefix(self) -> str:
        """Prefix of all names except that of the root link."""
        return "" if self.placement is None else f"{self.placement}__"

    def link_name(self, link: str) -> str:
        """Name of a link in the document."""
        return link if self.placement is None else link_name(self.asset, link, self.placement)


def link_name(asset: Asset, link: str, placement: str) -> str:
    """Name of a link of a placement: the root has the name of the placement."""
    return placement if link == asset.root.name else f"{placement}__{link}"


def link_from_urdf(asset: Asset, link: str) -> Pose:
    """Pose of a link's URDF frame in the link's own frame: at the anchor of its joint."""
    moved_by = asset.joint_of(link)
    return Pose() if moved_by is None else Pose(position=moved_by.anchor)


def add_all(robot: etree._Element, context: BodyContext) -> None:
    """Add every `<link>` of an asset below `<robot>`, parents first, each non-root link followed by its `<joint>`."""
    asset = context.asset
    for link in asset.links:
        _add_link(robot, link, context)
        if link.parent is not None:
            parent_urdf = link_from_urdf(asset, link.parent).inverse()
            joint.add(
                robot,
                asset.joint_of(link.name),
                context.link_name(link.parent),
                context.link_name(link.name),
                parent_urdf @ link.pose @ link_from_urdf(asset, link.name),
                context.prefix,
            )


def _add_link(robot: etree._Element, link: Link, context: BodyContext) -> None:
    """`<link>`: mass, visuals, colliders."""
    looks = {item.id: item for item in context.asset.materials}
    urdf_from_link = link_from_urdf(context.asset, link.name).inverse()
    element = etree.SubElement(robot, "link", {"name": context.link_name(link.name)})
    _add_inertial(element, link.inertial, urdf_from_link)
    for shown in link.visuals:
        path = context.meshes.of[shown.name]
        visual.add(element, shown, looks[shown.material], path, urdf_from_link, context.prefix)
    for shape in link.colliders:
        collider.add_all(element, shape, context.meshes, urdf_from_link, context.prefix)


def _add_inertial(link: etree._Element, inertial: Inertial, urdf_from_link: Pose) -> None:
    element = etree.SubElement(link, "inertial")
    number.add_origin(element, urdf_from_link @ Pose(position=inertial.center_of_mass))
    etree.SubElement(element, "mass", {"value": text(inertial.mass)})
    tensor = zip(INERTIA, map(text, full_inertia(inertial)), strict=True)
    etree.SubElement(element, "inertia", dict(tensor))
