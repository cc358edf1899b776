"""JSON Schemas of files that other programs read or write, made of records; who writes one holds it against its own."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Callable
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from casa_assets.errors import UnknownId
from casa_assets.layouts.run.scene_page import SceneReport
from casa_assets.library.entry_files import SLOTS, Certificate
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.plan import BaseKind, Plan, UpperKind
from casa_assets.model.kitchen.style import Style
from casa_assets.model.record import Record
from casa_assets.model.written_formats import BatchFile, BehaviorFile, SceneFile
from casa_assets.registry.kitchens import LIKE

DIALECT = "https://json-schema.org/draft/2020-12/schema"
# In asset.json a mesh and a picture are files beside it.
MESH_FILE = {
    "type": "object",
    "title": "Mesh",
    "description": "A mesh in a file of the same folder.",
    "properties": {"obj": {"type": "string", "description": "path of the OBJ file, relative to the folder"}},
    "required": ["obj"],
    "additionalProperties": False,
}
PICTURE_FILE = {"type": "string", "description": "path of the PNG file, relative to the folder"}
Schema = dict[str, Any]
# Tables of plans whose rows may be written by id, and their records.
HAVE_IDS = {
    "walls": "Wall",
    "openings": "PlanOpening",
    "columns": "Column",
    "runs": "Run",
    "worktop_items": "WorktopItem",
    "tables": "DiningTable",
    "wall_items": "WallItem",
    "floor_items": "FloorItem",
}
TITLES = {"plan": "plan, a YAML file", "scene_report": "report.json of a scene", "style": "style, a YAML file"}


class _Described(GenerateJsonSchema):
    """Schemas whose properties are described by the section `Attributes` of the docstring of their record."""

    def model_schema(self, schema: core_schema.ModelSchema) -> JsonSchemaValue:
        made = super().model_schema(schema)
        fields: dict[str, str] = {}
        for kind in (k for k in reversed(schema["cls"].__mro__) if issubclass(k, Record)):
            made["description"], described = _docstring(kind)
            fields |= described
        for name, field in schema["cls"].model_fields.items():
            row = made.get("properties", {}).get(field.alias or name)
            if row is not None and name in fields:
                row["description"] = fields[name]
        return made

    def handle_invalid_for_json_schema(self, schema: core_schema.CoreSchema, error_info: str) -> JsonSchemaValue:
        """Arrays of meshes have no schema: `_asset` puts files in their place."""
        return {}


def _docstring(kind: type[BaseModel]) -> tuple[str, dict[str, str]]:
    """First paragraphs of a record's docstring as one text, and its fields with its words on them."""
    summary, _, rest = (inspect.getdoc(kind) or "").partition("\n\nAttributes:\n")
    names = "|".join(kind.model_fields)
    parts = re.split(rf"(?:^|(?<=[.;] ))((?:{names})(?:, (?:{names}))*): ", " ".join(rest.split()))
    described = {
        name: text.strip() for named, text in zip(parts[1::2], parts[2::2], strict=True) for name in named.split(", ")
    }
    return " ".join(summary.split()), described


def _of(kind: type[BaseModel]) -> dict[str, Any]:
    return kind.model_json_schema(schema_generator=_Described)


def _asset() -> dict[str, Any]:
    asset, certificate = _of(Asset), _of(Certificate)
    definitions = asset.pop("$defs") | certificate.pop("$defs")
    definitions |= {"Asset": asset, "Certificate": certificate, "Mesh": MESH_FILE}
    definitions["Texture"]["properties"]["png"] = PICTURE_FILE
    definitions["Material"]["required"] = sorted({*definitions["Material"].get("required", []), *SLOTS})
    return {
        "title": "asset.json",
        "description": "An asset, and in a library the certificate of its checks.",
        "type": "object",
        "properties": {"asset": {"$ref": "#/$defs/Asset"}, "certificate": {"$ref": "#/$defs/Certificate"}},
        "required": ["asset"],
        "additionalProperties": False,
        "$defs": definitions,
    }


def plan_as_written(made: Schema) -> Schema:
    """The schema of a plan's file, given that of its record: tables may be mappings, units and parameters short."""
    definitions: Schema = made["$defs"]
    _write_choices_short(definitions)
    for table, record in HAVE_IDS.items():
        definitions[f"{record}Row"] = _without(definitions[record], "id")
        rows, named = made["properties"][table], definitions[record]["properties"]["id"]
        as_list = {k: rows.pop(k) for k in ("type", "items", "minItems") if k in rows}
        by_id: Schema = {
            "type": "object",
            "propertyNames": {k: v for k, v in named.items() if k in ("pattern", "maxLength")},
            "additionalProperties": {"$ref": f"#/$defs/{record}Row"},
        }
        if "minItems" in as_list:
            by_id["minProperties"] = as_list["minItems"]
        rows.pop("default", None)
        rows["anyOf"] = [by_id, as_list]
    for row, record, kinds in (("base", "BaseUnit", BaseKind), ("upper", "UpperUnit", UpperKind)):
        definitions[f"{record}Short"] = _unit(definitions[record], [str(k) for k in kinds])
        for run in ("Run", "RunRow"):
            definitions[run]["properties"][row]["items"] = {"$ref": f"#/$defs/{record}Short"}
    parameter = definitions["Parameter"]
    numbers: Schema = {"type": "number", "exclusiveMinimum": 0}
    short: Schema = {"type": "array", "items": numbers, "minItems": 3, "maxItems": 3}
    short["description"] = "default, low and high, metres"
    definitions["Parameter"] = {"anyOf": [short, parameter], "description": parameter.pop("description", "")}
    whole: Schema = {}
    for table, record in HAVE_IDS.items():
        if needed := definitions[f"{record}Row"].pop("required", None):
            whole[table] = {"additionalProperties": {"required": needed}}
    return _or_like(_without(made, "id"), whole)


def style_as_written(made: Schema) -> Schema:
    """The schema of a style's file, given that of its record: `range/pro_six` for a choice, `like` another style."""
    definitions: Schema = made["$defs"]
    _write_choices_short(definitions)
    parts = {"cabinets": "CabinetStyle", "counter": "WorktopStyle", "island": "WorktopStyle", "room": "RoomStyle"}
    whole = {key: {"required": definitions[record]["required"]} for key, record in parts.items()}
    for record in parts.values():
        definitions[record].pop("required", None)
    return _or_like(_without(made, "id"), whole)


def _write_choices_short(definitions: Schema) -> None:
    """Allow choices as `range/pro_six` or `library:<id>`, or as a mapping with such a preset and its differences."""
    choice = definitions["PresetChoice"]
    name = {**choice["properties"]["preset"], "pattern": r"^([a-z][a-z0-9_]*/|library:)[a-z][a-z0-9_]*$"}
    definitions["PresetChoice"] = {
        "description": choice["description"],
        "anyOf": [
            name,
            {"type": "object", "properties": {"preset": name}, "required": ["preset"], "additionalProperties": True},
        ],
    }


def _without(record: Schema, field: str) -> Schema:
    copy = {**record, "properties": {k: v for k, v in record["properties"].items() if k != field}}
    copy["required"] = [k for k in record.get("required", []) if k != field]
    return copy


def _unit(record: Schema, kinds: list[str]) -> Schema:
    """A unit: its kind, `kind: width`, `kind: {fields}`, or all its fields."""
    fields = _without(_without(record, "kind"), "id")
    fields["properties"] = {"id": record["properties"]["id"], **fields["properties"]}
    width = {k: v for k, v in record["properties"]["width"].items() if k != "default"}
    row = {"anyOf": [*width["anyOf"], {k: v for k, v in fields.items() if k not in ("title", "description")}]}
    by_kind: Schema = {
        "type": "object",
        "properties": dict.fromkeys(kinds, row),
        "minProperties": 1,
        "maxProperties": 1,
        "additionalProperties": False,
    }
    return {"description": record["description"], "anyOf": [{"enum": kinds}, by_kind, record]}


def _or_like(made: Schema, whole: Schema) -> Schema:
    """A schema of a file that states everything, see `whole`, or names one that it is like and states what differs."""
    required = made.pop("required")
    made["properties"] = {
        **made["properties"],
        LIKE: {"type": "string", "description": "name of one of its kind that it is like, but for what it states"},
    }
    made["anyOf"] = [{"required": [LIKE]}, {"required": required, "properties": whole}]
    return made


SCHEMAS: dict[str, Callable[[], dict[str, Any]]] = {
    "asset": _asset,
    "batch": lambda: _of(BatchFile),
    "behavior": lambda: _of(BehaviorFile),
    "plan": lambda: plan_as_written(_of(Plan)),
    "scene": lambda: _of(SceneFile),
    "scene_report": lambda: _of(SceneReport),
    "style": lambda: style_as_written(_of(Style)),
}


def title_of(name: str) -> str:
    """The file that a schema describes."""
    return TITLES.get(name, f"{name}.json")


def schema_text(name: str) -> str:
    """JSON Schema (2020-12) of a file, as docs/reference/schemas has it. Raises UnknownId."""
    if name not in SCHEMAS:
        raise UnknownId("schema", name, SCHEMAS)
    made = {"$schema": DIALECT, **SCHEMAS[name](), "title": title_of(name)}
    return json.dumps(made, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
