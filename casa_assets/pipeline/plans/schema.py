"""JSON Schemas of plans and styles as people write them: of the records, with the short forms that these accept."""

from __future__ import annotations

from typing import Any

from casa_assets.model.kitchen.units import BaseKind, UpperKind
from casa_assets.registry.kitchens import LIKE

Schema = dict[str, Any]
# Tables whose rows may be written by id.
HAVE_IDS = ("walls", "openings", "columns", "runs", "worktop_items", "tables", "wall_items", "floor_items")
RECORDS = {
    "walls": "Wall",
    "openings": "PlanOpening",
    "columns": "Column",
    "runs": "Run",
    "worktop_items": "WorktopItem",
    "tables": "DiningTable",
    "wall_items": "WallItem",
    "floor_items": "FloorItem",
}


def plan_as_written(made: Schema) -> Schema:
    """Schema of a plan's file, of that of its record.

    Walls, openings and so on may be mappings of ids to rows, units may be short, parameters lists of three numbers, and
    `like` may stand for all that a plan has to state.
    """
    definitions: Schema = made["$defs"]
    _write_choices_short(definitions)
    for table in HAVE_IDS:
        record = RECORDS[table]
        definitions[f"{record}Row"] = _without(definitions[record], "id")
        rows = made["properties"][table]
        as_list = {k: rows.pop(k) for k in ("type", "items", "minItems") if k in rows}
        by_id: Schema = {
            "type": "object",
            "propertyNames": _id_of(definitions[record]),
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
    short: Schema = {
        "type": "array",
        "items": numbers,
        "minItems": 3,
        "maxItems": 3,
        "description": "default, low and high, metres",
    }
    definitions["Parameter"] = {"anyOf": [short, parameter], "description": parameter.pop("description", "")}
    whole: Schema = {}
    for table in HAVE_IDS:
        if needed := definitions[f"{RECORDS[table]}Row"].pop("required", None):
            whole[table] = {"additionalProperties": {"required": needed}}
    return _or_like(_without(made, "id"), whole)


def style_as_written(made: Schema) -> Schema:
    """Schema of a style's file, of that of its record: `range/pro_six` may stand for a choice, `like` for the rest."""
    definitions: Schema = made["$defs"]
    _write_choices_short(definitions)
    parts = {"cabinets": "CabinetStyle", "counter": "WorktopStyle", "island": "WorktopStyle", "room": "RoomStyle"}
    whole = {key: {"required": definitions[record]["required"]} for key, record in parts.items()}
    for record in parts.values():
        definitions[record].pop("required", None)
    return _or_like(_without(made, "id"), whole)


def _write_choices_short(definitions: Schema) -> None:
    """`range/pro_six` or `library:<id>` stands for a choice, or a mapping with what differs beside it."""
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
    """A schema of a record without one of its fields."""
    copy = {**record, "properties": {k: v for k, v in record["properties"].items() if k != field}}
    copy["required"] = [k for k in record.get("required", []) if k != field]
    return copy


def _id_of(record: Schema) -> Schema:
    return {k: v for k, v in record["properties"]["id"].items() if k in ("pattern", "maxLength")}


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
    """A schema of a file that states everything, or names one that it is like and states what differs.

    Args:
        whole: what its properties have to state where it is like no other.
    """
    required = made.pop("required")
    made["properties"] = {
        **made["properties"],
        LIKE: {"type": "string", "description": "name of one of its kind that it is like, but for what it states"},
    }
    made["anyOf"] = [{"required": [LIKE]}, {"required": required, "properties": whole}]
    return made
