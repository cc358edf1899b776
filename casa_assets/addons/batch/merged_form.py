"""Scene in its light form -> its batch form, with as much of it kept as a number of primitives allows."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets import Asset
from casa_assets.addons.batch import fit_primitives as fit
from casa_assets.addons.batch import moving_parts
from casa_assets.addons.batch.moving_parts import WorldPart
from casa_assets.ext.arrays import Floats
from casa_assets.ext.kitchens import (
    BatchScene,
    JointWord,
    Layer,
    LightScene,
    PlacedJoint,
    PlacedLink,
    Placement,
    WorldCollider,
)
from casa_assets.ext.records import AssetJoint, Base, Collider, JointKind, Link, Pose, Region, Shape, joint_positions
from casa_assets.ext.solids import box_around, link_bounds, shape_bounds

# Strips and brackets as thin as this, and this share of the largest piece, are left out, metres.
SLIVER_M, SLIVER_SHARE = 0.008, 0.02
# Pieces that stand for one hull of the full form become one where no more than this of it is empty.
EMPTY_SHARE_OF_HULL = 0.45
# What stands out from a wall or a front, or hangs below something, by less than this is no obstacle, metres: sockets,
# skirting, the trim of a window, feet below a plinth.
FLAT_M = 0.022
STRIP_M = 0.2  # it is a strip or small: panelling and tiles of a whole wall are its surface, metres
# Labels of parts of a fixture of which MANY_PIECES become a few: what they enclose holds nothing.
OPEN_WORK = frozenset({"grate", "faucet", "canopy", "hinge"})
MANY_PIECES = 3
OVERHEAD_M = 2.35  # a thing on a wall cupboard is reached, what begins higher than this is not, metres above the floor
SMALL_OVERHEAD_M = 0.45  # what is smaller up there is left out, metres: the canopy of a lamp
# A lamp, or what else holds nothing, is fewer primitives where it is smaller than this, metres.
LARGE_THING_M = 0.75
MIN_PIECES, MOST_OF_PLAIN_THING, MOST_OF_LARGE_THING = 3, 2, 4
# Names of the region around a whole asset, the one that is added first. Ref: robocasa v1.0, fixtures and objects.
OUTER_REGIONS = ("bbox", "main")
Ref = tuple[str, str]  # placement and joint
Key = tuple[str, tuple[str, ...]]  # name of a placement, and its locked joints
MAX_TRIES, NEAR_ENOUGH = 4, 10  # forms that are tried at most; primitives below the limit that are near enough
MANY_ALIKE = 3  # number of like loose things without joints from which on they are seats
# Categories of fixtures of which the last one is locked, those first that a kitchen misses least.
LAST_UNITS = (
    *("window", "switch", "door", "hood", "tall_cabinet", "housing_cabinet", "island_base"),
    *("corner_cabinet", "wall_cabinet", "base_cabinet"),
)


def still_parts(place: Placement, form: Asset) -> list[WorldPart]:
    """The primitives of a placement that never move, in the world; those of lamps, clocks and curtains made few."""
    parts: list[WorldPart] = []
    for link in form.links:
        if form.base is Base.FREE or form.is_moved(link.name):
            continue
        touched = fit.touched_colliders(form)
        kept = [c for c in link.colliders if c.name not in touched]
        colliders = _of_many_pieces(_of_one_hull_each(_without_slivers(kept)))
        holds_nothing = not form.joints and all(region.name == moving_parts.WHOLE for region in form.regions)
        if place.layer is Layer.THINGS and holds_nothing and len(colliders) >= MIN_PIECES:
            # A lamp, a clock, a curtain; a large one may have more primitives.
            lower, upper = box_around(np.array([shape_bounds(c.shape, c.pose) for c in colliders]))
            is_large = float((upper - lower)[:2].max()) >= LARGE_THING_M
            limits = fit.FitLimits(MOST_OF_LARGE_THING if is_large else MOST_OF_PLAIN_THING, moving_parts.EMPTY_SHARE)
            colliders = fit.fitted_colliders(colliders, limits)
        world_from_link = place.pose @ form.asset_from_link(link.name)
        parts += [WorldPart(place, link.name, c.replace(pose=world_from_link @ c.pose)) for c in colliders]
    return parts


def _size(shape: Shape) -> Floats:
    """(3,) size of a primitive along its own axes, metres."""
    lower, upper = shape_bounds(shape, Pose())
    return np.asarray(upper - lower)


def _without_slivers(colliders: Sequence[Collider]) -> list[Collider]:
    """Colliders without those that are thin, and small compared with the largest."""
    sizes = [_size(c.shape) for c in colliders]
    largest = max((float(np.prod(size)) for size in sizes), default=0.0)
    sized = zip(colliders, sizes, strict=True)
    return [c for c, size in sized if size.min() > SLIVER_M or float(np.prod(size)) > SLIVER_SHARE * largest]


def _of_one_hull_each(colliders: Sequence[Collider]) -> tuple[Collider, ...]:
    """Colliders, with the pieces of one collider of the full form merged into one unless that is too empty."""
    groups: dict[str, list[Collider]] = {}
    for collider in colliders:
        groups.setdefault(LightScene.collider_of(collider.name), []).append(collider)
    found: list[Collider] = []
    for group in groups.values():
        if len(group) > 1:
            fitted = fit.fit_primitives([(c.shape, c.pose) for c in group], fit.FitLimits(1, EMPTY_SHARE_OF_HULL))
            filled = sum(np.prod(_size(c.shape)) for c in group)
            if len(fitted) == 1 and 1 - filled / np.prod(_size(fitted[0].shape)) <= EMPTY_SHARE_OF_HULL:
                found.append(fit.replaced(group[0], fitted[0].shape, fitted[0].pose))
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
        limits = fit.FitLimits(max(1, len(group) // moving_parts.PIECES_PER_GROUP), moving_parts.EMPTY_SHARE)
        found += fit.fitted_colliders(group, limits) if len(group) >= MANY_PIECES else group
    return tuple(found)


def exposed_parts(parts: Sequence[WorldPart]) -> list[WorldPart]:
    """Parts of one placement, those that nothing gets at from outside left out, and boxes merged."""
    aligned = [part for part in parts if part.is_aligned]
    if len(aligned) < 2:
        return list(parts)
    corners = np.array([part.bounds for part in aligned])
    askew = [part for part in parts if not part.is_aligned]
    shapes = [(part.collider.shape, part.collider.pose) for part in askew]
    space = fit.ReachableSpace(corners, fit.points_around(corners), shapes)
    found = []
    for cover in fit.cover_boxes(space):
        owner = aligned[cover.covered[0]]
        found.append(WorldPart(owner.place, owner.link, fit.replaced(owner.collider, *fit.box_between(cover.corners))))
    return [*found, *(part for part in askew if space.is_exposed(part.bounds[0], part.bounds[1]))]


def merged_parts(still: Sequence[WorldPart]) -> list[WorldCollider]:
    """The primitives of what never moves, merged."""
    aligned = [part for part in still if part.is_aligned]
    askew = [part for part in still if not part.is_aligned]
    corners = np.array([part.bounds for part in aligned])
    # Points from which a room is reached, above its worktops.
    low, high = box_around(np.array([part.bounds for part in still]))
    seeds = low + np.array([[x, y, 0.6] for x in (0.3, 0.5, 0.7) for y in (0.3, 0.5, 0.7)]) * (high - low)
    space = fit.ReachableSpace(corners, seeds, [(part.collider.shape, part.collider.pose) for part in askew])
    covers = fit.cover_boxes(space)
    kept = _without_flat([cover.corners for cover in covers])
    found = []
    for k in kept:
        owner = aligned[covers[k].covered[0]]
        found.append((owner, fit.replaced(owner.collider, *fit.box_between(covers[k].corners))))
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
        is_above = is_overhead or part.place.layer is Layer.CEILING
        colliders.append(WorldCollider(placement=part.place.name, collider=collider, is_overhead=is_above))
    return colliders


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
    below, above = np.array([FLAT_M] * 3), np.array([FLAT_M, FLAT_M, 2 * fit.TOLERANCE_M])
    held = (others[:, 0] - below <= box[0]).all(axis=1) & (others[:, 1] + above >= box[1]).all(axis=1)
    return bool(held.any())


def with_joints_locked(asset: Asset, locked: Collection[str], positions: Mapping[str, float]) -> Asset:
    """The asset without some of its joints; the colliders of what they moved go to the link that carries it.

    States and named poses lose what they say of a locked joint. Behaviour that looks at one, or at a key that it moved,
    is left out. `positions`: of joints, rad or m; a locked one stays at its own, or 0.
    """
    held = {joint.child for joint in asset.joints if joint.name in locked}
    left = (joint for joint in asset.joints if joint.name not in locked)
    joints = tuple(joint.replace(behind=None if joint.behind in locked else joint.behind) for joint in left)
    behavior = asset.behavior
    if behavior is not None:
        carried = asset.carried_by([joint.child for joint in asset.joints if joint.name in locked])
        keys = {collider.name for link in asset.links if link.name in carried for collider in link.colliders}
        if set(behavior.joints) & set(locked) or set(behavior.contacts) & keys:
            behavior = None
    moved = {joint.child for joint in joints}
    poses = {name: asset.parent_from_link(name, positions) for name in held}
    links = [link.replace(pose=poses.get(link.name, link.pose)) for link in asset.links]
    return asset.replace(
        links=_on_their_carriers(links, moved),
        joints=joints,
        states=tuple(state for state in asset.states if state.joint not in locked),
        keyframes=tuple(
            key.replace(joints=tuple(at for at in key.joints if at.joint not in locked)) for key in asset.keyframes
        ),
        behavior=behavior,
    )


def _on_their_carriers(links: list[Link], moved: Collection[str]) -> tuple[Link, ...]:
    """The links, with the colliders of those that are rigidly attached on the nearest that moves, or the root."""
    carrier_from: dict[str, tuple[str, Pose]] = {}
    colliders: dict[str, list[Collider]] = {link.name: [] for link in links}
    for link in links:
        if link.parent is None or link.name in moved:
            carrier_from[link.name] = (link.name, Pose())
        else:
            carrier, pose = carrier_from[link.parent]
            carrier_from[link.name] = (carrier, pose @ link.pose)
        carrier, pose = carrier_from[link.name]
        colliders[carrier] += [c.replace(pose=pose @ c.pose) for c in link.colliders]
    return tuple(link.replace(colliders=tuple(colliders[link.name])) for link in links)


class BatchForms:
    """Batch forms of one scene with more or fewer joints; what several of them share is made once."""

    def __init__(self, light: LightScene) -> None:
        self._scene = light.scene
        self._light_of = {asset.id: asset for asset in light.light_assets}
        self._assets: dict[Key, Asset] = {}
        self._still: dict[Key, list[WorldPart]] = {}  # parts that never move
        # By the same, and what becomes of its inside: its form.
        self._forms: dict[tuple[str, tuple[str, ...], moving_parts.Inside], Asset] = {}

    def form(
        self, locked: Collection[Ref] = (), filled: Collection[str] = (), blocks: Collection[str] = ()
    ) -> BatchScene:
        """The batch form of the scene without some joints, (placement, joint).

        `filled`: placements of loose things that become solid, and of fixtures whose doors do: nothing can be put into
        them, or into the bins of a door. `blocks`: those of fixtures of which all bins of a door become one block.
        """
        scene = self._scene
        keys = {
            place.name: (place.name, tuple(joint for where, joint in locked if where == place.name))
            for place in scene.placements
        }
        whole = [self._asset(place, keys[place.name]) for place in scene.placements]
        placed = list(zip(scene.placements, whole, strict=True))
        still = [part for place, asset in placed for part in self._parts(place, asset, keys[place.name])]
        loose = moving_parts.loose_parts(scene.placements, whole)
        forms = []
        for place, asset in placed:
            inside = moving_parts.Inside.SOLID if place.name in filled else moving_parts.Inside.KEPT
            key = (*keys[place.name], moving_parts.Inside.ONE_BLOCK if place.name in blocks else inside)
            if key not in self._forms:
                # A seat that becomes a block stands under a worktop, between its corbels.
                is_block = place.name in filled and not asset.joints
                few = moving_parts.with_few_primitives(place, asset, loose + still if is_block else loose, key[-1])
                self._forms[key] = _with_outer_region(few, asset)
            forms.append(self._forms[key])
        return BatchScene(
            scene=scene,
            forms=tuple(forms),
            world=tuple(merged_parts(still)),
            meeting=tuple(
                tuple(PlacedLink(placement=where, link=link) for where, link in group)
                for group in moving_parts.meeting_links(scene.placements, forms)
            ),
            locked=tuple(PlacedJoint(placement=where, joint=joint) for where, joint in locked),
            filled=tuple(filled),
        )

    def _asset(self, place: Placement, key: Key) -> Asset:
        if key not in self._assets:
            plain = moving_parts.with_plain_parts(self._light_of[place.asset], key[1])
            self._assets[key] = with_joints_locked(plain, key[1], joint_positions(place.joints))
        return self._assets[key]

    def _parts(self, place: Placement, asset: Asset, key: Key) -> list[WorldPart]:
        if key not in self._still:
            parts = still_parts(place, asset)
            # What is inside of a unit that cannot be opened need not be looked at in the whole room.
            self._still[key] = exposed_parts(parts) if key[1] else parts
        return self._still[key]


def _with_outer_region(form: Asset, whole: Asset) -> Asset:
    """The form with a region around all colliders that the asset had before they went to the world."""
    if any(region.name in OUTER_REGIONS for region in form.regions):
        return form
    bounds = (link_bounds(link, whole.asset_from_link(link.name)) for link in whole.links)
    boxes = [found for found in bounds if found is not None]
    if not boxes:
        return form
    box, pose = fit.box_between(box_around(np.array(boxes)))
    return form.replace(regions=(*form.regions, Region(name=OUTER_REGIONS[0], pose=pose, size=box.size)))


@dataclass(frozen=True)
class _Step:
    """Joints to lock, placements to make solid, and fixtures of which all bins of a door become one block, together."""

    locked: tuple[Ref, ...] = ()
    filled: tuple[str, ...] = ()
    blocks: tuple[str, ...] = ()


def batch_within(
    light: LightScene, most: int, words: Collection[JointWord] = tuple(JointWord), most_pairs: int | None = None
) -> BatchScene:
    """The batch form with the joints of some words, and of those as many as some primitives and pairs allow.

    Where there are too many, this is given up in this order, only as much as needed: the inside of loose appliances
    and their knobs and keys, the bins of doors, drawers behind doors, units that the kitchen has several of, the last
    ones first, of several drawers in one unit all but the uppermost, the legs of seats one by one, racks, the last
    window, room door, hood and cabinet, and what is free between the bins of a door. The form has more than `most`
    primitives where nothing is left to give up. `most_pairs`: that an engine has to look at.
    """
    light_of = {asset.id: asset for asset in light.light_assets}
    assets = {place.name: light_of[place.asset] for place in light.scene.placements}
    joints = ((name, asset, joint) for name, asset in assets.items() for joint in asset.joints)
    locked = [(name, joint.name) for name, asset, joint in joints if moving_parts.joint_word(asset, joint) not in words]
    steps, forms = list(_steps(assets, locked)), BatchForms(light)

    def with_steps(number: int) -> BatchScene:
        """The form with the first steps taken."""
        columns = ([one for step in steps[:number] for one in getattr(step, key)] for key in ("filled", "blocks"))
        return forms.form([*locked, *(ref for step in steps[:number] for ref in step.locked)], *columns)

    def size(form: BatchScene) -> int:
        """Number of primitives, or the equivalent of the number of pairs in primitives, whichever is larger."""
        pairs = 0 if most_pairs is None else math.ceil(most * form.pair_count / most_pairs)
        return max(form.collider_count, pairs)

    # Steps that are too few, and steps that are enough.
    few, many = 0, len(steps)
    form = with_steps(0)
    if size(form) <= most or not steps:
        return form
    best = with_steps(many)
    above, below = size(form) - most, most - size(best)
    for tried in range(MAX_TRIES):
        # All given up is never near enough: it is the least that is left of the kitchen, and a few steps may be free.
        if many - few <= 1 or (tried and 0 <= most - size(best) <= NEAR_ENOUGH):
            break
        # What a step saves differs: halfway, weighted by how far each end is from the aim.
        between = few + max(1, min(many - few - 1, round((many - few) * above / max(above + below, 1))))
        form = with_steps(between)
        if size(form) > most:
            few, above = between, size(form) - most
        else:
            many, below, best = between, most - size(form), form
    return best


def _steps(assets: Mapping[str, Asset], locked: Collection[Ref]) -> Iterator[_Step]:
    """Yield the simplifications in order, starting with those that a kitchen misses least."""
    left = {
        name: [joint for joint in asset.joints if (name, joint.name) not in locked] for name, asset in assets.items()
    }

    def of_words(name: str, *words: JointWord) -> list[AssetJoint]:
        return [joint for joint in left[name] if moving_parts.joint_word(assets[name], joint) in words]

    def given_up(name: str, joints: Collection[AssetJoint], filled: bool = False) -> Iterator[_Step]:
        left[name] = [joint for joint in left[name] if joint not in joints]
        if joints or filled:
            yield _Step(tuple((name, joint.name) for joint in joints), (name,) if filled else ())

    fixtures = [name for name, asset in assets.items() if asset.base is Base.FIXED]
    things = [name for name, asset in assets.items() if asset.base is Base.FREE]
    for name in things:
        if assets[name].joints:
            small = of_words(name, JointWord.KNOBS, JointWord.BUTTONS)
            yield from given_up(name, small, any(region.name != moving_parts.WHOLE for region in assets[name].regions))
    with_bins = []
    for name in fixtures:
        hinged = {joint.child for joint in left[name] if joint.kind is JointKind.HINGE}
        if any(region.link in hinged and region.name != moving_parts.WHOLE for region in assets[name].regions):
            with_bins.append(name)
            yield _Step(filled=(name,))
    for name in fixtures:
        yield from given_up(name, [j for j in of_words(name, JointWord.DRAWERS) if j.behind is not None])
    units = {name: assets[name].labels.category for name in fixtures if left[name]}
    for name in _of_several(units):
        del units[name]
        yield from given_up(name, left[name])
    for name in units:
        drawers = sorted(of_words(name, JointWord.DRAWERS), key=lambda joint: _height(assets[name], joint))
        yield from given_up(name, drawers[:-1])
    seats = Counter(assets[name].labels.category for name in things if not assets[name].joints)
    for name in things:
        yield from given_up(name, (), not assets[name].joints and seats[assets[name].labels.category] >= MANY_ALIKE)
    for name in fixtures:
        yield from given_up(name, of_words(name, JointWord.RACKS))
    for category in LAST_UNITS:
        for name in [name for name, found in units.items() if found == category]:
            yield from given_up(name, left[name])
    for name in with_bins:
        yield _Step(blocks=(name,))


def _of_several(units: Mapping[str, str]) -> Iterator[str]:
    """Of units, name -> category, those of which there are several, the last of the most frequent category first."""
    left = dict(units)
    while left:
        counts = Counter(left.values())
        category = max(sorted(counts), key=lambda name: counts[name])
        if counts[category] == 1:
            return
        last = [name for name, found in left.items() if found == category][-1]
        del left[last]
        yield last


def _height(asset: Asset, joint: AssetJoint) -> float:
    """Mean height of the colliders that a joint moves, in the frame of the asset, metres."""
    pose = asset.asset_from_link(joint.child)
    heights = [(pose @ collider.pose).position[2] for collider in asset.link(joint.child).colliders]
    return sum(heights) / max(len(heights), 1)
