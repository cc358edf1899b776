"""What a cluster answers where a job, a machine or an address is at fault."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from tests.consumers.cluster.machines import (
    ask,
    end,
    few_meshes,
    full_disk,
    machines,
    other_version,
    start_on,
    wrong_clock,
)

pytestmark = pytest.mark.consumers


def test_a_job_that_kills_what_does_it_is_rejected_after_two(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    with machines({}, {}) as cluster:
        found = ask(cluster.address, ("answer", "one"), ("kill_all_above", str(mark)), ("abort", ""), ("answer", "two"))
    assert (found[0], found[3]) == ("ONE", "TWO")
    assert found[1] == {"reason": "killed", "message": "the process was ended from outside, twice"}
    assert mark.read_text(encoding="ascii").split() == ["once", "once"]
    assert found[2]["reason"] == "signal"


@pytest.mark.certify  # in CI: tests/consumers/cluster/test_losses.py has a machine with a wrong clock
def test_a_wrong_clock_ends_no_job() -> None:
    with machines({}, wrong_clock(-400)) as cluster:
        found = ask(cluster.address, *[("clock", "1")] * 6)
    assert {round((time.time() - one) / 86400) for one in found} == {0, 400}


def test_another_version_on_one_machine_ends_the_run() -> None:
    with machines({}, other_version()) as cluster:
        found = ask(cluster.address, *[("burn", "1")] * 6)
    assert "has another version of casa-assets" in found["error"]


def test_a_cluster_of_full_disks_ends_the_run() -> None:
    with machines(full_disk(), full_disk()) as cluster:
        found = ask(cluster.address, ("answer", "word"))
    assert found["error"].startswith("no machine of the cluster has room on its disk:\n")
    assert found["error"].count("0.0 MB are free") == 2


def test_no_cluster_at_an_address_is_a_clear_error(tmp_path: Path) -> None:
    inputs = few_meshes(tmp_path / "meshes")
    run = start_on("127.0.0.1:1", inputs, tmp_path / "x")
    assert "no Ray cluster answers at 127.0.0.1:1" in end(run, 2, 120)
