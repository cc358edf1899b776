"""Robots of registry/robots/, each in a separate file named after the robot in robosuite."""

from __future__ import annotations

from casa_assets.errors import RegistryError, UnknownId
from casa_assets.model.kitchen.robot import Robot
from casa_assets.registry.layered import names_in, read_topmost
from casa_assets.registry.read import read_record

FOLDER = "robots"


def robot_names() -> tuple[str, ...]:
    """Ids of all robots, sorted."""
    return names_in(FOLDER)


def load_robot(name: str) -> Robot:
    """A robot.

    Raises:
        UnknownId: no robot has that name. RegistryError: its file is not a valid robot.
    """
    if name not in robot_names():
        raise UnknownId("robot", name, robot_names())
    document = read_topmost(f"{FOLDER}/{name}.yaml")
    if not isinstance(document.value, dict):
        raise RegistryError(document.file, 1, "", "a robot", type(document.value).__name__)
    return read_record(Robot, document.value, document, (), id=name)
