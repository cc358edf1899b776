"""The sample meshes are what their script makes, byte for byte."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("hash_seed", ["0", "4711"])
def test_script_makes_the_committed_bytes(tmp_path: Path, hash_seed: str) -> None:
    subprocess.run(
        [sys.executable, str(EXAMPLES / "make_meshes.py"), str(tmp_path)],
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        check=True,
        capture_output=True,
    )
    made, committed = contents(tmp_path), contents(EXAMPLES / "meshes")
    assert sorted(made) == sorted(committed)
    assert [name for name in made if made[name] != committed[name]] == []


def test_samples_are_small_and_the_readme_lists_each_once() -> None:
    assert sum(map(len, contents(EXAMPLES / "meshes").values())) < 1_500_000
    table = re.findall(r"^\| `([a-z_]+\.[a-z]+)`", (EXAMPLES / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    companions = {".mtl", ".bin", ".png", ".json"}
    mains = sorted(name for name in contents(EXAMPLES / "meshes") if Path(name).suffix not in companions)
    assert table == mains


def test_appliances_are_what_their_script_makes(tmp_path: Path) -> None:
    subprocess.run(
        [sys.executable, str(EXAMPLES / "make_appliances.py"), str(tmp_path / "made")],
        env={**os.environ, "CASA_ASSETS_CACHE": str(tmp_path / "cache")},
        check=True,
        capture_output=True,
    )
    made, committed = contents(tmp_path / "made"), contents(EXAMPLES / "appliances")
    assert made == committed
    assert sum(map(len, committed.values())) < 400_000
