"""Override of the guesses about one input, given by a person."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from casa_assets.model.record import Record


class UpAxis(StrEnum):
    """Axis of the file that points up."""

    X = "x"
    Y = "y"
    Z = "z"
    MINUS_X = "minus_x"
    MINUS_Y = "minus_y"
    MINUS_Z = "minus_z"


class Word(StrEnum):
    """A person's decision about an asset in review, in its current form."""

    ACCEPT = "accept"
    REJECT = "reject"


class UserOverride(Record):
    """Values that a person sets for one input; empty fields are guessed.

    Attributes:
        category: id, or empty.
        up: axis of the file that points up.
        turn_deg: turn about z, counter-clockwise from above, instead of the search for the front; degrees.
        decision: accept the asset with its guesses, or reject it; None: no decision.
        size_m: longest side, metres; 0: guessed.
        mass_kg: mass, kg; 0: guessed.
    """

    category: str = ""
    up: UpAxis | None = None
    turn_deg: float | None = None
    decision: Word | None = None
    size_m: Annotated[float, Field(ge=0, le=100)] = 0.0
    mass_kg: Annotated[float, Field(ge=0, le=10000)] = 0.0

    @property
    def is_empty(self) -> bool:
        """True if every field is empty."""
        return self == NO_OVERRIDE


NO_OVERRIDE = UserOverride()
