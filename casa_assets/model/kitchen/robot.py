"""Records of robots, and of the joints that they can reach in a kitchen."""

from __future__ import annotations

from enum import StrEnum
from statistics import median
from typing import Literal

from pydantic import Field

from casa_assets.model.kitchen.scene import SceneId
from casa_assets.model.record import Record, Vec2, Vec3


class RobotPart(Record):
    """One MJCF file of a robot, such as its base, its arm or its gripper."""

    name: str  # prefix, followed by an underscore, of all names in the file
    file: str  # path in the folder of robot models
    onto: str = ""  # body of an earlier part that carries it; empty for the first part


class Hand(Record):
    """Finger positions of a hand, and the position of an object between the fingers.

    Attributes:
        fingers: joint -> angle or position, radians or metres.
        point: middle of the held object, or the tip that presses, in the frame of the hand's body.
        approach, closing: directions in which the hand moves towards an object, and in which the fingers close.
    """

    fingers: dict[str, float] = Field(default_factory=dict)
    point: Vec3
    approach: Vec3
    closing: Vec3


class Arm(Record):
    """An arm with its hand.

    Attributes:
        body: body of the hand, in whose frame the points of the hand are given.
        touching: bodies and meshes that may touch the held object.
        opening: width of the widest object that fits between the fingers, m.
        grasp: hand when open, for handles, knobs and levers. press: for keys.
        closed: joint -> position of a finger when it meets the opposite one, so that a hand can approach a thin handle
            with its fingers half closed; empty for a hand that always approaches with open fingers.
    """

    name: str
    body: str
    touching: tuple[str, ...]
    opening: float
    grasp: Hand
    press: Hand
    closed: dict[str, float] = Field(default_factory=dict)


class Legs(Record):
    """Legs that bend and stretch together: the trunk stays level and moves up or down while the feet stay in place.

    A thigh leans as far in one direction as the shank below it leans in the other; both are taken to be equally long.

    Attributes:
        angles: joint -> its angle when nothing leans, and its change per radian of lean.
        length: length of a thigh plus a shank, m. lean: minimum and maximum, rad.
    """

    angles: dict[str, Vec2]
    length: float
    lean: Vec2


class Robot(Record):
    """A robot whose base is on the floor.

    Attributes:
        id: its name in robosuite. shape: in words. parts: from the base outwards. arms: that it works with.
        centre: centre of its base in the frame of the first part, which is placed on a parking place; x ahead, y to the
            left.
        drives: whether the base can move along with a door that is being opened.
        home: joint -> position at rest; these are the joints that move.
        fixed: joint -> position at which it stays; all other joints stay at zero.
        legs: how the legs bend, or None if the robot has no legs that bend. With legs, `home` also names `trunk`: the
            distance (m) of the trunk below its height at minimum lean.
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
    """How the base of a robot behaves while the hand opens a joint."""

    STANDING = "standing"
    DRIVING = "driving"
    NO = "no"


class Miss(StrEnum):
    """Why a hand does not reach something."""

    FAR = "out of reach"
    BLOCKED = "in the way"
    THICK = "too thick"


class JointReach(Record):
    """Result for one robot at one joint of a kitchen.

    Attributes:
        joint: its name in the MJCF.
        reached: the hand gets to the handle, knob, key or lever, and nothing else of the robot touches anything.
        followed: whether the hand keeps hold of it during the whole opening, with the base standing still or driving
            along.
        share: share of the opening that the hand followed, 0 to 1.
        margin: smallest distance of any hinge of the robot from an end of its range, over everything that was reached
            and followed, as a share of half the range: 0 at an end, 1 if all hinges are in the middle of their ranges.
        arm: that reached it; empty if none did.
        base: pose of the base when the hand got there: x, y of its centre (m) and its direction (rad).
        missed: why it is not reached, or None if it is. Out of reach: no posture was found even if the robot may pass
            through everything else. In the way: a posture was found only then. Too thick: it does not fit between the
            fingers.
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
    """Result for one robot in one kitchen: each joint that was tried."""

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
        """Median margin of the joints that it reaches, or None if it reaches no joint."""
        found = [j.margin for j in self.joints if j.margin is not None]
        return round(median(found), 3) if found else None


class SceneRobots(Record):
    """Results of all robots in one kitchen.

    Attributes:
        key: digest of everything that it was made from. scene_key: digest of the files of the scene that was used.
        without_parking: joints of fixtures for which the scene has no parking place, such as switches and windows; they
            are not tried with any robot.
        only: globs of the joints that were tried; empty if all were.
    """

    format: Literal[1] = 1
    scene: SceneId
    key: str
    scene_key: str
    robots: tuple[RobotCertificate, ...]
    without_parking: tuple[str, ...] = ()
    only: tuple[str, ...] = ()
