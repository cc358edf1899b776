"""Read small files of registry/: habits, roles, mixing, robots, look-alikes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Annotated

from pydantic import Field

from casa_assets.errors import RegistryError, UnknownId
from casa_assets.model.kitchen.habit import Habits
from casa_assets.model.kitchen.robot import Robot
from casa_assets.model.kitchen.style import Mixing
from casa_assets.model.record import Id, Record
from casa_assets.model.registry.document import expected_one_of
from casa_assets.model.registry.rows import RoleRule
from casa_assets.projects import read_once
from casa_assets.registry.kitchens import load_style, style_names
from casa_assets.registry.layered import names_in, read_table_file, read_topmost
from casa_assets.registry.load import load
from casa_assets.registry.objects import object_names
from casa_assets.registry.read import read_record, read_table

# Habits ---------------------------------------------------------------------------------------------------------------
# registry/habits.yaml: which objects people keep together in a kitchen, and where.

HABITS_FILE = "habits.yaml"


@read_once
def load_habits() -> Habits:
    """Kinds of spaces and habits. Raises RegistryError where the file is wrong, or names objects that there are not."""
    document = read_table_file(HABITS_FILE)
    habits = read_record(Habits, document.value, document, ())
    known = set(object_names())
    for name, habit in habits.habits.items():
        for field in ("objects", "vessel"):
            for category in getattr(habit, field):
                if category not in known:
                    at = ("habits", name, field, category)
                    raise document.fault(at, "a category of registry/objects/", repr(category))
    return habits


# Roles ----------------------------------------------------------------------------------------------------------------
# registry/roles.yaml: which assets of libraries a plan may use as its range, fridge, toaster and so on.

ROLES_FILE = "roles.yaml"


@read_once
def load_roles() -> Mapping[str, RoleRule]:
    """Rules of the roles by id, those of the project over those of the package. Raises RegistryError."""
    return read_table(RoleRule, read_table_file(ROLES_FILE))


# Mixing ---------------------------------------------------------------------------------------------------------------
# registry/mixing.yaml: what is drawn together where kitchens are drawn at random.

MIXING_FILE = "mixing.yaml"


@read_once
def load_mixing() -> Mixing:
    """The rules. Raises RegistryError where the file is wrong, or names a role that no style has."""
    document = read_table_file(MIXING_FILE)
    mixing = read_record(Mixing, document.value, document, ())
    known = {role for name in style_names() for role in load_style(name)[0].models}
    for suite, roles in mixing.suites.items():
        for i, role in enumerate(roles):
            if role not in known:
                raise document.fault(("suites", suite, i), "a role of the styles", repr(role))
    return mixing


# Robots ---------------------------------------------------------------------------------------------------------------
# Robots of registry/robots/, each in a separate file named after the robot in robosuite.

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


# Look alikes ----------------------------------------------------------------------------------------------------------
# Categories that are one kind to the eye, of registry/look_alikes.yaml.

LOOK_ALIKES_FILE = "look_alikes.yaml"


class LookAlikes(Record):
    """A row: categories that look the same, two at least, and why they do."""

    id: Id
    categories: Annotated[tuple[Id, ...], Field(min_length=2)]
    reason: Annotated[str, Field(min_length=1)]


@read_once
def look_alikes(root: Path | None = None) -> Mapping[str, str]:
    """Category -> name of the kind that it is to the eye, of those that share one.

    Args:
        root: the only folder to read; None reads the package's and the project's.
    Raises:
        RegistryError: a row names a category that there is not, or that another row has.
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
