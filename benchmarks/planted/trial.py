"""Run the tests that reach a fault, nearest first, until one fails or the time is up."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.planted.copies import copy_linked
from benchmarks.planted.faults import Fault
from benchmarks.planted.selection import Reaching

PLUGIN = Path(__file__).with_name("plugin")
MARKS = "not consumers and not certify"
# Test files of the first run of pytest; each run after it takes twice as many as the one before.
FIRST_FILES = 8
# What pytest says when all tests passed, and when it found none in the files (all may be marked).
ALL_PASSED, NOTHING_RUN = 0, 5


@dataclass(frozen=True)
class Failure:
    """A test that failed, and what it said first."""

    test: str
    error: str


@dataclass(frozen=True)
class Verdict:
    """What became of a fault.

    Attributes:
        outcome: `nearest` or `others` where a test caught it, `not caught`, `not caught within the budget`.
        seconds: until then. files: number of test files that were begun. failure: by which it was caught.
        steps: of the test that caught it, None where it only starts the program.
    """

    outcome: str
    seconds: float
    files: int
    failure: Failure | None = None
    steps: int | None = None


@dataclass
class Bench:
    """Where tests run.

    Attributes:
        clean: copy of the checkout. work: folder for copies. jobs: processes of pytest. budget_s: for each fault.
        cache: folder of built things that each fault begins with a copy of; None: with nothing.
        clean_fails: tests by whether they fail without any fault, as far as that was asked.
    """

    clean: Path
    work: Path
    jobs: int
    budget_s: float
    cache: Path | None = None
    clean_fails: dict[str, bool] = field(default_factory=dict)

    def try_fault(self, fault: Fault, tests: Sequence[Reaching]) -> Verdict:
        """Plant a fault and run the tests that reach it, in their order."""
        copy = copy_linked(self.clean, self.work / fault.id, fault)
        begun, spent = 0, 0.0
        try:
            for batch in _batches(tests):
                begun += len(batch)
                found, seconds = self._first_failure(copy, batch, self.budget_s - spent)
                spent += seconds
                if isinstance(found, Failure):
                    (steps,) = {test.steps for test in batch if test.path == found.test.partition("::")[0]} or {None}
                    outcome = "nearest" if steps == tests[0].steps else "others"
                    return Verdict(outcome, spent, begun, found, steps)
                if not found:
                    return Verdict("not caught within the budget", spent, begun)
            return Verdict("not caught", spent, begun)
        finally:
            shutil.rmtree(copy, ignore_errors=True)

    def _first_failure(self, copy: Path, batch: Sequence[Reaching], left_s: float) -> tuple[Failure | bool, float]:
        """The first test of a batch that fails due to the fault; else whether all came to an end; and seconds."""
        spent = 0.0
        while True:
            avoid = [test for test, fails in self.clean_fails.items() if fails]
            begin = time.monotonic()
            found = self._pytest(copy, [test.path for test in batch], avoid, left_s - spent)
            spent += time.monotonic() - begin
            if not isinstance(found, Failure) or not self._fails_anyway(found.test):
                return found, spent

    def _fails_anyway(self, test: str) -> bool:
        if test not in self.clean_fails:
            copy = copy_linked(self.clean, self.work / "without_fault")
            self.clean_fails[test] = self._pytest(copy, [test], [], 600) is not True
            shutil.rmtree(copy, ignore_errors=True)
        return self.clean_fails[test]

    def _pytest(self, copy: Path, tests: Iterable[str], avoid: Iterable[str], limit_s: float) -> Failure | bool:
        """Run tests: the first failure; else whether all came to an end within some seconds."""
        if limit_s <= 0:
            return False
        place = self.work / "run"
        place.mkdir()
        (place / "tmp").mkdir()
        if self.cache is not None:
            shutil.copytree(self.cache, place / "cache", symlinks=True)
        failures = place / "failures.jsonl"
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-p", "planted_failures"]
        command += ["-n", str(self.jobs), "--dist", "worksteal", "-m", MARKS, "--basetemp", str(place / "base")]
        command += [f"--deselect={test}" for test in avoid]
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        environment |= {"PYTHONPATH": os.pathsep.join((str(copy), str(PLUGIN))), "PLANTED_FAILURES": str(failures)}
        environment |= {"TMPDIR": str(place / "tmp")} | ({"CASA_TESTS_CACHE": str(place / "cache")} if self.cache else {})
        try:
            with (place / "output.txt").open("w") as output:
                running = subprocess.Popen(
                    [*command, *tests],
                    cwd=copy,
                    env=environment,
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
            found = _watch(running, failures, limit_s)
            if isinstance(found, Failure) or found == (ALL_PASSED,) or found == (NOTHING_RUN,):
                return found if isinstance(found, Failure) else True
            if found:
                tail = (place / "output.txt").read_text(errors="replace").strip().splitlines()[-1:]
                return Failure("pytest", f"ended with {found[0]}: {' '.join(tail)}")
            return False
        finally:
            _end_all(str(failures))
            shutil.rmtree(place, ignore_errors=True)


def _batches(tests: Sequence[Reaching]) -> Iterator[Sequence[Reaching]]:
    begin, count = 0, FIRST_FILES
    while begin < len(tests):
        yield tests[begin : begin + count]
        begin, count = begin + count, count * 2


def _watch(running: subprocess.Popen[bytes], failures: Path, limit_s: float) -> Failure | tuple[int, ...]:
    """Wait for the first failure or the end; then its exit status, none where it was ended after some seconds."""
    end = time.monotonic() + limit_s
    status = None
    while status is None and time.monotonic() < end and not _written(failures):
        with suppress(subprocess.TimeoutExpired):
            status = running.wait(timeout=0.2)
    if status is None:
        os.killpg(running.pid, signal.SIGTERM)
        with suppress(subprocess.TimeoutExpired):
            running.wait(timeout=5)
        with suppress(ProcessLookupError):
            os.killpg(running.pid, signal.SIGKILL)
        running.wait()
    if _written(failures):
        return Failure(**json.loads(failures.read_text(encoding="utf-8").splitlines()[0]))
    return () if status is None else (status,)


def _written(failures: Path) -> bool:
    """Whether the first line stands there to its end."""
    return failures.is_file() and "\n" in failures.read_text(encoding="utf-8")


def _end_all(word: str) -> None:
    """End processes that tests left behind: their environment names the file of failures of this run."""
    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if f"PLANTED_FAILURES={word}\0".encode() in (place / "environ").read_bytes():
                os.kill(int(place.name), signal.SIGKILL)
