"""Calibrate the confidences of parts, and compute the probability that the parts of a mesh are all right."""

from __future__ import annotations

import math
from collections.abc import Mapping

from casa_assets.articulate.plan import Articulation, PartPlan
from casa_assets.model.registry.confidence import ConfidenceModel

# Confidence of what nobody had to guess.
CERTAIN = 1.0


def calibrate_parts(articulation: Articulation, model: ConfidenceModel) -> Articulation:
    """Return the articulation with the confidence of each part as the share of such parts that are right.

    A part is right where its surface, its type and its joint are, so its joint gets the same number.
    """
    return articulation.replace(parts=tuple(_calibrated(part, model) for part in articulation.parts))


def _calibrated(part: PartPlan, model: ConfidenceModel) -> PartPlan:
    """Return a part with one calibrated confidence for it and its joint."""
    confidence = model.part_at(part.kind.value, part_score(part))
    return part.replace(confidence=confidence, joint=part.joint.replace(confidence=confidence))


def part_score(part: PartPlan) -> float:
    """Return how sure the code is of a part together with its joint."""
    return min(part.confidence, part.joint.confidence)


def plan_confidence(articulation: Articulation, model: ConfidenceModel) -> float:
    """Return how likely it is that all parts of a mesh are right, or all but one small fault.

    Args:
        articulation: with calibrated confidences of frame and parts.
    """
    return model.plan.at(plan_features(articulation))


def plan_features(articulation: Articulation) -> Mapping[str, float]:
    """Return what the confidence of a plan is computed from; all but `log_count` are between 0 and 1."""
    own = [p.confidence for p in articulation.parts if not p.added] or [0.0]
    return {
        "weakest": min(own),
        "mean": sum(own) / len(own),
        "all_right": math.prod(own),
        "log_count": math.log(len(own)),
        "frame": articulation.frame.confidence,
        "named": float(bool(articulation.category)),
    }


def weakest_part(articulation: Articulation) -> PartPlan | None:
    """Return the part with the lowest confidence, ignoring added parts; None if there are no others."""
    own = [p for p in articulation.parts if not p.added]
    return min(own, key=lambda p: p.confidence) if own else None
