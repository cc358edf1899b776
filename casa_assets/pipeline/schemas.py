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
from casa_assets.model.asset.asset import Asset
from casa_assets.model.formats.batch_schema import BatchFile
from casa_assets.model.formats.behavior_schema import BehaviorFile
from casa_assets.model.formats.scene_schema import SceneFile
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.style import Style
from casa_assets.model.record import Record
from casa_assets.pipeline.kitchens.scene_page import SceneReport
from casa_assets.pipeline.library.asset_json import SLOTS
from casa_assets.pipeline.library.library import Certificate
from casa_assets.pipeline.plans.schema import plan_as_written, style_as_written

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


class _Described(GenerateJsonSchema):
    """Schemas whose properties are described by the section `Attributes` of the docstring of their record."""

    def model_schema(self, schema: core_schema.ModelSchema) -> JsonSchemaValue:
        made = super().model_schema(schema)
        fields: dict[str, str] = {}
        for kind in (k for k in reversed(schema["cls"].__mro__) if issubclass(k, Record)):
            made["description"], said = _docstring(kind)
            fields |= said
        for name, field in schema["cls"].model_fields.items():
            row = made.get("properties", {}).get(field.alias or name)
            if row is not None and name in fields:
                row["description"] = fields[name]
        return made

    def handle_invalid_for_json_schema(self, schema: core_schema.CoreSchema, error_info: str) -> JsonSchemaValue:
        """Arrays of meshes have no schema: `_asset` puts files in their place."""
        return {}


def _docstring(kind: type[BaseModel]) -> tuple[str, dict[str, str]]:
    """First paragraphs of a record's docstring as one text, and its fields with what it says of them."""
    summary, _, rest = (inspect.getdoc(kind) or "").partition("\n\nAttributes:\n")
    names = "|".join(kind.model_fields)
    parts = re.split(rf"(?:^|(?<=[.;] ))((?:{names})(?:, (?:{names}))*): ", " ".join(rest.split()))
    said = {
        name: text.strip() for named, text in zip(parts[1::2], parts[2::2], strict=True) for name in named.split(", ")
    }
    return " ".join(summary.split()), said


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


SCHEMAS: dict[str, Callable[[], dict[str, Any]]] = {
    "asset": _asset,
    "batch": lambda: _of(BatchFile),
    "behavior": lambda: _of(BehaviorFile),
    "plan": lambda: plan_as_written(_of(Plan)),
    "scene": lambda: _of(SceneFile),
    "scene_report": lambda: _of(SceneReport),
    "style": lambda: style_as_written(_of(Style)),
}
TITLES = {"plan": "plan, a YAML file", "scene_report": "report.json of a scene", "style": "style, a YAML file"}


def title_of(name: str) -> str:
    """The file that a schema describes."""
    return TITLES.get(name, f"{name}.json")


def schema_text(name: str) -> str:
    """JSON Schema (2020-12) of a file, as docs/reference/schemas has it. Raises UnknownId."""
    if name not in SCHEMAS:
        raise UnknownId("schema", name, SCHEMAS)
    made = {"$schema": DIALECT, **SCHEMAS[name](), "title": title_of(name)}
    return json.dumps(made, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
