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
    """Share of guesses that are right, by the confidence that the code gives them; straight between the points.

    Before the first point it is straight from nothing: few of the cases that it is fitted on are that doubtful.

    Attributes:
        given: confidences of the code, ascending. right: share that is right at each, never falling.
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
        """Return the share that is right at a confidence."""
        return round(float(np.interp(confidence, (0.0, *self.given), (0.0, *self.right))), 3)


class Weights(Record):
    """A logistic model: the probability is that of `intercept` plus the weighted sum of the features, as log odds."""

    intercept: float
    weights: dict[str, float]

    def at(self, features: Mapping[str, float]) -> float:
        """Return the probability for some features. Raises KeyError where one is missing."""
        log_odds = self.intercept + sum(weight * features[name] for name, weight in self.weights.items())
        return round(1.0 / (1.0 + math.exp(-min(max(log_odds, -30.0), 30.0))), 3)


class Bars(Record):
    """Least confidence that is sure enough.

    Attributes:
        frame: of up and front. plan: of all parts together. front: of a door or drawer behind which is built.
    """

    frame: Annotated[float, Field(ge=0, le=1)]
    plan: Annotated[float, Field(ge=0, le=1)]
    front: Annotated[float, Field(ge=0, le=1)]


class ConfidenceModel(Record):
    """What turns the confidences of the code into shares of cases that are right.

    Attributes:
        frame, part: curves of the guesses of the axes, and of one part with its joint.
        kinds: curves of parts of one kind, of kinds with enough examples; `part` is for all others.
        plan: weights of all parts together.
        bars: below them a person has to look.
    """

    frame: Curve
    part: Curve
    kinds: dict[str, Curve]
    plan: Weights
    bars: Bars

    def part_at(self, kind: str, confidence: float) -> float:
        """Return the share of parts of a kind that is right at a confidence."""
        return self.kinds.get(kind, self.part).at(confidence)
