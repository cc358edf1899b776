"""Read registry/habits.yaml: which objects people keep together in a kitchen, and where."""

from __future__ import annotations

from casa_assets.model.registry.rows import Habits
from casa_assets.projects import read_once
from casa_assets.registry.families import object_names
from casa_assets.registry.read import read_record, read_table_file

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
