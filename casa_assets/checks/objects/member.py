"""A member of a category of objects, with what is printed on it: the subject of the checks on each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from casa_assets.core.typing import Floats
from casa_assets.model.asset.asset import Asset
from casa_assets.model.registry.category import Category


@dataclass(frozen=True)
class PrintedLine:
    """A line of letters in the picture of a material.

    Attributes:
        text: as it is written.
        cover: (H, W) share of each pixel of the picture that its letters cover, 0..1; row 0 is the upper edge.
        runs_upwards: its baseline runs upwards in the picture.
    """

    text: str
    cover: Floats
    runs_upwards: bool


@dataclass(frozen=True, eq=False)
class ObjectMember:
    """A member of a category; compared by identity, so that measurements of it can be cached.

    Attributes:
        asset: of it. category: its category in the registry.
        printed: id of a material -> the lines that say what is in the package.
    """

    asset: Asset
    category: Category
    printed: Mapping[str, tuple[PrintedLine, ...]]
