"""Clusters whose jobs, machines, disks, clocks, addresses or heads fail, all on this machine."""

from __future__ import annotations

import signal
import tempfile
import time
from pathlib import Path

import pytest

from tests.consumers.cluster.machines import (
    JOB,
    RAY_WORKER,
    ask,
    begun_with,
    end,
    few_meshes,
    machines,
    start,
    start_on,
    wrong_clock,
)
from tests.support.library.libraries import differences
from tests.support.program.environments import wait_until

pytestmark = pytest.mark.consumers
MOUNT = 'mount -t tmpfs -o size=1m none "$0" && exec "$@"'


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return few_meshes(tmp_path_factory.mktemp("inputs") / "meshes")


@pytest.fixture(scope="module")
def expected(inputs: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    library = tmp_path_factory.mktemp("local") / "library"
    end(start("ingest", inputs, "--library", library))
    return library


def test_what_is_killed_in_the_middle_changes_nothing(inputs: Path, expected: Path, tmp_path: Path) -> None:
    library = tmp_path / "library"

    def finished() -> int:
        return len(list(library.glob("*/*/asset.json")))

    with machines({}, {}) as cluster:
        run = start_on(cluster.address, inputs, library)
        wait_until(lambda: finished() > 0, run)
        assert cluster.kill(JOB)
        wait_until(lambda: finished() > 1, run)
        assert cluster.kill(RAY_WORKER)
        wait_until(lambda: finished() > 2, run)
        cluster.order("kill")
        end(run)
    assert differences(library, expected) == []


def test_a_killed_run_is_resumed_by_the_next(inputs: Path, expected: Path, tmp_path: Path) -> None:
    library = tmp_path / "library"
    with machines({}, {}) as cluster:
        run = start_on(cluster.address, inputs, library)
        wait_until(lambda: any(library.glob("*/*/asset.json")), run)
        run.send_signal(signal.SIGKILL)
        run.wait()
        assert differences(library, expected)
        finished = {path: path.stat().st_mtime_ns for path in library.glob("*/*/asset.json")}
        end(start_on(cluster.address, inputs, library))
    assert {path: path.stat().st_mtime_ns for path in finished} == finished
    assert differences(library, expected) == []


def test_a_machine_with_a_full_disk_and_one_with_a_wrong_clock(inputs: Path, expected: Path, tmp_path: Path) -> None:
    library = tmp_path / "library"
    with machines({}, begun_with("full_disk"), wrong_clock()) as cluster:
        run = start_on(cluster.address, inputs, library)
        assert "a machine of the cluster gets no more jobs" in end(run)
    assert differences(library, expected) == []


def test_a_job_that_kills_what_does_it_is_rejected_after_two(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    with machines({}, {}) as cluster:
        found = ask(cluster.address, ("answer", "one"), ("kill_all_above", str(mark)), ("abort", ""), ("answer", "two"))
    assert (found[0], found[3]) == ("ONE", "TWO")
    assert found[1] == {"reason": "killed", "message": "the process was ended from outside, twice"}
    assert mark.read_text(encoding="ascii").split() == ["once", "once"]
    assert found[2]["reason"] == "signal"


@pytest.mark.certify  # in CI: a whole run on a cluster with such a machine
def test_a_wrong_clock_ends_no_job() -> None:
    with machines({}, wrong_clock(-400)) as cluster:
        found = ask(cluster.address, *[("clock", "1")] * 6)
    assert {round((time.time() - one) / 86400) for one in found} == {0, 400}


def test_another_version_on_one_machine_ends_the_run() -> None:
    with machines({}, begun_with("other_version")) as cluster:
        found = ask(cluster.address, *[("burn", "1")] * 6)
    assert "has another version of casa-assets" in found["error"]


def test_a_cluster_of_full_disks_ends_the_run() -> None:
    with machines(*[begun_with("full_disk")] * 2) as cluster:
        found = ask(cluster.address, ("answer", "word"))
    assert found["error"].startswith("no machine of the cluster has room on its disk:\n")
    assert found["error"].count("0.0 MB are free") == 2


def test_no_cluster_at_an_address_is_a_clear_error(inputs: Path, tmp_path: Path) -> None:
    run = start_on("127.0.0.1:1", inputs, tmp_path / "x")
    assert "no Ray cluster answers at 127.0.0.1:1" in end(run, 2, 120)


@pytest.mark.certify  # Ray takes a minute to notice
def test_a_run_whose_own_ray_is_lost_connects_again() -> None:
    with machines({}, {}) as cluster:
        found = ask(cluster.address, *[("burn", "1")] * 8, more=["--lose-ray"])
    assert found == ["burnt"] * 8


@pytest.mark.certify  # Ray takes a minute to notice
def test_a_cluster_whose_head_is_lost_ends_the_run(inputs: Path, expected: Path, tmp_path: Path) -> None:
    library = tmp_path / "library"
    with machines({}) as cluster:
        run = start_on(cluster.address, inputs, library)
        wait_until(lambda: any(library.glob("*/*/asset.json")), run)
        assert cluster.kill("gcs_server")
        assert "is lost; start Ray again, then run the same command again" in end(run, 2, 120)
    end(start("ingest", inputs, "--library", library))
    assert differences(library, expected) == []


@pytest.mark.certify
def test_a_machine_with_a_disk_of_one_megabyte_gets_no_jobs(tmp_path: Path) -> None:
    """A disk for temporary files that is really full; mounting one takes a right (`unshare`)."""
    within = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c", MOUNT, str(tmp_path)]
    with machines({}, {"TMPDIR": str(tmp_path)}, within=within) as cluster:
        found = ask(cluster.address, *[("temporary_folder", "1")] * 6)
    assert set(found) == {tempfile.gettempdir()} != {str(tmp_path)}
