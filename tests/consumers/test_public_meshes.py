"""109 public meshes of other makers, in the shapes that sources deliver, through the whole of ingest."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.support.library.libraries import input_rows

pytestmark = pytest.mark.certify

SHARED = Path(os.environ.get("CASA_SHARED", "../shared"))
OLDEST = Path(os.environ.get("CASA_MUJOCO331", ".venv-mujoco331/bin/python"))
OLD = Path(os.environ.get("CASA_MUJOCO337", ".venv-mujoco337/bin/python"))
GATES = ("MJC001", "MJC002", "MJC006", "USD002", "USD003", "PAR001", "PAR002", "PAR003", "PAR004")

LOAD = """
import sys, warnings
import mujoco
heard = []
mujoco.set_mju_user_warning(heard.append)
for path in sys.stdin.read().split("\\n"):
    with warnings.catch_warnings(record=True) as raised:
        warnings.simplefilter("always")
        mujoco.MjModel.from_xml_path(path)
    assert not heard and not raised, (path, heard, [str(w.message) for w in raised])
print(mujoco.__version__)
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[dict[str, Any]]]:
    """The library, and what the command line said of each input."""
    assert SHARED.is_dir(), f"{SHARED} is missing; set CASA_SHARED"
    library = tmp_path_factory.mktemp("public") / "library"
    sources = [str(SHARED / "data" / "dev" / name) for name in ("objaverse", "text-to-3d", "appliances")]
    command = [sys.executable, "-m", "casa_assets.cli.main", "ingest", *sources, "--library", str(library), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1, 4), done.stderr
    return library, input_rows(done.stdout)


def test_every_input_ends_with_a_verdict(run: tuple[Path, list[dict[str, Any]]]) -> None:
    rows = run[1]
    assert len(rows) == 109
    assert all(r["status"] != "rejected" or r["code"] for r in rows)
    assert not [r for r in rows if r["code"].startswith("RUN")]


def test_at_least_nine_of_ten_become_assets(run: tuple[Path, list[dict[str, Any]]]) -> None:
    rows = run[1]
    refused = [(r["path"], r["code"], r["message"]) for r in rows if r["status"] == "rejected"]
    assert len(refused) <= 0.1 * len(rows), refused


def test_every_certificate_names_the_gates(run: tuple[Path, list[dict[str, Any]]]) -> None:
    folders = [p.parent for p in run[0].glob("*/*/asset.json")]
    assert len(folders) == sum(r["status"] != "rejected" for r in run[1])
    for folder in folders:
        certificate = json.loads((folder / "asset.json").read_text(encoding="utf-8"))["certificate"]
        passed = {r["code"] for r in certificate["report"]["results"] if r["passed"]}
        wanted = set(GATES) if 'data="fixed"' not in (folder / "model.xml").read_text() else set(GATES) - {"MJC006"}
        assert wanted <= passed, (folder.name, wanted - passed)


@pytest.mark.parametrize("python", [Path(sys.executable), OLD, OLDEST], ids=["this", "3.3.7", "3.3.1"])
def test_mujoco_loads_all_without_a_warning(run: tuple[Path, list[dict[str, Any]]], python: Path) -> None:
    files = sorted(str(p) for name in ("model", "scene") for p in run[0].glob(f"*/*/{name}.xml"))
    done = subprocess.run([python, "-c", LOAD], input="\n".join(files), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not done.stderr.strip()


def test_the_simready_command_agrees(run: tuple[Path, list[dict[str, Any]]]) -> None:
    layers = sorted(run[0].glob("*/*/usd/*.usda"))[::10]
    assert layers
    validate = Path(sys.executable).with_name("simready-validate")
    for layer in layers:
        command = [validate, "--profile", "Robotics-Prop", "--version", "4.0.0", "-v", str(layer)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, (layer.name, done.stdout[-2000:], done.stderr[-2000:])
