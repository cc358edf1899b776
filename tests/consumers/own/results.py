"""What a user's script or command has made, told in one form: scenes and assets with what was checked of them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.support.program.environments import Environment


@dataclass(frozen=True)
class Checked:
    """A scene or an asset that was checked.

    Attributes:
        passed: verdict of the checks. facts: content of scene.json, or the record of the asset in asset.json.
        results: of each check, by its code. versions: of what made it, as its certificate states them.
    """

    passed: bool
    facts: Mapping[str, Any]
    results: Mapping[str, Mapping[str, Any]]
    versions: Mapping[str, str] = field(default_factory=dict)


def by_code(report: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    return {result["code"]: result for result in report["results"]}


def certified(folder: Path) -> Checked:
    """The asset in a folder of a library: it is there since it has passed."""
    read = json.loads((folder / "asset.json").read_text(encoding="utf-8"))
    certificate = read["certificate"]
    return Checked(True, read["asset"], by_code(certificate["report"]), certificate["versions"])


def only_entry(library: Path, category: str) -> Path:
    (found,) = (path.parent for path in library.glob(f"{category}/*/asset.json"))
    return found


# Begins the scripts of users: what `Checked` holds, of what Python has made.
TELLING = """
import json
from pathlib import Path
import casa_assets as casa

told = {}

def tell(name, report, facts, versions=None):
    results = [r.model_dump(mode="json") for r in report.results]
    told[name] = {"passed": report.passed, "facts": facts, "results": results, "versions": versions or {}}

def tell_asset(name, asset, report=None):
    folder = asset.write("out/by_python")
    record = json.loads((folder / "asset.json").read_text())["asset"]
    tell(name, report or asset.check(), record)

def end():
    Path("told.json").write_text(json.dumps(told))
"""


def told_by(environment: Environment, folder: Path, script: str) -> dict[str, Checked]:
    environment.python(script, cwd=folder)
    read = json.loads((folder / "told.json").read_text(encoding="utf-8"))
    return {n: Checked(r["passed"], r["facts"], by_code(r), r["versions"]) for n, r in read.items()}
