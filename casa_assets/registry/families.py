"""Families of registry/families/ and objects of registry/objects/: their data, joined to the code that builds them."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, get_args

import numpy as np
from pydantic import Field

from casa_assets.asset.assemble import Family
from casa_assets.asset.family import AvailableFinishes, Params, is_finish
from casa_assets.asset.sampling import read_fixed, read_sample_rules
from casa_assets.errors import CasaError, RegistryError, UnknownId
from casa_assets.model.record import Id, Record
from casa_assets.model.registry.document import Document, KeyPath, expected_one_of
from casa_assets.projects import read_once
from casa_assets.registry import load, read_record
from casa_assets.registry.plugins import or_of_ignored
from casa_assets.registry.plugins.families import GROUPS, LOOKS, MODELS, forms, plugin_families
from casa_assets.registry.read import names_in, read_table_file

FOLDER = "families"
PLUGIN_GROUP = "plug-ins"  # of families that plug-ins add
NAMED_LOOKS = "looks.yaml"
LOOK_RULES = "look_rules.yaml"
OBJECTS = "objects"


class FamilyFile(Record):
    """One file of registry/families/, before its presets are read with the family's own type of numbers.

    Attributes:
        title: what a person calls a member, one line. category: id in registry/fixtures.yaml.
        description: what members there are, one sentence.
        sample: field -> the rule by which a random member's value is drawn (`asset/sampling.py`); None if the code
            of the family has a function for it.
        presets: preset -> the numbers and choices that differ from the defaults of the family's Params.
    """

    title: str
    category: Id
    description: str
    sample: dict[str, Any] | None = None
    presets: dict[Id, Any]


class AddedPresets(Record):
    """A file of a project about a family of a plug-in: preset -> what differs from the defaults."""

    presets: dict[Id, Any]


class LookRules(Record):
    """The rules of registry/look_rules.yaml: field -> the rule by which its value is drawn."""

    cabinet: dict[str, Any]
    appliance: dict[str, Any]


def family_names() -> tuple[str, ...]:
    """Names of all families, group by group; those of plug-ins come last."""
    return (*MODELS, *plugin_families())


@read_once
def family(name: str) -> Family[Any]:
    """A family with its presets.

    Raises UnknownId: no family has that name; the error names the nearest that exist. RegistryError:
    registry/families/<name>.yaml has values that the family's Params do not accept.
    """
    if name in MODELS:
        return read_family(MODELS[name], read_table_file(f"{FOLDER}/{name}.yaml"))
    if name in plugin_families():
        return _of_plugin(name)
    raise UnknownId("family", name, family_names())


def families() -> Mapping[str, Family[Any]]:
    """All families by name. Raises RegistryError, also where a file belongs to no family."""
    for name in names_in(FOLDER):
        if name not in family_names():
            document = read_table_file(f"{FOLDER}/{name}.yaml")
            expected = expected_one_of(family_names(), name)
            raise RegistryError(document.file, 1, "", expected, f"a file called {name!r}")
    return MappingProxyType({name: family(name) for name in family_names()})


def family_groups() -> Mapping[str, tuple[Family[Any], ...]]:
    """All families by their group, such as `cabinets` or `cooking`."""
    groups = {group: tuple(family(m.name) for m in models) for group, models in GROUPS.items()}
    added = {PLUGIN_GROUP: tuple(map(family, plugin_families()))} if plugin_families() else {}
    return MappingProxyType({**groups, **added})


def _of_plugin(name: str) -> Family[Any]:
    """A family that a plug-in adds, with the presets that a project states for it."""
    plugin, made = plugin_families()[name]
    known = load().fixtures
    if made.category not in known:
        expected = f"its category to be {expected_one_of(tuple(known), made.category)}; a row of fixtures.yaml"
        raise CasaError(f"{plugin.where}: family {name}: expected {expected}, got {made.category!r}")
    if name not in names_in(FOLDER):
        return made
    document = read_table_file(f"{FOLDER}/{name}.yaml")
    rows = read_record(AddedPresets, document.value, document, ()).presets
    added = {preset: read_record(made.params, row, document, ("presets", preset)) for preset, row in rows.items()}
    return replace(made, presets=MappingProxyType({**made.presets, **added}))


@dataclass(frozen=True)
class Parameter:
    """A field of Params, for people.

    Attributes:
        name: of a field of a nested record such as a look, `look.face`.
        kind: `number`, `finish`, or the choices, such as `left | right`. default: as in YAML; empty if there is none.
        bounds: such as `0.2 to 1.2`; of a list, those of its length.
    """

    name: str
    kind: str
    default: str
    bounds: str
    description: str


def parameters_of(params: type[Params], at: str = "") -> list[Parameter]:
    """All fields of a family's Params in order, each followed by those of the record that it holds."""
    schema = params.model_json_schema()
    found = []
    for name, field in params.model_fields.items():
        row = schema["properties"][name]
        nested = [kind for kind in (field.annotation, *get_args(field.annotation)) if _is_params(kind)]
        default = "" if field.is_required() or _is_params(field.annotation) else json.dumps(row["default"]).strip('"')
        limits = {**row, **row.get("anyOf", [{}])[0]}
        low, high = (
            next((f"{limits[key]:g}" for key in keys if key in limits), "")
            for keys in (("minimum", "exclusiveMinimum", "minItems"), ("maximum", "exclusiveMaximum", "maxItems"))
        )
        bounds = f"{low} to {high}" if low and high else low and f"from {low}"
        kind = "finish" if is_finish(field) else _kind(row, schema.get("$defs", {}))
        found.append(Parameter(at + name, kind, default, bounds, field.description or ""))
        for record in nested:
            found += parameters_of(record, f"{at}{name}.")
    return found


def _is_params(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, Params)


def _kind(row: Mapping[str, Any], definitions: Mapping[str, Any]) -> str:
    """The type of a value by its JSON schema, in words."""
    if "$ref" in row:
        return _kind(definitions[row["$ref"].rpartition("/")[2]], definitions)
    if "anyOf" in row:
        return " | ".join(_kind(option, definitions) for option in row["anyOf"])
    if "enum" in row or "const" in row:
        return " | ".join(map(str, row.get("enum", [row.get("const")])))
    if row["type"] == "array":
        items = row.get("prefixItems") or [row["items"]]
        return f"list of {' and '.join(dict.fromkeys(_kind(item, definitions) for item in items))}"
    return {"integer": "whole number", "boolean": "true | false", "object": "record"}.get(row["type"], str(row["type"]))


def read_family(model: Family[Any], document: Document) -> Family[Any]:
    """The family that a document describes. Raises RegistryError with file, line, pointer, expected and got."""
    file = read_record(FamilyFile, document.value, document, ())
    categories = load().fixtures
    if file.category not in categories:
        raise document.fault(("category",), expected_one_of(tuple(categories), file.category), repr(file.category))
    if (file.sample is None) == (model.sample is None):
        expected = "rules" if file.sample is None else "no rules, since its code has `sample`"
        raise document.fault(("sample",), expected, "nothing" if file.sample is None else "rules")
    presets = {name: _preset(model, name, row, document) for name, row in file.presets.items()}
    return replace(
        model,
        sample=model.sample or read_sample_rules(model.params, file.sample or {}, document),
        title=file.title,
        category=file.category,
        description=file.description,
        presets=MappingProxyType(presets),
    )


def _preset(model: Family[Any], name: str, row: Any, document: Document) -> Params:
    """One preset; for a field of type CabinetLook, the name of a row of looks.yaml is accepted too."""
    at: KeyPath = ("presets", name)
    if isinstance(row, dict):
        row = dict(row)
        for key, value in row.items():
            field = model.params.model_fields.get(key)
            if isinstance(value, str) and field is not None and field.annotation is LOOKS["cabinet"]:
                if value not in looks():
                    raise document.fault((*at, key), expected_one_of(tuple(looks()), value), repr(value))
                row[key] = looks()[value]
    made: Params = read_record(model.params, row, document, at)
    return made


@read_once
def looks() -> Mapping[str, Params]:
    """The named looks of cabinets: kind of front, handle, finishes. Raises RegistryError."""
    document = read_table_file(NAMED_LOOKS)
    if not isinstance(document.value, dict):
        raise document.fault((), "a mapping of names to looks", type(document.value).__name__)
    rows = document.value.items()
    return MappingProxyType({name: read_record(LOOKS["cabinet"], row, document, (name,)) for name, row in rows})


@read_once
def look_samplers() -> Mapping[type[Params], Callable[[np.random.Generator, AvailableFinishes], Params]]:
    """How a look of each type is drawn. Raises RegistryError."""
    document = read_table_file(LOOK_RULES)
    rules = read_record(LookRules, document.value, document, ())
    return {look: read_sample_rules(look, getattr(rules, name), document, (name,)) for name, look in LOOKS.items()}


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
    for name, member in _object_rows().items():
        found.setdefault(member[0], []).append(name)
    return MappingProxyType({name: tuple(rows) for name, rows in found.items()})


def object_family(name: str) -> Family[Any]:
    """The family of the objects of a category. Raises UnknownId with the nearest names, RegistryError."""
    rows = _object_rows()
    if name not in rows:
        raise UnknownId("category of objects", name, rows)
    return rows[name][1]


def object_names() -> tuple[str, ...]:
    """Categories of which there are objects, file by file."""
    return tuple(_object_rows())


@read_once
def _object_rows() -> Mapping[str, tuple[str, Family[Any]]]:
    """Of each category the name of its file and its family."""
    found: dict[str, tuple[str, Family[Any]]] = {}
    for stem in names_in(OBJECTS):
        document = read_table_file(f"{OBJECTS}/{stem}.yaml")
        if not isinstance(document.value, dict):
            raise document.fault((), "a mapping of categories to objects", type(document.value).__name__)
        for name in document.value:
            if name in found:
                message = f"a category that no other file has; to change its row, use {OBJECTS}/{found[name][0]}.yaml"
                raise document.fault((name,), message, repr(name))
            found[name] = (stem, _object_family(str(name), document))
    return MappingProxyType(found)


def _object_family(name: str, document: Document) -> Family[Any]:
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
        form, name=name, sample=rules, title=name.replace("_", " "), category=name, description=row.about, form=row.form
    )
