"""One job on a machine of a cluster, without Ray: what it answers, and which machines are refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from casa_assets.runs import limits
from casa_assets.runs import ray_node as node
from casa_assets.runs.limits import Limits, WorkerFailure
from casa_assets.runs.ray_node import Full, Order, Unfit

pytestmark = pytest.mark.content("code", "runs", keep=0)

WARM = "tests.support.program.pool_jobs:nothing"


@pytest.fixture
def order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Order:
    """Of a run in the working folder, whose marker is on a shared disk."""
    monkeypatch.chdir(Path.cwd())  # a job moves to the folder of the run
    monkeypatch.setattr(node, "SHARED_DISK_S", 0.3)
    marker = tmp_path / "marker"
    marker.touch()
    limits = Limits(cpu_s=5, memory_bytes=2_000_000_000)
    return Order("tests.support.program.pool_jobs:do", (WARM,), limits, 1_000_000, Path.cwd(), marker, node.version())


def test_a_job_answers_and_its_faults_are_its_own(order: Order) -> None:
    assert node.work(order, ("answer", "word")) == "WORD"
    for job, reason in ((("segfault", ""), "signal"), (("burn", "60"), "timeout")):
        found = node.work(order, job)
        assert isinstance(found, WorkerFailure)
        assert found.reason == reason
    assert node.work(order, ("answer", "still")) == "STILL"


def test_an_unfit_machine_is_refused(order: Order) -> None:
    for changed, message in [
        ({"version": "another"}, "another version"),
        ({"marker": Path("/nowhere/elsewhere/marker")}, "does not see /nowhere/elsewhere"),
        ({"folder": Path("/nowhere/away")}, "working folder /nowhere/away"),
    ]:
        found = node.work(replace(order, **changed), ("answer", "word"))
        assert isinstance(found, Unfit)
        assert message in found.message


def test_a_full_disk_is_told_in_place_of_an_answer(order: Order, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before the job or after it; where there is no folder for temporary files, too."""
    monkeypatch.setattr(node, "_node_id", lambda: "this one")
    for free in ([0], [10**9, 0]):
        monkeypatch.setattr(limits.shutil, "disk_usage", Mock(side_effect=[SimpleNamespace(free=n) for n in free]))
        found = node.work(order, ("answer", "word"))
        assert isinstance(found, Full)
        assert found.node == "this one"
        assert "0.0 MB are free, jobs need 64 MB; make room, or set TMPDIR" in found.message
    refused = FileNotFoundError(2, "No usable temporary directory found")
    monkeypatch.setattr(limits.tempfile, "gettempdir", Mock(side_effect=refused))
    assert "No usable temporary directory found" in str(limits.full_disk())


def test_the_version_is_that_of_the_code_and_of_the_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    ours = node.version()
    node.version.cache_clear()
    assert node.version() == ours
    node.version.cache_clear()
    monkeypatch.setattr(node.importlib.metadata, "version", lambda name: "another")
    assert node.version() != ours
    node.version.cache_clear()
