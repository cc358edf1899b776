"""Follow each way of splitting a mesh into fragments to a plan of moving parts, and choose the best plan."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.infer import articulate_fragments
from casa_assets.articulate.plan import Articulation, Frame, Models, PartKind
from casa_assets.articulate.segment.fragments import measure_fragments, render_sides
from casa_assets.articulate.segment.segmentations import Segmentation, segmentations
from casa_assets.articulate.segment.shell_segments import Fragmentation, fragment_mesh
from casa_assets.articulate.segment.welded_mesh import WeldedMesh

# What a part counts for is its confidence less this, and a plan that is not the first has to be better by this much.
# Fitted on bench, track and own cases (benchmarks/articulate/ways.py --margins).
LEAST_CONFIDENCE, MIN_ADVANTAGE = 0.3, 0.5
# The same over a first plan without any part: one part that is rather sure is enough. A choice.
MIN_ADVANTAGE_OVER_NOTHING = 0.25
# Parts of two plans are the same where this share of their surface is. A choice.
MIN_SAME_SURFACE = 0.9


@dataclass(frozen=True)
class Plan:
    """The moving parts found if a mesh is split in one way."""

    way: Segmentation
    fragmentation: Fragmentation
    articulation: Articulation

    @property
    def score(self) -> float:
        """Return the sum of how much surer than not at all its parts are."""
        return plan_score([part.confidence for part in self.articulation.parts])


def choose_plan(mesh: WeldedMesh, frame: Frame, category: str = "", models: Models | None = None) -> Plan:
    """Return the plan of a mesh in its frame that has clearly more parts that are probably right; else the first.

    Where the welded fragments say the same, theirs is returned.

    Args:
        mesh: z up, the front faces -y, a diagonal of 1, the middle at the origin.
        category: id of a category where it is known, empty otherwise.
        models: what was learned from labelled cases; None to go by rules alone.
    """
    plans = candidate_plans(mesh, frame, category, models)
    advantage = needed_advantage(len(plans[0].articulation.parts))
    best = plans[best_score([plan.score for plan in plans], advantage)]
    # What is cut off needlessly may go with the wrong part: the rim of an oven with its door.
    whole = (p for p in plans if p.way is Segmentation.WELDED and _is_the_same(mesh, p.articulation, best.articulation))
    return next(whole, best)


def plan_score(confidences: Iterable[float], least: float = LEAST_CONFIDENCE) -> float:
    """Return the score of a plan whose parts have these confidences."""
    return sum(confidence - least for confidence in confidences)


def needed_advantage(parts_of_first: int) -> float:
    """Return by how much a plan has to be better than the first one, which has this many parts."""
    return MIN_ADVANTAGE if parts_of_first else MIN_ADVANTAGE_OVER_NOTHING


def best_score(scores: Sequence[float], advantage: float = MIN_ADVANTAGE) -> int:
    """Return the index of the plan to take: the best one if it is better than the first by `advantage`."""
    best = max(range(len(scores)), key=lambda k: round(scores[k], 9))
    return best if scores[best] > scores[0] + advantage else 0


def candidate_plans(mesh: WeldedMesh, frame: Frame, category: str = "", models: Models | None = None) -> list[Plan]:
    """Return the plan of each way to split a mesh, the one that is right most often first."""
    images = render_sides(mesh)
    controls = None if models is None else models.controls
    found = []
    for way, labels in segmentations(mesh).items():
        fragmentation = fragment_mesh(mesh, labels, models)
        measured = measure_fragments(mesh, fragmentation.labels, images=images)
        articulation = articulate_fragments(measured, frame, category, controls, fragmentation.fronts)
        if way in (Segmentation.CREASES, Segmentation.HOLES) and not _has_whole_lids(mesh, articulation):
            continue
        found.append(Plan(way, fragmentation, articulation))
    # The creases of a fused shell are seams of its fronts as well: they are no better than the other ways.
    is_shell = any(p.fragmentation.shell is not None for p in found if p.way is Segmentation.WELDED)
    # In the skin of a grid of cubes every step is a crease, and every thing that stands out leaves a hole.
    late = (Segmentation.CREASES, Segmentation.HOLES) if mesh.cell > 0.0 else (Segmentation.CREASES,)
    return sorted(found, key=lambda p: p.way in late) if is_shell else found


def _is_the_same(mesh: WeldedMesh, one: Articulation, other: Articulation) -> bool:
    """Return whether two plans have parts of the same kinds, each of nearly the same surface."""
    if [p.kind for p in one.parts] != [p.kind for p in other.parts]:
        return False
    for a, b in zip(one.parts, other.parts, strict=True):
        both = float(mesh.areas[np.intersect1d(a.faces, b.faces)].sum())
        if both < MIN_SAME_SURFACE * float(mesh.areas[np.union1d(a.faces, b.faces)].sum()):
            return False
    return True


def _has_whole_lids(mesh: WeldedMesh, articulation: Articulation) -> bool:
    """Return whether no lid is cut out of what is welded, as the lining of a mug would be."""
    label = mesh.fragment_labels
    count = np.bincount(label[label >= 0])
    for part in articulation.parts:
        if part.kind is PartKind.LID:
            mine = label[part.faces]
            used = np.bincount(mine[mine >= 0], minlength=len(count))
            if ((used > 0) & (used < count)).any():
                return False
    return True
