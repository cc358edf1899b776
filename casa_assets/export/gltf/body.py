"""Links of an asset -> nodes below each other, with their joints, visuals, colliders and regions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from casa_assets.export.gltf import layer
from casa_assets.export.gltf.layer import LayerName, Layers
from casa_assets.export.gltf.number import placed, rounded
from casa_assets.export.gltf.visual import Meshes
from casa_assets.model.asset.asset import Asset, Joint, Link, Visual
from casa_assets.model.kitchen.scene import OUTER_FACE


@dataclass
class Nodes:
    """Nodes as glTF lists them."""

    rows: list[dict[str, Any]] = field(default_factory=list)

    def add(self, row: dict[str, Any], below: int | None = None) -> int:
        """Add a node as a child of the node `below`, and return its index."""
        self.rows.append(row)
        index = len(self.rows) - 1
        if below is not None:
            self.rows[below].setdefault("children", []).append(index)
        return index


@dataclass(frozen=True)
class Copy:
    """One copy of an asset in a document.

    Attributes:
        prefix: prefix of the names of its nodes and joints: empty, or the placement's name and a slash.
        layer: layer of its visuals.
        positions: joint name -> position in the file, rad or m; joints that are not named are at zero.
    """

    asset: Asset
    prefix: str = ""
    layer: LayerName = LayerName.VISUAL
    positions: Mapping[str, float] = field(default_factory=dict)


def add_all(nodes: Nodes, meshes: Meshes, copy: Copy, below: int, wanted: Layers) -> dict[str, int]:
    """Add a node for each link below the node `below`; return link name -> index of its node."""
    asset = copy.asset
    looks = {material.id: material for material in asset.materials}
    found: dict[str, int] = {}
    for link in asset.links:
        moved_by = asset.joint_of(link.name)
        extras: dict[str, Any] = {"link": link.name}
        if moved_by is not None:
            extras["joint"] = joint_facts(asset, moved_by, copy)
        pose = asset.parent_from_link(link.name, copy.positions)
        row = {"name": copy.prefix + link.name, "extras": extras, **placed(pose)}
        found[link.name] = nodes.add(row, below if link.parent is None else found[link.parent])
        _add_visuals(nodes, meshes, link, looks, copy, found[link.name])
        for part in layer.nodes(link, asset.regions, meshes, wanted):
            nodes.add({**part, "name": f"{copy.prefix}{link.name}/{part['name']}"}, found[link.name])
    return found


def joint_facts(asset: Asset, joint: Joint, copy: Copy) -> dict[str, Any]:
    """`extras.joint` of the link that a joint moves; `rest` is the position of the joint in the file."""
    states = {s.value: rounded(s.interval) for s in asset.states if s.joint == joint.name}
    behind = {} if joint.behind is None else {"behind": copy.prefix + joint.behind}
    return {
        "name": copy.prefix + joint.name,
        "type": joint.kind.value,
        "axis": rounded(joint.axis),
        "anchor": rounded(joint.anchor),
        "range": rounded(joint.range),
        "rest": rounded([copy.positions.get(joint.name, 0.0)])[0],
        **({"states": states} if states else {}),
        **behind,
    }


def _add_visuals(nodes: Nodes, meshes: Meshes, link: Link, looks: dict[str, Any], copy: Copy, below: int) -> None:
    """Add one node for the visuals of a link, and another for faces that look out of the room."""
    groups: dict[LayerName, list[Visual]] = {}
    for visual in link.visuals:
        group = LayerName.OUTSIDE if visual.label == OUTER_FACE else copy.layer
        groups.setdefault(group, []).append(visual)
    for group, visuals in groups.items():
        mesh = meshes.of_visuals(visuals, looks)
        if mesh is not None:
            labels = sorted({v.label for v in visuals if v.label is not None})
            extras = {"layer": group.value, **({"labels": labels} if labels else {})}
            name = f"{copy.prefix}{link.name}/{group.value}"
            nodes.add({"name": name, "mesh": mesh, "extras": extras}, below)
