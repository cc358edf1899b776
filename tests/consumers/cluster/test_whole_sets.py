"""Whole sets of meshes in three ways: file by file one library, whoever did the work."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.consumers.cluster.machines import machines, start
from tests.support.library.libraries import ROOT, casa, entries_of
from tests.support.library.sharded_inputs import public_differences
from tests.support.program.environments import wait_until

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
def test_one_machine_shards_and_a_cluster_that_loses_one_make_one_library(name: str, tmp_path: Path) -> None:
    sources = SETS[name]
    assert all(source.is_dir() for source in sources), "the shared data is missing; set CASA_SHARED"
    one, merged, cluster = (tmp_path / place for place in ("one", "merged", "cluster"))
    done = casa("ingest", *sources, "--library", one, *LIMITS)
    assert done.returncode in (0, 1, 4), done.stderr
    assert len(entries_of(one)) > 10
    shards = [tmp_path / "shards" / str(index) for index in range(1, COUNT + 1)]
    for index, shard in enumerate(shards, 1):
        part = casa("ingest", *sources, "--shard", f"{index}/{COUNT}", "--library", shard, *LIMITS)
        assert part.returncode in (0, 1, 4), part.stderr
    joined = casa("library", "merge", *shards, "--library", merged)
    assert joined.returncode == done.returncode, joined.stderr
    assert public_differences(one, merged) == []
    with machines({}, {}) as two:
        run = start(
            "ingest", *sources, "--library", cluster, *LIMITS, "--quiet", "--engine", "ray", "--address", two.address
        )
        wait_until(lambda: len(entries_of(cluster)) > len(entries_of(one)) / 2, run, most_s=7200)
        two.order("kill")
        text, _ = run.communicate()
    assert run.returncode == done.returncode, text
    assert public_differences(one, cluster) == []
