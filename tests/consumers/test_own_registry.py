"""Rows and files for registry/ that pages of docs/howto show: put into a checkout, they do what the page says."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from tests.documents import ROOT, blocks, pages, program
from tests.libraries import with_cache

pytestmark = pytest.mark.consumers
MAIN = ("-c", "from casa_assets.cli.main import main; main()")
NAMED = re.compile(r"# registry/([\w/]+\.yaml)\n")


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory, cache: Path) -> Path:
    """A copy of the program and its registry, with every row and file in it that the pages show."""
    folder = tmp_path_factory.mktemp("checkout")
    for name in ("casa_assets", "registry"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shown = [(NAMED.match(b.code), b) for page in pages() for b in blocks(page) if b.language == "yaml"]
    found = [(match[1], block.code[match.end() :]) for match, block in shown if match]
    assert len(found) == 4
    for name, text in found:
        assert yaml.safe_load(text)
        path = folder / "registry" / name
        before = f"{path.read_text(encoding='utf-8')}\n" if path.exists() else ""
        path.write_text(before + text, encoding="utf-8")
    with_cache(folder / "out" / "scenes", cache)
    return folder


def run(checkout: Path, *words: str) -> subprocess.CompletedProcess[str]:
    environment = {**program(), "PYTHONPATH": str(checkout)}
    return subprocess.run(
        [sys.executable, *words], cwd=checkout, env=environment, capture_output=True, text=True, check=False
    )


def command_line(checkout: Path, *words: str) -> str:
    done = run(checkout, *MAIN, *words)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_plan_in_a_style(checkout: Path) -> None:
    listed = command_line(checkout, "scenes", "list")
    assert "studio" in listed
    assert "harbour" in listed
    command_line(checkout, "scene", "new", "studio", "--style", "harbour", "--seed", "3", "--json")
    facts = json.loads((checkout / "out/scenes/studio__harbour__s3/scene.json").read_text(encoding="utf-8"))
    assert 4.4 <= facts["parameters"]["width"] <= 5.0
    assert facts["surfaces"]["cabinet"] == "paint_powder_blue"
    assert {"sink", "main_range", "main_fridge", "toaster"} <= {f["name"] for f in facts["fixtures"]}


def test_a_word_that_is_wrong_is_told_with_its_line(checkout: Path) -> None:
    plan = checkout / "registry" / "plans" / "studio.yaml"
    text = plan.read_text(encoding="utf-8")
    plan.write_text(text.replace("- dishwasher", "- dishwahser"), encoding="utf-8")
    try:
        done = run(checkout, *MAIN, "scene", "new", "studio", "--style", "harbour")
    finally:
        plan.write_text(text, encoding="utf-8")
    assert done.returncode == 2
    line = text[: text.index("- dishwasher")].count("\n") + 1
    assert re.search(rf"studio\.yaml:{line}: runs\.main\.base\.3", done.stderr + done.stdout)


def test_a_texture(checkout: Path) -> None:
    assert "1 texture and 0 sets checked, 0 with faults" in command_line(
        checkout, "textures", "check", "plaster_harbour"
    )
    assert "plaster_harbour" in command_line(checkout, "textures", "list", "--set", "wall", "--json")


def test_a_category(checkout: Path) -> None:
    code = "from casa_assets import registry; print(registry.load().categories['honey_dipper'].mass_kg)"
    done = run(checkout, "-c", code)
    assert done.returncode == 0, done.stderr
    assert "0.03" in done.stdout
