"""decisions.yaml: the decisions on an articulated mesh, for a person to read, edit and give back."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from casa_assets import registry
from casa_assets.articulate.decisions import Decisions, Direction, PartDecision, axis_word
from casa_assets.articulate.plan import Cavity, InteriorKind, PartKind, PartPlan
from casa_assets.articulate.run.build import NAMING_CONFIDENCE, ArticulateResult
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.parts import JointKind

DECISIONS_NAME = "decisions.yaml"
# Fields of a decision that cannot be told from the plan that was made with it.
_NOT_IN_PLAN = ("flip", "axis", "anchor_m", "box_m")
_HEAD = """\
# What was decided on {name}. Change a line and run again with `--decisions {file}`; a line that is left out is guessed.
#   hinge: left, right, top or bottom, seen by who stands before it.   kind: {kinds}
#   A part can also have: remove: true | merge: <part that it is a piece of> | flip: true (opens the other way) |
#   on: <part or body> | endless: true | axis: +z | anchor_m: [x, y, z]
#   decision: accept (it leaves review as it is) or reject.
#   cavities: the space behind a door or in a drawer. build: true | false   interior: {interiors}
#   A part that was missed: a new name with kind and box_m: [[x, y, z], [x, y, z]], two corners in metres of all that
#   belongs to it (x right, y back, z up, origin under the middle).
"""


def read_decisions(path: Path) -> Decisions:
    """Read a decisions.yaml. Raises RegistryError with file and line where it is invalid."""
    document = registry.read_document(path)
    return registry.read_record(Decisions, document.value, document, ())


def text(built: ArticulateResult, given: Decisions) -> str:
    """Return the decisions.yaml of a mesh, with confidence and next likely choice as comments.

    Args:
        given: decisions that it was built with; what of them the result does not show is repeated.
    """
    frame = built.articulation.frame
    up, front = (frame.direction_to_file(v) for v in ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0)))
    kinds, interiors = ", ".join(PartKind), ", ".join(InteriorKind)
    name = built.source.path or "the mesh"
    lines = [_HEAD.format(name=name, file=DECISIONS_NAME, kinds=kinds, interiors=interiors)]
    lines += [] if given.decision is None else [f"decision: {given.decision.value}"]
    # A guess that is not sure is not repeated as if somebody had said so.
    mark = "" if built.confidence[0] >= NAMING_CONFIDENCE else "# "
    lines.append(_row(f"{mark}category", built.category.id, built.confidence))
    mark = "" if frame.confidence >= registry.load_confidence().bars.frame else "# "
    lines.append(_row(f"{mark}up", _axis(axis_word(up)), (frame.confidence, frame.reason), frame.runner_up))
    lines.append(_row(f"{mark}front", _axis(axis_word(front)), (frame.confidence, frame.reason)))
    lines.append(_row("size_m", f"{built.longest_m:.6g}", built.size))
    shown = [part for part in built.articulation.parts if not part.added]
    lines += [f"# No part was found, but {sign}." for sign in built.articulation.signs]
    lines.append("parts:" if shown or given.parts else "parts: {}")
    for part in shown:
        lines += _part(part, frame.metres or 1.0) + _given_fields(given.parts.get(part.name), _NOT_IN_PLAN)
    for name in sorted(given.parts.keys() - {part.name for part in shown}):
        if given.parts[name].taken_by is not None:
            lines += [f"  {name}:", *_given_fields(given.parts[name], ("remove", "merge", "kind", "box_m"))]
    lines += ["cavities:"] if built.articulation.cavities else []
    for cavity in built.articulation.cavities:
        lines += _cavity(cavity, frame.metres or 1.0, built.placed.footprint_center)
    return "\n".join(lines) + "\n"


def _part(part: PartPlan, metres: float) -> list[str]:
    joint = part.joint
    lines = [_row(f"  {part.name}", "", (part.confidence, part.reason)), f"    kind: {part.kind.value}"]
    if part.parent:
        lines.append(f"    on: {part.parent}")
    if joint.edge is not None:
        # The confidence of a part is that of its joint too, and is in the line of the part.
        lines.append(_line("    hinge", joint.edge.value, _comment(joint.reason, joint.runner_up)))
    if joint.kind is JointKind.SLIDE:
        lines.append(f"    travel_m: {joint.range[1] * metres:.4f}")
    elif joint.endless:
        lines.append("    endless: true")
    else:
        lines.append(f"    opens_deg: {math.degrees(joint.range[1]):.1f}")
    return lines


def _given_fields(given: PartDecision | None, names: Sequence[str]) -> list[str]:
    """Return the lines of those fields of a part that a person gave."""
    stated = {} if given is None else given.model_dump(mode="json", exclude_defaults=True)
    return [f"    {name}: {json.dumps(stated[name])}" for name in names if name in stated]


def _cavity(cavity: Cavity, metres: float, origin: Floats) -> list[str]:
    """Return the lines of the interior behind a front, built or the mesh's own."""
    box = [(np.array(c) - origin) * metres for c in (cavity.lower, cavity.upper)]
    words = ", ".join("[" + ", ".join(f"{v:.4f}" for v in c) + "]" for c in box)
    return [
        _row(f"  {cavity.parts[0]}", "", (cavity.confidence, cavity.reason)),
        f"    {'# ' if cavity.in_doubt else ''}build: {str(cavity.built).lower()}",
        f"    interior: {cavity.interior.value}",
        f"    furnish: {str(cavity.furnish).lower()}",
        f"    box_m: [{words}]",
    ]


def _axis(word: Direction) -> str:
    """Return a quoted axis: YAML reads a bare `+y` as text, but some editors do not."""
    return f'"{word}"' if isinstance(word, str) else "[" + ", ".join(f"{c:.9g}" for c in word) + "]"


def _row(key: str, value: str, confidence: tuple[float, str], other: str = "") -> str:
    """Return one line with its confidence as a comment."""
    share, reason = confidence
    why = _comment(reason, other)
    return _line(key, value, f"{share:.0%} sure: {why}" if why else f"{share:.0%} sure")


def _comment(reason: str, other: str) -> str:
    """Return the reason of a decision and the next likely choice, as far as there are any."""
    return "; else ".join(words for words in (reason, other) if words)


def _line(key: str, value: str, comment: str) -> str:
    """Return one line of the file; a comment of several lines is put into one."""
    row, words = f"{key}: {value}".rstrip(), " ".join(comment.split())
    return f"{row}  # {words}" if words else row
