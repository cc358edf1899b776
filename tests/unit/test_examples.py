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


def made(script: str, out: Path, **environment: str) -> dict[str, bytes]:
    words = [sys.executable, str(EXAMPLES / script), str(out)]
    subprocess.run(words, env={**os.environ, **environment}, check=True, capture_output=True)
    return contents(out)


@pytest.mark.parametrize("hash_seed", ["0", "4711"])
def test_script_makes_the_committed_bytes(tmp_path: Path, hash_seed: str) -> None:
    found, committed = made("make_meshes.py", tmp_path, PYTHONHASHSEED=hash_seed), contents(EXAMPLES / "meshes")
    assert sorted(found) == sorted(committed)
    assert [name for name in found if found[name] != committed[name]] == []


def test_samples_are_small_and_the_readme_lists_each_once() -> None:
    assert sum(map(len, contents(EXAMPLES / "meshes").values())) < 1_500_000
    table = re.findall(r"^\| `([a-z_]+\.[a-z]+)`", (EXAMPLES / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    companions = {".mtl", ".bin", ".png", ".json"}
    assert table == sorted(name for name in contents(EXAMPLES / "meshes") if Path(name).suffix not in companions)


def test_appliances_are_what_their_script_makes(tmp_path: Path) -> None:
    committed = contents(EXAMPLES / "appliances")
    assert made("make_appliances.py", tmp_path / "made", CASA_ASSETS_CACHE=str(tmp_path / "cache")) == committed
    assert sum(map(len, committed.values())) < 400_000
