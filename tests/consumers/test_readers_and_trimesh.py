"""Every good file of the shared data, read by our readers and by trimesh: each difference is explained by a rule.

The rules, with a sentence each, stand in tests/support/mesh/mesh_readings.py.
"""

from __future__ import annotations

import csv
import os
from pathlib import Path

import pytest

from casa_assets import registry
from tests.support.mesh.mesh_readings import differences, ours, theirs

pytestmark = pytest.mark.consumers

DATA = Path(os.environ.get("CASA_SHARED", "../shared")) / "data"
KINDS = (".glb", ".gltf", ".obj", ".ply", ".stl", ".dae")


def good_files() -> list[Path]:
    """Main files that a curator would keep, in the formats that our own readers read."""
    out = []
    for folder in ("dev", "wild"):
        with (DATA / folder / "truth.csv").open(encoding="utf-8") as table:
            rows = [r["file"] for r in csv.DictReader(table) if r.get("good", "yes") == "yes"]
        out += [DATA / folder / row for row in rows if Path(row).suffix.lower() in KINDS]
    return sorted(out)


def test_each_difference_has_its_rule() -> None:
    files = good_files()
    assert len(files) >= 140
    limits = registry.load().limits
    table = {}
    for path in files:
        if found := differences(path, ours(path, dict(limits)), theirs(path)):
            table[str(path.relative_to(DATA))] = found
    assert table == {}
