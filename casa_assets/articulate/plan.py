"""What articulation decides, as records: a frame, the moving parts, their joints, and how sure each of it is.

Lengths are in units of the analysed mesh: the frame says how they lead back to the file and on to metres.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import numpy as np
import numpy.typing as npt

from casa_assets.model.joint import JointKind
from casa_assets.model.provenance import Confidence
from casa_assets.model.record import ArrayOf, Id, Record, Vec2, Vec3

FaceIndex = Annotated[npt.NDArray[np.int64], ArrayOf("int64", (-1,))]
Matrix3 = Annotated[npt.NDArray[np.float64], ArrayOf("float64", (3, 3))]
Floats = npt.NDArray[np.float64]


class PartKind(StrEnum):
    """What a moving part is; it decides how its joint moves."""

    DOOR = "door"
    DRAWER = "drawer"
    LID = "lid"
    KNOB = "knob"
    BUTTON = "button"
    LEVER = "lever"
    SPOUT = "spout"
    TRAY = "tray"


class Edge(StrEnum):
    """The side of a front that a hinge runs along, seen by who stands before it."""

    LEFT = "left"
    RIGHT = "right"
    TOP = "top"
    BOTTOM = "bottom"


class Frame(Record):
    """How the axes of a file become ours: z up, x right, y back.

    Attributes:
        rotation: proper; `frame = rotation @ (file - origin) * scale`.
        origin: middle of the box round everything, file units.
        scale: makes the diagonal of that box 1.
        metres: length of the diagonal, metres.
        confidence, because: of the axes; `runner_up` names the next best ones.
    """

    rotation: Matrix3
    origin: Vec3
    scale: float
    metres: float | None = None
    confidence: Confidence = 1.0
    because: str = ""
    runner_up: str = ""

    def to_file(self, points: Floats) -> Floats:
        """(N, 3) points of the frame, in file axes and units."""
        found: Floats = np.asarray(points) @ self.rotation / self.scale + np.array(self.origin)
        return found

    def direction_to_file(self, direction: Vec3) -> Vec3:
        """A unit direction of the frame, in file axes."""
        x, y, z = (float(v) for v in np.array(direction) @ self.rotation)
        return (x, y, z)


class JointPlan(Record):
    """How a part moves against its parent, in the frame, closed.

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
    edge: Edge | None = None
    confidence: Confidence = 0.5
    because: str = ""
    runner_up: str = ""


class PartPlan(Record):
    """A part that moves.

    Attributes:
        name: unique. parent: name of the part that carries it, empty for the body.
        faces: of the mesh as it came in. grip: those that a hand takes, a subset.
    """

    name: Id
    kind: PartKind
    parent: str = ""
    faces: FaceIndex
    grip: FaceIndex
    joint: JointPlan
    confidence: Confidence = 0.5
    because: str = ""


class Articulation(Record):
    """A mesh taken apart: what does not belong to a part is the body."""

    frame: Frame
    parts: tuple[PartPlan, ...] = ()
    category: str = ""
