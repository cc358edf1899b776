"""What is found in a mesh that is split in one way only, without anything learned from labelled cases."""

from __future__ import annotations

from casa_assets.articulate.infer import articulate_fragments
from casa_assets.articulate.plan import Articulation, Frame
from casa_assets.articulate.segment.fragments import measure_fragments
from casa_assets.articulate.segment.shell_segments import Fragmentation


def articulate_fragmentation(fragmentation: Fragmentation, frame: Frame, category: str = "") -> Articulation:
    """The moving parts of a mesh in its frame, which is split into these fragments."""
    measured = measure_fragments(fragmentation.mesh, fragmentation.labels)
    return articulate_fragments(measured, frame, category, known=fragmentation.fronts)
