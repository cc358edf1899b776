"""Asset in its light form -> the same with few primitives on what moves: doors, drawers, loose things."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from itertools import combinations, product

import numpy as np

from casa_assets import Asset
from casa_assets.addons.batch import fit_primitives as fit
from casa_assets.ext.arrays import Floats
from casa_assets.ext.kitchens import JointWord, Placement
from casa_assets.ext.records import (
    AssetJoint,
    Base,
    Box,
    Collider,
    Cylinder,
    Exclusion,
    JointKind,
    Link,
    Pose,
    Region,
    Shape,
    joint_positions,
)
from casa_assets.ext.solids import box_around, link_bounds, shape_bounds

# Label of the collider that a hand takes -> word.
WORD_OF_GRIP = {
    "knob": JointWord.KNOBS,
    "button": JointWord.BUTTONS,
    "key": JointWord.BUTTONS,
    "lever": JointWord.LEVERS,
    "spout": JointWord.LEVERS,
    "rack": JointWord.RACKS,
    "tray": JointWord.RACKS,
    "lid": JointWord.LIDS,
}
TAP_LINKS = ("handle", "handle_temp")  # links of a tap that a hand takes by their own handle, which is no door
SLIDING_SHELVES = ("rack", "tray")  # links that are racks also where a hand takes them by a handle
POSITIONS = 9  # positions of each joint that are looked at, both ends of its range among them
# Links whose boxes come as close as this may touch, metres.
NEAR_M = 0.003
Ref = tuple[str, str]  # name of a placement, and of a link of it
# Primitives of a loose thing at most, of one that is solid, of a seat that is; and how much of each may be empty.
MOST_OF_THING, MOST_OF_SOLID, MOST_OF_SEAT, EMPTY_SHARE = 6, 3, 2, 0.35
# Round parts of a door or a tap that one primitive replaces, and the share of it that may be empty.
PIECES_PER_GROUP, EMPTY_SHARE_OF_PIECES = 3, 0.6
LINING_M = 0.022  # the inner front of a drawer is no thicker than this, metres, nor the front than three times
LINING_SHARE = 0.5  # it has this share of the area of the front, 0..1
# Two boxes of a moving part become one where no more than this is empty between them, and nothing is kept there, m^3.
FILLED_M3 = 0.003
# A bin of a door becomes a block, which has no more than this empty: those above each other stay apart, m^3.
BIN_M3 = 0.008
# On each side of a region no more than this share of its size is taken, and no more than twice the tolerance.
REGION_SHARE = 0.015
WHOLE = "main"  # name of the region around a whole asset; the others are inside of it
HANDLE = "handle"  # label of the parts of a handle


def joint_word(asset: Asset, joint: AssetJoint) -> JointWord:
    """The word of a joint."""
    labels = {collider.name: collider.label for link in asset.links for collider in link.colliders}
    label = labels.get(joint.grip or "")
    if label in WORD_OF_GRIP:
        return WORD_OF_GRIP[label]
    if joint.child.rstrip("0123456789") in SLIDING_SHELVES:
        return JointWord.RACKS
    if joint.child in TAP_LINKS:
        return JointWord.LEVERS
    return JointWord.DOORS if joint.kind is JointKind.HINGE else JointWord.DRAWERS


def meeting_links(placements: Sequence[Placement], forms: Sequence[Asset]) -> list[tuple[Ref, ...]]:
    """Sets of two or more moving links of fixtures that can touch each other; `forms`: the asset of each placement.

    Two links can where the boxes that they pass through over the ranges of their joints come near each other, unless
    one carries the other or the asset says that they never collide.
    """
    swept: dict[Ref, Floats] = {}
    apart: set[frozenset[Ref]] = set()
    for place, form in zip(placements, forms, strict=True):
        if form.base is not Base.FIXED:
            continue
        for link in form.links:
            if link.colliders and form.is_moved(link.name):
                swept[place.name, link.name] = _swept(place, form, link.name)
            if link.parent is not None:
                apart.add(frozenset({(place.name, link.name), (place.name, link.parent)}))
        apart |= {frozenset({(place.name, e.first), (place.name, e.second)}) for e in form.exclusions}
    groups = {ref: {ref} for ref in swept}
    for first, second in _near(swept):
        if frozenset({first, second}) not in apart and groups[first] is not groups[second]:
            groups[first] |= groups[second]
            for ref in groups[second]:
                groups[ref] = groups[first]
    whole = {id(group): group for group in groups.values() if len(group) > 1}
    return sorted(tuple(sorted(group)) for group in whole.values())


def _near(swept: dict[Ref, Floats]) -> Iterator[tuple[Ref, Ref]]:
    names, boxes = list(swept), np.array(list(swept.values())).reshape(-1, 2, 3)
    for i, name in enumerate(names):
        near = (boxes[i + 1 :, 0] <= boxes[i, 1] + NEAR_M).all(axis=1)
        near &= (boxes[i + 1 :, 1] >= boxes[i, 0] - NEAR_M).all(axis=1)
        for k in np.flatnonzero(near):
            yield name, names[i + 1 + int(k)]


def _swept(place: Placement, form: Asset, name: str) -> Floats:
    """(2, 3) corners of the box that a link passes through, world frame, metres."""
    chain = []
    link = form.link(name)
    while True:
        joint = form.joint_of(link.name)
        if joint is not None:
            chain.append(joint)
        if link.parent is None:
            break
        link = form.link(link.parent)
    found = []
    for values in product(*(np.linspace(*joint.range, POSITIONS) for joint in chain)):
        positions = {joint.name: float(value) for joint, value in zip(chain, values, strict=True)}
        bounds = link_bounds(form.link(name), place.pose @ form.asset_from_link(name, positions))
        assert bounds is not None
        found.append(bounds)
    return box_around(np.array(found))


class Inside(Enum):
    """How the inside of loose things and the bins of doors are represented."""

    KEPT = "kept"
    SOLID = "solid"  # a thing is solid, each bin a block
    ONE_BLOCK = "one block"  # all bins of a door are one block


def with_few_primitives(place: Placement, form: Asset, loose: Sequence[WorldPart], inside: Inside) -> Asset:
    """The form with fewer primitives on each link that moves; on those that never do only what a behaviour looks at.

    `loose`: the primitives of loose things, and others that this one avoids. `inside`: of it, and of bins of doors.
    """
    links, touched = [], fit.touched_colliders(form)
    for link in form.links:
        if form.base is Base.FREE:
            colliders = _of_thing(place, form, link, loose, inside is not Inside.KEPT)
        elif form.is_moved(link.name):
            colliders = _of_moving_part(form, link, inside)
        else:
            colliders = tuple(c for c in link.colliders if c.name in touched)
        links.append(link.replace(colliders=colliders))
    exclusions = form.exclusions
    if form.base is Base.FREE:
        # Its parts are coarse, and its joints have ranges.
        pairs = combinations([link.name for link in links if link.colliders], 2)
        exclusions = tuple(Exclusion(first=first, second=second) for first, second in pairs)
    # A joint whose grip was merged into another collider has none.
    names = {c.name for link in links for c in link.colliders}
    joints = tuple(joint if joint.grip in names else joint.replace(grip=None) for joint in form.joints)
    return form.replace(links=tuple(links), joints=joints, exclusions=exclusions)


@dataclass(frozen=True)
class WorldPart:
    """A primitive of a placement as the scene begins: the link that it is of, and the collider with its world pose."""

    place: Placement
    link: str
    collider: Collider

    @cached_property
    def bounds(self) -> Floats:
        """(2, 3) corners in the world, metres."""
        return shape_bounds(self.collider.shape, self.collider.pose)

    @property
    def is_aligned(self) -> bool:
        """True for a box whose faces look along the axes of the world."""
        return isinstance(self.collider.shape, Box) and fit.is_aligned(self.collider.pose)


def loose_parts(placements: Sequence[Placement], forms: Sequence[Asset]) -> list[WorldPart]:
    """The primitives of all loose things."""
    found = []
    for place, form in zip(placements, forms, strict=True):
        if form.base is not Base.FREE:
            continue
        positions = joint_positions(place.joints)
        for link in form.links:
            world_from_link = place.pose @ form.asset_from_link(link.name, positions)
            found += [WorldPart(place, link.name, c.replace(pose=world_from_link @ c.pose)) for c in link.colliders]
    return found


def _of_thing(
    place: Placement, form: Asset, link: Link, loose: Sequence[WorldPart], is_filled: bool
) -> tuple[Collider, ...]:
    """The primitives of a link of a loose thing, kept out of the space for its contents and of neighbouring things."""
    if len(link.colliders) < 2:
        return link.colliders
    own = [part for part in loose if part.place.name == place.name and part.link == link.name]
    lower, upper = box_around(np.array([part.bounds for part in own]))
    link_from_world = (place.pose @ form.asset_from_link(link.name, joint_positions(place.joints))).inverse()
    others = (part for part in loose if (part.place.name, part.link) != (place.name, link.name))
    near = (part for part in others if (part.bounds[0] < upper).all() and (part.bounds[1] > lower).all())
    beside = [shape_bounds(part.collider.shape, link_from_world @ part.collider.pose) for part in near]
    kept_free = [region for region in form.regions if region.link == link.name and region.name != WHOLE]
    free = [] if is_filled else [_inner_space(region) for region in kept_free]
    corners = np.array(beside) if beside else None
    touched = fit.touched_colliders(form)
    kept = tuple(c for c in link.colliders if c.name in touched)
    merged = [c for c in link.colliders if c.name not in touched]
    most = (MOST_OF_SOLID if form.joints else MOST_OF_SEAT) if is_filled else MOST_OF_THING
    return (*fit.fitted_colliders(merged, fit.FitLimits(most, EMPTY_SHARE, free, corners)), *kept)


def _of_moving_part(form: Asset, link: Link, inside: Inside) -> tuple[Collider, ...]:
    """The primitives of a door, a drawer or another part of a fixture: boxes become one where that takes no room."""
    kept = {joint.grip for joint in form.joints} | fit.touched_colliders(form)
    apart = [c for c in link.colliders if c.name in kept or not isinstance(c.shape, Box) or not fit.is_aligned(c.pose)]
    boxes = [c for c in link.colliders if c not in apart]
    round_ = [c for c in apart if c.name not in kept]
    if len(round_) > 1:
        limits = fit.FitLimits(max(1, len(round_) // PIECES_PER_GROUP), EMPTY_SHARE_OF_PIECES)
        apart = [*(c for c in apart if c.name in kept), *fit.fitted_colliders(round_, limits)]
    if len(boxes) > 1:
        corners = np.array([shape_bounds(c.shape, c.pose) for c in boxes])
        space = fit.ReachableSpace(corners, fit.points_around(corners), [(c.shape, c.pose) for c in apart])
        merged = [(cover.corners, cover.covered[0]) for cover in fit.cover_boxes(space)]
        joint = form.joint_of(link.name)
        if joint is None or joint.kind is JointKind.SLIDE:
            merged = _filled(_without_lining(merged), _regions(form, link.name), FILLED_M3)
        else:
            # The inner edge of a door that became thicker would run into the door beside it.
            leaf, bins = _leaf_and_bins(merged)
            if inside is Inside.KEPT:
                bins = _filled(bins, _regions(form, link.name), FILLED_M3)
            else:
                # Nothing is kept in the bins any more, but the drawers below them are in their way.
                most_empty = BIN_M3 if inside is Inside.SOLID else np.inf
                bins = _filled(bins, _other_links(form, link.name), most_empty)
            merged = [*leaf, *bins]
        boxes = [fit.replaced(boxes[i], *fit.box_between(found)) for found, i in merged]
    return (*boxes, *apart)


def with_plain_parts(asset: Asset, locked: Collection[str]) -> Asset:
    """The asset without the posts of handles; a locked part has no handle, and a locked drawer or rack is one block."""
    touched = fit.touched_colliders(asset)
    grips = {joint.grip for joint in asset.joints} | touched
    shut = [joint for joint in asset.joints if joint.name in locked]
    moved_by_locked = {joint.child for joint in shut}
    blocks = {joint.child for joint in shut if joint_word(asset, joint) in (JointWord.DRAWERS, JointWord.RACKS)}
    links = []
    for link in asset.links:
        has_grip = any(c.label == HANDLE and c.name in grips for c in link.colliders)
        colliders = [c for c in link.colliders if c.label != HANDLE or c.name in grips or not has_grip]
        body = [c for c in colliders if c.name not in grips]
        if link.name in blocks and len(body) > 1:
            whole = box_around(np.array([shape_bounds(c.shape, c.pose) for c in body]))
            colliders = [fit.replaced(body[0], *fit.box_between(whole)), *(c for c in colliders if c.name in grips)]
        if link.name in moved_by_locked and asset.base is Base.FIXED:
            colliders = [c for c in colliders if c.label != HANDLE or c.name in touched] or colliders
        links.append(link.replace(colliders=tuple(colliders)))
    joints = tuple(joint.replace(grip=None) if joint.name in locked else joint for joint in asset.joints)
    return asset.replace(links=tuple(links), joints=joints)


def _without_lining(boxes: list[tuple[Floats, int]]) -> list[tuple[Floats, int]]:
    """Boxes without the thin ones that lie flat against a larger one, which becomes as thick as both.

    So a drawer has its front as one box and not two. Each has the index of the largest collider that it replaces.
    """
    found: list[tuple[Floats, int]] = []
    for corners, index in sorted(boxes, key=lambda box: -float(np.prod(box[0][1] - box[0][0]))):
        lined = [(k, axis) for k, (front, _) in enumerate(found) for axis in range(3) if _lines(corners, front, axis)]
        if not lined:
            found.append((corners, index))
            continue
        (k, axis), *_ = lined
        front, owner = found[k]
        thicker = front.copy()
        thicker[0, axis] = min(corners[0, axis], front[0, axis])
        thicker[1, axis] = max(corners[1, axis], front[1, axis])
        found[k] = (thicker, owner)
    return found


def _lines(lining: Floats, front: Floats, axis: int) -> bool:
    """True where a thin box lies flat against a side of a front, across an axis, and covers most of it."""
    across = [other for other in range(3) if other != axis]
    if (lining[0, across] < front[0, across] - fit.TOLERANCE_M).any():
        return False
    if (lining[1, across] > front[1, across] + fit.TOLERANCE_M).any():
        return False
    thickness, of_front = (float(box[1, axis] - box[0, axis]) for box in (lining, front))
    if thickness > LINING_M or of_front > 3 * LINING_M:
        return False
    if lining[0, axis] > front[1, axis] + fit.TOLERANCE_M or lining[1, axis] < front[0, axis] - fit.TOLERANCE_M:
        return False
    area, of_front_area = (float(np.prod(box[1, across] - box[0, across])) for box in (lining, front))
    return area > LINING_SHARE * of_front_area


def _leaf_and_bins(boxes: list[tuple[Floats, int]]) -> tuple[list[tuple[Floats, int]], list[tuple[Floats, int]]]:
    """The boxes of a door that make its leaf, as thick as the largest of them, and those behind."""
    largest, _ = max(boxes, key=lambda box: float(np.prod(box[0][1] - box[0][0])))
    axis = int(np.argmin(largest[1] - largest[0]))
    leaf: list[tuple[Floats, int]] = []
    bins: list[tuple[Floats, int]] = []
    for corners, index in boxes:
        common = min(corners[1, axis], largest[1, axis]) - max(corners[0, axis], largest[0, axis])
        is_leaf = common > (corners[1, axis] - corners[0, axis]) / 2
        (leaf if is_leaf else bins).append((corners, index))
    return leaf, bins


def _regions(form: Asset, link: str) -> Floats:
    """(N, 2, 3) corners of what a link can hold, in its frame."""
    regions = [region for region in form.regions if region.link == link and region.name != WHOLE]
    return np.array([shape_bounds(*_inner_space(region)) for region in regions]).reshape(-1, 2, 3)


def _other_links(form: Asset, link: str) -> Floats:
    """(N, 2, 3) corners of what other links that move are made of, a little smaller, in the frame of a link, metres."""
    link_from_asset = form.asset_from_link(link).inverse()
    found = []
    for other in form.links:
        if other.name != link and form.is_moved(other.name):
            link_from_other = link_from_asset @ form.asset_from_link(other.name)
            for collider in other.colliders:
                lower, upper = shape_bounds(collider.shape, link_from_other @ collider.pose)
                margin = np.minimum(fit.TOLERANCE_M, REGION_SHARE * (upper - lower))
                found.append((lower + margin, upper - margin))
    return np.array(found).reshape(-1, 2, 3)


def _filled(boxes: list[tuple[Floats, int]], kept_free: Floats, most_empty: float) -> list[tuple[Floats, int]]:
    """Boxes of which pairs with at most `most_empty` m^3 between them are one, outside of (N, 2, 3) `kept_free`."""
    found = list(boxes)
    while True:
        best: tuple[float, int, int] | None = None
        for i, (first, _) in enumerate(found):
            for k in range(i + 1, len(found)):
                second = found[k][0]
                both = np.array([np.minimum(first[0], second[0]), np.maximum(first[1], second[1])])
                whole, *parts = (float(np.prod(box[1] - box[0])) for box in (both, first, second))
                empty = whole - sum(parts)
                taken = ((kept_free[:, 0] < both[1]) & (kept_free[:, 1] > both[0])).all(axis=1).any()
                if empty <= most_empty and not taken and (best is None or empty < best[0]):
                    best = (empty, i, k)
        if best is None:
            return found
        _, i, k = best
        pair = found[i], found[k]
        _, owner = max(pair, key=lambda box: float(np.prod(box[0][1] - box[0][0])))
        both = box_around(np.array([box for box, _ in pair]))
        found = [box for n, box in enumerate(found) if n not in (i, k)] + [(both, owner)]


def _inner_space(region: Region) -> tuple[Shape, Pose]:
    """A region as a shape with its pose in its link, a little smaller on each side."""
    x, y, z = (max(size - 2 * min(2 * fit.TOLERANCE_M, REGION_SHARE * size), fit.SIZE_STEP_M) for size in region.size)
    return (Box(size=(x, y, z)) if region.kind == "box" else Cylinder(radius=x / 2, height=z)), region.pose
