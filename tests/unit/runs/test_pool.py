"""Workers that misbehave harm nobody but their own job."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from casa_assets.core.system import is_worker
from casa_assets.errors import CasaError
from casa_assets.runs import limits
from casa_assets.runs.limits import Limits, WorkerFailure, WorkerPlan, available, plan_workers
from casa_assets.runs.pool import Pool
from casa_assets.runs.server import OOM_SCORE
from tests.support.library.libraries import write_files

pytestmark = pytest.mark.content("code", "runs", keep=0)

DO = "tests.support.program.pool_jobs:do"
WARM = "tests.support.program.pool_jobs:nothing"
LIMITS = Limits(cpu_s=60, memory_bytes=2_000_000_000)


@pytest.fixture
def pool() -> Iterator[Pool]:
    with Pool(2, LIMITS, WARM) as made:
        yield made


def run(pool: Pool, *jobs: tuple[str, str]) -> list[Any]:
    """Answers in the order of the jobs, each of which has exactly one."""
    answers = list(pool.run(DO, jobs))
    assert sorted(number for number, _ in answers) == list(range(len(jobs)))
    return [answer for _, answer in sorted(answers, key=lambda pair: pair[0])]


def wait_until_gone(pid: int) -> None:
    """Return once a process has ended (a zombie has); a test that waits for ever has failed."""
    with suppress(FileNotFoundError):
        while Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] not in "ZX":
            time.sleep(0.01)


def test_answers_belong_to_their_jobs(pool: Pool) -> None:
    assert run(pool) == []
    words = [f"word {i}" for i in range(20)]
    assert run(pool, *(("answer", w) for w in words)) == [w.upper() for w in words]
    assert run(pool, ("nothing", ""), ("large", "x")) == [None, b"x" * 5_000_000]
    (died,) = run(pool, ("raise", "7"))
    assert "in _raise" in died.trace
    # A worker is known, has one thread and is ended before the run.
    own = int(Path("/proc/self/oom_score_adj").read_text(encoding="ascii"))
    jobs = [("is_worker", ""), ("threads", ""), ("oom_score", "")]
    assert run(pool, *jobs) == [True, "1", max(own, OOM_SCORE)]
    assert not is_worker()


@pytest.mark.parametrize(
    ("what", "reason", "message"),
    [
        ("abort", "signal", "SIGABRT"),
        ("segfault", "signal", "SIGSEGV"),
        ("exit", "signal", "exit code 7"),
        ("sys_exit", "error", "SystemExit: 7"),
        ("raise", "error", "ValueError: 7"),
        ("eat", "memory", "more than 2 GB"),
        ("out_of_memory_inside", "memory", "more than 2 GB"),
        ("out_of_memory_at_import", "memory", "more than 2 GB"),
        ("out_of_memory_in_other_words", "memory", "more than 2 GB"),
        ("out_of_memory_when_told", "memory", "more than 2 GB"),
        ("unsendable", "error", "not to be sent"),
        ("unreadable", "error", "not a number"),
    ],
)
def test_a_job_that_fails_leaves_the_others_alone(pool: Pool, what: str, reason: str, message: str) -> None:
    before, died, after = run(pool, ("answer", "a"), (what, "7"), ("answer", "b"))
    assert (before, after) == ("A", "B")
    assert isinstance(died, WorkerFailure)
    assert died.reason == reason
    assert message in died.message


def test_a_job_that_hangs_is_stopped() -> None:
    with Pool(2, Limits(60.0, LIMITS.memory_bytes, idle_s=1.0), WARM) as pool:
        died, *others = run(pool, ("hang", ""), *(("answer", "a") for _ in range(5)))
    assert others == ["A"] * 5
    assert isinstance(died, WorkerFailure)
    assert died.reason == "stuck"
    assert "made no progress for 1 s" in died.message


@pytest.mark.parametrize("what", ["burn", "burn_in_children"])
def test_processor_time_of_a_job_and_of_what_it_starts_is_limited(what: str) -> None:
    with Pool(2, Limits(0.5, LIMITS.memory_bytes), WARM) as pool:
        died, other = run(pool, (what, "60"), ("answer", "a"))
    assert other == "A"
    assert died == WorkerFailure("timeout", "used more than 0.5 s of processor time and was stopped")


def test_a_busy_machine_changes_no_verdict() -> None:
    """Half of the limit is used by one job, all of it by another; with ten times as much to do for each core too."""
    jobs = [("burn", "0.4"), ("burn", "60")]
    with Pool(2, Limits(0.9, LIMITS.memory_bytes), WARM) as pool:
        idle = run(pool, *jobs)
        hogs = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(5 * (os.cpu_count() or 1))]
        begin = time.monotonic()
        try:
            busy = run(pool, *jobs)
            took = time.monotonic() - begin
        finally:
            for hog in hogs:
                hog.kill()
                hog.wait()
    assert took > 0.9, "the machine was not busy"
    assert busy == idle
    assert idle[0] == "burnt"
    assert idle[1].reason == "timeout"


@pytest.mark.parametrize("what", ["grandchild", "die_with_grandchild", "hang_with_grandchild"])
def test_what_a_job_started_ends_with_it(what: str, tmp_path: Path) -> None:
    note = tmp_path / "pid"
    with Pool(1, Limits(60.0, LIMITS.memory_bytes, idle_s=2.0), WARM) as pool:
        first, second = run(pool, (what, str(note)), ("answer", "a"))
        wait_until_gone(int(note.read_text(encoding="ascii")))
    assert second == "A"
    assert first == "answered" or isinstance(first, WorkerFailure)


@pytest.mark.parametrize("what", ["die_once", "kill_server_once"])
def test_a_job_is_not_to_blame_for_one_death_from_outside(pool: Pool, what: str, tmp_path: Path) -> None:
    jobs = [("answer", "a"), (what, str(tmp_path / "mark")), ("answer", "b"), ("answer", "c")]
    assert run(pool, *jobs) == ["A", "second time", "B", "C"]


@pytest.mark.parametrize(("warm", "message"), [("broken", "libnothing"), ("deadly", "cannot be started")])
def test_a_server_that_cannot_get_ready_or_dies_again_and_again_ends_the_run(warm: str, message: str) -> None:
    with Pool(1, LIMITS, f"tests.support.program.pool_jobs:{warm}") as pool, pytest.raises(CasaError, match=message):
        run(pool, ("answer", "a"))


def test_a_run_that_is_given_up_leaves_no_process(tmp_path: Path) -> None:
    note = tmp_path / "pid"
    with Pool(2, LIMITS, WARM) as pool:
        for _, answer in pool.run(DO, [("answer", "a"), ("hang_with_grandchild", str(note)), ("answer", "b")]):
            assert answer in ("A", "B")
            if note.exists() and note.read_text(encoding="ascii"):
                break
            if answer == "B":
                while not (note.exists() and note.read_text(encoding="ascii")):
                    time.sleep(0.01)
                break
    wait_until_gone(int(note.read_text(encoding="ascii")))


GB = 1_000_000_000


def test_what_does_not_fit_gets_less_memory_first_and_fewer_workers_then() -> None:
    assert plan_workers(2, 8 * GB, free_bytes=100 * GB) == WorkerPlan(2, 8 * GB, 8 * GB)
    assert plan_workers(8, 8 * GB, free_bytes=40 * GB) == WorkerPlan(8, 4_500_000_000, 8 * GB)
    few = plan_workers(64, 8 * GB, free_bytes=20 * GB)
    assert (few.workers, few.memory_bytes, few.alone_bytes) == (9, 2 * GB, 8 * GB)
    assert few.message == "9 instead of 64 at once (--jobs): 20 GB of memory are free, and each may need 2 GB"
    tiny = plan_workers(2, 8 * GB, free_bytes=1 * GB)
    assert (tiny.workers, tiny.memory_bytes, tiny.alone_bytes) == (1, 900_000_000, 900_000_000)


def test_free_memory_is_that_of_the_machine_and_of_its_groups(
    subtests: pytest.Subtests, tmp_path_factory: pytest.TempPathFactory
) -> None:
    for files, free in [
        ({}, 8 * 1024),
        ({"group/memory.max": "max"}, 8 * 1024),
        ({"group/memory.max": "6144", "group/memory.current": "4096"}, 2048),
        ({"memory.max": "5120", "memory.current": "4096", "memory.stat": "anon 1\ninactive_file 512"}, 1536),
        ({"memory/a/memory.limit_in_bytes": "4096", "memory/a/memory.usage_in_bytes": "96"}, 4000),
        ({"memory/memory.limit_in_bytes": "4096", "memory/memory.usage_in_bytes": "9999"}, 0),
    ]:
        with subtests.test(files=files, free=free):
            tmp_path = tmp_path_factory.mktemp("case")
            memory, groups = "MemTotal: 16 kB\nMemAvailable:   8 kB\n", "4:cpu:/a\n3:memory:/a\n0::/group\n"
            write_files(tmp_path / "proc", {"meminfo": memory, "self/cgroup": groups})
            write_files(tmp_path / "groups", {name: f"{text}\n" for name, text in files.items()})
            assert available(tmp_path / "proc", tmp_path / "groups") == free


def test_fewer_workers_than_asked_for_are_told_once(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(limits, "available", lambda: 3 * GB)
    with Pool(4, LIMITS, WARM) as pool:
        assert run(pool, ("answer", "a")) == ["A"]
        assert caplog.messages == [], "one job needs one worker"
        assert run(pool, *(("answer", "a") for _ in range(3))) == ["A"] * 3
        assert run(pool, *(("answer", "a") for _ in range(3))) == ["A"] * 3
    assert caplog.messages == ["1 instead of 4 at once (--jobs): 3 GB of memory are free, and each may need 2 GB"]


def test_a_job_that_had_less_memory_beside_others_is_tried_again_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three workers with 1.2 GB each: one job needs 1.6 GB, which it may use, and one 3.2 GB, which it may not."""
    monkeypatch.setattr(limits, "available", lambda: 4 * GB)
    with Pool(3, LIMITS, WARM, least_bytes=GB) as pool:
        first, second, third = run(pool, ("take", "1.6"), ("eat", ""), ("answer", "a"))
    assert first == "1.6"
    assert second == WorkerFailure("memory", "needs more than 2 GB of memory")
    assert third == "A"
