"""Adds the objects of this folder to those that RoboCasa's kitchens sample from; works with v0.2 and v1.0.

    import sys

    sys.path.insert(0, "<this folder>")
    import casa_objects

    casa_objects.register()  # ('casa', 'casa_test', 'casa_train')
    env = robosuite.make(..., obj_registries=("casa_train",), obj_instance_split=None)

Models are not moved. The folder has to be writable: RoboCasa copies each XML to a file next to it while it loads.
Only RoboCasa and the standard library are needed.
"""

from __future__ import annotations

import importlib
import inspect
import json
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
# Ref: robocasa v1.0, groups of categories by their types.
GROUPS = {
    "food": ("vegetable", "fruit", "sweets", "dairy", "meat", "bread_food", "pastry", "cooked_food"),
    "in_container": (
        *("vegetable", "fruit", "sweets", "dairy", "meat", "bread_food", "pastry", "cooked_food"),
        *("tool", "iced_item"),
    ),
}


def register(root: Path | str = HERE) -> tuple[str, ...]:
    """Add every category of the export to RoboCasa's tables.

    Categories that RoboCasa already has keep their other registries.

    Returns:
        Names for `obj_registries`.
    """
    utils = importlib.import_module("robocasa.models.objects.kitchen_object_utils")
    tables = importlib.import_module("robocasa.models.objects.kitchen_objects")
    return fill(utils.ObjCat, tables.OBJ_CATEGORIES, tables.OBJ_GROUPS, Path(root))


def fill(kind: Any, categories: dict[str, Any], groups: dict[str, list[str]], root: Path) -> tuple[str, ...]:
    """Add the categories of an export to the given tables.

    Args:
        kind: RoboCasa's class of a category; its parameters show the generation.
    """
    known = inspect.signature(kind).parameters
    generation = "v1_0" if "fridgable" in known else "v0_2"
    entries = json.loads((root / f"categories_{generation}.json").read_text(encoding="ascii"))
    added = set()
    for name, entry in entries.items():
        if name not in categories:
            _group(groups, name, tuple(entry["types"]))
        registries = {key: value for key, value in entry.items() if isinstance(value, dict)}
        common = {key: value for key, value in entry.items() if key not in registries and key != "types"}
        types = tuple(entry["types"])
        for registry, own in registries.items():
            folders = [str(root / "objects" / folder) for folder in own["model_folders"]]
            row = kind(name, types, **{**common, **own, "model_folders": folders})
            # A runtime with several search paths finds an absolute folder once for each of them.
            row.mjcf_paths = sorted(set(row.mjcf_paths))
            if len(row.mjcf_paths) == 1:
                # RoboCasa cuts this list in two for its own splits, and draws from none where a part is empty.
                row.mjcf_paths *= 2
            categories.setdefault(name, {})[registry] = row
            added.add(registry)
    return tuple(sorted(added))


def _group(groups: dict[str, list[str]], name: str, types: tuple[str, ...]) -> None:
    """Add a category that is new to RoboCasa to the groups of its types.

    RoboCasa's own categories are already in their groups. A category without types (a shoe, a microwave) is only found
    by its own name: `all` is the group of objects that are scattered in kitchens.
    """
    wanted = [name, *types, *(group for group, any_of in GROUPS.items() if set(any_of) & set(types))]
    for group in [*wanted, "all"] if types else wanted:
        members = groups.setdefault(group, [])
        if name not in members:
            members.append(name)
