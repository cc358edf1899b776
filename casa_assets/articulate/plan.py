"""Records of an articulation: frame, moving parts, joints, learned models, and the confidence of each decision."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, Forest, significant
from casa_assets.model.asset.asset import Confidence
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.record import ArrayOf, Id, Record, Vec2, Vec3
from casa_assets.model.registry.rows import ConfidenceModel

# Lengths are in units of the analysed mesh, whose diagonal is 1; the frame maps them to the file and to metres.
FaceIndex = Annotated[npt.NDArray[np.int64], ArrayOf("int64", (-1,))]
Matrix3 = Annotated[npt.NDArray[np.float64], ArrayOf("float64", (3, 3))]
Cloud = Annotated[npt.NDArray[np.float64], ArrayOf("float64", (-1, 3))]


def to_vec3(values: Iterable[float]) -> Vec3:
    """Return three numbers, unrounded."""
    x, y, z = (float(v) for v in values)
    return (x, y, z)


def round7(value: float) -> float:
    """Round a number to seven significant digits."""
    return significant(float(value), 7)


def round7_vec3(values: Iterable[float]) -> Vec3:
    """Return three numbers rounded to seven significant digits; what is nearer to zero than 1e-9 becomes zero."""
    return to_vec3(round7(v) if abs(v) > 1e-9 else 0.0 for v in values)


def round_mm(value: float) -> float:
    """Round metres to a tenth of a millimetre."""
    return round(float(value), 4)


def round_mm_vec3(values: Iterable[float]) -> Vec3:
    """Round a point or a size, metres, to tenths of a millimetre."""
    return to_vec3(round_mm(v) for v in values)


@dataclass(frozen=True)
class Models:
    """Decision forests, used where rules decide less well.

    Attributes:
        controls: distinguishes knobs, keys and neither, from CONTROL_FEATURES.
        fronts_alone, fronts: decide whether a rectangle of a fused shell is a door or drawer, from FEATURES of
            fronts/front_hypotheses.py alone, and with CONTEXT.
    """

    controls: Forest
    fronts_alone: Forest
    fronts: Forest


@dataclass(frozen=True)
class PlanModels:
    """Decision forests by which a plan is chosen.

    Attributes:
        parts: probability that a part of a plan is right, from PART_FEATURES of search/plan_features.py.
        plans: expected quality of a plan, 0..1, from PLAN_FEATURES of the same module.
    """

    parts: Forest
    plans: Forest


class PartKind(StrEnum):
    """Type of a moving part; it decides how its joint moves."""

    DOOR = "door"
    DRAWER = "drawer"
    LID = "lid"
    KNOB = "knob"
    BUTTON = "button"
    LEVER = "lever"
    SPOUT = "spout"
    TRAY = "tray"


class HingeEdge(StrEnum):
    """Edge of a front that a hinge runs along, as seen by a person standing before it."""

    LEFT = "left"
    RIGHT = "right"
    TOP = "top"
    BOTTOM = "bottom"


class Frame(Record):
    """Transform from the axes of a file to ours: z up, x right, y back.

    Attributes:
        rotation: proper; `frame = rotation @ (file - origin) * scale`.
        origin: middle of the box round everything, file units.
        scale: makes the diagonal of that box 1.
        metres: length of the diagonal, metres.
        confidence, reason: of the axes; `runner_up` names the next best ones.
    """

    rotation: Matrix3
    origin: Vec3
    scale: float
    metres: float | None = None
    confidence: Confidence = 1.0
    reason: str = ""
    runner_up: str = ""

    def to_file(self, points: Floats) -> Floats:
        """Convert (N, 3) points of the frame to file axes and units."""
        return np.asarray(np.asarray(points) @ self.rotation / self.scale + np.array(self.origin))

    def direction_to_file(self, direction: Vec3) -> Vec3:
        """Convert a unit direction of the frame to file axes."""
        return to_vec3(np.array(direction) @ self.rotation)


class JointPlan(Record):
    """Joint between a part and its parent, in the frame, in the closed pose.

    Attributes:
        axis: unit. anchor: a point of it. range: from closed (0), rad or diagonals.
        endless: a knob or turntable that turns round and round; its range is one turn.
        edge: that a hinge of a front runs along; `runner_up` is the next likely one.
    """

    kind: JointKind
    axis: Vec3
    anchor: Vec3
    range: Vec2
    endless: bool = False
    edge: HingeEdge | None = None
    confidence: Confidence = 0.5
    reason: str = ""
    runner_up: str = ""


def slide(axis: Vec3, anchor: Vec3, length: float, confidence: float = 0.5, reason: str = "") -> JointPlan:
    """Return a joint along which a part comes out by a length, diagonals."""
    reach = (0.0, length)
    return JointPlan(kind=JointKind.SLIDE, axis=axis, anchor=anchor, range=reach, confidence=confidence, reason=reason)


def hinge(axis: Vec3, anchor: Vec3, angles: Vec2 | None = None, confidence: float = 0.5, reason: str = "") -> JointPlan:
    """Return a joint about which a part turns between two angles, rad; round and round without them."""
    return JointPlan(
        kind=JointKind.HINGE,
        axis=axis,
        anchor=anchor,
        range=angles or (0.0, 2 * math.pi),
        endless=angles is None,
        confidence=confidence,
        reason=reason,
    )


class PartPlan(Record):
    """A moving part.

    Attributes:
        name: unique. parent: name of the part that carries it, empty for the body.
        faces: of the mesh as it came in. grip: those that a hand takes, a subset.
        added: the mesh has no such part; it came with an interior that was built.
    """

    name: Id
    kind: PartKind
    parent: str = ""
    faces: FaceIndex
    grip: FaceIndex
    joint: JointPlan
    confidence: Confidence = 0.5
    reason: str = ""
    added: bool = False

    @property
    def full_reason(self) -> str:
        """Return why it is this part, and why it has this joint."""
        words = (w for reason in (self.reason, self.joint.reason) for w in reason.split("; ") if w)
        return "; ".join(dict.fromkeys(words))


class InteriorKind(StrEnum):
    """Type of interior, by which a cavity is lined and furnished."""

    OVEN = "oven"
    MICROWAVE = "microwave"
    REFRIGERATOR = "refrigerator"
    DISHWASHER = "dishwasher"
    CABINET = "cabinet"
    PLAIN = "plain"
    DRAWER = "drawer"


# Names of the meshes and visuals that were built, by the interior that they belong to.
ADDED_MESH_NAMES = {f: f"added_{f.value}" for f in InteriorKind}


class Cavity(Record):
    """The space behind a door, or in a drawer, in the frame.

    Attributes:
        parts: names of the one or two parts that close it; the cavity of a drawer moves with it, as do objects in it.
        lower, upper: inner corners; `lower[1]` is the y of its opening, in a drawer the back of its front.
        wall: thickness of the walls to build around it. outer: corners that it stays within, where the body begins.
        built: the mesh has no such cavity, so it is to be built; otherwise the mesh has one, or it stays `empty`.
        cut: corners of the box that is cut out of the body for it, None if the body is hollow.
        fronts: corners of boxes that the body must leave free for the panels of its parts, if it is cut.
        furnish: shelves, racks or a turntable are added too.
        in_doubt: it would be built, but a front of it is too uncertain.
    """

    parts: tuple[str, ...]
    interior: InteriorKind
    lower: Vec3
    upper: Vec3
    wall: float
    outer: tuple[Vec3, Vec3]
    built: bool
    empty: bool = False
    cut: tuple[Vec3, Vec3] | None = None
    fronts: tuple[tuple[Vec3, Vec3], ...] = ()
    furnish: bool = True
    in_doubt: bool = False
    confidence: Confidence = 0.5
    reason: str = ""


class AddedGeometry(Record):
    """Geometry that was built and belongs to one link.

    Attributes:
        part: name, empty for the body. interior: of the cavity that it furnishes.
        faces: added ones, after those of the mesh.
        clouds: (N, 3) points of each convex shape that is touched of it, in the frame.
    """

    part: str
    interior: InteriorKind
    faces: FaceIndex
    clouds: tuple[Cloud, ...] = ()


class StorageSpace(Record):
    """A box that objects can be put into, in the frame; `part` is what it moves with, empty for the body."""

    name: Id
    part: str = ""
    lower: Vec3
    upper: Vec3


class Articulation(Record):
    """A mesh split into moving parts; what belongs to no part is the body.

    Attributes:
        traits: what the form of its fronts says of its kind; names of FORM_TRAITS (kinds.py).
        cavities: what the fronts close. added: what was built in them, with the spaces that it leaves.
        signs: where no part was found, what speaks for some all the same, in words.
        value: how right the plan was expected to be when it was chosen, 0..1.
    """

    frame: Frame
    parts: tuple[PartPlan, ...] = ()
    category: str = ""
    traits: tuple[str, ...] = ()
    cavities: tuple[Cavity, ...] = ()
    added: tuple[AddedGeometry, ...] = ()
    spaces: tuple[StorageSpace, ...] = ()
    signs: tuple[str, ...] = ()
    value: float = 0.0

    def face_owner(self, count: int) -> npt.NDArray[np.int64]:
        """Return the (F,) index of the part that each of `count` faces belongs to, -1 for the body."""
        owner = np.full(count, -1, dtype=np.int64)
        for i, part in enumerate(self.parts):
            owner[part.faces] = i
        return owner


def calibrate_parts(articulation: Articulation, model: ConfidenceModel) -> Articulation:
    """Return the articulation with the confidence of each part as the share of such parts that are right.

    A part is right where its surface, its type and its joint are, so its joint gets the same number.
    """
    parts = []
    for part in articulation.parts:
        confidence = model.part_at(part.kind.value, part_score(part))
        parts.append(part.replace(confidence=confidence, joint=part.joint.replace(confidence=confidence)))
    return articulation.replace(parts=tuple(parts))


def part_score(part: PartPlan) -> float:
    """Return how sure the code is of a part together with its joint."""
    return min(part.confidence, part.joint.confidence)


def plan_confidence(articulation: Articulation, model: ConfidenceModel) -> float:
    """Return how likely it is that all parts of a mesh are right, or all but one small fault.

    Args:
        articulation: with calibrated confidences of frame and parts.
    """
    own = [p.confidence for p in articulation.parts if not p.added] or [0.0]
    features = {
        "weakest": min(own),
        "mean": sum(own) / len(own),
        "all_right": math.prod(own),
        "log_count": math.log(len(own)),
        "frame": articulation.frame.confidence,
        # What a person has decided about every part is right, whatever was thought of the plan before.
        "value": 1.0 if min(own) >= 1.0 else articulation.value,
        "named": float(bool(articulation.category)),
    }
    return model.plan.at(features)
