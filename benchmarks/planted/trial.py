"""Run the tests that reach a fault, nearest first, until one fails or the time is up."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.planted.faults import Fault, copy_linked
from tests.selection import Reaching

PLUGIN = Path(__file__).with_name("plugin")
MARKS = "not consumers and not certify"
# Test files of the first run of pytest; each run after it takes twice as many as the one before.
FIRST_FILES = 8
# What pytest says when all tests passed, and when it found none in the files (all may be marked).
ALL_PASSED, NOTHING_RUN = 0, 5
# Stands for a test where pytest ended without one that failed, such as for a conftest.py that cannot be imported.
PYTEST = "pytest"
# Variables: the file of failures, for the plug-in; a cache of built things, for the tests.
FAILURES, CACHE = "PLANTED_FAILURES", "CASA_TESTS_CACHE"
# For one test without a fault, seconds.
CLEAN_LIMIT_S = 600.0


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
        python: that runs pytest, with all that the checkout needs.
        clean_fails: tests by whether they fail without any fault, as far as that was asked.
    """

    clean: Path
    work: Path
    jobs: int
    budget_s: float
    cache: Path | None = None
    python: str = sys.executable
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
        while tests := [test.path for test in batch if not self.clean_fails.get(test.path)]:
            avoid = [f"--deselect={test}" for test, fails in self.clean_fails.items() if fails]
            begin = time.monotonic()
            found = self._pytest(copy, [*avoid, *tests], left_s - spent)
            spent += time.monotonic() - begin
            if not isinstance(found, Failure) or not self._fails_anyway(found, tests):
                return found, spent
        return True, spent  # none of these files can be read without the fault either

    def _fails_anyway(self, failure: Failure, tests: Sequence[str]) -> bool:
        """Whether a test fails without the fault too.

        Raises:
            SystemExit: pytest does not even begin in this checkout without the fault.
        """
        if failure.test not in self.clean_fails:
            copy = copy_linked(self.clean, self.work / "without_fault")
            words = ["--collect-only", *tests] if failure.test == PYTEST else [failure.test]
            fails = self._pytest(copy, words, CLEAN_LIMIT_S) is not True
            shutil.rmtree(copy, ignore_errors=True)
            if failure.test == PYTEST:
                if fails:
                    message = (
                        "pytest runs no tests of this checkout, with or without faults; it may need another Python"
                    )
                    raise SystemExit(f"{message} (--python). It {failure.error}")
                return False
            self.clean_fails[failure.test] = fails
        return self.clean_fails[failure.test]

    def _pytest(self, copy: Path, words: Sequence[str], limit_s: float) -> Failure | bool:
        """Run tests of a copy: the first failure; else whether all came to an end within some seconds.

        Args:
            words: options of pytest, and tests.
        """
        if limit_s <= 0:
            return False
        place = self.work / "run"
        (place / "tmp").mkdir(parents=True)
        if self.cache is not None:
            shutil.copytree(self.cache, place / "cache", symlinks=True)
        failures = place / "failures.jsonl"
        command = [self.python, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-p", "planted_failures"]
        command += ["-n", str(self.jobs), "--dist", "worksteal", "-m", MARKS, "--basetemp", str(place / "base"), *words]
        try:
            with (place / "output.txt").open("w") as output:
                running = subprocess.Popen(
                    command,
                    cwd=copy,
                    env=self._environment(copy, place, failures),
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
            found = _watch(running, failures, limit_s)
            if isinstance(found, Failure):
                return found
            if found is not None and found not in (ALL_PASSED, NOTHING_RUN):
                tail = (place / "output.txt").read_text(errors="replace").strip().splitlines()[-1:]
                return Failure(PYTEST, f"ended with {found}: {' '.join(tail)}")
            return found is not None
        finally:
            _end_all(failures)
            shutil.rmtree(place, ignore_errors=True)

    def _environment(self, copy: Path, place: Path, failures: Path) -> dict[str, str]:
        """Variables of the tests: code of the copy alone, temporary files and built things in a place of their own."""
        kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONDONTWRITEBYTECODE", CACHE)}
        own = {"PYTHONPATH": os.pathsep.join((str(copy), str(PLUGIN))), FAILURES: str(failures)}
        built = {} if self.cache is None else {CACHE: str(place / "cache")}
        return {**kept, **own, **built, "TMPDIR": str(place / "tmp")}


def _batches(tests: Sequence[Reaching]) -> Iterator[Sequence[Reaching]]:
    begin, count = 0, FIRST_FILES
    while begin < len(tests):
        yield tests[begin : begin + count]
        begin, count = begin + count, count * 2


def _watch(running: subprocess.Popen[bytes], failures: Path, limit_s: float) -> Failure | int | None:
    """Wait for the first failure, or for the end; then the exit status, None where it was ended after some seconds."""
    end = time.monotonic() + limit_s
    status = None
    while status is None and time.monotonic() < end and not _written(failures):
        with suppress(subprocess.TimeoutExpired):
            status = running.wait(timeout=0.2)
    if status is None:
        for number, patience_s in ((signal.SIGTERM, 5), (signal.SIGKILL, None)):
            with suppress(ProcessLookupError, subprocess.TimeoutExpired):
                os.killpg(running.pid, number)
                running.wait(timeout=patience_s)
    if _written(failures):
        return Failure(**json.loads(failures.read_text(encoding="utf-8").splitlines()[0]))
    return status


def _written(failures: Path) -> bool:
    """Whether the first line stands there to its end."""
    return failures.is_file() and "\n" in failures.read_text(encoding="utf-8")


def _end_all(failures: Path) -> None:
    """End processes that tests left behind: their environment names the file of failures of this run."""
    word = f"{FAILURES}={failures}\0".encode()
    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if word in (place / "environ").read_bytes():
                os.kill(int(place.name), signal.SIGKILL)


# Results --------------------------------------------------------------------------------------------------------------

APPLIES_NOT = "does not apply"
COLUMNS = ("nearest", "others", "not caught", "not caught within the budget", APPLIES_NOT)
HEADS = ("by nearest", "by others", "not caught", "not in budget", "no such text")


@dataclass(frozen=True)
class Results:
    """A file of results of one checkout; others' results in it stay. path: of the file. checkout: its name."""

    path: Path
    checkout: str

    def verdicts(self, faults: Sequence[Fault], budget_s: float) -> dict[str, Verdict]:
        """What is known of faults, by id; what did not end within a smaller budget is to be tried again."""
        digests = {fault.id: fault.digest for fault in faults}
        found = {}
        for row in self._rows("fault"):
            if digests.get(row["fault"]) == row["digest"]:
                failure = Failure(**row["failure"]) if row["failure"] else None
                verdict = Verdict(row["outcome"], row["seconds"], row["files"], failure, row["steps"])
                if not (verdict.outcome == COLUMNS[3] and row["budget_s"] < budget_s):
                    found[row["fault"]] = verdict
        return found

    def clean_fails(self) -> dict[str, bool]:
        """Tests, by whether they fail without a fault."""
        return {row["test"]: row["fails"] for row in self._rows("test")}

    def add(self, fault: Fault, verdict: Verdict, budget_s: float) -> None:
        """Append what became of a fault."""
        own = {"checkout": self.checkout, "fault": fault.id, "digest": fault.digest, "budget_s": budget_s}
        self._append(own | asdict(verdict))

    def add_clean(self, tests: Mapping[str, bool]) -> None:
        """Append what is known of tests without a fault."""
        known = self.clean_fails()
        for test, fails in tests.items():
            if test not in known:
                self._append({"checkout": self.checkout, "test": test, "fails": fails})

    def _append(self, row: Mapping[str, object]) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")

    def _rows(self, field: str) -> list[dict[str, Any]]:
        """Rows of the checkout that have a field; a last line that was cut off is none."""
        lines = self.path.read_text(encoding="utf-8").split("\n")[:-1] if self.path.is_file() else []
        rows = [json.loads(line) for line in lines]
        return [row for row in rows if row["checkout"] == self.checkout and field in row]


def line_of(fault: Fault, verdict: Verdict) -> str:
    """One line about a fault, for whoever watches."""
    test = verdict.failure.test if verdict.failure else ""
    way = "" if not test else f" ({'starts the program' if verdict.steps is None else f'{verdict.steps} steps'})"
    words = f"{fault.id:32} {verdict.outcome:28} {verdict.seconds:6.1f} s  {verdict.files:3} files  {test}{way}"
    return words.rstrip()


def summary(faults: Sequence[Fault], verdicts: Mapping[str, Verdict]) -> str:
    """Counts per package and per kind, and the list of faults that no test caught."""
    parts = [_table("package", faults, verdicts, lambda fault: fault.package)]
    parts.append(_table("kind", faults, verdicts, lambda fault: fault.kind))
    missed = [fault for fault in faults if fault.id in verdicts and verdicts[fault.id].outcome in COLUMNS[2:4]]
    if missed:
        parts.append("\n".join(["Not caught:", *(_missed(fault, verdicts[fault.id]) for fault in missed)]))
    return "\n\n".join(parts)


def _missed(fault: Fault, verdict: Verdict) -> str:
    return f"  {fault.id} ({fault.file}): {fault.what} [{verdict.outcome}, {verdict.files} files]"


def _table(head: str, faults: Sequence[Fault], verdicts: Mapping[str, Verdict], group: Callable[[Fault], str]) -> str:
    tried = [fault for fault in faults if fault.id in verdicts]
    rows: list[tuple[str, ...]] = [(head, "faults", *HEADS)]
    for name in (*sorted({group(fault) for fault in tried}), "all"):
        own = [verdicts[fault.id].outcome for fault in tried if name in {group(fault), "all"}]
        rows.append((name, str(len(own)), *(str(own.count(column)) for column in COLUMNS)))
    return "\n".join(f"{row[0]:16}" + "".join(f"{cell:>15}" for cell in row[1:]) for row in rows)
