"""The strip of pictures of an articulated mesh: closed, coloured by part, taken apart, and parts open one by one.

It is no part of what is certified: it can be drawn later, and its absence changes no other file of the entry.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from casa_assets.articulate.plan import PartKind
from casa_assets.pipeline.process_name import process_name
from casa_assets.preview.strip import MovingJoint, joint_strip

if TYPE_CHECKING:
    from casa_assets.pipeline.articulate.run import ArticulateOutcome
    from casa_assets.pipeline.library.library import Library

NAME = "strip.png"
# Parts whose motion is too small to see, or that look the same all the way round, have no picture of their own.
_WITHOUT_PICTURE = frozenset({PartKind.KNOB, PartKind.BUTTON})


def write(outcome: ArticulateOutcome, folder: Path) -> None:
    """Draw the strip of an outcome into a folder that holds its model.

    Raises:
        CannotDraw, NoRenderer: no picture can be made of it, or on this machine.
    """
    (folder / NAME).write_bytes(joint_strip(folder / "model.xml", moving_joints(outcome), _heading(outcome)))


def is_missing(outcome: ArticulateOutcome) -> bool:
    """Return whether an entry that an earlier run made has moving parts and no strip."""
    return bool(outcome.travels) and outcome.folder is not None and not (outcome.folder / NAME).exists()


def add(outcome: ArticulateOutcome, library: Library) -> None:
    """Draw the strip of an entry that an earlier run made, and put it there by one rename. Raises as `write`."""
    assert outcome.folder is not None
    picture = joint_strip(outcome.folder / "model.xml", moving_joints(outcome), _heading(outcome))
    fresh = library.staging / f"{outcome.folder.name}.{process_name()}.png"
    fresh.write_bytes(picture)
    fresh.replace(outcome.folder / NAME)


def moving_joints(outcome: ArticulateOutcome) -> list[MovingJoint]:
    """Return the joints of the moving parts, in their order, with their captions."""
    found = []
    for part in outcome.articulation.parts if outcome.articulation is not None else ():
        joint, travel = part.joint, outcome.travels[part.name]
        how = joint.kind.value + (f" {joint.edge.value}" if joint.edge else "")
        other = f", else {joint.runner_up}" if joint.runner_up else ""
        message = f"{how}, {part.confidence:.0%} sure{other}" + (
            "" if travel.free_share >= 1.0 else f"; runs into {travel.blocked_by}"
        )
        found.append(MovingJoint(travel.joint, part.name, message, alone=part.kind not in _WITHOUT_PICTURE))
    return found


def _heading(outcome: ArticulateOutcome) -> str:
    """Return the heading of the strip."""
    assert outcome.articulation is not None
    frame = outcome.articulation.frame
    return f"{outcome.mesh}: {outcome.category}; frame {frame.confidence:.0%} sure"
