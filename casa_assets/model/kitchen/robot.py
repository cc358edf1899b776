"""What a robot is made of, and what it can reach in a kitchen."""

from __future__ import annotations

from enum import StrEnum
from statistics import median
from typing import Literal

from pydantic import Field

from casa_assets.model.kitchen.scene import SceneId
from casa_assets.model.record import Record, Vec2, Vec3


class RobotPart(Record):
    """One MJCF file of a robot, such as its base, its arm or its gripper.

    Attributes:
        name: put before the names of all that the file holds, with an underscore.
        file: path in the folder of robot models. onto: body of an earlier part that carries it; empty for the first.
    """

    name: str
    file: str
    onto: str = ""


class Hand(Record):
    """How fingers are held, and where a thing is between them.

    Attributes:
        fingers: joint -> angle or position, radians or metres.
        point: middle of what is held, or the tip that presses, in the frame of the hand's body.
        approach: direction in which the hand moves towards a thing. closing: direction in which its fingers close.
    """

    fingers: dict[str, float] = Field(default_factory=dict)
    point: Vec3
    approach: Vec3
    closing: Vec3


class Arm(Record):
    """An arm with its hand.

    Attributes:
        body: of the hand, in whose frame its points are. touching: bodies and meshes that may touch what is held.
        opening: widest thing that goes between the fingers, m.
        grasp: open, for handles, knobs and levers. press: for keys.
        closed: joint -> where a finger is once nothing is left between it and its opposite, so that a hand comes to a
            thin handle with its fingers half closed; empty for a hand that always comes with them open.
    """

    name: str
    body: str
    touching: tuple[str, ...]
    opening: float
    grasp: Hand
    press: Hand
    closed: dict[str, float] = Field(default_factory=dict)


class Legs(Record):
    """Legs that bend and stretch together: the trunk stays level and rises or sinks over feet that stay where they are.

    A thigh leans as far one way as the shank below it leans the other; both count as equally long.

    Attributes:
        angles: joint -> its angle where nothing leans, and by how much it turns for each radian of lean.
        length: of a thigh and a shank together, m. lean: least and most, rad.
    """

    angles: dict[str, Vec2]
    length: float
    lean: Vec2


class Robot(Record):
    """A robot that stands on the floor.

    Attributes:
        id: its name in robosuite. shape: in words.
        parts: its files, from the base outwards. arms: that it works with.
        centre: of its base in the frame of the first part, which is put on a parking place; x ahead, y to the left.
        drives: whether the base can go along with a door that is being opened.
        home: joint -> where it is at rest; these are the joints that move. fixed: joint -> where it stays; the others
            stay at zero. legs: how they bend; its home then names `trunk`, the height of the trunk, m, below that
            over legs with least lean. None where nothing bends.
    """

    id: str
    shape: str
    parts: tuple[RobotPart, ...]
    arms: tuple[Arm, ...]
    centre: Vec2 = (0.0, 0.0)
    drives: bool
    home: dict[str, float]
    fixed: dict[str, float] = Field(default_factory=dict)
    legs: Legs | None = None


class Following(StrEnum):
    """How a robot goes along with what it opens."""

    STANDING = "standing"
    DRIVING = "driving"
    NO = "no"


class Miss(StrEnum):
    """Why a hand does not get to something."""

    FAR = "out of reach"
    BLOCKED = "in the way"
    THICK = "too thick"


class JointReach(Record):
    """What a robot can do at one joint of a kitchen.

    Attributes:
        fixture, joint: of the scene; the joint by its name in the MJCF.
        reached: its hand gets to the handle, knob, key or lever, and nothing else of the robot touches anything.
        followed: whether the hand stays on it along the whole opening, the base standing or driving along.
        share: of the opening that the hand followed, 0 to 1.
        margin: smallest distance of any hinge of the robot to an end of its range, along all that was reached and
            followed, as a share of half the range: 0 at an end, 1 where all are in their middle.
        arm: that did it; empty where none reached. base: where the base stood when the hand got there: x, y of its
            centre and its direction, m and radians.
        missed: why it is not reached; None where it is. Out of reach: no posture was found even where the robot may
            pass through all else. In the way: one was found then. Too thick: it does not go between the fingers.
    """

    fixture: str
    joint: str
    reached: bool
    followed: Following = Following.NO
    share: float = 0.0
    margin: float | None = None
    arm: str = ""
    base: Vec3 | None = None
    missed: Miss | None = None


class RobotCertificate(Record):
    """What one robot can do in one kitchen."""

    robot: str
    shape: str
    drives: bool
    joints: tuple[JointReach, ...]

    @property
    def reached(self) -> int:
        """Number of joints whose handle the robot reaches."""
        return sum(j.reached for j in self.joints)

    @property
    def followed(self) -> int:
        """Number of joints that the robot opens all the way."""
        return sum(j.followed is not Following.NO for j in self.joints)

    @property
    def margin(self) -> float | None:
        """Median of the margins of the joints that it reaches; None where it reaches none."""
        found = [j.margin for j in self.joints if j.margin is not None]
        return round(median(found), 3) if found else None


class SceneRobots(Record):
    """What robots can do in one kitchen.

    Attributes:
        key: of all that it was made from. scene_key: of the files of the scene that it was found on.
        without_parking: joints of fixtures that a scene has no parking place for, such as switches and windows; no
            robot is tried on them.
        only: globs of the joints that were tried; empty where all were.
    """

    format: Literal[1] = 1
    scene: SceneId
    key: str
    scene_key: str
    robots: tuple[RobotCertificate, ...]
    without_parking: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
