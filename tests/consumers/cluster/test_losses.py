"""Runs on a cluster of two machines, both on this one, that loses something: the library is that of one machine."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from tests.consumers.cluster.machines import (
    JOB,
    RAY_WORKER,
    end,
    few_meshes,
    full_disk,
    machines,
    start,
    start_on,
    wrong_clock,
)
from tests.support.library.libraries import differences
from tests.support.program.environments import wait_until

pytestmark = pytest.mark.consumers


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A few of the sample meshes; one of them is broken."""
    return few_meshes(tmp_path_factory.mktemp("inputs") / "meshes")


@pytest.fixture(scope="module")
def expected(inputs: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The library that this machine makes of them."""
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
    with machines({}, full_disk(), wrong_clock()) as cluster:
        run = start_on(cluster.address, inputs, library)
        assert "a machine of the cluster gets no more jobs" in end(run)
    assert differences(library, expected) == []
