"""The record of registry/confidence.yaml: calibration curves and thresholds for the confidences of `articulate`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from casa_assets.model.asset.provenance import Confidence
from casa_assets.model.record import Record


class Curve(Record):
    """Share of guesses that are right, as a piecewise linear function of the confidence that the code gives them.

    Below the first point it is a straight line from (0, 0), since few of the fitted cases have such a low confidence.

    Attributes:
        given: confidences of the code, ascending.
        right: share of right guesses at each, never decreasing.
    """

    given: tuple[Confidence, ...]
    right: tuple[Confidence, ...]

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if not self.given or len(self.given) != len(self.right):
            raise ValueError("given and right have to be of one length")
        if list(self.given) != sorted(set(self.given)) or list(self.right) != sorted(self.right):
            raise ValueError("given has to rise, and right must not fall")
        return self

    def at(self, confidence: float) -> float:
        """Return the share of right guesses at a confidence."""
        return round(float(np.interp(confidence, (0.0, *self.given), (0.0, *self.right))), 3)


class Weights(Record):
    """A logistic model: its log odds are `intercept` plus the weighted sum of the features."""

    intercept: float
    weights: dict[str, float]

    def at(self, features: Mapping[str, float]) -> float:
        """Return the probability for some features. Raises KeyError if one is missing."""
        log_odds = self.intercept + sum(weight * features[name] for name, weight in self.weights.items())
        return round(1.0 / (1.0 + math.exp(-min(max(log_odds, -30.0), 30.0))), 3)


class Bars(Record):
    """Minimum confidence for accepting a guess without review.

    Attributes:
        frame: of up and front.
        plan: of all parts together.
        front: of a door or drawer behind which an interior is built.
    """

    frame: Annotated[float, Field(ge=0, le=1)]
    plan: Annotated[float, Field(ge=0, le=1)]
    front: Annotated[float, Field(ge=0, le=1)]


class ConfidenceModel(Record):
    """Calibration from confidences of the code to shares of cases that are right.

    Attributes:
        frame, part: curves for the guesses of the axes, and of one part with its joint.
        kinds: curves for kinds of parts with enough examples; `part` is for all other kinds.
        plan: weights of all parts together.
        bars: below these confidences a person has to check the result.
    """

    frame: Curve
    part: Curve
    kinds: dict[str, Curve]
    plan: Weights
    bars: Bars

    def part_at(self, kind: str, confidence: float) -> float:
        """Return the share of right guesses for parts of a kind at a confidence."""
        return self.kinds.get(kind, self.part).at(confidence)
