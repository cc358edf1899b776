"""Links of fixtures -> which of them can touch each other, from the boxes that they pass through."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.bounds import link_bounds
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.kitchen.scene import Placement

# Positions of each joint that are looked at, both ends of its range among them.
POSITIONS = 9
# Links whose boxes come as close as this may touch, metres.
NEAR_M = 0.003

Ref = tuple[str, str]  # name of a placement, and of a link of it


def meeting_links(placements: Sequence[Placement], forms: Sequence[Asset]) -> list[tuple[Ref, ...]]:
    """Sets of moving links of fixtures that can touch each other, each of two links or more.

    Two links can where the boxes that they pass through over the ranges of their joints come near each other, unless
    one carries the other or the asset says that they never collide.

    Args:
        forms: the asset of each placement.
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
    """Pairs of links whose boxes come near each other."""
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
    corners = np.array(found)
    return np.array([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])
