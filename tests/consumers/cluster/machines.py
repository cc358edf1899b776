"""Ray clusters of machines that are all this one, and what befalls them."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from casa_assets.runs.limits import trees
from tests.support.library.libraries import ROOT, command, ran
from tests.support.program.environments import packages_of

MESHES = ROOT / "examples" / "meshes"
FEW = ("apple.glb", "banana.glb", "cereal_box.glb", "knife.stl", "spoon.dae", "milk_carton.ply")
# Words of command lines: of a process of Ray that does our jobs, and of one that a job runs in.
RAY_WORKER, JOB = "ray::", "casa_assets.runs.server"


def surroundings(*folders: Path) -> dict[str, str]:
    """Environment in which Ray is found, and before it the modules of some folders."""
    paths = os.pathsep.join(map(str, [*folders, packages_of("ray"), ROOT]))
    return {**os.environ, "PYTHONPATH": paths, "RAY_USAGE_STATS_ENABLED": "0", "COLUMNS": "200"}


def start(*arguments: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        command(*arguments), env=surroundings(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def start_on(address: str, inputs: Path, library: Path) -> subprocess.Popen[str]:
    return start("ingest", inputs, "--library", library, "--engine", "ray", "--address", address)


def end(run: subprocess.Popen[str], code: int = 1, most_s: float | None = 600) -> str:
    text, _ = run.communicate(timeout=most_s)
    assert run.returncode == code, text
    return text


def few_meshes(folder: Path) -> Path:
    """A few of the sample meshes in a new folder; one of them is broken."""
    folder.mkdir()
    for name in FEW:
        shutil.copy(MESHES / name, folder)
    return folder


def begun_with(folder: str) -> dict[str, str]:
    """Environment of a machine on which Python starts as a sitecustomize.py here says: `full_disk`, `other_version`."""
    return {"PYTHONPATH": surroundings(Path(__file__).parent / folder)["PYTHONPATH"]}


def wrong_clock(days: int = -400) -> dict[str, str]:
    """Environment of a machine whose calendar is wrong by so many days; what counts seconds from its start is right."""
    library = packages_of("ray") / "libfaketime" / "vendor" / "libfaketime" / "src" / "libfaketime.so.1"
    assert library.is_file()
    return {
        "LD_PRELOAD": str(library),
        "RAY_LD_PRELOAD_ON_WORKERS": "1",
        "FAKETIME": f"{days:+d}d",
        "FAKETIME_DONT_FAKE_MONOTONIC": "1",
        "NO_FAKE_STAT": "1",
    }


class Machines:
    """A cluster of machines with one processor each.

    Args:
        environments: variables that each machine has besides ours.
        within: command that starts them, with what it is to start as its last words.
    """

    def __init__(self, environments: Sequence[Mapping[str, str]], within: Sequence[str] = ()) -> None:
        self._process = subprocess.Popen(
            [*within, sys.executable, Path(__file__).parent / "nodes.py", json.dumps(list(environments))],
            env=surroundings(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        assert self._process.stdout is not None
        self.address = self._process.stdout.readline().strip()
        assert self.address, "no cluster started"

    def order(self, word: str) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{word}\n")
        self._process.stdin.flush()
        assert self._process.stdout.readline().strip() == "done"

    def kill(self, words: str) -> int:
        """End, as by the kernel, the youngest process of the cluster whose command line has some words.

        Returns:
            Its number; 0 where there is none.
        """
        started = [process.pid for process in trees([self._process.pid])[self._process.pid]]
        for pid in sorted((one for one in started if words in _command_line(one)), key=_started_at, reverse=True):
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
                return pid
        return 0

    def end(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(60)


def ask(address: str, *jobs: tuple[str, str], more: Sequence[str] = ()) -> Any:
    """What a cluster answers to jobs of tests/support/program/pool_jobs.py, see ask.py; more: words for it."""
    words = [sys.executable, Path(__file__).parent / "ask.py", address, json.dumps(jobs), *more]
    return json.loads(ran(*words, env=surroundings(), timeout=300).stdout)


@contextmanager
def machines(*environments: Mapping[str, str], within: Sequence[str] = ()) -> Iterator[Machines]:
    made = Machines(environments, within)
    try:
        yield made
    finally:
        made.end()


def _command_line(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
    except OSError:
        return ""


def _started_at(pid: int) -> int:
    """Ticks since the machine was started."""
    try:
        return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19])
    except OSError:
        return 0
