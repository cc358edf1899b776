"""Whatever befalls a batch half-way, no entry is half-written, the verdicts of the others stand, and it goes on later.

Runs killed from outside are tests of determinism (`test_kill.py`); here it is the machine or an input that fails.
"""

from __future__ import annotations

import json
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.support.library.libraries import ROOT, casa_here, command, differences

pytestmark = pytest.mark.slow

# `sitecustomize` of the program and its workers: what happens when they come to one input or one file.
KILLED = """
import os, signal, sys

if any("runs.server" in word for word in sys.orig_argv):  # the one that forks the workers
    from casa_assets.ingest.run import steps as worker

    collect = worker.collect

    def deadly(found, limits):
        if "milk" in found.main:
            os.kill(os.getpid(), signal.SIGKILL)
        return collect(found, limits)

    worker.collect = deadly
"""
HANGING = KILLED.replace("os.kill(os.getpid(), signal.SIGKILL)", "signal.pause()")
FULL = """
import errno, os, pathlib

write = pathlib.Path.write_bytes


def fill(path, data):
    if "milk" in str(path) and path.suffix == ".usda":
        write(path, data[: len(data) // 2])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
    return write(path, data)


pathlib.Path.write_bytes = fill
"""


def hook(folder: Path, code: str) -> str:
    """PYTHONPATH of a folder whose sitecustomize is the code, which finds the package that is tested."""
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(code, encoding="ascii")
    return f"{folder}:{ROOT}"


def goes_on(few: Path, library: Path) -> None:
    """Assert that nothing half-written is left, and that the same command ends where an undisturbed run ends."""
    folders = [p for p in library.glob("*/*") if p.is_dir() and not p.parent.name.startswith(".")]
    assert all((p / "asset.json").exists() or (p / "reject.json").exists() for p in folders)
    assert list((library / ".casa" / "staging").iterdir()) == []
    assert casa_here("ingest", few / "in", "--library", library, "--jobs", 1).returncode == 1
    assert differences(few / "library", library) == []


def test_an_input_whose_worker_is_killed_twice(few: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = tmp_path / "library"
    with monkeypatch.context() as patch:  # of the processes that this one starts
        patch.setenv("PYTHONPATH", hook(tmp_path / "hook", KILLED))
        done = casa_here("ingest", few / "in", "--library", library, "--jobs", 1, "--json")
    assert done.returncode == 1, done.stderr
    said = {row["path"]: row for row in map(json.loads, done.stdout.splitlines())}
    assert said["milk_carton.obj"]["code"] == "RUN003"
    assert "SIGKILL" in said["milk_carton.obj"]["message"]
    assert said["cereal_box.obj"]["status"] == "accepted"
    goes_on(few, library)


def test_ctrl_c_while_a_worker_hangs(few: Path, tmp_path: Path) -> None:
    library = tmp_path / "library"
    arguments = command("ingest", few / "in", "--library", library, "--jobs", 2)
    environment = {"PYTHONPATH": hook(tmp_path / "hook", HANGING), "PATH": "/usr/bin:/bin"}
    run = subprocess.Popen(
        arguments, cwd=ROOT, env=environment, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
    )
    while not list(library.glob("cereal/*/asset.json")):  # the other one hangs meanwhile, or will
        assert run.poll() is None
        time.sleep(0.01)
    begin = time.monotonic()
    run.send_signal(signal.SIGINT)
    _, message = run.communicate(timeout=240)
    assert run.returncode == 130
    assert time.monotonic() - begin < 120
    assert message.splitlines() == ["stopped; the same command goes on from here"]
    goes_on(few, library)


def test_a_disk_that_fills_up(few: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = tmp_path / "library"
    with monkeypatch.context() as patch:
        patch.setenv("PYTHONPATH", hook(tmp_path / "hook", FULL))
        done = casa_here("ingest", few / "in", "--library", library, "--jobs", 1)
    assert done.returncode == 2, done.stdout + done.stderr
    assert "cannot be written to: No space left on device" in done.stderr.replace("\n", " ")
    assert not list(library.glob("milk/*"))
    goes_on(few, library)


@pytest.mark.parametrize("place", ["/proc/library", "/dev/null/library", "/sys/library"])
def test_a_folder_that_cannot_be_written_to(few: Path, place: str) -> None:
    done = casa_here("ingest", few / "in", "--library", place)
    assert done.returncode == 2
    assert "cannot be written to" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_reader_of_the_lines_that_goes_away(few: Path, tmp_path: Path) -> None:
    """`casa-assets ingest --json | head -1`: no bug is reported, nothing is half-written."""
    library = tmp_path / "library"
    arguments = command("ingest", few / "in", "--library", library, "--jobs", 1, "--json")
    run = subprocess.Popen(arguments, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert run.stdout is not None
    assert run.stderr is not None
    json.loads(run.stdout.readline())
    run.stdout.close()
    message = run.stderr.read()
    assert run.wait() in (0, 1, 2)
    assert "Traceback" not in message
    goes_on(few, library)
