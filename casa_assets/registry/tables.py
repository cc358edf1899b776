"""Read small files of registry/: roles, robots and look-alikes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Annotated

from pydantic import Field

from casa_assets.errors import RegistryError, UnknownId
from casa_assets.model.kitchen.robot import Robot
from casa_assets.model.record import Id, Record
from casa_assets.model.registry.document import expected_one_of
from casa_assets.model.registry.rows import RoleRule
from casa_assets.projects import read_once
from casa_assets.registry.load import load
from casa_assets.registry.read import names_in, read_record, read_table, read_table_file, read_topmost

ROLES_FILE, LOOK_ALIKES_FILE = "roles.yaml", "look_alikes.yaml"
ROBOTS = "robots"


@read_once
def load_roles() -> Mapping[str, RoleRule]:
    """Rules of the roles by id, those of the project over those of the package. Raises RegistryError."""
    return read_table(RoleRule, read_table_file(ROLES_FILE))


def robot_names() -> tuple[str, ...]:
    """Ids of all robots, sorted."""
    return names_in(ROBOTS)


def load_robot(name: str) -> Robot:
    """A robot. Raises UnknownId: no robot has that name. RegistryError: its file is not a valid robot."""
    if name not in robot_names():
        raise UnknownId("robot", name, robot_names())
    document = read_topmost(f"{ROBOTS}/{name}.yaml")
    if not isinstance(document.value, dict):
        raise RegistryError(document.file, 1, "", "a robot", type(document.value).__name__)
    return read_record(Robot, document.value, document, (), id=name)


class LookAlikes(Record):
    """A row: categories that look the same, two at least, and why they do."""

    id: Id
    categories: Annotated[tuple[Id, ...], Field(min_length=2)]
    reason: Annotated[str, Field(min_length=1)]


@read_once
def look_alikes(root: Path | None = None) -> Mapping[str, str]:
    """Category -> name of the kind that it is to the eye, of those that share one.

    `root`: the only folder to read; None reads the package's and the project's. Raises RegistryError: a row names a
    category that there is not, or that another row has.
    """
    document = read_table_file(LOOK_ALIKES_FILE, root)
    known = load(root).categories
    found: dict[str, str] = {}
    for name, row in read_table(LookAlikes, document).items():
        for number, category in enumerate(row.categories):
            at = (name, "categories", number)
            if category not in known:
                raise document.fault(at, expected_one_of(tuple(known), category), repr(category))
            if category in found:
                raise document.fault(at, "a category that no other row has", f"{category!r}, also in {found[category]}")
            found[category] = name
    return MappingProxyType(found)
