"""Scene in its light form -> its batch form, with as much of it kept as a number of primitives allows."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from casa_assets.geometry.merging.batch_form import BatchForms
from casa_assets.geometry.merging.joint_words import joint_word
from casa_assets.geometry.merging.moving_parts import WHOLE
from casa_assets.model.asset.asset import Asset, Base, Joint, JointKind
from casa_assets.model.kitchen.batch_scene import BatchScene
from casa_assets.model.kitchen.joint_word import JointWord
from casa_assets.model.kitchen.scene import LightScene

Ref = tuple[str, str]  # placement and joint
# Forms that are tried at most, and so many primitives below the limit are near enough.
MAX_TRIES, NEAR_ENOUGH = 4, 10
# Loose things without joints of which a kitchen has so many are seats.
MANY_ALIKE = 3
# Categories of fixtures of which the last one is locked, those first that a kitchen misses least.
LAST_UNITS = (
    "window",
    "switch",
    "door",
    "hood",
    "tall_cabinet",
    "housing_cabinet",
    "island_base",
    "corner_cabinet",
    "wall_cabinet",
    "base_cabinet",
)


@dataclass(frozen=True)
class _Step:
    """Simplifications that are made together.

    Attributes:
        locked: joints to lock. filled: placements of loose things, and of fixtures with bins on doors, to make solid.
        blocks: placements of fixtures of which all bins of a door become one block.
    """

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
    window, room door, hood and cabinet, and what is free between the bins of a door.

    Args:
        most: primitives. The form has more where nothing is left to give up.
        words: of the joints that stay. most_pairs: of primitives that an engine has to look at; None: any number.
    """
    light_of = {asset.id: asset for asset in light.light_assets}
    assets = {place.name: light_of[place.asset] for place in light.scene.placements}
    locked = [
        (name, joint.name)
        for name, asset in assets.items()
        for joint in asset.joints
        if joint_word(asset, joint) not in words
    ]
    steps, forms = list(_steps(assets, locked)), BatchForms(light)

    def with_steps(number: int) -> BatchScene:
        """The form with the first steps taken."""
        taken = steps[:number]
        more = [ref for step in taken for ref in step.locked]
        filled = [name for step in taken for name in step.filled]
        blocks = [name for step in taken for name in step.blocks]
        return forms.form([*locked, *more], filled, blocks)

    def size(form: BatchScene) -> int:
        """Number of primitives, or the equivalent of the number of pairs in primitives, whichever is larger."""
        return (
            form.collider_count
            if most_pairs is None
            else max(form.collider_count, math.ceil(most * form.pair_count / most_pairs))
        )

    # So many steps are too few, and so many enough.
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

    def of_words(name: str, *words: JointWord) -> list[Joint]:
        return [joint for joint in left[name] if joint_word(assets[name], joint) in words]

    def given_up(name: str, joints: Collection[Joint], filled: bool = False) -> Iterator[_Step]:
        left[name] = [joint for joint in left[name] if joint not in joints]
        if joints or filled:
            yield _Step(tuple((name, joint.name) for joint in joints), (name,) if filled else ())

    fixtures = [name for name, asset in assets.items() if asset.base is Base.FIXED]
    things = [name for name, asset in assets.items() if asset.base is Base.FREE]
    for name in things:
        if assets[name].joints:
            small = of_words(name, JointWord.KNOBS, JointWord.BUTTONS)
            yield from given_up(name, small, any(region.name != WHOLE for region in assets[name].regions))
    with_bins = []
    for name in fixtures:
        hinged = {joint.child for joint in left[name] if joint.kind is JointKind.HINGE}
        if any(region.link in hinged and region.name != WHOLE for region in assets[name].regions):
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
    """Names of units of which there are several of a category, the last of the most frequent one first.

    Args:
        units: name -> category.
    """
    left = dict(units)
    while left:
        counts = Counter(left.values())
        category = max(sorted(counts), key=lambda name: counts[name])
        if counts[category] == 1:
            return
        last = [name for name, found in left.items() if found == category][-1]
        del left[last]
        yield last


def _height(asset: Asset, joint: Joint) -> float:
    """Mean height of the colliders that a joint moves, in the frame of the asset, metres."""
    pose = asset.asset_from_link(joint.child)
    heights = [(pose @ collider.pose).position[2] for collider in asset.link(joint.child).colliders]
    return sum(heights) / max(len(heights), 1)
