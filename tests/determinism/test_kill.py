"""Runs that are killed, in part or whole and at any moment, and gone on with, end where an undisturbed run ends."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from tests.support.library.libraries import ROOT, casa_here, command, differences, entries_of

pytestmark = pytest.mark.slow

Moment = Callable[[Path], bool]


def children(pid: int) -> list[int]:
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            state, parent = path.read_text(encoding="utf-8").rpartition(")")[2].split()[:2]
            if int(parent) == pid and state not in "ZX":
                found.append(int(path.parent.name))
    return found


def kill(*pids: int) -> None:
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


@contextmanager
def run_until(moment: Moment, inputs: Path, library: Path) -> Iterator[tuple[subprocess.Popen[bytes], int, list[int]]]:
    """A run that has come to a moment (or to its end), its server and its workers."""
    arguments = command("ingest", inputs, "--library", library, "--jobs", 2, "--json")
    run = subprocess.Popen(arguments, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while run.poll() is None and not moment(library):
        time.sleep(0.002)
    working = children(run.pid)  # of the process that waits and passes signals on
    servers = children(working[0]) if working else []
    server = servers[0] if servers else 0
    yield run, server, children(server) if server else []
    run.wait()
    while servers and Path(f"/proc/{server}").exists():  # nothing of it may still be writing
        time.sleep(0.002)


def is_staged(name: str) -> Moment:
    """A file of an asset is in the staging folder, where a folder may go while it is looked into."""

    def come(library: Path) -> bool:
        with suppress(FileNotFoundError):
            return any((library / ".casa" / "staging").glob(name))
        return False

    return come


has_begun, is_half_written = is_staged("[!u]*/*"), is_staged("*/*/model.xml")


def has_published(library: Path) -> bool:
    return any(library.glob("*/*/asset.json"))


def is_worked_on(library: Path) -> bool:
    return is_half_written(library) or has_published(library)


def finish(few: Path, library: Path) -> None:
    """Assert that the same command ends where an undisturbed run ends."""
    done = casa_here("ingest", few / "in", "--library", library, "--jobs", 2)
    assert done.returncode == 1, done.stdout + done.stderr
    assert list((library / ".casa" / "staging").iterdir()) == []
    assert differences(few / "library", library) == []


@pytest.mark.parametrize("times", [2, pytest.param(3, marks=pytest.mark.certify)])
def test_killed_and_killed_again(few: Path, tmp_path: Path, times: int) -> None:
    library = tmp_path / "library"
    with run_until(has_begun, few / "in", library) as (run, _, _):
        kill(run.pid)  # the run alone
    assert entries_of(library) != entries_of(few / "library"), "killed too late"
    with run_until(is_half_written, few / "in", library) as (run, server, workers):
        kill(*workers, server, run.pid)  # everything
    if times > 2:
        with run_until(has_published, few / "in", library) as (run, _, workers):
            kill(run.pid, *workers)
    finish(few, library)


@pytest.mark.representatives(1)
@pytest.mark.parametrize("victim", ["workers", "server"])
def test_a_run_goes_on_without_what_was_killed(few: Path, tmp_path: Path, victim: str) -> None:
    library = tmp_path / "library"
    with run_until(is_worked_on, few / "in", library) as (run, server, workers):
        kill(*(workers if victim == "workers" else [server]))
    assert run.returncode == 1
    assert differences(few / "library", library) == []


@pytest.mark.representatives(1)
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_stopped_politely(few: Path, tmp_path: Path, number: int) -> None:
    library = tmp_path / "library"
    arguments = command("ingest", few / "in", "--library", library, "--jobs", 2)
    run = subprocess.Popen(arguments, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not is_worked_on(library):
        assert run.poll() is None
        time.sleep(0.002)
    run.send_signal(number)
    message = run.communicate()[1].splitlines()
    assert (run.returncode, message) == (128 + number, ["stopped; the same command goes on from here"])
    finish(few, library)
