"""Categories that are one kind to the eye, of registry/look_alikes.yaml."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Annotated

from pydantic import Field

from casa_assets.model.record import Id, Record
from casa_assets.model.registry.fields import expected_one_of
from casa_assets.projects import read_once
from casa_assets.registry.layered import read_table_file
from casa_assets.registry.load import load
from casa_assets.registry.read import read_table

FILE = "look_alikes.yaml"


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
    document = read_table_file(FILE, root)
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
