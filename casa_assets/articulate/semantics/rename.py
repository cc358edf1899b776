"""Rename links, joints, colliders, regions and states of an asset to the names that runtimes look for."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from casa_assets.articulate.controls.burners import find_burners
from casa_assets.articulate.interior.regions import link_bounds
from casa_assets.articulate.plan import Articulation, PartKind
from casa_assets.articulate.semantics.annotate_for_runtime import annotate_for_runtime
from casa_assets.articulate.semantics.part_roles import PlacedPart, RuntimeName, runtime_names
from casa_assets.articulate.vectors import round7_vec3
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.joint import Joint
from casa_assets.model.asset.link import Collider, Link, Visual
from casa_assets.model.asset.site import Region
from casa_assets.model.pose import Pose

# Doors and drawers whose ranges runtimes read as -a..0 or 0..a about +x, +y or +z.
_PLAIN_AXES = frozenset({PartKind.DOOR, PartKind.DRAWER, PartKind.TRAY, PartKind.LEVER})
# Labels of visuals that protrude from the box by which runtimes place an object.
_OUTSIDE = frozenset({"handle", "knob", "button", "lever"})
# Range of a knob with settings. Ref: RoboCasa v1.0, class Stove: less than 2 pi - 0.35.
KNOB_SETTING_RANGE_RAD = math.radians(300)
# An axis within 3 degrees of x, y or z is snapped to it: loaders that scale fixtures handle no other.
AXIS_SNAP_COS = math.cos(math.radians(3))


def rename_for_runtime(asset: Asset, articulation: Articulation, category: str) -> tuple[Asset, dict[str, str]]:
    """Rename an asset for its category and annotate it; return it with part name -> joint name.

    Parts that the category has no names for keep their own, as do all parts of an object without a category. The
    contract is the intended one: the checks decide whether it is met.
    """
    boxes = {p.name: link_bounds(asset, p.name) for p in articulation.parts}
    places = [
        PlacedPart(p, (boxes[p.name][0] + boxes[p.name][1]) / 2, boxes[p.name][1] - boxes[p.name][0])
        for p in articulation.parts
    ]
    burners = find_burners(asset) if category in ("hob", "range") else ()
    names = runtime_names(places, category, burners)
    new_names = {p.name: names.get(p.name, RuntimeName(p.name, f"{p.name}_joint")) for p in articulation.parts}
    opens_positive = {p.name for p in articulation.parts if p.name in names and p.kind in _PLAIN_AXES}
    joints = {part: name.joint for part, name in new_names.items()}
    links = {part: name.link for part, name in new_names.items()}
    joint_names = {f"{part}_joint": joint for part, joint in joints.items()}
    asset = asset.replace(
        links=tuple(_link(k, new_names) for k in asset.links),
        joints=tuple(
            _setting(_joint(j, new_names, joint_names, j.child in opens_positive), j.child in names)
            for j in asset.joints
        ),
        states=tuple(
            s.replace(name=s.name.replace(s.joint, joint_names[s.joint]), joint=joint_names[s.joint])
            for s in asset.states
        ),
        exclusions=tuple(
            e.replace(first=links.get(e.first, e.first), second=links.get(e.second, e.second)) for e in asset.exclusions
        ),
        regions=(main_region(asset), *(r.replace(link=links.get(r.link, r.link)) for r in asset.regions)),
    )
    return (annotate_for_runtime(asset, category, burners) if category else asset), joints


def main_region(asset: Asset) -> Region:
    """Return the box by which an asset is placed: all of it but its handles and controls."""
    clouds = []
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        clouds += [pose.apply(v.mesh.vertices) for v in link.visuals if v.label not in _OUTSIDE]
    points = np.concatenate(clouds or [asset.bounds])
    lower, upper = points.min(axis=0), points.max(axis=0)
    return Region(
        name="main",
        pose=Pose(position=round7_vec3((lower + upper) / 2)),
        size=round7_vec3(np.maximum(upper - lower, 1e-3)),
    )


def _link(link: Link, new_names: Mapping[str, RuntimeName]) -> Link:
    """Return a link with its colliders and visuals renamed."""
    name = new_names[link.name].link if link.name in new_names else link.name
    parent = new_names[link.parent].link if link.parent is not None and link.parent in new_names else link.parent
    first = new_names[link.name].shape if link.name in new_names else ""

    def renamed_word(word: str) -> str:
        return name + word[len(link.name) :] if word.startswith(link.name) else word

    colliders: tuple[Collider, ...] = tuple(
        c.replace(name=first if first and not i else renamed_word(c.name)) for i, c in enumerate(link.colliders)
    )
    visuals: tuple[Visual, ...] = tuple(v.replace(name=renamed_word(v.name)) for v in link.visuals)
    return link.replace(name=name, parent=parent, colliders=colliders, visuals=visuals)


def _joint(
    joint: Joint, new_names: Mapping[str, RuntimeName], joint_names: Mapping[str, str], opens_positive: bool
) -> Joint:
    """Return a joint renamed and with its axis snapped to x, y or z; that of a front points along +x, +y or +z."""
    name = new_names[joint.child]
    grip = None
    if joint.grip is not None:
        grip = name.shape or name.link + joint.grip[len(joint.child) :]
    renamed = joint.replace(
        name=name.joint,
        child=name.link,
        grip=grip,
        axis=_straight(joint.axis),
        behind=None if joint.behind is None else joint_names[joint.behind],
    )
    if not opens_positive or max(renamed.axis, key=abs) > 0:
        return renamed
    x, y, z = (-c if c else 0.0 for c in renamed.axis)
    drive = None if renamed.drive is None else renamed.drive.replace(target=-renamed.drive.target)
    lower, upper = renamed.range
    return renamed.replace(axis=(x, y, z), range=(-upper, -lower if lower else 0.0), drive=drive)


def _setting(joint: Joint, known: bool) -> Joint:
    """Limit the range of a knob that sets something: it does not turn endlessly."""
    if known and joint.name.startswith("knob_") and joint.range[1] > KNOB_SETTING_RANGE_RAD:
        return joint.replace(range=(joint.range[0], KNOB_SETTING_RANGE_RAD))
    return joint


def _straight(axis: tuple[float, float, float]) -> tuple[float, float, float]:
    """Snap an axis to x, y or z where it is nearly that."""
    k = max(range(3), key=lambda i: abs(axis[i]))
    if abs(axis[k]) < AXIS_SNAP_COS:
        return axis
    x, y, z = (float(np.sign(axis[k])) if i == k else 0.0 for i in range(3))
    return (x, y, z)
