"""Robots of registry/robots/, each a file of its own, named after the robot in robosuite."""

from __future__ import annotations

from casa_assets.errors import RegistryError, UnknownId
from casa_assets.model.kitchen.robot import Robot
from casa_assets.registry.load import data_root, read_document, read_record

FOLDER = "robots"


def robot_names() -> tuple[str, ...]:
    """Ids of all robots, sorted."""
    return tuple(sorted(p.stem for p in (data_root() / FOLDER).glob("*.yaml")))


def load_robot(name: str) -> Robot:
    """A robot.

    Raises:
        UnknownId: there is none of that name. RegistryError: its file is no robot.
    """
    if name not in robot_names():
        raise UnknownId("robot", name, robot_names())
    path = data_root() / FOLDER / f"{name}.yaml"
    document = read_document(path)
    if not isinstance(document.value, dict):
        raise RegistryError(path.name, 1, "", "a robot", type(document.value).__name__)
    return read_record(Robot, document.value, document, (), id=name)
