"""Runs on a Ray cluster of two machines, both on this one: the library of one machine, whatever is lost."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.libraries import differences

ROOT = Path(__file__).parents[2]
PLACE = ROOT / os.environ.get("CASA_RAY", ".venv-ray")
MESHES = ROOT / "examples" / "meshes"
FEW = ("apple.glb", "banana.glb", "cereal_box.glb", "knife.stl", "spoon.dae", "milk_carton.ply")

pytestmark = pytest.mark.consumers


def surroundings() -> dict[str, str]:
    """Environment in which Ray is found, in front of our packages."""
    assert PLACE.is_dir(), f"{PLACE.name} is missing; ./dev consumers makes it"
    (packages,) = PLACE.glob("lib/python3*/site-packages")
    paths = os.pathsep.join([str(packages), str(ROOT)])
    return {**os.environ, "PYTHONPATH": paths, "RAY_USAGE_STATS_ENABLED": "0", "COLUMNS": "200"}


def casa(*arguments: object) -> subprocess.Popen[str]:
    """The command line, running."""
    return subprocess.Popen(
        [sys.executable, "-m", "casa_assets.cli.main", *map(str, arguments)],
        env=surroundings(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


class Machines:
    """A cluster of machines with one processor each."""

    def __init__(self, count: int) -> None:
        self._process = subprocess.Popen(
            [sys.executable, Path(__file__).parent / "ray_nodes.py", str(count)],
            env=surroundings(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        assert self._process.stdout is not None
        self.address = self._process.stdout.readline().strip()
        assert self.address, "no cluster started"

    def kill_one(self) -> None:
        """End the last machine at once."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write("kill\n")
        self._process.stdin.flush()
        assert self._process.stdout.readline().strip() == "done"

    def end(self) -> None:
        """End all of them."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(60)


@contextmanager
def machines(count: int) -> Iterator[Machines]:
    """A cluster for a test."""
    made = Machines(count)
    try:
        yield made
    finally:
        made.end()


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A few of the sample meshes; one of them is broken."""
    folder = tmp_path_factory.mktemp("inputs") / "meshes"
    folder.mkdir()
    for name in FEW:
        shutil.copy(MESHES / name, folder)
    return folder


@pytest.fixture(scope="module")
def expected(inputs: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The library that this machine makes of them."""
    library = tmp_path_factory.mktemp("local") / "library"
    done = casa("ingest", inputs, "--library", library)
    text, _ = done.communicate()
    assert done.returncode == 1, text
    return library


def test_a_machine_that_is_lost_in_the_middle_changes_nothing(inputs: Path, expected: Path, tmp_path: Path) -> None:
    library = tmp_path / "library"
    with machines(2) as cluster:
        run = casa("ingest", inputs, "--library", library, "--engine", "ray", "--address", cluster.address)
        _wait_for(lambda: any(library.glob("*/*/asset.json")), run)
        cluster.kill_one()
        text, _ = run.communicate(timeout=600)
    assert run.returncode == 1, text
    assert differences(library, expected) == []


def test_a_killed_run_is_resumed_by_the_next(inputs: Path, expected: Path, tmp_path: Path) -> None:
    library = tmp_path / "library"
    with machines(2) as cluster:
        order = ("ingest", inputs, "--library", library, "--engine", "ray", "--address", cluster.address)
        run = casa(*order)
        _wait_for(lambda: any(library.glob("*/*/asset.json")), run)
        run.send_signal(signal.SIGKILL)
        run.wait()
        assert differences(library, expected)
        finished = {path: path.stat().st_mtime_ns for path in library.glob("*/*/asset.json")}
        run = casa(*order)
        text, _ = run.communicate(timeout=600)
    assert run.returncode == 1, text
    assert {path: path.stat().st_mtime_ns for path in finished} == finished
    assert differences(library, expected) == []


def test_no_cluster_at_an_address_is_a_clear_error(inputs: Path, tmp_path: Path) -> None:
    run = casa("ingest", inputs, "--library", tmp_path / "x", "--engine", "ray", "--address", "127.0.0.1:1")
    text, _ = run.communicate(timeout=120)
    assert run.returncode == 2, text
    assert "no Ray cluster answers at 127.0.0.1:1" in text


def _wait_for(is_there: object, run: subprocess.Popen[str]) -> None:
    """Wait until something is there, as long as a run is going on."""
    assert callable(is_there)
    give_up = time.monotonic() + 300
    while not is_there():
        assert run.poll() is None, "the run ended before"
        assert time.monotonic() < give_up
        time.sleep(0.1)
