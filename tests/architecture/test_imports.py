"""The import rules hold, and the linter that says so is able to say otherwise."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CONTRACTS = {
    contract["id"]: contract["name"]
    for contract in tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
}

# Contract, module that may not hold the line, line.
PLANTS = [
    ("layers", "export", "import casa_assets.ingest"),
    ("layers", "model/pose", "import casa_assets.pipeline"),
    ("layers", "errors", "import casa_assets.model.pose"),
    ("layers", "pipeline", "import casa_assets.cli"),
    ("layers", "checks", "from casa_assets import registry"),
    ("layers", "core", "import casa_assets.geometry"),
    ("writers", "export/mjcf", "from casa_assets.geometry.inertia import drop_unfelt_products"),
    ("writers", "export/usd", "from casa_assets.geometry.lightweight import lighten"),
    ("pxr", "model/pose", "from pxr import Usd"),
    ("pxr", "pipeline", "import pxr"),
    ("pxr", "export/mjcf", "from pxr import Gf"),
    ("mujoco", "export/mjcf", "import mujoco"),
    ("mujoco", "pipeline", "import mujoco"),
    ("trimesh", "geometry", "import trimesh"),
    ("packed", "pipeline", "import ufbx"),
    ("packed", "geometry", "import DracoPy"),
    ("exr", "pipeline", "import OpenEXR"),
    ("coacd", "pipeline", "import coacd"),
    ("coacd", "geometry", "import vhacdx"),
    ("terminal", "pipeline", "import rich.console"),
    ("terminal", "checks", "import typer"),
    ("yaml", "pipeline", "import yaml"),
    ("mink", "pipeline", "import mink"),
    ("mink", "checks", "import robosuite"),
    ("stores", "pipeline", "import fsspec"),
    ("stores", "cli", "import s3fs"),
    ("stores", "ingest", "import aiohttp"),
    ("learned", "cli", "import torch"),
]


def lint(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the import linter on the package in `folder`, with this project's contracts."""
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command as lint; lint()"]
    return subprocess.run(
        [*command, "--no-cache", "--no-logo", "--config", str(ROOT / "pyproject.toml"), *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder), "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A folder with a copy of the package that may be changed."""
    shutil.copytree(ROOT / "casa_assets", tmp_path / "casa_assets", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def test_contracts_hold() -> None:
    done = lint(ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{len(CONTRACTS)} kept, 0 broken" in done.stdout


def test_every_contract_has_a_plant() -> None:
    assert {contract for contract, _, _ in PLANTS} == set(CONTRACTS)


def test_every_contract_speaks_in_a_sentence() -> None:
    assert all(len(name.split()) >= 4 for name in CONTRACTS.values())


@pytest.mark.parametrize(("contract", "module", "line"), PLANTS)
def test_linter_reports_what_is_planted(copy: Path, contract: str, module: str, line: str) -> None:
    folder = copy / "casa_assets" / module
    target = folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")
    target.write_text(f"{target.read_text() if target.exists() else ''}\n{line}\n")
    done = lint(copy)
    assert done.returncode == 1, done.stdout + done.stderr
    assert f"{CONTRACTS[contract]} BROKEN" in done.stdout
    assert f"{len(CONTRACTS) - 1} kept, 1 broken" in done.stdout, "the plant broke another contract as well"


def test_a_new_package_needs_a_place(copy: Path) -> None:
    (copy / "casa_assets" / "utils").mkdir()
    (copy / "casa_assets" / "utils" / "__init__.py").touch()
    done = lint(copy)
    assert done.returncode == 1
    assert "utils" in done.stdout
