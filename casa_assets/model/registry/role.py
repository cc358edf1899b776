"""Rows of registry/roles.yaml: what an asset of a library has to be like to stand where a plan has a role."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from casa_assets.model.asset.asset import Base
from casa_assets.model.record import Id, Record, Vec2


class RoleRule(Record):
    """A role of plans and styles, and the assets of libraries that suit it.

    Attributes:
        id: word of plans and styles, such as `range`.
        categories: of assets that suit; any where it is empty.
        width, depth, height: least and greatest size of the asset without its handles, metres; None: any.
        level: heights between which its largest level face should be, which is the cooktop of a range, metres; it is
            scaled to that as far as the sizes allow. None: it stays as large as it is where that fits.
        base: how it is attached there; None: as the asset has it.
        refused: why no asset of a library can stand there; empty where one can.
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
        """Least and greatest width, depth and height, metres, of those that are bounded."""
        spans = {"width": self.width, "depth": self.depth, "height": self.height}
        return {name: span for name, span in spans.items() if span is not None}
