"""Choose the plan that is most probably right among all that were followed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.plan import Articulation, Frame, Models, PlanModels
from casa_assets.articulate.search.plan_features import measure_plans, whole_features
from casa_assets.articulate.search.plans import Plan, follow_plans
from casa_assets.articulate.segment.fragments import WeldedMesh
from casa_assets.articulate.segment.segmentations import Segmentation
from casa_assets.core.numeric import Floats

# Parts of two plans are the same where this share of their surface is. A choice.
MIN_SAME_SURFACE = 0.9
# Of a shell a part counts for its confidence less the first of these; a plan that is not the first has to be better by
# the second, and over a first plan without any part by the third. Choices.
LEAST_CONFIDENCE, MIN_ADVANTAGE, MIN_ADVANTAGE_OVER_NOTHING = 0.3, 0.5, 0.25
# How much the value of plans counts against the looks of frames. A choice.
LEAST_VALUE, VALUE_POWER = 0.02, 2.0


@dataclass(frozen=True)
class Choice:
    """The plan that was chosen.

    Attributes:
        value: how right it is expected to be, 0..1: the mean of F1 by surface, and by all that is right of a part.
        parts: (P,) probability that each part is right. frame_confidence: of its frame against the others.
    """

    plan: Plan
    value: float
    parts: Floats
    frame_confidence: float


def choose_plan(
    mesh: WeldedMesh, frames: Sequence[Frame], category: str, models: Models, plan_models: PlanModels
) -> Choice:
    """Return the plan that is expected to be most right; of a shell the one whose parts are together the surest.

    Where the welded fragments of the same frame say the same, theirs is returned.

    Args:
        mesh: file axes and units. frames: the likeliest first. category: id where it is known, empty otherwise.
        models, plan_models: what was learned from labelled cases.
    """
    plans = follow_plans(mesh, frames, category, models)
    measures = measure_plans(plans)
    chances = [_chances(plan_models, m.parts) for m in measures]
    rows = np.array([whole_features(m, c) for m, c in zip(measures, chances, strict=True)])
    values = plan_models.plans.probabilities(rows)[:, 1]
    is_shell = any(p.fragmentation.shell is not None for p in plans if p.way is Segmentation.WELDED)
    order = sorted(range(len(plans)), key=lambda k: (-round(float(values[k]), 9), k))
    # Forests that also learned from shells chose worse (benchmarks/train/plans.py).
    best = _surest_by_sum(plans) if is_shell else order[0]
    # What is cut off needlessly may go with the wrong part: the rim of an oven with its door.
    for k in order:
        plan = plans[k]
        is_welded = plan.way is Segmentation.WELDED and plan.frame is plans[best].frame
        if is_welded and _is_the_same(mesh, plan.articulation, plans[best].articulation):
            best = k
            break
    likely = list({id(p.frame): p.frame for p in plans}.values())
    goods = [max(float(v) for p, v in zip(plans, values, strict=True) if p.frame is f) for f in likely]
    sure = frame_confidences([f.confidence for f in likely], goods)
    mine = next(k for k, f in enumerate(likely) if f is plans[best].frame)
    return Choice(plans[best], float(values[best]), chances[best], float(sure[mine]))


def _surest_by_sum(plans: Sequence[Plan]) -> int:
    """Return the index of the plan of the likeliest frame, no kind assumed, whose parts are together the surest."""
    first = [k for k, p in enumerate(plans) if p.frame is plans[0].frame and not p.hypothesis.kind]
    if any(plans[k].fragmentation.shell is not None for k in first if plans[k].way is Segmentation.WELDED):
        # Seams of fronts are creases of a shell as well, and in a skin of cubes every step is one: no reason to split.
        is_skin = plans[0].measured.mesh.cell > 0.0
        late = (Segmentation.CREASES, Segmentation.HOLES) if is_skin else (Segmentation.CREASES,)
        first.sort(key=lambda k: plans[k].way in late)
    sums = [sum(part.confidence - LEAST_CONFIDENCE for part in plans[k].articulation.parts) for k in first]
    best = max(range(len(first)), key=lambda k: round(sums[k], 9))
    needed = MIN_ADVANTAGE if plans[first[0]].articulation.parts else MIN_ADVANTAGE_OVER_NOTHING
    return first[best] if sums[best] > sums[0] + needed else first[0]


def frame_confidences(guessed: Sequence[float], values: Sequence[float]) -> Floats:
    """Return the share of each frame in what speaks for all: confidence by looks times the value of its best plan."""
    weights = np.maximum(guessed, 1e-3) * (np.asarray(values) + LEAST_VALUE) ** VALUE_POWER
    found: Floats = weights / weights.sum()
    return found


def _chances(models: PlanModels, parts: Floats) -> Floats:
    return models.parts.probabilities(parts)[:, 1] if len(parts) else np.zeros(0)


def _is_the_same(mesh: WeldedMesh, one: Articulation, other: Articulation) -> bool:
    """Return whether two plans have parts of the same kinds that move alike, each of nearly the same surface."""
    if [(p.kind, p.joint.edge) for p in one.parts] != [(p.kind, p.joint.edge) for p in other.parts]:
        return False
    for a, b in zip(one.parts, other.parts, strict=True):
        both = float(mesh.areas[np.intersect1d(a.faces, b.faces)].sum())
        if both < MIN_SAME_SURFACE * float(mesh.areas[np.union1d(a.faces, b.faces)].sum()):
            return False
    return True
