"""JSON Schemas: those that are published are those of this code, and files that were really written keep to them."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from typer.testing import CliRunner

import casa_assets as casa
from casa_assets.api.schemas import SCHEMAS, schema_text
from casa_assets.cli.main import app
from casa_assets.layouts.run.recipe import SceneResult
from tests.support.program.documents import ROOT


def faults(name: str, data: Any) -> list[str]:
    """What a reader that knows nothing but the schema would find wrong, with its place."""
    schema = json.loads(schema_text(name))
    Draft202012Validator.check_schema(schema)
    return [f"{e.json_path}: {e.message}" for e in Draft202012Validator(schema).iter_errors(data)]


def content(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def test_published_schemas_are_up_to_date_and_printed() -> None:
    for name in SCHEMAS:
        path = ROOT / "docs" / "reference" / "schemas" / f"{name}.schema.json"
        assert path.read_text(encoding="utf-8") == schema_text(name), "run ./dev docs"
    assert CliRunner().invoke(app, ["schemas"]).stdout.split() == list(SCHEMAS)
    assert CliRunner().invoke(app, ["schemas", "scene"]).stdout == schema_text("scene")
    with pytest.raises(casa.UnknownId, match="scene"):
        schema_text("scenes")


def test_every_field_of_scene_json_is_described() -> None:
    schema = json.loads(schema_text("scene"))
    records = {"scene.json": schema, **schema["$defs"]}
    fields = [(name, field) for name, record in records.items() for field in record.get("properties", {})]
    assert len(fields) > 100
    assert [f for f in fields if not records[f[0]]["properties"][f[1]].get("description")] == []


def test_a_kitchen_and_its_report(checked_kitchen: tuple[Path, SceneResult]) -> None:
    out, done = checked_kitchen
    folder = Path(done.folder)
    scene = content(folder / "scene.json")
    assert faults("scene", scene) == []
    assert faults("scene_report", content(folder / "report.json")) == []
    machines = sorted((out / "assets" / "behavior").glob("*.json"))
    assert machines
    assert [f for path in machines for f in faults("behavior", content(path))] == []

    broken = copy.deepcopy(scene)
    broken["fixtures"][0]["quaternion"] = [1.0, 0.0, 0.0]
    assert "quaternion" in "".join(faults("scene", broken))
    del broken["parking"]
    assert any("parking" in fault for fault in faults("scene", broken))


def test_assets(boxes: Path, tmp_path: Path) -> None:
    ingested = sorted((boxes / "library").glob("*/*/asset.json"))
    assert ingested
    built = casa.build("microwave", "steel").write(tmp_path) / "asset.json"
    for path in (*ingested, built):
        assert faults("asset", content(path)) == [], path
    assert faults("behavior", content(built.with_name("behavior.json"))) == []
    broken = content(built)
    broken["asset"]["links"][0]["visuals"][0]["mesh"] = "box.obj"
    assert any("mesh" in fault for fault in faults("asset", broken))
