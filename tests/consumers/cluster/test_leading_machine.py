"""Runs whose own machine loses Ray, or whose cluster loses its head; Ray takes a minute to notice."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.consumers.cluster.machines import ask, end, few_meshes, machines, start, start_on
from tests.support.library.libraries import differences
from tests.support.program.environments import wait_until

pytestmark = pytest.mark.certify


def test_a_run_whose_own_ray_is_lost_connects_again() -> None:
    with machines({}, {}) as cluster:
        found = ask(cluster.address, *[("burn", "1")] * 8, more=["--lose-ray"])
    assert found == ["burnt"] * 8


def test_a_cluster_whose_head_is_lost_ends_the_run(tmp_path: Path) -> None:
    inputs, library, expected = few_meshes(tmp_path / "meshes"), tmp_path / "library", tmp_path / "expected"
    with machines({}) as cluster:
        run = start_on(cluster.address, inputs, library)
        wait_until(lambda: any(library.glob("*/*/asset.json")), run)
        assert cluster.kill("gcs_server")
        assert "is lost; start Ray again, then run the same command again" in end(run, 2, 120)
    for place in (library, expected):
        end(start("ingest", inputs, "--library", place))
    assert differences(library, expected) == []
