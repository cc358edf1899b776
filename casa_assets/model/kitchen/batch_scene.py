"""The batch form of a kitchen: a scene with few primitives, for engines that step thousands of copies at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

from pydantic import model_validator

from casa_assets.model.asset.asset import Asset, Base, Collider
from casa_assets.model.kitchen.scene import PlacedLink, Scene
from casa_assets.model.record import Id, Record

# Pixels along the longer side of a picture: about 5 mm of a floor, and cameras of policies have some hundred.
PICTURE_PX = 256


class WorldCollider(Record):
    """A primitive that never moves and replaces colliders of one or more placements.

    Attributes:
        placement: name of the placement that has the largest of these colliders.
        collider: named like that largest collider, with its pose in the world frame; its substance is one of that
            placement's asset.
        is_overhead: whether it is so high that only a robot can touch it.
    """

    placement: Id
    collider: Collider
    is_overhead: bool = False


class PlacedJoint(Record):
    """A joint of a placement."""

    placement: Id
    joint: Id


class EngineSizes(Record):
    """Buffer sizes that a GPU engine needs for one world of a batch form, and the measurements that they are based on.

    Attributes:
        nconmax: number of contacts to allocate, 1.5 times `contacts`; mujoco_warp's `make_data` has arguments of this
            name and of the next three.
        njmax: number of constraint rows to allocate.
        nccdmax: number of convex pairs to allocate.
        nvmax: number of awake degrees of freedom to allocate.
        contacts: maximum number at once in the trials.
        rows: maximum number of constraint rows in the trials.
        awake: maximum number of awake degrees of freedom in the trials.
        convex_pairs: pairs of shapes that need the general convex algorithm, such as a cylinder and a box.
        awake_in_use: awake degrees of freedom with a placeholder robot and one fixture in use, and no object
            dropped.
        fixtures: number of fixtures that were used in the trials, one after the other.
        mujoco_bytes: memory of an MjData in MuJoCo itself: its buffer, and the largest part of its arena that was used.
    """

    nconmax: int
    njmax: int
    nccdmax: int
    nvmax: int
    contacts: int
    rows: int
    convex_pairs: int
    awake: int
    awake_in_use: int
    fixtures: int
    mujoco_bytes: int


class BatchScene(Record):
    """A scene with fewer primitives and fewer joints, and without contacts that are impossible.

    Attributes:
        scene: the full scene.
        forms: the batch form of the asset of each placement, in the order of the placements. Parts that never move have
            no colliders in them. Locked joints are left out; the parts that they moved stay in the start pose.
        world: the colliders of everything that never moves.
        meeting: sets of links of two or more fixtures that could touch each other; no other links of fixtures ever do.
        locked: joints of the scene that the forms do not have.
        filled: names of loose objects that are solid here but hollow in the scene, and of fixtures whose door bins are
            filled.
    """

    scene: Scene
    forms: tuple[Asset, ...]
    world: tuple[WorldCollider, ...]
    meeting: tuple[tuple[PlacedLink, ...], ...] = ()
    locked: tuple[PlacedJoint, ...] = ()
    filled: tuple[Id, ...] = ()

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if [form.id for form in self.forms] != [place.asset for place in self.scene.placements]:
            raise ValueError("a batch form has a form of the asset of each placement, in their order")
        names = {place.name for place in self.scene.placements}
        if any(item.placement not in names for item in self.world):
            raise ValueError("each collider of the world belongs to a placement")
        return self

    @property
    def collider_count(self) -> int:
        """Number of its primitives."""
        return len(self.world) + sum(len(link.colliders) for form in self.forms for link in form.links)

    @property
    def pair_count(self) -> int:
        """Number of pairs of primitives that an engine has to check for contacts.

        These are pairs of a loose object with anything that is not overhead, and pairs of fixture parts that can meet.
        """
        things = [sum(len(link.colliders) for link in form.links) for form in self.forms if form.base is Base.FREE]
        fixed = sum(len(link.colliders) for form in self.forms for link in form.links) - sum(things)
        low = sum(not item.is_overhead for item in self.world)
        counts = {
            (place.name, link.name): len(link.colliders)
            for place, form in zip(self.scene.placements, self.forms, strict=True)
            for link in form.links
        }
        meeting = (_pairs_of([counts[ref.placement, ref.link] for ref in group]) for group in self.meeting)
        return sum(things) * (low + fixed) + _pairs_of(things) + sum(meeting)


def _pairs_of(counts: Sequence[int]) -> int:
    """Number of pairs of members of different groups."""
    return (sum(counts) ** 2 - sum(count**2 for count in counts)) // 2
