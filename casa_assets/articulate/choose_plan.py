"""Follow each way of splitting a mesh into fragments to a plan of moving parts, and choose the best plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.frame.axes import SCORE_WEIGHTS
from casa_assets.articulate.frame.score_candidate import SCORE_NAMES
from casa_assets.articulate.infer import articulate_fragments
from casa_assets.articulate.models import Models
from casa_assets.articulate.plan import Articulation, Frame
from casa_assets.articulate.plan_features import plan_features
from casa_assets.articulate.segment.fragment_measures import measure_fragments, render_sides
from casa_assets.articulate.segment.segmentations import Segmentation, segmentations
from casa_assets.articulate.segment.shell_segments import Fragmentation, fragment_mesh
from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.core.typing import Floats

# What a plan may be: mostly wrong; partly right; every part right, or all but one small fault.
GRADES = ("wrong", "partly", "right")
# Value of a grade when plans are compared.
_VALUES = (0.0, 0.5, 1.0)


@dataclass(frozen=True)
class Plan:
    """What would move if a mesh were split in one way.

    Attributes:
        way: of splitting. fragmentation: the fragments. articulation: the parts found.
        features: numbers of PLAN_FEATURES. guess_score: by the weights of the frame guess.
        chances: (3,) probability of each of GRADES, None where no forest told it.
    """

    way: Segmentation
    fragmentation: Fragmentation
    articulation: Articulation
    features: Floats
    guess_score: float
    chances: Floats | None = None

    @property
    def score(self) -> float:
        """Return how good it probably is; comparable between plans of one mesh only."""
        return self.guess_score if self.chances is None else plan_value(self.chances)


def plan_value(chances: Floats) -> float:
    """Return the expected value of a plan from the probabilities of GRADES."""
    return float(chances @ np.array(_VALUES))


def choose_plan(mesh: WeldedMesh, frame: Frame, category: str = "", models: Models | None = None) -> Plan:
    """Return the most plausible plan of a mesh in its frame; of equal ones the first in the order of Segmentation.

    Args:
        mesh: z up, the front faces -y, a diagonal of 1, the middle at the origin.
        category: id of a category where it is known, empty otherwise.
        models: what was learned from labelled cases; None to go by rules alone.
    """
    return max(candidate_plans(mesh, frame, category, models), key=lambda p: round(p.score, 9))


def candidate_plans(mesh: WeldedMesh, frame: Frame, category: str = "", models: Models | None = None) -> list[Plan]:
    """Return the plan of each way to split a mesh."""
    images = render_sides(mesh)
    weights = np.array([SCORE_WEIGHTS.get(name, 0.0) for name in SCORE_NAMES])
    controls = None if models is None else models.controls
    found = []
    for way, labels in segmentations(mesh).items():
        fragmentation = fragment_mesh(mesh, labels)
        measured = measure_fragments(mesh, fragmentation.labels, images=images)
        articulation = articulate_fragments(measured, frame, category, controls)
        features = plan_features(articulation, measured, way, fragmentation.shell is not None)
        forest = None if models is None else models.plans
        chances = None if forest is None else forest.probabilities(features[None])[0]
        if chances is not None:
            articulation = articulation.replace(chance=round(float(chances[GRADES.index("right")]), 3))
        guess = float(weights @ features[: len(SCORE_NAMES)])
        found.append(Plan(way, fragmentation, articulation, features, guess, chances))
    return found
