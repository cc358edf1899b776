"""User decisions on a mesh, which override guesses: decisions.yaml, its records, and their application."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AfterValidator, AliasChoices, Field, model_validator

from casa_assets.articulate.fronts.joints import DRAWER_TRAVEL_SHARE, hinge_joint
from casa_assets.articulate.fronts.panels import Panel
from casa_assets.articulate.plan import (
    Articulation,
    Cavity,
    HingeEdge,
    InteriorKind,
    JointPlan,
    PartKind,
    PartPlan,
    hinge,
    slide,
    to_vec3,
)
from casa_assets.articulate.segment.fragments import WeldedMesh
from casa_assets.articulate.segment.orthographic import FRONT, SIDES, TOP
from casa_assets.core.numeric import Floats
from casa_assets.errors import CasaError, UnknownId
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.record import Id, Record, Vec3
from casa_assets.model.source import Word

Angle = Annotated[float, Field(gt=0, le=360)]
Length = Annotated[float, Field(gt=0, le=3)]
BODY = "body"
GIVEN_REASON = "given in the decisions"
_GIVEN: Mapping[str, Any] = {"confidence": 1.0, "reason": GIVEN_REASON}
# Values of decisions.yaml that differ by less are the guessed ones, rounded for reading.
ANGLE_TOLERANCE_DEG, LENGTH_TOLERANCE_M = 0.06, 6e-5
# A piece that reaches no farther than this over the edges of a front, diagonals, leaves its hinge; a choice.
PIECE_TOLERANCE = 0.006
KNOB_RANGE_RAD, BUTTON_TRAVEL, LEVER_RANGE = 2 * math.pi, 0.004, math.pi / 2
_AXES = "xyz"
DECISIONS_NAME = "decisions.yaml"
# Fields of a decision that the plan that was made with it does not show.
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


def parse_direction(word: str | Vec3) -> Vec3:
    """Return a unit vector from `+z`, `-y`, `x` or three numbers. Raises ValueError."""
    if isinstance(word, str):
        name = word.lstrip("+-").lower()
        if len(name) != 1 or name not in _AXES or len(word) > 2:
            raise ValueError(f"{word!r} is none of +x, -x, +y, -y, +z, -z")
        sign = -1.0 if word.startswith("-") else 1.0
        x, y, z = (sign if a == name else 0.0 for a in _AXES)
        return (x, y, z)
    norm = math.sqrt(sum(c * c for c in word))
    if norm < 1e-9:
        raise ValueError("three zeros are no direction")
    return (word[0] / norm, word[1] / norm, word[2] / norm)


def _known(word: str | Vec3) -> str | Vec3:
    if isinstance(word, str):
        parse_direction(word)
    return word


Direction = Annotated[str | Vec3, AfterValidator(_known)]


def axis_word(vector: Vec3) -> Direction:
    """Return the shortest spelling of a direction that `parse_direction` reads back."""
    for i, name in enumerate(_AXES):
        if abs(abs(vector[i]) - 1.0) < 1e-6:
            return ("+" if vector[i] > 0 else "-") + name
    return vector


class PartDecision(Record):
    """User decision on one part; fields that are left out keep what was found.

    Attributes:
        remove: it does not move, and stays with what carries it.
        merge: part that it is a piece of and moves with, or `body`.
        kind: what it is. hinge: the side that it hinges on, for a door or a lid.
        flip: it opens the other way: turned or moved in the opposite direction about or along the same axis.
        opens_deg, travel_m: how far it goes. endless: it turns round and round.
        on: part that carries it, or `body`.
        axis: such as `+z`, or three numbers, asset frame; the way that it slides, or turns right-handed about.
        anchor_m: a point of the axis of a hinge, metres, asset frame (origin under the middle).
        box_m: two corners, metres, asset frame: all that lies in it is the part. For parts that were not found.
    """

    remove: bool = False
    merge: Id | None = None
    kind: PartKind | None = None
    hinge: HingeEdge | None = None
    flip: bool = False
    opens_deg: Angle | None = None
    travel_m: Length | None = None
    endless: bool | None = None
    on: Id | None = None
    axis: Direction | None = None
    anchor_m: Vec3 | None = None
    box_m: tuple[Vec3, Vec3] | None = None

    @model_validator(mode="after")
    def _sound(self) -> Self:
        """Raise ValueError for a box without a kind, and for a part that is removed and merged."""
        if self.box_m is not None and self.kind is None:
            raise ValueError("a part that is given by a box needs a kind")
        if self.remove and self.merge is not None:
            raise ValueError("a part is removed or merged, not both")
        return self

    @property
    def taken_by(self) -> str | None:
        """Return the part that gets its faces, empty for the link that carries it; None if it stays a part."""
        return "" if self.remove else self.merge


class CavityDecision(Record):
    """User decision on the cavity behind a door or in a drawer; fields that are left out keep what was found.

    Attributes:
        build: walls and what belongs in are built; else it stays as the mesh has it.
        interior: what it is furnished as; `filling` in older files. furnish: shelves, racks or a turntable come in.
        box_m: two corners of the space inside its walls, metres, asset frame.
    """

    build: bool | None = None
    interior: InteriorKind | None = Field(default=None, validation_alias=AliasChoices("interior", "filling"))
    furnish: bool | None = None
    box_m: tuple[Vec3, Vec3] | None = None


class Decisions(Record):
    """The decisions.yaml of one mesh.

    Attributes:
        decision: accept the asset as decided here, or reject it; None: neither.
        category: id in the registry. up, front: such as `+y`, or three numbers, axes of the file.
        size_m: longest side, metres.
        parts: by name.
        cavities: by the name of the part that closes each, the left one of two; `rooms` in older files.
    """

    decision: Word | None = None
    category: Id | None = None
    up: Direction | None = None
    front: Direction | None = None
    size_m: Annotated[float, Field(gt=0, le=10)] | None = None
    parts: dict[Id, PartDecision] = Field(default_factory=dict)
    cavities: dict[Id, CavityDecision] = Field(default_factory=dict, validation_alias=AliasChoices("cavities", "rooms"))


def apply_decisions(articulation: Articulation, mesh: WeldedMesh, decisions: Decisions) -> Articulation:
    """Return the articulation with the user's decisions on its parts applied.

    Args:
        articulation: as inferred, with `frame.metres` set. mesh: in the frame.
    Raises:
        UnknownId: a part is named that was not found and is not given by a box either.
        CasaError: nothing lies in a box, or parts are merged in a circle.
    """
    names = [p.name for p in articulation.parts]
    for name, decision in decisions.parts.items():
        if name not in names and decision.box_m is None:
            raise UnknownId("part", name, names)
    parts = [_apply_decision(p, decisions.parts.get(p.name), mesh, articulation) for p in articulation.parts]
    new = [_new_part(n, w, mesh, articulation) for n, w in decisions.parts.items() if n not in names and not w.remove]
    if new:
        taken = np.unique(np.concatenate([p.faces for p in new]))
        parts = [
            p.replace(faces=np.setdiff1d(p.faces, taken), grip=np.setdiff1d(p.grip, taken)) if len(taken) else p
            for p in parts
        ]
    all_parts = [p for p in (*parts, *new) if len(p.faces)]
    carriers = {p.name for p in all_parts}
    for part in all_parts:
        if part.parent and part.parent not in carriers and part.parent not in names:
            raise UnknownId("part", part.parent, sorted(carriers))
    all_parts = [p if p.parent in carriers else p.replace(parent="") for p in all_parts]
    return articulation.replace(parts=tuple(_with_pieces(all_parts, decisions, mesh)))


def _with_pieces(parts: list[PartPlan], decisions: Decisions, mesh: WeldedMesh) -> list[PartPlan]:
    """Return the parts that stay, with the faces of those that are removed or merged into them."""
    by_name = {p.name: p for p in parts}
    taken_by: dict[str, str] = {}
    for part in parts:
        decision = decisions.parts.get(part.name)
        if decision is None or (taker := decision.taken_by) is None:
            continue
        if taker not in ("", BODY, *by_name):
            raise UnknownId("part", taker, sorted(by_name))
        taken_by[part.name] = "" if taker == BODY else taker or part.parent

    def taker_of(name: str) -> str:
        passed: list[str] = []
        while name in taken_by:
            if name in passed:
                raise CasaError(f"parts are merged in a circle: {', '.join(passed)}")
            passed.append(name)
            name = taken_by[name]
        return name

    pieces: dict[str, list[PartPlan]] = {}
    for name in taken_by:
        pieces.setdefault(taker_of(name), []).append(by_name[name])
    return [
        _with_faces_of(p.replace(parent=taker_of(p.parent)), pieces.get(p.name, []), mesh)
        for p in parts
        if p.name not in taken_by
    ]


def _with_faces_of(part: PartPlan, pieces: list[PartPlan], mesh: WeldedMesh) -> PartPlan:
    """Return a part with the faces of its pieces; its hinge moves to the edge of the panel that they make together."""
    if not pieces:
        return part
    whole = part.replace(
        faces=np.unique(np.concatenate([p.faces for p in (part, *pieces)])),
        grip=np.unique(np.concatenate([p.grip for p in (part, *pieces)])),
        **_GIVEN,
    )
    if part.joint.edge is None:
        return whole
    before, after = (np.stack(_panel_box(p, mesh)) for p in (part, whole))
    in_plane = [0, 1] if part.kind is PartKind.LID else [0, 2]
    if np.abs(after - before)[:, in_plane].max() <= PIECE_TOLERANCE:
        return whole
    moved = _default_hinge(part.joint.edge, part.kind, *after)
    return whole.replace(joint=moved.replace(range=part.joint.range))


def _new_part(name: str, decision: PartDecision, mesh: WeldedMesh, articulation: Articulation) -> PartPlan:
    """Return a part made of all fragments that lie within a box."""
    assert decision.box_m is not None
    assert decision.kind is not None
    lower, upper = (_to_frame(np.array(c), mesh, articulation) for c in decision.box_m)
    lower, upper = np.minimum(lower, upper) - 1e-4, np.maximum(lower, upper) + 1e-4
    label = mesh.fragment_labels
    corners = mesh.points[mesh.faces]
    outside = ((corners < lower) | (corners > upper)).any(axis=(1, 2))
    crossing = np.unique(label[outside])
    faces = np.flatnonzero(~np.isin(label, crossing) & (label >= 0))
    if not len(faces):
        raise CasaError(f"part {name!r}: nothing lies whole within box_m; it is in metres, origin under the middle")
    part = PartPlan(
        name=name,
        kind=decision.kind,
        faces=faces,
        grip=faces[:0],
        # Replaced before it is used.
        joint=slide((0.0, -1.0, 0.0), (0.0, 0.0, 0.0), 1.0),
        **_GIVEN,
    )
    joint = _default_joint(decision.kind, decision.hinge, part, mesh)
    return _apply_decision(part.replace(joint=joint), decision.replace(hinge=None), mesh, articulation)


def _apply_decision(
    part: PartPlan, decision: PartDecision | None, mesh: WeldedMesh, articulation: Articulation
) -> PartPlan:
    if decision is None:
        return part
    joint, changed = part.joint, part
    kind = decision.kind or part.kind
    if kind is not part.kind or (decision.hinge is not None and decision.hinge is not joint.edge):
        joint = _default_joint(kind, decision.hinge or joint.edge, part, mesh)
    metres = articulation.frame.metres or 1.0
    if decision.axis is not None:
        axis = parse_direction(decision.axis)
        if float(np.dot(axis, joint.axis)) < 1 - 1e-9:
            joint = joint.replace(axis=axis, edge=None, **_GIVEN)
    if decision.anchor_m is not None:
        anchor = _to_frame(np.array(decision.anchor_m), mesh, articulation)
        if float(np.linalg.norm(anchor - np.array(joint.anchor))) * metres > LENGTH_TOLERANCE_M:
            joint = joint.replace(anchor=to_vec3(anchor), edge=None, **_GIVEN)
    joint = _with_range(joint, decision, metres)
    if decision.endless is not None and joint.kind is JointKind.HINGE and decision.endless is not joint.endless:
        span = (0.0, KNOB_RANGE_RAD) if decision.endless else joint.range
        joint = joint.replace(endless=decision.endless, range=span, **_GIVEN)
    if decision.flip:
        x, y, z = joint.axis
        joint = joint.replace(axis=(-x, -y, -z), **_GIVEN)
    parent = part.parent if decision.on is None else "" if decision.on == BODY else decision.on
    if kind is not part.kind or parent != part.parent:
        changed = part.replace(kind=kind, parent=parent, **_GIVEN)
    return changed if joint is part.joint else changed.replace(joint=joint)


def _with_range(joint: JointPlan, decision: PartDecision, metres: float) -> JointPlan:
    if joint.kind is JointKind.SLIDE:
        if decision.travel_m is None or abs(decision.travel_m - joint.range[1] * metres) <= LENGTH_TOLERANCE_M:
            return joint
        return joint.replace(range=(0.0, decision.travel_m / metres), **_GIVEN)
    if decision.opens_deg is None or abs(decision.opens_deg - math.degrees(joint.range[1])) <= ANGLE_TOLERANCE_DEG:
        return joint
    return joint.replace(range=(0.0, math.radians(decision.opens_deg)), **_GIVEN)


def _default_joint(kind: PartKind, edge: HingeEdge | None, part: PartPlan, mesh: WeldedMesh) -> JointPlan:
    """Return the usual joint of a part of a kind at its place."""
    lower, upper = _panel_box(part, mesh)
    middle = to_vec3((lower + upper) / 2)
    if kind in (PartKind.DOOR, PartKind.LID):
        return _default_hinge(edge or (HingeEdge.TOP if kind is PartKind.LID else HingeEdge.LEFT), kind, lower, upper)
    if kind in (PartKind.DRAWER, PartKind.TRAY):
        joint = slide((0.0, -1.0, 0.0), middle, DRAWER_TRAVEL_SHARE * float(upper[1] - lower[1]))
    elif kind is PartKind.BUTTON:
        joint = slide((0.0, 1.0, 0.0), middle, BUTTON_TRAVEL)
    elif kind is PartKind.KNOB:
        joint = hinge((0.0, -1.0, 0.0), middle)
    else:
        joint = hinge((0.0, 0.0, 1.0) if kind is PartKind.SPOUT else (1.0, 0.0, 0.0), middle, (0.0, LEVER_RANGE))
    return joint.replace(**_GIVEN)


def _default_hinge(edge: HingeEdge, kind: PartKind, lower: Floats, upper: Floats) -> JointPlan:
    """Return a hinge along an edge of a panel between two corners of the frame."""
    side = TOP if kind is PartKind.LID else FRONT
    a, b = lower @ SIDES[side].T, upper @ SIDES[side].T
    return hinge_joint(Panel([], np.minimum(a, b), np.maximum(a, b)), edge, side).replace(**_GIVEN)


def hinge_at_face(part: PartPlan, mesh: WeldedMesh) -> JointPlan:
    """Return the hinge of a part with its axis in the plane of its face, as inset doors have it, not near its back."""
    lower, upper = _panel_box(part, mesh)
    x, y, z = part.joint.anchor
    reason = f"{part.joint.reason}; set in: the axis lies at its face"
    if part.kind is PartKind.LID:
        return part.joint.replace(anchor=(x, y, float(upper[2])), reason=reason)
    return part.joint.replace(anchor=(x, float(lower[1]), z), reason=reason)


def _panel_box(part: PartPlan, mesh: WeldedMesh) -> tuple[Floats, Floats]:
    """Return the (3,) lower and upper corner of a part without what a hand takes of it."""
    panel_faces = np.setdiff1d(part.faces, part.grip)
    points = mesh.points[mesh.faces[panel_faces if len(panel_faces) else part.faces].reshape(-1)]
    return points.min(axis=0), points.max(axis=0)


def _to_frame(point: Floats, mesh: WeldedMesh, articulation: Articulation) -> Floats:
    """Convert a point of the asset frame (metres, origin under the middle) to the frame of the analysis."""
    return point / (articulation.frame.metres or 1.0) + mesh.footprint_center


def decisions_text(
    name: str,
    articulation: Articulation,
    placed: WeldedMesh,
    category: tuple[str, float, str],
    size_m: tuple[float, float, str],
    given: Decisions,
    least_sure: tuple[float, float],
) -> str:
    """Return the decisions.yaml of a mesh, with confidence and next likely choice as comments.

    Args:
        name: of the mesh. placed: in the frame.
        category, size_m: what was chosen, how sure, and why.
        given: decisions that it was built with; what of them the result does not show is repeated.
        least_sure: a category and a frame that are less sure are not repeated as if somebody had stated them.
    """
    frame = articulation.frame
    up, front = (frame.direction_to_file(v) for v in ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0)))
    kinds, interiors = ", ".join(PartKind), ", ".join(InteriorKind)
    lines = [_HEAD.format(name=name, file=DECISIONS_NAME, kinds=kinds, interiors=interiors)]
    lines += [] if given.decision is None else [f"decision: {given.decision.value}"]
    marks = [
        "" if sure >= least else "# " for sure, least in zip((category[1], frame.confidence), least_sure, strict=True)
    ]
    lines.append(_row(f"{marks[0]}category", category[0], category[2], sure=category[1]))
    lines.append(_row(f"{marks[1]}up", _axis(axis_word(up)), frame.reason, frame.runner_up, frame.confidence))
    lines.append(_row(f"{marks[1]}front", _axis(axis_word(front)), frame.reason, sure=frame.confidence))
    lines.append(_row("size_m", f"{size_m[0]:.6g}", size_m[2], sure=size_m[1]))
    shown = [part for part in articulation.parts if not part.added]
    lines += [f"# No part was found, but {sign}." for sign in articulation.signs]
    lines.append("parts:" if shown or given.parts else "parts: {}")
    for part in shown:
        lines += _part(part, frame.metres or 1.0) + _given_fields(given.parts.get(part.name), _NOT_IN_PLAN)
    for missing in sorted(given.parts.keys() - {part.name for part in shown}):
        if given.parts[missing].taken_by is not None:
            lines += [f"  {missing}:", *_given_fields(given.parts[missing], ("remove", "merge", "kind", "box_m"))]
    lines += ["cavities:"] if articulation.cavities else []
    for cavity in articulation.cavities:
        lines += _cavity(cavity, frame.metres or 1.0, placed.footprint_center)
    return "\n".join(lines) + "\n"


def _part(part: PartPlan, metres: float) -> list[str]:
    joint = part.joint
    lines = [_row(f"  {part.name}", "", part.reason, sure=part.confidence), f"    kind: {part.kind.value}"]
    if part.parent:
        lines.append(f"    on: {part.parent}")
    if joint.edge is not None:
        # The confidence of a part is that of its joint too, and is in the line of the part.
        lines.append(_row("    hinge", joint.edge.value, joint.reason, joint.runner_up))
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
        _row(f"  {cavity.parts[0]}", "", cavity.reason, sure=cavity.confidence),
        f"    {'# ' if cavity.in_doubt else ''}build: {str(cavity.built).lower()}",
        f"    interior: {cavity.interior.value}",
        f"    furnish: {str(cavity.furnish).lower()}",
        f"    box_m: [{words}]",
    ]


def _axis(word: Direction) -> str:
    """Return a quoted axis: YAML reads a bare `+y` as text, but some editors do not."""
    return f'"{word}"' if isinstance(word, str) else "[" + ", ".join(f"{c:.9g}" for c in word) + "]"


def _row(key: str, value: str, reason: str, other: str = "", sure: float | None = None) -> str:
    """Return one line, with the reason and the next likely choice as a comment of one line, after the confidence."""
    words = " ".join("; else ".join(word for word in (reason, other) if word).split())
    if sure is not None:
        words = f"{sure:.0%} sure: {words}" if words else f"{sure:.0%} sure"
    row = f"{key}: {value}".rstrip()
    return f"{row}  # {words}" if words else row
