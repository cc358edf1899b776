"""What may stand in files of the project, and import what. What ruff can say of a source, ruff says (`./dev lint`)."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

# Read-only text of the project; built things and what the user makes are not ours to judge.
TEXT_SUFFIXES = {"", ".cfg", ".csv", ".json", ".md", ".obj", ".mtl", ".py", ".sh", ".toml", ".txt", ".yaml", ".yml"}
SKIPPED = re.compile(r"^(\.git|\.venv.*|\..*_cache|\.hypothesis|\.coverage.*|out|build|dist|__pycache__)$")

# Written in two halves, so that this file does not hold them.
FORBIDDEN = [
    re.compile("/wo" + r"rk/"),
    re.compile("/ro" + r"ot/"),
    re.compile("/ho" + r"me/[a-z]"),
    re.compile(r"https?://[^\s)>\"']*(pypi|pytho" + r"nhosted)", re.IGNORECASE),
    re.compile("(extra-)?index-u" + "rl"),
]


def texts() -> Iterator[Path]:
    folders = [ROOT]
    while folders:
        for path in sorted(folders.pop().iterdir()):
            if SKIPPED.match(path.name):
                continue
            if path.is_dir():
                folders.append(path)
            elif path.suffix in TEXT_SUFFIXES:
                yield path


def test_no_machine_or_index_is_named() -> None:
    found = [
        f"{path.relative_to(ROOT).as_posix()}:{number}: {pattern.pattern}"
        for path in texts()
        for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1)
        for pattern in FORBIDDEN
        if pattern.search(line)
    ]
    assert found == []


PINS = [line for line in (ROOT / "constraints.txt").read_text("utf-8").splitlines() if not line.startswith("#")]


def test_constraints_are_names_and_versions() -> None:
    pin = r"""[A-Za-z0-9_.-]+==[A-Za-z0-9_.+!-]+( ; python_version (<|>=) "3\.\d+")?"""
    assert [line for line in PINS if not re.fullmatch(pin, line)] == []


PYTHONS = ("3.11", "3.12", "3.13", "3.14")


def test_every_requirement_has_a_lowest_version_and_a_pin_above_it() -> None:
    pins: dict[str, list[Requirement]] = {}
    for pin in map(Requirement, PINS):
        pins.setdefault(canonicalize_name(pin.name), []).append(pin)
    project, extras = SETTINGS["project"], SETTINGS["project"]["optional-dependencies"]
    # torch has builds for each kind of processor and card, so what the extra clip brings is not pinned.
    pinned = [*project["dependencies"], *(line for name, lines in extras.items() if name != "clip" for line in lines)]
    for requirement in map(Requirement, [*pinned, *extras["clip"]]):
        assert {clause.operator for clause in requirement.specifier} & {">=", "=="}, f"{requirement} has no lower bound"
    for requirement in map(Requirement, pinned):
        held = pins.get(canonicalize_name(requirement.name), [])
        assert held, f"{requirement.name} is not in constraints.txt"
        for python in PYTHONS:
            environment = {"python_version": python, "python_full_version": f"{python}.0", "extra": ""}
            if requirement.marker is None or requirement.marker.evaluate(environment):
                here = [pin for pin in held if pin.marker is None or pin.marker.evaluate(environment)]
                assert len(here) == 1, f"{requirement.name} has {len(here)} pins on Python {python}"
                version = next(iter(here[0].specifier)).version
                assert requirement.specifier.contains(version, prereleases=True), f"{requirement} excludes {version}"


def lint(folder: Path) -> str:
    """What the import linter says of the package in `folder`, with this project's contracts, and its exit code."""
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command as lint; lint()"]
    words = [*command, "--no-cache", "--no-logo", "--config", str(ROOT / "pyproject.toml")]
    environment = {**os.environ, "PYTHONPATH": str(folder), "COLUMNS": "200"}
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    return f"{done.stdout}{done.stderr}exit code {done.returncode}"


def test_import_contracts_hold_and_an_import_that_goes_up_is_told(tmp_path: Path) -> None:
    contracts = {one["id"]: one["name"] for one in SETTINGS["tool"]["importlinter"]["contracts"]}
    told = lint(ROOT)
    assert f"{len(contracts)} kept, 0 broken" in told
    assert told.endswith("exit code 0")
    shutil.copytree(ROOT / "casa_assets", tmp_path / "casa_assets", ignore=shutil.ignore_patterns("__pycache__"))
    with (tmp_path / "casa_assets" / "errors.py").open("a", encoding="utf-8") as file:
        file.write("\nimport casa_assets.model.pose\n")
    told = lint(tmp_path)
    assert f"{contracts['layers']} BROKEN" in told
    assert f"{len(contracts) - 1} kept, 1 broken" in told
    assert told.endswith("exit code 1")
