"""RoboCasa's entries for our object categories (OBJ_CATEGORIES), one table per release.

An entry has the types and attributes of a category and, per object registry, the folders of its models. We have three
registries: all instances, those for training and those for testing. RoboCasa's own splits depend on the order of file
names, so that a new instance may move another one to the other split; ours depend on the digest of the source or shape
of the instance.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from casa_assets.model.asset.provenance import Split
from casa_assets.model.record import Id, Record
from casa_assets.model.registry.category import Affordance, Category
from casa_assets.model.registry.contract import RobocasaRelease

FOLDER = "objects"
# Attributes of a category that a generation knows. Ref: robocasa v0.2 and v1.0, kitchen_object_utils.
_FIRST = (
    Affordance.GRASPABLE,
    Affordance.WASHABLE,
    Affordance.MICROWAVABLE,
    Affordance.COOKABLE,
    Affordance.FREEZABLE,
)
ATTRIBUTES: Mapping[RobocasaRelease, tuple[Affordance, ...]] = {
    RobocasaRelease.V0_2: _FIRST,
    RobocasaRelease.V1_0: (*_FIRST, Affordance.FRIDGABLE, Affordance.DISHWASHABLE),
}


class Instance(Record):
    """One object of the export.

    Attributes:
        id: id of the asset, and name of its folder.
        category: id.
        split: training or test.
    """

    id: Id
    category: Id
    split: Split


def instance_folder(instance: Instance, registry: str) -> str:
    """Folder of an instance below the root of the export."""
    return f"{FOLDER}/{registry}/{instance.category}/{instance.id}"


def registry_splits(registry: str) -> dict[str, Split | None]:
    """Object registry -> split of its instances (None: all)."""
    return {registry: None, **{f"{registry}_{split.value}": split for split in Split}}


def category_tables(
    instances: Sequence[Instance], categories: Mapping[str, Category], registry: str
) -> dict[RobocasaRelease, dict[str, Any]]:
    """For each generation: category -> entry, sorted.

    Registries in which a category has no instance are left out of its entry, since RoboCasa cannot draw from an empty
    one.
    """
    return {
        generation: {
            name: _entry(categories[name], [i for i in instances if i.category == name], registry, generation)
            for name in sorted({i.category for i in instances})
        }
        for generation in RobocasaRelease
    }


def _entry(
    category: Category, instances: Sequence[Instance], registry: str, generation: RobocasaRelease
) -> dict[str, Any]:
    entry: dict[str, Any] = {"types": [kind.value for kind in category.types]}
    entry |= {use.value: category.can(use) for use in ATTRIBUTES[generation]}
    for name, split in registry_splits(registry).items():
        if any(split in (None, i.split) for i in instances):
            entry[name] = {
                "model_folders": [f"{registry}/{category.id}"],
                "exclude": sorted(i.id for i in instances if split not in (None, i.split)),
                # Our models have their real size. It must be a float: RoboCasa takes an int for a list.
                "scale": 1.0,
            }
    return entry


def file_name(generation: RobocasaRelease) -> str:
    """Name of the file of a generation's entries."""
    return f"categories_{generation.value}.json"


def json_bytes(data: Any) -> bytes:
    """JSON for people and programs, sorted, ASCII."""
    return (json.dumps(data, sort_keys=True, indent=1, allow_nan=False) + "\n").encode("ascii")
