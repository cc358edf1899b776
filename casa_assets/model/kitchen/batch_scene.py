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
    """A primitive that never moves and stands for colliders of one or several placements.

    Attributes:
        placement: name of that to which the largest of these colliders belongs.
        collider: called like that one, its pose in the world; its substance is one of that placement's asset.
        is_overhead: so high that only a robot can touch it.
    """

    placement: Id
    collider: Collider
    is_overhead: bool = False


class PlacedJoint(Record):
    """A joint of a placement."""

    placement: Id
    joint: Id


class EngineSizes(Record):
    """Sizes of the buffers that a GPU engine needs for a world of a batch form, and what they were found from.

    Attributes:
        nconmax: contacts to make room for, one and a half times `contacts`; arguments of mujoco_warp's `make_data`
            are called so, as are the next three.
        njmax: constraint rows to make room for. nccdmax: convex pairs. nvmax: degrees of freedom awake.
        contacts: the most at once in the trials. rows: constraint rows. awake: degrees of freedom awake.
        convex_pairs: pairs of shapes that go through the general convex algorithm, such as a cylinder and a box.
        awake_in_use: degrees of freedom awake with a stand-in of a robot and one fixture in use, and nothing dropped.
        fixtures: how many were used in the trials, one after the other.
        mujoco_bytes: memory of an MjData of MuJoCo's own: its buffer, and the most of its arena that was used.
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
    """A scene with fewer primitives, fewer joints, and the contacts left out that cannot be.

    Attributes:
        scene: the full one.
        forms: the asset of each placement, in their order. What never moves has no colliders there. Joints that are
            locked are not there: what they moved stands as in the start pose.
        world: the colliders of what never moves.
        meeting: sets of links of two or more fixtures that could touch each other; other links of fixtures never do.
        locked: the joints that the scene has and the forms do not.
        filled: names of the loose things that are solid here and hollow in the scene, and of the fixtures whose bins in
            doors are.
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
        """Number of pairs of its primitives that an engine has to look at.

        They are of loose things with all that is not overhead, and of parts of fixtures that can meet.
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
