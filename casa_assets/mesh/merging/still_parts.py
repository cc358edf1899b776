"""Parts of a kitchen that never move -> few primitives in the world, merged across fixtures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.core.numeric import Floats
from casa_assets.mesh.merging.fit_primitives import (
    FitLimits,
    box_between,
    fit_primitives,
    fitted_colliders,
    is_aligned,
    points_around,
    replaced,
    touched_colliders,
)
from casa_assets.mesh.merging.moving_parts import EMPTY_SHARE, PIECES_PER_GROUP, WHOLE
from casa_assets.mesh.merging.reachable_space import TOLERANCE_M, ReachableSpace, cover_boxes
from casa_assets.mesh.solid.primitive import box_around, shape_bounds
from casa_assets.model.asset.asset import Asset, Base, Collider
from casa_assets.model.asset.parts import Box, Shape
from casa_assets.model.kitchen.scene import Layer, LightScene, Placement, WorldCollider
from casa_assets.model.pose import Pose

# Strips and brackets as thin as this, and this share of the largest piece, are left out, metres.
SLIVER_M, SLIVER_SHARE = 0.008, 0.02
# Pieces that stand for one hull of the full form become one where no more than this of it is empty.
EMPTY_SHARE_OF_HULL = 0.45
# What stands out from a wall or a front, or hangs below something, by less than this is no obstacle, metres: sockets,
# skirting, the trim of a window, feet below a plinth.
FLAT_M = 0.022
# It is a strip or small: panelling and tiles of a whole wall are its surface, metres.
STRIP_M = 0.2
# Parts of a fixture of which so many pieces become a few, by label: what they enclose holds nothing.
OPEN_WORK = frozenset({"grate", "faucet", "canopy", "hinge"})
MANY_PIECES = 3
# A thing on a wall cupboard is reached, what begins higher than this is not, metres above the floor.
OVERHEAD_M = 2.35
# What is smaller up there is left out, metres: the canopy of a lamp.
SMALL_OVERHEAD_M = 0.45
# A lamp, or what else holds nothing, is fewer primitives where it is smaller than this, metres.
LARGE_THING_M = 0.75
MIN_PIECES, MOST_OF_PLAIN_THING, MOST_OF_LARGE_THING = 3, 2, 4


@dataclass(frozen=True)
class StillPart:
    """A primitive that never moves: whose it is, and the collider with its pose in the world."""

    place: Placement
    collider: Collider

    @property
    def bounds(self) -> Floats:
        """(2, 3) corners in the world, metres."""
        return shape_bounds(self.collider.shape, self.collider.pose)

    @property
    def is_aligned(self) -> bool:
        """True for a box whose faces look along the axes of the world."""
        return isinstance(self.collider.shape, Box) and is_aligned(self.collider.pose)


def still_parts(place: Placement, form: Asset) -> list[StillPart]:
    """The primitives of a placement that never move, in the world; those of lamps, clocks and curtains made few."""
    parts: list[StillPart] = []
    for link in form.links:
        if form.base is Base.FREE or form.is_moved(link.name):
            continue
        touched = touched_colliders(form)
        kept = [c for c in link.colliders if c.name not in touched]
        colliders = _of_many_pieces(_of_one_hull_each(_without_slivers(kept)))
        holds_nothing = not form.joints and all(region.name == WHOLE for region in form.regions)
        if place.layer is Layer.THINGS and holds_nothing and len(colliders) >= MIN_PIECES:
            # A lamp, a clock, a curtain; a large one may have more primitives.
            lower, upper = box_around(np.array([shape_bounds(c.shape, c.pose) for c in colliders]))
            is_large = float((upper - lower)[:2].max()) >= LARGE_THING_M
            limits = FitLimits(MOST_OF_LARGE_THING if is_large else MOST_OF_PLAIN_THING, EMPTY_SHARE)
            colliders = fitted_colliders(colliders, limits)
        world_from_link = place.pose @ form.asset_from_link(link.name)
        parts += [StillPart(place, c.replace(pose=world_from_link @ c.pose)) for c in colliders]
    return parts


def _size(shape: Shape) -> Floats:
    """(3,) size of a primitive along its own axes, metres."""
    lower, upper = shape_bounds(shape, Pose())
    return np.asarray(upper - lower)


def _without_slivers(colliders: Sequence[Collider]) -> list[Collider]:
    """Colliders without those that are thin, and small compared with the largest."""
    sizes = [_size(c.shape) for c in colliders]
    largest = max((float(np.prod(size)) for size in sizes), default=0.0)
    return [
        collider
        for collider, size in zip(colliders, sizes, strict=True)
        if size.min() > SLIVER_M or float(np.prod(size)) > SLIVER_SHARE * largest
    ]


def _of_one_hull_each(colliders: Sequence[Collider]) -> tuple[Collider, ...]:
    """Colliders, with the pieces of one collider of the full form merged into one unless that is too empty."""
    groups: dict[str, list[Collider]] = {}
    for collider in colliders:
        groups.setdefault(LightScene.collider_of(collider.name), []).append(collider)
    found: list[Collider] = []
    for group in groups.values():
        if len(group) > 1:
            fitted = fit_primitives([(c.shape, c.pose) for c in group], FitLimits(1, EMPTY_SHARE_OF_HULL))
            filled = sum(np.prod(_size(c.shape)) for c in group)
            if len(fitted) == 1 and 1 - filled / np.prod(_size(fitted[0].shape)) <= EMPTY_SHARE_OF_HULL:
                found.append(replaced(group[0], fitted[0].shape, fitted[0].pose))
                continue
        found += group
    return tuple(found)


def _of_many_pieces(colliders: Sequence[Collider]) -> tuple[Collider, ...]:
    """Colliders of which the pieces of a grate, of a tap or of a hood are fewer."""
    groups: dict[str, list[Collider]] = {}
    for collider in colliders:
        is_piece = collider.label in OPEN_WORK
        groups.setdefault(str(collider.label) if is_piece else collider.name, []).append(collider)
    found: list[Collider] = []
    for group in groups.values():
        limits = FitLimits(max(1, len(group) // PIECES_PER_GROUP), EMPTY_SHARE)
        found += fitted_colliders(group, limits) if len(group) >= MANY_PIECES else group
    return tuple(found)


def exposed_parts(parts: Sequence[StillPart]) -> list[StillPart]:
    """Parts of one placement, those that nothing gets at from outside left out, and boxes merged."""
    aligned = [part for part in parts if part.is_aligned]
    if len(aligned) < 2:
        return list(parts)
    corners = np.array([part.bounds for part in aligned])
    askew = [part for part in parts if not part.is_aligned]
    space = ReachableSpace(corners, points_around(corners), [(p.collider.shape, p.collider.pose) for p in askew])
    found = []
    for cover in cover_boxes(space):
        owner = aligned[cover.covered[0]]
        found.append(StillPart(owner.place, replaced(owner.collider, *box_between(cover.corners))))
    return [*found, *(part for part in askew if space.is_exposed(part.bounds[0], part.bounds[1]))]


def merged_parts(still: Sequence[StillPart]) -> list[WorldCollider]:
    """The primitives of what never moves, merged."""
    aligned = [part for part in still if part.is_aligned]
    askew = [part for part in still if not part.is_aligned]
    corners = np.array([part.bounds for part in aligned])
    space = ReachableSpace(corners, _seeds(still), [(part.collider.shape, part.collider.pose) for part in askew])
    covers = cover_boxes(space)
    kept = _without_flat([cover.corners for cover in covers])
    found = []
    for k in kept:
        owner = aligned[covers[k].covered[0]]
        found.append((owner, replaced(owner.collider, *box_between(covers[k].corners))))
    for part in askew:
        lower, upper = part.bounds
        if space.is_exposed(lower, upper) and not _is_flat(np.array([lower, upper]), corners):
            found.append((part, part.collider))
    colliders = []
    for part, collider in found:
        lower, upper = shape_bounds(collider.shape, collider.pose)
        is_overhead = bool(lower[2] > OVERHEAD_M)
        if is_overhead and (upper - lower).max() < SMALL_OVERHEAD_M:
            continue
        colliders.append(
            WorldCollider(
                placement=part.place.name,
                collider=collider,
                is_overhead=is_overhead or part.place.layer is Layer.CEILING,
            )
        )
    return colliders


def _seeds(still: Sequence[StillPart]) -> Floats:
    """(9, 3) points from which a room is reached, above its worktops."""
    low, high = box_around(np.array([part.bounds for part in still]))
    shares = np.array([[x, y, 0.6] for x in (0.3, 0.5, 0.7) for y in (0.3, 0.5, 0.7)])
    points: Floats = low + shares * (high - low)
    return points


def _without_flat(boxes: Sequence[Floats]) -> list[int]:
    """Indices of boxes without those that lie flat against another, on a wall or a front."""
    corners = np.array(boxes)
    volumes = np.prod(corners[:, 1] - corners[:, 0], axis=1)
    kept = np.ones(len(corners), dtype=bool)
    for i in np.argsort(volumes, kind="stable"):
        kept[i] = not _is_flat(corners[i], corners[kept & (volumes > volumes[i])])
    return [int(i) for i in np.flatnonzero(kept)]


def _is_flat(box: Floats, others: Floats) -> bool:
    """True where a strip, (2, 3) its corners, lies flat against the side or the bottom of one of (N, 2, 3) others."""
    if np.sort(box[1] - box[0])[1] > STRIP_M:
        return False
    below, above = np.array([FLAT_M] * 3), np.array([FLAT_M, FLAT_M, 2 * TOLERANCE_M])
    held = (others[:, 0] - below <= box[0]).all(axis=1) & (others[:, 1] + above >= box[1]).all(axis=1)
    return bool(held.any())
