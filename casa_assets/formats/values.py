"""Shared by the writers of all formats: numbers as text, and MuJoCo's groups and contact dimensions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from casa_assets.core.numeric import srgb_from_linear
from casa_assets.model.asset.asset import Site
from casa_assets.model.asset.parts import Shape, Sphere

# Numbers -> text: nine significant digits, which hold a float32 exactly, and no minus before zero.

# Enough to read a float32 back exactly. Ref: IEEE 754-2008, 5.12.2.
FORMAT = "%.9g"


def number(value: float) -> str:
    """Text of one number."""
    text = FORMAT % value
    return "0" if text == "-0" else text


def numbers(values: Iterable[float]) -> str:
    """Text of several numbers, one space between them."""
    return " ".join(number(float(v)) for v in values)


def srgb(color: Sequence[float]) -> str:
    """Text of a linear RGB or RGBA colour as display values; alpha stays as it is."""
    return numbers((*(srgb_from_linear(c) for c in color[:3]), *color[3:]))


def rounded(values: Iterable[float]) -> list[float]:
    """Numbers with the same nine digits."""
    return [float(number(value)) for value in values]


@dataclass(frozen=True)
class Groups:
    """MuJoCo's groups of geoms: by default, a viewer or a renderer shows 0, 1 and 2 and hides the others.

    Attributes:
        colliders: collision geoms. Geoms that both collide and are drawn, as in the light form, are in the group of
            visuals.
        visuals: drawn geoms.
        shell: drawn geoms of the ceiling of a room and of the faces of its walls that look out of it.
        regions: named volumes that are neither drawn nor collide.
    """

    colliders: int = 3
    visuals: int = 2
    shell: int = 4
    regions: int = 5


# Ref: mujoco_menagerie has visuals in 2 and colliders in 3. The cameras of robosuite hide 0 and show 1 and 2.
VIEWER_GROUPS = Groups()
# Ref: robosuite, geoms of group 0 collide and geoms of group 1 are drawn; robocasa's own regions are in 1.
ROBOSUITE_GROUPS = Groups(colliders=0, visuals=1, shell=2, regions=1)
# The viewer hides sites of group 3 until asked for them.
SITE_GROUP = 3
# Flames and streams, which runtimes show by raising their alpha, are in a group that every camera sees.
EFFECT_GROUP = 1

# With sliding friction alone (3) a ball that spins never stops; 4 adds spinning. Ref: robosuite's objects.
FACETED_CONTACT = 4
# A sphere has no face to rest on: only rolling friction stops it, and only 6 turns that on.
ROUND_CONTACT = 6


def contact_dimensions(shape: Shape) -> int:
    """MuJoCo's `condim` of a shape."""
    return ROUND_CONTACT if isinstance(shape, Sphere) else FACETED_CONTACT


def site_group(site: Site) -> int:
    """Group of a site: a fully transparent site is an effect."""
    return SITE_GROUP if site.color[3] else EFFECT_GROUP
