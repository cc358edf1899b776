"""Whole sets of meshes through four shards, merged by the command line: file by file the library of one run."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.libraries import ROOT, casa, entries_of
from tests.sharded_inputs import public_differences

pytestmark = pytest.mark.certify

DATA = Path(os.environ.get("CASA_SHARED", "../shared")).absolute() / "data"
COUNT = 4
SETS = {
    "samples": [ROOT / "examples" / "meshes"],
    "development": [DATA / "dev" / name for name in ("objaverse", "text-to-3d", "appliances")],
    "wild": [DATA / "wild"],
    "hostile": [DATA / "bad" / "files"],
}
# A bomb that goes off dies of the first; what takes long on a busy machine does not end otherwise than on an idle one.
LIMITS = ("--memory", 2, "--timeout", 1200)


@pytest.mark.parametrize("name", SETS)
def test_four_shards_are_one_run(name: str, tmp_path: Path) -> None:
    sources = SETS[name]
    assert all(source.is_dir() for source in sources), "the shared data is missing; set CASA_SHARED"
    done = casa("ingest", *sources, "--library", tmp_path / "one", *LIMITS)
    assert done.returncode in (0, 1, 4), done.stderr
    shards = [tmp_path / "shards" / str(index) for index in range(1, COUNT + 1)]
    for index, shard in enumerate(shards, 1):
        part = casa("ingest", *sources, "--shard", f"{index}/{COUNT}", "--library", shard, *LIMITS)
        assert part.returncode in (0, 1, 4), part.stderr
    merged = casa("library", "merge", *shards, "--library", tmp_path / "merged")
    assert merged.returncode == done.returncode, merged.stderr
    assert len(entries_of(tmp_path / "one")) > 10
    assert public_differences(tmp_path / "one", tmp_path / "merged") == []
