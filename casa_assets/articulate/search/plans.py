"""Follow a mesh to a plan in each likely frame, for each way to split it, and under each likely kind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.infer import KindHypothesis, articulate_by_kind
from casa_assets.articulate.plan import Articulation, Frame, Models, PartKind
from casa_assets.articulate.segment.fragments import (
    MeasuredFragments,
    WeldedMesh,
    measure_fragments,
    render_sides,
)
from casa_assets.articulate.segment.segmentations import Segmentation, segmentations
from casa_assets.articulate.segment.shell_segments import Fragmentation, fragment_mesh
from casa_assets.core.numeric import Ints

# Kinds that are tried beside none, for each frame and way of splitting.
MAX_KINDS = 4
# Frames that are less likely than this are not followed: hardly any of them was right (benchmarks/train/plans.py).
MIN_FRAME_CONFIDENCE = 0.08


@dataclass(frozen=True)
class Plan:
    """The moving parts that were found in one frame, with the mesh split in one way and one kind assumed.

    Attributes:
        measured: the fragments in that frame.
    """

    frame: Frame
    way: Segmentation
    fragmentation: Fragmentation
    measured: MeasuredFragments
    hypothesis: KindHypothesis

    @property
    def articulation(self) -> Articulation:
        """Return the parts."""
        return self.hypothesis.articulation


def follow_plans(mesh: WeldedMesh, frames: Sequence[Frame], category: str, models: Models) -> list[Plan]:
    """Return the plan of each frame, way and kind, those of the likeliest frame first.

    Args:
        mesh: file axes and units. frames: the likeliest first. category: id where it is known, empty otherwise.
    """
    likely = [f for f in frames[1:] if f.confidence >= MIN_FRAME_CONFIDENCE]
    out: list[Plan] = []
    ways: dict[Segmentation, Ints] = {}
    for frame in (*frames[:1], *likely):
        placed = mesh.in_frame(frame)
        # Frames differ by quarter turns, which no way of splitting sees.
        ways = ways or segmentations(placed)
        out += _plans_in_frame(placed, frame, ways, category, models)
    return out


def _plans_in_frame(
    mesh: WeldedMesh, frame: Frame, ways: dict[Segmentation, Ints], category: str, models: Models
) -> list[Plan]:
    images = render_sides(mesh)
    found: list[Plan] = []
    for way, labels in ways.items():
        fragmentation = fragment_mesh(mesh, labels, models)
        measured = measure_fragments(mesh, fragmentation.labels, images=images)
        hypotheses = articulate_by_kind(
            measured, frame, category, models.controls, fragmentation.fronts, 0 if category else MAX_KINDS
        )
        for hypothesis in hypotheses:
            if way in (Segmentation.CREASES, Segmentation.HOLES) and not has_whole_lids(mesh, hypothesis.articulation):
                continue
            found.append(Plan(frame, way, fragmentation, measured, hypothesis))
    return found


def has_whole_lids(mesh: WeldedMesh, articulation: Articulation) -> bool:
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
