"""Objects of registry/objects/: the form of each category, what all its members have in common, how they are drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from pydantic import Field

from casa_assets.asset.kit.assemble import Family
from casa_assets.asset.sampling import read_fixed, read_sample_rules
from casa_assets.errors import UnknownId
from casa_assets.model.record import Id, Record
from casa_assets.model.registry.document import Document, expected_one_of
from casa_assets.projects import read_once
from casa_assets.registry import load, read_record
from casa_assets.registry.layered import names_in, read_table_file
from casa_assets.registry.plugins import or_of_ignored
from casa_assets.registry.plugins.families import forms

FOLDER = "objects"


class ObjectRow(Record):
    """A row of a file of registry/objects/, under the id of a category in registry/categories.yaml."""

    form: Id = Field(description="name of a form")
    about: str = Field(description="what members there are, one sentence")
    sample: dict[str, Any] = Field(
        description="field -> the rule by which a member's value is drawn (`asset/sampling.py`)"
    )
    fixed: dict[str, Any] = Field(
        default_factory=dict, description="field of the form's Params -> the value that all members have"
    )


@read_once
def object_files() -> Mapping[str, tuple[str, ...]]:
    """The categories of each file, by the name of the file, such as `fruit`. Raises RegistryError."""
    found: dict[str, list[str]] = {}
    for name, member in _rows().items():
        found.setdefault(member[0], []).append(name)
    return MappingProxyType({name: tuple(rows) for name, rows in found.items()})


def object_family(name: str) -> Family[Any]:
    """The family of the objects of a category. Raises UnknownId with the nearest names, RegistryError."""
    rows = _rows()
    if name not in rows:
        raise UnknownId("category of objects", name, rows)
    return rows[name][1]


def object_names() -> tuple[str, ...]:
    """Categories of which there are objects, file by file."""
    return tuple(_rows())


@read_once
def _rows() -> Mapping[str, tuple[str, Family[Any]]]:
    """Of each category the name of its file and its family."""
    found: dict[str, tuple[str, Family[Any]]] = {}
    for stem in names_in(FOLDER):
        document = read_table_file(f"{FOLDER}/{stem}.yaml")
        if not isinstance(document.value, dict):
            raise document.fault((), "a mapping of categories to objects", type(document.value).__name__)
        for name in document.value:
            if name in found:
                message = f"a category that no other file has; to change its row, use {FOLDER}/{found[name][0]}.yaml"
                raise document.fault((name,), message, repr(name))
            found[name] = (stem, _read(str(name), document))
    return MappingProxyType(found)


def _read(name: str, document: Document) -> Family[Any]:
    """The family of a row. Raises RegistryError with file, line, pointer, expected and got."""
    categories = load().categories
    if name not in categories:
        raise document.fault((name,), expected_one_of(tuple(categories), name), repr(name))
    row = read_record(ObjectRow, document.value[name], document, (name,))
    if row.form not in forms():
        expected = expected_one_of(tuple(forms()), row.form) + or_of_ignored()
        raise document.fault((name, "form"), expected, repr(row.form))
    form = forms()[row.form]
    fixed = read_fixed(form.params, row.fixed, document, (name, "fixed"))
    rules = read_sample_rules(form.params, row.sample, document, (name, "sample"), fixed)
    return replace(
        form,
        name=name,
        sample=rules,
        title=name.replace("_", " "),
        category=name,
        description=row.about,
        form=row.form,
    )
