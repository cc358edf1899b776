"""What the four kinds of refrigerators share: their numbers, the draw of a size, and the steps of building one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from casa_assets.families.family import Params, Supplies, between, pick
from casa_assets.families.kit.assemble import assemble
from casa_assets.families.kit.asset_builder import Bench
from casa_assets.families.parts.appliance.look import Form, Kick, Look
from casa_assets.families.parts.appliance.trim import adorn
from casa_assets.families.parts.refrigerator import case as parts
from casa_assets.families.parts.refrigerator.case import BETWEEN, FLOOR, GAP, SIDE, TOP, Room
from casa_assets.families.parts.refrigerator.door import Leaf
from casa_assets.families.parts.refrigerator.rooms import finish
from casa_assets.model.asset.asset import Asset
from casa_assets.model.record import Vec2

HINGE_INSET = 0.05  # metres from the side of the case to the middle of a hinge's cover
EDGE = 0.003  # metres that a door stays away from what is above or below it


class Refrigerator(Params):
    """Numbers of every refrigerator. Metres.

    Attributes:
        width, depth, height: outside, with doors but without pulls. foot: height of what it stands on.
        shelves: panes in the fridge. bins: in each door of the fridge. look: form, finishes and pulls.
    """

    width: float
    depth: float
    height: float
    foot: Annotated[float, Field(ge=0.04, le=0.12)] = 0.06
    shelves: Annotated[int, Field(ge=1, le=4)] = 3
    bins: Annotated[int, Field(ge=1, le=4)] = 3
    look: Look = Look()


def draw_size(
    rng: np.random.Generator, look: Look, widths: Sequence[float], depth: Vec2, height: Vec2
) -> dict[str, Any]:
    """Fields that give the outer size: a width of those given, depth, height and foot within bounds, metres."""
    return {
        "width": pick(rng, tuple(widths)),
        "depth": between(rng, *depth, 0.01),
        "height": between(rng, *height, 0.01),
        "foot": between(rng, 0.09, 0.11, 0.005) if look.kick is Kick.FEET else between(rng, 0.05, 0.09, 0.005),
    }


def has_plain_doors(look: Look) -> bool:
    """Whether a dispenser can be let into its doors."""
    return look.form in (Form.FLAT, Form.SOFT)


def without_display(look: Look) -> Look:
    """The look without a touch panel, where the doors are plain and may have a dispenser instead."""
    return look.replace(display=False) if has_plain_doors(look) else look


@dataclass(frozen=True)
class Case:
    """A refrigerator while it is built: the front of its case is y = 0, its left side x = 0.

    Attributes:
        family: name of the family and of its contract. p: its numbers. bench: where it is put together.
    """

    family: str
    p: Refrigerator
    bench: Bench

    @staticmethod
    def of(family: str, p: Refrigerator, supplies: Supplies) -> Case:
        """A case with nothing in it."""
        bench = Bench(supplies)
        bench.contract = family
        return Case(family, p, bench)

    @property
    def deep(self) -> float:
        """Depth of the case without doors, metres."""
        return self.p.depth - self.p.look.thick - GAP

    @property
    def top(self) -> float:
        """Height of the case without covers of hinges, metres."""
        return parts.roof(self.p.height, self.p.look)

    @property
    def inside(self) -> tuple[float, float, float, float]:
        """Planes of the whole inside: left, right, bottom, top, metres."""
        return SIDE, self.p.width - SIDE, self.p.foot + FLOOR, self.top - TOP

    def below(self, split: float) -> tuple[float, float, float, float, float]:
        """Left, right, bottom, top and depth of the inside below a wall whose middle is at height `split`, metres."""
        left, right, bottom, _ = self.inside
        return left, right, bottom, split - BETWEEN / 2, self.deep

    def above(self, split: float) -> tuple[float, float, float, float, float]:
        """The same above that wall."""
        left, right, _, top = self.inside
        return left, right, split + BETWEEN / 2, top, self.deep

    def enclose(self, *rooms: Room) -> None:
        """Walls round the rooms, and what they stand on."""
        p = self.p
        parts.shell(self.bench, p.width, self.deep, self.top, p.foot, rooms, p.look)
        parts.stand(self.bench, p.width, self.deep, p.foot, p.look)

    def finished(self, leaves: Sequence[Leaf], others: Sequence[str], badge: Leaf, fridge: Sequence[Leaf]) -> Asset:
        """The asset: covers over the hinges, badge, states, lamp.

        Args:
            leaves: doors at the top, which turn on covered hinges. others: joints of further doors and drawers.
            badge: the leaf that carries the badge. fridge: leaves whose opening lights the lamp.
        """
        p = self.p
        for right in sorted({leaf.right for leaf in leaves}):
            at = p.width - HINGE_INSET if right else HINGE_INSET
            parts.cover(self.bench, at, self.top, p.look.thick, p.look)
        adorn(self.bench, badge, p.look)
        joints = [leaf.joint for leaf in leaves]
        finish(self.bench, (*joints, *others), [leaf.joint for leaf in fridge])
        self.bench.region("main", (0.0, -GAP - p.look.thick, 0.0), (p.width, self.deep, p.height))
        return assemble(self.bench, self.family, p)
