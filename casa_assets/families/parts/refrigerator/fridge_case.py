"""Common parameters, sampling and building steps of the four families of refrigerators."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from casa_assets.families.family import Params, between, pick
from casa_assets.families.kit.asset_builder import AssetBuilder
from casa_assets.families.parts.appliance.look import ApplianceFront, ApplianceKick, ApplianceLook
from casa_assets.families.parts.appliance.trim import add_badge
from casa_assets.families.parts.refrigerator import case as parts
from casa_assets.families.parts.refrigerator.case import (
    DIVIDER_THICKNESS,
    DOOR_GAP,
    FLOOR_THICKNESS,
    SIDE_THICKNESS,
    TOP_THICKNESS,
    Compartment,
)
from casa_assets.families.parts.refrigerator.door import FridgeDoor
from casa_assets.families.parts.refrigerator.furnishing import finish_refrigerator
from casa_assets.model.record import Vec2

HINGE_INSET = 0.05  # metres from the side of the case to the middle of a hinge's cover
DOOR_EDGE_GAP = 0.003  # metres that a door stays away from what is above or below it


class Refrigerator(Params):
    """Parameters of every refrigerator. Metres.

    Attributes:
        width, depth, height: outside, with doors but without pulls. foot: height of its base.
        shelves: panes in the fridge. bins: in each door of the fridge. look: form, finishes and pulls.
    """

    width: float
    depth: float
    height: float
    foot: Annotated[float, Field(ge=0.04, le=0.12)] = 0.06
    shelves: Annotated[int, Field(ge=1, le=4)] = 3
    bins: Annotated[int, Field(ge=1, le=4)] = 3
    look: ApplianceLook = ApplianceLook()


def draw_size(
    rng: np.random.Generator, look: ApplianceLook, widths: Sequence[float], depth: Vec2, height: Vec2
) -> dict[str, Any]:
    """Fields that give the outer size: a width of those given, depth, height and foot within bounds, metres."""
    return {
        "width": pick(rng, tuple(widths)),
        "depth": between(rng, *depth, 0.01),
        "height": between(rng, *height, 0.01),
        "foot": between(rng, 0.09, 0.11, 0.005) if look.kick is ApplianceKick.FEET else between(rng, 0.05, 0.09, 0.005),
    }


def has_plain_doors(look: ApplianceLook) -> bool:
    """True where a dispenser can be let into the doors."""
    return look.form in (ApplianceFront.FLAT, ApplianceFront.SOFT)


def without_display(look: ApplianceLook) -> ApplianceLook:
    """The look without a touch panel, where the doors are plain and may have a dispenser instead."""
    return look.replace(display=False) if has_plain_doors(look) else look


@dataclass(frozen=True)
class FridgeCase:
    """A refrigerator while it is built: the front of its case is y = 0, its left side x = 0.

    Attributes:
        p: its numbers. builder: where it is put together.
    """

    p: Refrigerator
    builder: AssetBuilder

    @property
    def deep(self) -> float:
        """Depth of the case without doors, metres."""
        return self.p.depth - self.p.look.thick - DOOR_GAP

    @property
    def top(self) -> float:
        """Height of the case without covers of hinges, metres."""
        return self.p.height - (0.0 if self.p.look.form is ApplianceFront.PANEL else parts.HINGE_COVER_HEIGHT)

    @property
    def inside(self) -> tuple[float, float, float, float]:
        """Planes of the whole inside: left, right, bottom, top, metres."""
        return SIDE_THICKNESS, self.p.width - SIDE_THICKNESS, self.p.foot + FLOOR_THICKNESS, self.top - TOP_THICKNESS

    def below(self, split: float) -> tuple[float, float, float, float, float]:
        """Left, right, bottom, top and depth of the inside below a wall whose middle is at height `split`, metres."""
        left, right, bottom, _ = self.inside
        return left, right, bottom, split - DIVIDER_THICKNESS / 2, self.deep

    def above(self, split: float) -> tuple[float, float, float, float, float]:
        """Left, right, bottom, top and depth of the inside above that wall, metres."""
        left, right, _, top = self.inside
        return left, right, split + DIVIDER_THICKNESS / 2, top, self.deep

    def enclose(self, *compartments: Compartment) -> None:
        """Add walls round the compartments, and the base."""
        p = self.p
        parts.add_case(self.builder, p.width, self.deep, self.top, p.foot, compartments, p.look)
        parts.add_base(self.builder, p.width, self.deep, p.foot, p.look)

    def finish(
        self,
        doors: Sequence[FridgeDoor],
        other_joints: Sequence[str],
        badge_door: FridgeDoor,
        fridge_doors: Sequence[FridgeDoor],
    ) -> None:
        """Add covers over the hinges, the badge, states and the lamp.

        Args:
            doors: doors at the top, which turn on covered hinges. other_joints: joints of further doors and drawers.
            badge_door: the door with the badge. fridge_doors: doors whose opening lights the lamp.
        """
        p = self.p
        for right in sorted({door.right for door in doors}):
            at = p.width - HINGE_INSET if right else HINGE_INSET
            parts.add_hinge_cover(self.builder, at, self.top, p.look.thick, p.look)
        add_badge(self.builder, badge_door, p.look)
        joints = [door.joint for door in doors]
        finish_refrigerator(self.builder, (*joints, *other_joints), [door.joint for door in fridge_doors])
        self.builder.region("main", (0.0, -DOOR_GAP - p.look.thick, 0.0), (p.width, self.deep, p.height))
