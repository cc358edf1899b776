"""What a cluster answers if a job, a machine, a disk, an address or its head is at fault."""

from __future__ import annotations

import tempfile
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
    start,
    start_on,
    wrong_clock,
)
from tests.support.library.libraries import differences
from tests.support.program.environments import wait_until

pytestmark = pytest.mark.consumers
MOUNT = 'mount -t tmpfs -o size=1m none "$0" && exec "$@"'


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


@pytest.mark.certify  # Ray takes a minute to notice
def test_a_run_whose_own_ray_is_lost_connects_again() -> None:
    with machines({}, {}) as cluster:
        found = ask(cluster.address, *[("burn", "1")] * 8, more=["--lose-ray"])
    assert found == ["burnt"] * 8


@pytest.mark.certify  # Ray takes a minute to notice
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


@pytest.mark.certify
def test_a_machine_with_a_disk_of_one_megabyte_gets_no_jobs(tmp_path: Path) -> None:
    """A disk for temporary files that is really full; mounting one takes a right (`unshare`)."""
    within = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c", MOUNT, str(tmp_path)]
    with machines({}, {"TMPDIR": str(tmp_path)}, within=within) as cluster:
        found = ask(cluster.address, *[("temporary_folder", "1")] * 6)
    assert set(found) == {tempfile.gettempdir()} != {str(tmp_path)}
