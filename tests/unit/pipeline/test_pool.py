"""Workers that misbehave harm nobody but their own job."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from casa_assets.errors import CasaError
from casa_assets.pipeline.isolation.pool import Died, Limits, Pool
from casa_assets.pipeline.isolation.server import OOM_SCORE

DO = "tests.pool_jobs:do"
WARM = "tests.pool_jobs:nothing"
LIMITS = Limits(seconds=60, memory_bytes=2_000_000_000)


@pytest.fixture
def pool() -> Iterator[Pool]:
    with Pool(2, LIMITS, WARM) as made:
        yield made


def run(pool: Pool, *jobs: tuple[str, str]) -> list[Any]:
    """Answers in the order of the jobs, each of which has exactly one."""
    answers = list(pool.run(DO, jobs))
    assert sorted(number for number, _ in answers) == list(range(len(jobs)))
    return [answer for _, answer in sorted(answers, key=lambda pair: pair[0])]


def is_alive(pid: int) -> bool:
    """Whether a process runs (a zombie does not)."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state not in "ZX"


def wait_until_gone(pid: int) -> None:
    """Return once a process has ended; a test that waits for ever has failed."""
    while is_alive(pid):
        time.sleep(0.01)


def test_answers_belong_to_their_jobs(pool: Pool) -> None:
    words = [f"word {i}" for i in range(20)]
    assert run(pool, *(("answer", w) for w in words)) == [w.upper() for w in words]


def test_nothing_to_do(pool: Pool) -> None:
    assert run(pool) == []


def test_an_answer_may_be_none_or_large(pool: Pool) -> None:
    assert run(pool, ("nothing", ""), ("large", "x")) == [None, b"x" * 5_000_000]


@pytest.mark.parametrize(
    ("what", "reason", "says"),
    [
        ("abort", "signal", "SIGABRT"),
        ("segfault", "signal", "SIGSEGV"),
        ("exit", "signal", "exit code 7"),
        ("sys_exit", "error", "SystemExit: 7"),
        ("raise", "error", "ValueError: 7"),
        ("eat", "memory", "more than 2 GB"),
        ("unsendable", "error", "not to be sent"),
        ("unreadable", "error", "not a number"),
    ],
)
def test_a_job_that_fails_leaves_the_others_alone(pool: Pool, what: str, reason: str, says: str) -> None:
    before, died, after = run(pool, ("answer", "a"), (what, "7"), ("answer", "b"))
    assert (before, after) == ("A", "B")
    assert isinstance(died, Died)
    assert died.reason == reason
    assert says in died.says


def test_a_python_error_comes_with_its_place(pool: Pool) -> None:
    (died,) = run(pool, ("raise", "7"))
    assert "in _raise" in died.trace


def test_what_a_job_prints_goes_nowhere(pool: Pool, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(pool, ("print", "done"), ("read_input", "")) == ["done", ""]
    assert capfd.readouterr() == ("", "")


def test_a_job_that_hangs_is_stopped() -> None:
    with Pool(2, Limits(1.0, LIMITS.memory_bytes), WARM) as pool:
        died, *others = run(pool, ("hang", ""), *(("answer", "a") for _ in range(5)))
    assert others == ["A"] * 5
    assert died == Died("timeout", "still running after 1 s and was stopped")


@pytest.mark.parametrize("what", ["grandchild", "die_with_grandchild", "hang_with_grandchild"])
def test_what_a_job_started_ends_with_it(what: str, tmp_path: Path) -> None:
    note = tmp_path / "pid"
    with Pool(1, Limits(2.0, LIMITS.memory_bytes), WARM) as pool:
        first, second = run(pool, (what, str(note)), ("answer", "a"))
        wait_until_gone(int(note.read_text(encoding="ascii")))
    assert second == "A"
    assert first == "answered" or isinstance(first, Died)


@pytest.mark.parametrize("what", ["die_once", "kill_server_once"])
def test_a_job_is_not_to_blame_for_one_death_from_outside(pool: Pool, what: str, tmp_path: Path) -> None:
    jobs = [("answer", "a"), (what, str(tmp_path / "mark")), ("answer", "b"), ("answer", "c")]
    assert run(pool, *jobs) == ["A", "second time", "B", "C"]


def test_a_server_that_cannot_get_ready_ends_the_run() -> None:
    with Pool(1, LIMITS, "tests.pool_jobs:broken") as pool, pytest.raises(CasaError, match="libnothing"):
        run(pool, ("answer", "a"))


def test_a_server_that_dies_again_and_again_ends_the_run() -> None:
    with Pool(1, LIMITS, "tests.pool_jobs:deadly") as pool, pytest.raises(CasaError, match="cannot be started"):
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


def test_the_kernel_ends_workers_before_the_run(pool: Pool) -> None:
    own = int(Path("/proc/self/oom_score_adj").read_text(encoding="ascii"))
    assert run(pool, ("oom_score", "")) == [max(own, OOM_SCORE)]


def test_workers_have_one_thread_each(pool: Pool) -> None:
    assert run(pool, ("threads", "")) == ["1"]
