"""Rows of registry/roles.yaml: requirements on an asset of a library that fills a role of a plan."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from casa_assets.model.asset.asset import Base
from casa_assets.model.record import Id, Record, Vec2


class RoleRule(Record):
    """A role of plans and styles, and the requirements on assets of libraries that fill it.

    Attributes:
        id: word of plans and styles, such as `range`.
        categories: categories of suitable assets; empty: any.
        width, depth, height: minimum and maximum size of the asset without its handles, metres; None: any.
        level: allowed heights of its largest horizontal face, which is the cooktop of a range, metres; the asset is
            scaled to them as far as the sizes allow. None: it keeps its size if that fits.
        base: how it is attached there; None: as in the asset.
        refused: why no asset of a library can fill this role; empty if one can.
    """

    id: Id
    categories: tuple[Id, ...] = ()
    width: Vec2 | None = None
    depth: Vec2 | None = None
    height: Vec2 | None = None
    level: Vec2 | None = None
    base: Base | None = None
    refused: str = ""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        for name in ("width", "depth", "height", "level"):
            span = getattr(self, name)
            if span is not None and not 0 < span[0] <= span[1]:
                raise ValueError(f"{name} is [least, greatest] in metres, got {list(span)}")
        return self

    @property
    def sizes(self) -> dict[str, Vec2]:
        """Minimum and maximum width, depth and height, metres, of those that are bounded."""
        spans = {"width": self.width, "depth": self.depth, "height": self.height}
        return {name: span for name, span in spans.items() if span is not None}
