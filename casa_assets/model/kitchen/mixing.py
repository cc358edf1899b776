"""How kitchens are drawn at random: the content of registry/mixing.yaml."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Self

from pydantic import Field, model_validator

from casa_assets.model.record import Id, Record, Vec2

Count = Annotated[int, Field(ge=1, le=4)]


class Harmony(Record):
    """Rules for finishes of the four surfaces that may be combined.

    Attributes:
        patterned, wooden: kinds of textures that count as patterned or wooden.
        most_patterned, most_wooden: maximum number of surfaces with such a texture.
        dark_below: mean lightness in Oklab below which a finish is dark.
        most_dark: maximum number of dark surfaces.
        strong_from: mean chroma in Oklab from which a colour is strong.
        earth_hues_deg: lower and upper Oklab hue, degrees, of strong colours that count as neutral nevertheless.
        most_hue_deg: maximum difference in hue between two strong colours, degrees.
    """

    patterned: tuple[Id, ...]
    wooden: tuple[Id, ...]
    most_patterned: Count
    most_wooden: Count
    dark_below: Annotated[float, Field(ge=0, le=1)]
    most_dark: Count
    strong_from: Annotated[float, Field(ge=0, le=0.4)]
    earth_hues_deg: Vec2
    most_hue_deg: Annotated[float, Field(ge=0, le=180)]


class Mixing(Record):
    """Rules for drawing a kitchen at random.

    Attributes:
        own_share: probability that a part is taken from the kitchen's own style; otherwise one of all styles is drawn.
        suites: name -> roles of styles that are drawn together.
        finishes: which finishes may be combined.
    """

    own_share: Annotated[float, Field(ge=0, le=1)]
    suites: Mapping[Id, tuple[Id, ...]]
    finishes: Harmony

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        roles = [role for suite in self.suites.values() for role in suite]
        twice = sorted({role for role in roles if roles.count(role) > 1})
        if twice:
            raise ValueError(f"{', '.join(twice)}: a role stands in one suite at most")
        return self
