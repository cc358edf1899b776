"""Documents as far as they need not be run: code blocks, links, files that they name; JSON Schemas, as published."""

from __future__ import annotations

import ast
import copy
import json
import re
import shlex
import subprocess
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from typer.testing import CliRunner

import casa_assets as casa
from casa_assets.api.schemas import SCHEMAS, schema_text
from casa_assets.cli.main import app
from casa_assets.formats.read.formats import SUFFIXES
from casa_assets.layouts.run.recipe import SceneResult
from tests.architecture.test_commands import unknown
from tests.support.program.documents import LANGUAGES, REASONS, ROOT, Block, blocks, indented, pages

BLOCKS = [block for page in pages() for block in blocks(page)]
BENCHMARKS = subprocess.check_output([ROOT / "dev", "bench"], text=True).split()


def test_every_block_says_what_it_is_and_most_are_run() -> None:
    assert [block for block in BLOCKS if block.language not in LANGUAGES] == []
    assert [(block, block.reason) for block in BLOCKS if block.reason and block.reason not in REASONS] == []
    assert [page for page in pages() if indented(page)] == []
    code = [block for block in BLOCKS if block.language in ("sh", "python")]
    ours = [block for block in code if block.page.startswith(("README", "docs/quick", "docs/howto"))]
    assert sum(not b.reason for b in ours) > 0.6 * len(ours) > 40
    python = [b for b in ours if b.page in ("README.md", "docs/howto/use/python.md") and b.language == "python"]
    assert [b for b in python if b.reason] == []


def wrong(command: str, block: Block) -> bool:
    """Whether a command of a page is none that the program, `./dev` or an environment has."""
    words = [w for w in shlex.split(command) if not re.fullmatch(r"\w+=.*", w)]
    if words[0] == "casa-assets":
        return bool(unknown(words[1:]))
    if words[0] == "./dev":
        known = f"\n  {words[1]} " in (ROOT / "dev").read_text(encoding="utf-8")
        return not known or (words[1] == "bench" and len(words) > 2 and words[2] not in BENCHMARKS)
    program = Path(words[0]).name  # of a separate environment, where a folder is named
    return program != "python" and not (
        block.reason and program in ("python3", "python3.11", "python3.12", "pip", "source")
    )


def test_commands_take_their_options() -> None:
    lines = [(block, command) for block in BLOCKS if block.language == "sh" for command in block.commands]
    assert [f"{block}: {command}" for block, command in lines if wrong(command, block)] == []


def test_what_no_reader_of_the_pages_runs_parses() -> None:
    for block in BLOCKS:
        if block.language == "python" and block.reason:
            ast.parse(block.code, filename=str(block))
        if block.language == "json":
            assert json.loads(block.code), block


# Where a path of a document may start, beside the root of the repository.
STARTS = ("", "casa_assets/", "tests/")
LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)")
NAMED = re.compile(r"`([\w./]+/[\w.]+\.(?:py|yaml|md|txt|toml))`")


def test_links_and_pictures_lead_somewhere() -> None:
    for page in pages():
        links = [link for link in LINK.findall((ROOT / page).read_text(encoding="utf-8")) if "://" not in link]
        assert [link for link in links if not (ROOT / Path(page).parent / link).exists()] == [], page


def test_files_that_are_named_and_samples_that_commands_read_exist() -> None:
    for page in pages():
        made = " ".join(block.code for block in blocks(page) if block.language == "python")
        words = [word for b in blocks(page) if b.language == "sh" for line in b.commands for word in line.split()]
        samples = [word.strip("'\"") for word in words if word.startswith("examples/")]
        assert [sample for sample in samples if not list(ROOT.glob(sample)) and sample not in made] == [], page
    for page in (*pages(), "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md"):
        named = NAMED.findall((ROOT / page).read_text(encoding="utf-8"))
        found = [path for path in named if not path.startswith(("out/", "rejected/", "usd/", "meshes/"))]
        assert [path for path in found if not any((ROOT / start / path).is_file() for start in STARTS)] == [], page


def faults(name: str, data: Any) -> list[str]:
    """What a reader that knows nothing but the schema would find wrong, with its place."""
    schema = json.loads(schema_text(name))
    Draft202012Validator.check_schema(schema)
    return [f"{e.json_path}: {e.message}" for e in Draft202012Validator(schema).iter_errors(data)]


def content(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def test_the_page_of_formats_has_the_suffixes_that_are_read() -> None:
    page = (ROOT / "docs/reference/input_formats.md").read_text(encoding="utf-8")
    assert {suffix for suffix in SUFFIXES if f"`{suffix}`" not in page} == set()


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
