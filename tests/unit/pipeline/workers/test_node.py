"""One job on a machine of a cluster, without Ray: what it answers, and which machines are refused."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from casa_assets.pipeline.workers import limits
from casa_assets.pipeline.workers import ray_node as node
from casa_assets.pipeline.workers.limits import Limits, WorkerFailure
from casa_assets.pipeline.workers.ray_node import Full, Order, Unfit

pytestmark = pytest.mark.content("code", "pipeline.workers", keep=0)

WARM = "tests.pool_jobs:nothing"


@pytest.fixture
def order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Order:
    """Of a run in the working folder, whose marker is on a shared disk."""
    monkeypatch.chdir(Path.cwd())  # a job moves to the folder of the run
    monkeypatch.setattr(node, "SHARED_DISK_S", 0.3)
    marker = tmp_path / "marker"
    marker.touch()
    limits = Limits(cpu_s=5, memory_bytes=2_000_000_000)
    return Order("tests.pool_jobs:do", (WARM,), limits, 1_000_000, Path.cwd(), marker, node.version())


def answer(order: Order, *job: str) -> Any:
    """What a job answers."""
    found = node.work(order, job)
    assert not isinstance(found, Unfit), found
    return found


def test_a_job_answers(order: Order) -> None:
    assert answer(order, "answer", "word") == "WORD"


def test_a_crash_ends_its_job_alone(order: Order) -> None:
    found = answer(order, "segfault", "")
    assert isinstance(found, WorkerFailure)
    assert found.reason == "signal"
    assert answer(order, "answer", "still") == "STILL"


def test_the_limits_of_the_run_hold(order: Order) -> None:
    found = answer(order, "burn", "60")
    assert isinstance(found, WorkerFailure)
    assert found.reason == "timeout"


def test_another_version_is_refused(order: Order) -> None:
    found = node.work(Order(**{**vars(order), "version": "another"}), ("answer", "word"))
    assert isinstance(found, Unfit)
    assert "another version" in found.message


def test_a_machine_without_the_shared_disk_is_refused(order: Order, tmp_path: Path) -> None:
    found = node.work(Order(**{**vars(order), "marker": tmp_path / "elsewhere" / "marker"}), ("answer", "word"))
    assert isinstance(found, Unfit)
    assert f"does not see {tmp_path / 'elsewhere'}" in found.message


def test_a_machine_without_the_working_folder_is_refused(order: Order, tmp_path: Path) -> None:
    found = node.work(Order(**{**vars(order), "folder": tmp_path / "away"}), ("answer", "word"))
    assert isinstance(found, Unfit)
    assert f"working folder {tmp_path / 'away'}" in found.message


@pytest.mark.parametrize("free", [[0], [10**9, 0]], ids=["before", "afterwards"])
def test_a_full_disk_is_told_in_place_of_an_answer(
    order: Order, monkeypatch: pytest.MonkeyPatch, free: list[int]
) -> None:
    left = iter(free)
    monkeypatch.setattr(limits.shutil, "disk_usage", lambda _: SimpleNamespace(free=next(left)))
    monkeypatch.setattr(node, "_node_id", lambda: "this one")
    found = node.work(order, ("answer", "word"))
    assert isinstance(found, Full)
    assert found.node == "this one"
    assert "0.0 MB are free, jobs need 64 MB; make room, or set TMPDIR" in found.message


def test_no_folder_for_temporary_files_is_a_full_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> str:
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.setattr(limits.tempfile, "gettempdir", refuse)
    assert "No usable temporary directory found" in str(limits.full_disk())


def test_the_version_is_that_of_the_code_and_of_the_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    ours = node.version()
    node.version.cache_clear()
    assert node.version() == ours
    node.version.cache_clear()
    monkeypatch.setattr(node.importlib.metadata, "version", lambda name: "another")
    assert node.version() != ours
    node.version.cache_clear()
