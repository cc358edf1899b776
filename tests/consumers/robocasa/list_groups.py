"""Reads in RoboCasa's source which objects its atomic tasks draw, and draws them from an export's registries.

    python list_groups.py EXPORT DRAWS

Prints one JSON object: registry -> rows {"task", "groups", "exclude", "filters", "max_size", "error", "categories"},
one row for each object that a task asks for, with the categories of DRAWS draws, or why there was none. Runs in
RoboCasa's own environment, RoboCasa as it is.
"""

from __future__ import annotations

import ast
import inspect
import json
import sys
import textwrap
from collections.abc import Iterator
from typing import Any

import numpy as np
import robocasa  # noqa: F401  registers the tasks
from robocasa.environments.kitchen.kitchen import REGISTERED_KITCHEN_ENVS
from robocasa.models.objects.kitchen_object_utils import sample_kitchen_object_helper
from robocasa.utils.dataset_registry import ATOMIC_TASK_DATASETS

FILTERS = ("graspable", "washable", "microwavable", "cookable", "freezable", "fridgable", "dishwashable")
# What `create_obj` asks besides of what stands in a fixture; the fixtures are attributes of the task.
OF_FIXTURES = {"sink": "washable", "dishwasher": "dishwashable", "microwave": "microwavable", "fridge": "fridgable"}
COOKING = {
    "stove": {"pan", "kettle_non_electric", "pot", "saucepan", "cookware"},
    "oven": {"oven_tray", "pan", "pot", "saucepan", "cake"},
}


def dicts(kind: type) -> Iterator[dict[str, ast.expr]]:
    """The keywords of each `dict(...)` of an object in the methods of a task and of what it is made from."""
    for base in kind.__mro__:
        method = vars(base).get("_get_obj_cfgs")
        if method is None:
            continue
        tree = ast.parse(textwrap.dedent(inspect.getsource(method)))
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "dict":
                found = {word.arg: word.value for word in node.keywords if word.arg}
                if "name" in found and "placement" in found:
                    yield found
        return


def default_of(kind: type, name: str) -> Any:
    """The value of an argument that a task is made with where its caller gives none."""
    for base in kind.__mro__:
        made = vars(base).get("__init__")
        if made is None:
            continue
        for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(made)))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "super().__init__":
                given = {word.arg: word.value for word in node.keywords}
                if isinstance(given.get(name), ast.Constant):
                    return ast.literal_eval(given[name])
        default = inspect.signature(made).parameters.get(name)
        if default is not None and default.default is not inspect.Parameter.empty:
            return default.default
    return None


def value(kind: type, node: ast.expr | None) -> Any:
    if node is None:
        return None
    if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "self":
        return default_of(kind, node.attr)
    return ast.literal_eval(node)


def wanted(kind: type) -> Iterator[dict[str, Any]]:
    for row in dicts(kind):
        groups, exclude = value(kind, row.get("obj_groups")) or "all", value(kind, row.get("exclude_obj_groups"))
        filters = {name: True for name in FILTERS if name in row and value(kind, row[name]) is True}
        placement = row.get("placement")
        inside = {word.arg: word.value for word in getattr(placement, "keywords", ())}
        place = ast.unparse(inside["fixture"]).removeprefix("self.") if "fixture" in inside else ""
        if place in OF_FIXTURES:
            filters[OF_FIXTURES[place]] = True
        names = {groups} if isinstance(groups, str) else set(groups)
        if place in COOKING and not names & COOKING[place]:
            filters["cookable"] = True
        yield {"groups": groups, "exclude": exclude, "filters": filters, "max_size": value(kind, row.get("max_size"))}
        container = value(kind, inside.get("try_to_place_in"))
        if container:
            held = {OF_FIXTURES[place]: True} if place in OF_FIXTURES else {}
            yield {"groups": container, "exclude": None, "filters": held, "max_size": None}


def draw(row: dict[str, Any], registry: str, draws: int) -> dict[str, Any]:
    found: set[str] = set()
    error = ""
    asked = {**row["filters"], "rng": np.random.default_rng(0), "obj_registries": (registry,)}
    try:
        for _ in range(draws):
            found.add(sample_kitchen_object_helper(row["groups"], row["exclude"], **asked)[1]["cat"])
    except Exception as fault:  # noqa: BLE001 - each row answers for itself
        error = f"{type(fault).__name__}: {fault}"
    return {**row, "error": error, "categories": sorted(found)}


def main() -> None:
    sys.path.insert(0, sys.argv[1])
    import casa_objects

    names, tasks = casa_objects.register(), sorted(ATOMIC_TASK_DATASETS)
    rows = [{"task": task, **row} for task in tasks for row in wanted(REGISTERED_KITCHEN_ENVS[task])]
    print(json.dumps({name: [draw(row, name, int(sys.argv[2])) for row in rows] for name in names}))


if __name__ == "__main__":
    main()
