"""Divide an asset into the fixtures that RoboCasa knows, and move each so that its frame is where RoboCasa expects it.

RoboCasa v1.0 has one joint `slidejoint` per Drawer, one pair of doors per HingeCabinet, one door per SingleCabinet.
One of our units may have several of them. A part that is divided off gets its moving links, their joints with
RoboCasa's names, and the regions behind them; the rest keeps the carcass.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from casa_assets import Asset
from casa_assets.ext.arrays import Floats, decimals
from casa_assets.ext.records import Collider, Inertial, Link, Mesh, Pose, Region, Site, Vec3, Visual
from casa_assets.ext.solids import link_bounds

# RoboCasa v1.0 places a fixture by the frame of its body `object`, and interprets the position of a region in that
# frame, whichever body the region belongs to. It also assumes half of a fixture's size on each side of the frame
# (counters), and recognises a top drawer by the height of the frame. All of this is correct if the frames of the asset,
# and of every body that is not rotated, are in the middle of its region `main`.

MAIN = "main"
# A quaternion this close to none is none: frames of families are turned by quarter turns or not at all.
MAX_TURN = 1e-9
T = TypeVar("T", Site, Region, Collider)


def main_region(asset: Asset) -> Region:
    """The region `main` of an asset. Raises KeyError if it does not exist."""
    return {region.name: region for region in asset.regions}[MAIN]


def main_center(asset: Asset) -> Vec3:
    """Middle of `main` in the asset frame, metres."""
    main = main_region(asset)
    return _rounded(np.array((asset.asset_from_link(main.link) @ main.pose).position))


def moved(asset: Asset, center: Floats) -> Asset:
    """The asset with its origin, and the frames of bodies that are not rotated, at a given point, metres."""
    frames: dict[str, Pose] = {}  # link -> its new frame in the centred asset
    links, offsets = [], {}
    for link in asset.links:
        old = asset.asset_from_link(link.name)
        is_turned = max(abs(q) for q in old.quaternion[1:]) > MAX_TURN
        place = _rounded(np.array(old.position) - center)
        frames[link.name] = Pose(position=place, quaternion=old.quaternion) if is_turned else Pose()
        offsets[link.name] = np.zeros(3) if is_turned else np.array(place)
        parent = Pose() if link.parent is None else frames[link.parent]
        links.append(_moved_link(link, offsets[link.name]).replace(pose=parent.inverse() @ frames[link.name]))
    return asset.replace(
        links=tuple(links),
        joints=tuple(
            joint.replace(anchor=_rounded(np.array(joint.anchor) + offsets[joint.child])) for joint in asset.joints
        ),
        sites=tuple(_moved(site, offsets[site.link]) for site in asset.sites),
        regions=tuple(_moved(region, offsets[region.link]) for region in asset.regions),
    )


def _moved_link(link: Link, offset: Floats) -> Link:
    if not offset.any():
        return link
    center = _rounded(np.array(link.inertial.center_of_mass) + offset)
    meshes = [visual.mesh.with_vertices(visual.mesh.vertices + offset, visual.mesh.normals) for visual in link.visuals]
    return link.replace(
        inertial=link.inertial.replace(center_of_mass=center),
        visuals=tuple(visual.replace(mesh=mesh) for visual, mesh in zip(link.visuals, meshes, strict=True)),
        colliders=tuple(_moved(collider, offset) for collider in link.colliders),
    )


def _moved(thing: T, offset: Floats) -> T:
    pose = Pose(position=_rounded(np.array(thing.pose.position) + offset), quaternion=thing.pose.quaternion)
    return thing.replace(pose=pose)


def _rounded(values: Floats) -> Vec3:
    """Round to ten decimals: sums of lengths in metres must not leave errors such as 1e-17."""
    x, y, z = (decimals(float(v), 10) for v in values)
    return x, y, z


# Parts ----------------------------------------------------------------------------------------------------------------

DRAWER, PAIR, SINGLE = "drawer", "hinge_cabinet", "single_cabinet"
COUNTER, HOUSING, PANEL = "counter", "housing_cabinet", "panel_cabinet"
# Contracts of units that may hold several drawers and doors.
CABINETS = (DRAWER, PAIR, SINGLE, HOUSING, "open_cabinet", "island_base")
_JOINT = re.compile(r"(?:(?P<prefix>\w+?)_)?(?P<kind>slidejoint|leftdoorhinge|rightdoorhinge|doorhinge)")
# The body of a part that holds nothing but what moves: RoboCasa fixes it to the world, so that its mass is never felt.
FIXED = Inertial(mass=0.001, center_of_mass=(0.0, 0.0, 0.0), inertia=(1e-6, 1e-6, 1e-6, 0.0, 0.0, 0.0))
# The second arm of an L-shaped worktop: its free surface, and the board below it.
SIDE_TOP = "top_side"


@dataclass(frozen=True)
class Part:
    """One fixture made from an asset; its front faces -y. `name`: added to that of the placement, empty for the rest.

    `links`: link of the whole -> name of its body in the part. `whole_from_part`: pose of the frame of `asset`.
    """

    name: str
    asset: Asset
    links: Mapping[str, str]
    whole_from_part: Pose = Pose()  # noqa: RUF009


@dataclass
class _Group:
    """Doors or a drawer that become a fixture: prefix of their joints, contract, joint of the whole -> new name."""

    prefix: str
    contract: str
    joints: dict[str, str] = field(default_factory=dict)


def divide(asset: Asset, is_corner_of_side: bool = False) -> tuple[Part, ...]:
    """Divide an asset into fixtures, the rest first; `is_corner_of_side`: a worktop's corner goes to its second arm."""
    if asset.contract in CABINETS:
        return _divide_cabinet(asset)
    if asset.contract == COUNTER and any(r.name == SIDE_TOP for r in asset.regions):
        return _divide_worktop(asset, is_corner_of_side)
    return (Part("", asset, {link.name: link.name for link in asset.links}),)


def _divide_cabinet(asset: Asset) -> tuple[Part, ...]:
    groups = _groups(asset)
    split_off = [g for g in groups if g.prefix or g.contract == DRAWER]
    rest_doors = [g for g in groups if g not in split_off]
    if not split_off:
        return (Part("", asset, {link.name: link.name for link in asset.links}),)
    moved = {name: asset.carried_by(_children(asset, group.joints)) for group in split_off for name in [group.prefix]}
    regions = {group.prefix: _regions_of(asset, group, moved[group.prefix]) for group in split_off}
    taken = {link for links in moved.values() for link in links}
    behind = {region.name for found in regions.values() for region, _ in found}
    rest = _selected(
        asset,
        "",
        [link for link in asset.links if link.name not in taken],
        [region for region in asset.regions if region.name not in behind],
        {},
    )
    contract = rest_doors[0].contract if rest_doors else HOUSING if asset.contract == HOUSING else PANEL
    rest = rest.replace(contract=contract, regions=_renumbered(rest.regions))
    parts = [Part("", rest, {link.name: link.name for link in rest.links})]
    for group in split_off:
        empty = Link(name=asset.root.name, pose=asset.root.pose, inertial=FIXED)
        links = [empty, *(link for link in asset.links if link.name in moved[group.prefix])]
        found = [region.replace(name=name) for region, name in regions[group.prefix]]
        box = _front_box(asset, _children(asset, group.joints))
        name = group.prefix or DRAWER
        made = _selected(asset, name, links, [*found, box], group.joints).replace(contract=group.contract)
        parts.append(Part(name, made, {link.name: link.name for link in links[1:]}))
    return tuple(parts)


def _groups(asset: Asset) -> list[_Group]:
    """Drawers and doors by the prefix of their joints, in the order of the joints."""
    groups: dict[tuple[str, bool], _Group] = {}
    for joint in asset.joints:
        match = _JOINT.fullmatch(joint.name)
        if match is None:
            continue
        prefix, kind = match["prefix"] or "", match["kind"]
        contract = {"slidejoint": DRAWER, "doorhinge": SINGLE}.get(kind, PAIR)
        group = groups.setdefault((prefix, contract == DRAWER), _Group(prefix, contract))
        group.joints[joint.name] = kind
    return list(groups.values())


def _children(asset: Asset, joints: Collection[str]) -> list[str]:
    return [joint.child for joint in asset.joints if joint.name in joints]


def _regions_of(asset: Asset, group: _Group, links: Collection[str]) -> list[tuple[Region, str]]:
    """Regions of a group, each with its new name: those on its links, and levels behind its doors."""
    own = [region for region in asset.regions if region.link in links]
    if group.contract == DRAWER:
        return [(region, "int" if region.name.endswith("int") else region.name) for region in own]
    lower, upper = _span(asset, _children(asset, group.joints))
    levels = [
        region
        for region in asset.regions
        if re.fullmatch(r"level\d+", region.name) and lower[2] < _middle(asset, region)[2] < upper[2]
    ]
    return [(region, region.name) for region in own] + [(region, f"level{k}") for k, region in enumerate(levels)]


def _renumbered(regions: Iterable[Region]) -> tuple[Region, ...]:
    """Levels renumbered from 0 without gaps, as RoboCasa expects; the other regions unchanged."""
    out, count = [], 0
    for region in regions:
        if re.fullmatch(r"level\d+", region.name):
            region, count = region.replace(name=f"level{count}"), count + 1
        out.append(region)
    return tuple(out)


def _middle(asset: Asset, region: Region) -> Floats:
    return np.array((asset.asset_from_link(region.link) @ region.pose).position)


def _span(asset: Asset, links: Collection[str]) -> Floats:
    """(2, 3) corners of the colliders of links, asset frame, joints at zero, metres."""
    boxes = [b for n in links if (b := link_bounds(asset.link(n), asset.asset_from_link(n))) is not None]
    return np.array([np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]])


def _front_box(asset: Asset, links: Collection[str]) -> Region:
    """Region `main` of a part that is divided off: as wide and as deep as the whole, as high as its fronts."""
    main = main_region(asset)
    center, half = _middle(asset, main), np.array(main.size) / 2
    span = _span(asset, links)
    lower, upper = center - half, center + half
    lower[2], upper[2] = max(lower[2], span[0][2]), min(upper[2], span[1][2])
    return box_region(MAIN, lower, upper)


def box_region(name: str, lower: Floats, upper: Floats) -> Region:
    """A region of the root link between two corners, metres."""
    return Region(name=name, pose=Pose(position=_vec3((lower + upper) / 2)), size=_vec3(upper - lower))


def _selected(
    asset: Asset, name: str, links: Iterable[Link], regions: Iterable[Region], joints: Mapping[str, str]
) -> Asset:
    """Some links of an asset with all that belongs to them; `name`: added to the id; `joints`: old name -> new name."""
    links = tuple(links)
    names = {link.name for link in links}
    kept = [joint for joint in asset.joints if joint.child in names]
    new = {joint.name: joints.get(joint.name, joint.name) for joint in kept}
    shown = {visual.material for link in links for visual in link.visuals}
    felt = {collider.substance for link in links for collider in link.colliders}
    keyframes = []
    for key in asset.keyframes:
        values = tuple(at.replace(joint=new[at.joint]) for at in key.joints if at.joint in new)
        keyframes.append(key.replace(joints=values))
    return asset.replace(
        id=f"{asset.id}_{name}" if name else asset.id,
        links=links,
        joints=tuple(j.replace(name=new[j.name], behind=new.get(j.behind) if j.behind else None) for j in kept),
        sites=tuple(site for site in asset.sites if site.link in names),
        regions=tuple(regions),
        states=tuple(state.replace(joint=new[state.joint]) for state in asset.states if state.joint in new),
        exclusions=tuple(pair for pair in asset.exclusions if pair.first in names and pair.second in names),
        keyframes=tuple(keyframes),
        behavior=asset.behavior if len(kept) == len(asset.joints) else None,
        materials=tuple(material for material in asset.materials if material.id in shown),
        substances=tuple(s for s in asset.substances if s.id in felt) or asset.substances,
    )


def _divide_worktop(asset: Asset, is_corner_of_side: bool) -> tuple[Part, ...]:
    """Divide an L-shaped worktop into two rectangles: one along the back wall, one along the side wall.

    `main` of one of them covers the corner, for objects above and below it.
    """
    regions = {region.name: region for region in asset.regions}
    side, main = regions[SIDE_TOP], regions[MAIN]
    center, half = _middle(asset, main), np.array(main.size) / 2
    side_center, side_half = _middle(asset, side), np.array(side.size) / 2
    lower, upper = center - half, center + half
    edge = float(side_center[1] + side_half[1])  # where the second arm meets the first
    root = asset.root
    behind, before = _cut(root, edge)
    first_lower, first_upper = np.array([lower[0], edge, lower[2]]), upper.copy()
    second_lower = np.array([side_center[0] - side_half[0], lower[1], lower[2]])
    second_upper = np.array([side_center[0] + side_half[0], edge, upper[2]])
    is_right = side_center[0] > center[0]
    if is_corner_of_side:
        second_upper[1] = upper[1]
        if is_right:
            first_upper[0] = second_lower[0]
        else:
            first_lower[0] = second_upper[0]
    rest = [region for region in asset.regions if region.name not in (MAIN, SIDE_TOP)]
    second = [side.replace(name="top"), box_region(MAIN, second_lower, second_upper)]
    names = {root.name: root.name}
    arm = _selected(asset, "side", [before.replace(inertial=FIXED)], second, {})
    # The front of the second arm looks along x.
    turn = Pose(quaternion=(math.sqrt(0.5), 0.0, 0.0, -math.sqrt(0.5) if is_right else math.sqrt(0.5)))
    return (
        Part("", _selected(asset, "", [behind], [*rest, box_region(MAIN, first_lower, first_upper)], {}), names),
        Part("side", _turned(arm, turn), names, turn),
    )


def _turned(asset: Asset, turn: Pose) -> Asset:
    """An asset with one link and no joints, in a frame rotated by a quarter turn about z."""
    back = turn.inverse()
    rotation = np.round(back.rotation)
    root = asset.root
    visuals = [
        visual.replace(
            mesh=visual.mesh.with_vertices(
                visual.mesh.vertices @ rotation.T,
                None if visual.mesh.normals is None else visual.mesh.normals @ rotation.T,
            )
        )
        for visual in root.visuals
    ]
    colliders = [collider.replace(pose=back @ collider.pose) for collider in root.colliders]
    regions = []
    for region in asset.regions:
        center, half = rotation @ np.array(region.pose.position), np.abs(rotation @ np.array(region.size)) / 2
        regions.append(box_region(region.name, center - half, center + half))
    return asset.replace(
        links=(root.replace(visuals=tuple(visuals), colliders=tuple(colliders)),), regions=tuple(regions)
    )


def _cut(link: Link, edge: float) -> tuple[Link, Link]:
    """Cut a static link in two: the part beyond y = `edge`, metres, and the part in front of it.

    A face belongs to the part that contains its middle: both parts are drawn in their old place, so that no seam is
    visible.
    """
    beyond: list[Visual] = []
    before: list[Visual] = []
    for visual in link.visuals:
        middles = visual.mesh.vertices[visual.mesh.faces].mean(axis=1)[:, 1]
        for out, mask in ((beyond, middles >= edge), (before, middles < edge)):
            if mask.any():
                out.append(visual.replace(mesh=_with_faces(visual.mesh, visual.mesh.faces[mask])))
    colliders = [(collider, collider.pose.position[1] >= edge) for collider in link.colliders]
    return (
        link.replace(visuals=tuple(beyond), colliders=tuple(c for c, is_beyond in colliders if is_beyond)),
        link.replace(visuals=tuple(before), colliders=tuple(c for c, is_beyond in colliders if not is_beyond)),
    )


def _with_faces(mesh: Mesh, faces: npt.NDArray[np.int32]) -> Mesh:
    used, numbers = np.unique(faces, return_inverse=True)
    return Mesh(
        vertices=mesh.vertices[used],
        faces=numbers.reshape(faces.shape),
        uv=None if mesh.uv is None else mesh.uv[used],
        normals=None if mesh.normals is None else mesh.normals[used],
    )


def _vec3(values: Floats) -> Vec3:
    x, y, z = (float(v) for v in values)
    return x, y, z
