"""Names that runtimes look for, in place of `door_0`: links, joints and shapes of a thing whose category is known.

Ref: registry/contracts, and the fixture classes of RoboCasa that they were read from.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.articulate.plan import Articulation, Edge, PartKind, PartPlan
from casa_assets.geometry.tessellate import surface
from casa_assets.model.asset import Asset
from casa_assets.model.joint import Joint
from casa_assets.model.link import Collider, Link, Visual
from casa_assets.model.place import Region
from casa_assets.model.pose import Pose

Floats = npt.NDArray[np.float64]

FRIDGES = ("refrigerator", "fridge")
CABINETS = ("cabinet", "drawer_stack", "island_base", "sink_base")
FOLDING = ("oven", "dishwasher", "range")
# Doors and drawers whose ranges runtimes read as -a..0 or 0..a about +x, +y or +z.
_PLAIN_AXES = frozenset({PartKind.DOOR, PartKind.DRAWER, PartKind.TRAY})


@dataclass(frozen=True)
class Name:
    """Of a part: its link and its joint."""

    link: str
    joint: str


@dataclass(frozen=True)
class _Place:
    """A part, and the middle and size of what it is made of: right, back, up, metres."""

    part: PartPlan
    middle: Floats
    size: Floats


def named(asset: Asset, found: Articulation, category: str) -> tuple[Asset, dict[str, str]]:
    """The asset under the names that its category has, with the region `main`; part -> name of its joint.

    What a category has no names for keeps its own, as does all of a thing without a category.
    """
    places = [_Place(p, *_extent(asset, p.name)) for p in found.parts]
    names = _names(places, category)
    links = {p.name: names.get(p.name, Name(p.name, f"{p.name}_joint")).link for p in found.parts}
    joints = {p.name: names.get(p.name, Name(p.name, f"{p.name}_joint")).joint for p in found.parts}
    plain = {p.name for p in found.parts if names and p.kind in _PLAIN_AXES}
    called = {f"{part}_joint": joint for part, joint in joints.items()}
    return asset.replace(
        links=tuple(_link(k, links) for k in asset.links),
        joints=tuple(_joint(j, links, called, j.child in plain) for j in asset.joints),
        states=tuple(
            s.replace(name=s.name.replace(s.joint, called[s.joint]), joint=called[s.joint]) for s in asset.states
        ),
        exclusions=tuple(
            e.replace(first=links.get(e.first, e.first), second=links.get(e.second, e.second)) for e in asset.exclusions
        ),
        regions=(*asset.regions, main_region(asset, found)),
    ), joints


def main_region(asset: Asset, found: Articulation) -> Region:
    """The box by which it is placed: all of it but its handles and controls."""
    out = {p.name for p in found.parts if p.kind in (PartKind.KNOB, PartKind.BUTTON, PartKind.LEVER)}
    clouds = []
    for link in asset.links:
        if link.name not in out:
            pose = asset.asset_from_link(link.name)
            clouds += [pose.apply(v.mesh.vertices) for v in link.visuals]
    held = [c for k in asset.links for c in _handles(asset, k)]
    points = np.concatenate(clouds or [asset.bounds])
    low, high = points.min(axis=0), points.max(axis=0)
    for box in held:
        # A handle stands out at the front alone; what reaches no farther than it is left out.
        rest = points[points[:, 1] > box[1][1] - 1e-6]
        if len(rest) and low[1] >= box[0][1] - 0.003:
            low[1] = rest[:, 1].min()
    size = np.maximum(high - low, 1e-3)
    return Region(name="main", pose=Pose(position=_vec((low + high) / 2)), size=_vec(size))


def _handles(asset: Asset, link: Link) -> list[Floats]:
    """(2, 3) boxes of the handle shapes of a link, asset frame."""
    pose = asset.asset_from_link(link.name)
    out = []
    for collider in link.colliders:
        if collider.label == "handle":
            points = pose.apply(surface(collider.shape, collider.pose)[0])
            out.append(np.array([points.min(axis=0), points.max(axis=0)]))
    return out


def _names(places: Sequence[_Place], category: str) -> Mapping[str, Name]:
    """Names of those parts that a category has names for."""
    if category == "microwave":
        doors = _of(places, PartKind.DOOR)
        return {doors[0].part.name: Name("door", "microjoint")} if len(doors) == 1 else {}
    if any(word in category for word in FRIDGES):
        return _fridge(places)
    if any(word in category for word in FOLDING):
        return _oven(places, category)
    if any(word in category for word in CABINETS):
        return _cabinet(places)
    return {}


def _oven(places: Sequence[_Place], category: str) -> Mapping[str, Name]:
    doors = sorted(_of(places, PartKind.DOOR), key=lambda p: -p.middle[2])
    names: dict[str, Name] = {}
    words = [""] if len(doors) == 1 else ["upper_", "lower_"] if len(doors) == 2 else []
    for word, door in zip(words, doors, strict=False):
        names[door.part.name] = Name(f"{word}door", f"{word}door_joint")
    racks = [p for p in _of(places, PartKind.TRAY) if not p.part.joint.endless]
    # The lowest is rack0: a dishwasher's rack1 is the upper one.
    for i, rack in enumerate(sorted(racks, key=lambda p: p.middle[2])[:6]):
        names[rack.part.name] = Name(f"rack{i}", f"rack{i}_joint")
    knobs = sorted(_of(places, PartKind.KNOB), key=lambda p: p.middle[0])
    if "oven" in category and len(knobs) == 2:
        for word, knob in zip(("temp", "time"), knobs, strict=True):
            names[knob.part.name] = Name(f"knob_{word}", f"knob_{word}_joint")
    return names


def _fridge(places: Sequence[_Place]) -> Mapping[str, Name]:
    """Doors and drawers by where they are: beside each other, or one above the other."""
    doors = sorted(_of(places, PartKind.DOOR), key=lambda p: p.middle[0])
    drawers = sorted(_of(places, PartKind.DRAWER), key=lambda p: -p.middle[2])
    names: dict[str, Name] = {}
    parts: list[tuple[_Place, str]] = []
    if len(doors) == 1:
        parts = [(doors[0], "fridge_door")]
    elif len(doors) == 2:
        beside = abs(doors[0].middle[0] - doors[1].middle[0]) > abs(doors[0].middle[2] - doors[1].middle[2])
        if beside and drawers:
            parts = [(doors[0], "fridge_left_door"), (doors[1], "fridge_right_door")]
        elif beside:
            parts = [(doors[0], "freezer_door"), (doors[1], "fridge_door")]
        else:
            small, large = sorted(doors, key=lambda p: float(p.size[2]))
            parts = [(small, "freezer_door"), (large, "fridge_door")]
    elif len(doors) == 3:
        low = min(doors, key=lambda p: p.middle[2])
        left, right = [p for p in doors if p is not low]
        parts = [(left, "fridge_left_door"), (right, "fridge_right_door"), (low, "freezer_door")]
    for place, word in parts:
        names[place.part.name] = Name(word, f"{word}_joint")
    if parts and not any(w.startswith("freezer") for _, w in parts) and drawers:
        names[drawers[-1].part.name] = Name("freezer_door", "freezer_door_joint")
        drawers = drawers[:-1]
    for i, drawer in enumerate(drawers if parts else []):
        names[drawer.part.name] = Name(f"fridge_drawer{i}", f"fridge_drawer{i}_joint")
    return names


def _cabinet(places: Sequence[_Place]) -> Mapping[str, Name]:
    """Doors that hinge at the side, and drawers."""
    doors = [p for p in _of(places, PartKind.DOOR) if p.part.joint.edge in (Edge.LEFT, Edge.RIGHT)]
    drawers = sorted(_of(places, PartKind.DRAWER), key=lambda p: (-round(p.middle[2], 3), p.middle[0]))
    names: dict[str, Name] = {}
    if len(doors) == 1:
        names[doors[0].part.name] = Name("door", "doorhinge")
    elif len(doors) == 2 and {p.part.joint.edge for p in doors} == {Edge.LEFT, Edge.RIGHT}:
        for p in doors:
            word = "left" if p.part.joint.edge is Edge.LEFT else "right"
            names[p.part.name] = Name(f"{word}door", f"{word}doorhinge")
    if len(drawers) == 1:
        names[drawers[0].part.name] = Name("drawer", "slidejoint")
    else:
        for i, p in enumerate(drawers):
            names[p.part.name] = Name(f"drawer{i}", f"drawer{i}_slidejoint")
    return names


def _of(places: Sequence[_Place], kind: PartKind) -> list[_Place]:
    """Parts of a kind that the body carries."""
    return [p for p in places if p.part.kind is kind and not p.part.parent]


def _extent(asset: Asset, link: str) -> tuple[Floats, Floats]:
    """Middle and size of a link as it is seen, asset frame, metres."""
    pose = asset.asset_from_link(link)
    clouds = [pose.apply(v.mesh.vertices) for v in asset.link(link).visuals]
    points = np.concatenate(clouds or [np.array([pose.position])])
    return (points.min(axis=0) + points.max(axis=0)) / 2, np.ptp(points, axis=0)


def _link(link: Link, links: Mapping[str, str]) -> Link:
    name = links.get(link.name, link.name)
    parent = None if link.parent is None else links.get(link.parent, link.parent)

    def own(word: str) -> str:
        return name + word[len(link.name) :]

    colliders: tuple[Collider, ...] = tuple(c.replace(name=own(c.name)) for c in link.colliders)
    visuals: tuple[Visual, ...] = tuple(v.replace(name=own(v.name)) for v in link.visuals)
    return link.replace(name=name, parent=parent, colliders=colliders, visuals=visuals)


def _joint(joint: Joint, links: Mapping[str, str], called: Mapping[str, str], plain: bool) -> Joint:
    name = called[joint.name]
    child = links[joint.child]
    grip = None if joint.grip is None else child + joint.grip[len(joint.child) :]
    fresh = joint.replace(
        name=name, child=child, grip=grip, behind=None if joint.behind is None else called[joint.behind]
    )
    if not plain or max(joint.axis, key=abs) > 0:
        return fresh
    x, y, z = (-c if c else 0.0 for c in joint.axis)
    drive = None if joint.drive is None else joint.drive.replace(target=-joint.drive.target)
    low, high = joint.range
    return fresh.replace(axis=(x, y, z), range=(-high, -low if low else 0.0), drive=drive)


def _vec(values: Floats) -> tuple[float, float, float]:
    x, y, z = (float(f"{float(v):.7g}") if abs(v) > 1e-9 else 0.0 for v in values)
    return (x, y, z)
