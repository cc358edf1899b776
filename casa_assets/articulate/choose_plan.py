"""Follow each way of splitting a mesh into fragments to a plan of moving parts, and choose the best plan."""

from __future__ import annotations

from dataclasses import dataclass

from casa_assets.articulate.infer import articulate_fragments
from casa_assets.articulate.models import Models
from casa_assets.articulate.plan import Articulation, Frame
from casa_assets.articulate.segment.fragment_measures import measure_fragments, render_sides
from casa_assets.articulate.segment.segmentations import Segmentation, segmentations
from casa_assets.articulate.segment.shell_segments import Fragmentation, fragment_mesh
from casa_assets.articulate.segment.welded_mesh import WeldedMesh


@dataclass(frozen=True)
class Plan:
    """What would move if a mesh were split in one way.

    Attributes:
        way: of splitting. fragmentation: the fragments. articulation: the parts found.
    """

    way: Segmentation
    fragmentation: Fragmentation
    articulation: Articulation

    @property
    def expected_parts(self) -> float:
        """Return how many parts are probably right: the sum of their confidences."""
        return sum(part.confidence for part in self.articulation.parts)


def choose_plan(mesh: WeldedMesh, frame: Frame, category: str = "", models: Models | None = None) -> Plan:
    """Return the plan of a mesh in its frame with the most parts that are probably right; of equal ones the first.

    Args:
        mesh: z up, the front faces -y, a diagonal of 1, the middle at the origin.
        category: id of a category where it is known, empty otherwise.
        models: what was learned from labelled cases; None to go by rules alone.
    """
    return max(candidate_plans(mesh, frame, category, models), key=lambda p: round(p.expected_parts, 9))


def candidate_plans(mesh: WeldedMesh, frame: Frame, category: str = "", models: Models | None = None) -> list[Plan]:
    """Return the plan of each way to split a mesh."""
    images = render_sides(mesh)
    controls = None if models is None else models.controls
    found = []
    for way, labels in segmentations(mesh).items():
        fragmentation = fragment_mesh(mesh, labels, models)
        measured = measure_fragments(mesh, fragmentation.labels, images=images)
        articulation = articulate_fragments(measured, frame, category, controls, fragmentation.fronts)
        found.append(Plan(way, fragmentation, articulation))
    return found
