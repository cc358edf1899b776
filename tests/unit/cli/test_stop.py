"""SIGTERM and Ctrl-C end every verb within seconds, in one line, with no process left, also within a native call."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from tests.support.library.libraries import BOXES, box_obj, hooked

pytestmark = pytest.mark.slow

SOON_S = 5.0
# `sitecustomize` of the program and its workers: one function of the verb becomes a native call of hours, during
# which no handler of Python runs.
ENDLESS = """
import functools, hashlib, importlib, os, pathlib, sys

if any(word in ("casa_assets.cli.main",) or "runs.server" in word for word in sys.orig_argv):
    module, name = os.environ["CASA_TEST_ENDLESS"].split(":")
    found = importlib.import_module(module)

    @functools.wraps(getattr(found, name))
    def endless(*_, **__):
        pathlib.Path(os.environ["CASA_TEST_MARK"]).touch()
        hashlib.pbkdf2_hmac("sha256", b"", b"", 2_000_000_000)

    setattr(found, name, endless)
"""
VERBS = {
    "ingest {mesh} --library {out}": "ingest.run.steps:work",
    "ingest {mesh} --library {out} --jobs 1": "ingest.run.inputs:survey",
    "articulate {mesh} --library {out}": "articulate.run.steps:articulate_one",
    "families build microwave --library {out}": "families.build:build_one",
    "families show microwave --preset steel --out {out}": "families.build:build_one",
    "families catalogue microwave --no-swatches --out {out}": "families.build:build_asset",
    "textures make oak_natural_plank --out {out}": "textures.run.recipes:finish_of",
    "textures sheet oak_natural_plank --out {out}": "textures.run.recipes:finish_of",
    "textures check oak_natural_plank --out {out}": "textures.run.recipes:finish_of",
    "textures ingest {folder} --library {out}": "textures.run.packs:survey",
    "scenes build l_small__coastal --out {out}": "layouts.run.scene_folders:build_with_options",
    "scenes check l_small__coastal --out {out}": "layouts.run.check:check_one",
    "scenes sample 2 --out {out}": "layouts.run.check:check_one",
    "scenes preview l_small__coastal --out {folder}": "layouts.run.scene_folders:draw_cameras",
    "scenes new galley --style rustic --out {out}": "layouts.run.scene_folders:build_with_options",
    "preview {folder} --out {out}": "show.reports.pictures:draw",
    "report --library {folder}": "show.reports.library_page:write",
    "find mug --library {folder}": "library.search:search_entries",
    "export robocasa {folder} --out {out}": "addons.robocasa.run:export",
}
# One that works in workers and one that works in the program's own process; one of each signal.
OFTEN = ("ingest {mesh} --library {out} --jobs 1", "find mug --library {folder}")


@pytest.fixture
def places(tmp_path: Path) -> dict[str, Path]:
    """A mesh, a folder that passes for a library and for one of scenes, and where to write to."""
    mesh, folder = tmp_path / "milk_carton.obj", tmp_path / "folder"
    mesh.write_text(box_obj(BOXES["milk_carton"]), encoding="ascii")
    for path in (folder / ".casa", folder / "l_small__coastal", tmp_path / "hook"):
        path.mkdir(parents=True)
    return {"mesh": mesh, "folder": folder} | {name: tmp_path / name for name in ("out", "hook", "mark")}


def start(verb: str, function: str, places: dict[str, Path]) -> subprocess.Popen[str]:
    """The program, once it is within the call that does not end."""
    words = [word.format(**places) for word in verb.split()]
    environment = {"CASA_TEST_ENDLESS": f"casa_assets.{function}", "CASA_TEST_MARK": str(places["mark"])}
    run = hooked(ENDLESS, places["hook"], *words, **environment)
    while not places["mark"].exists():
        assert run.poll() is None, run.communicate()[1]
        time.sleep(0.02)
    time.sleep(0.2)  # from the mark into the call
    return run


def left_of(mark: Path) -> list[int]:
    """Processes that were started by the program: they have the mark in their environment."""
    found = []
    for path in Path("/proc").glob("[0-9]*/environ"):
        with suppress(OSError):
            if str(mark).encode() in path.read_bytes():
                found.append(int(path.parent.name))
    return found


@pytest.mark.parametrize("verb", [pytest.param(v, marks=[pytest.mark.certify] * (v not in OFTEN)) for v in VERBS])
def test_every_verb_stops_soon_even_in_a_native_call(verb: str, places: dict[str, Path]) -> None:
    number = (signal.SIGTERM, signal.SIGINT)[sorted(VERBS).index(verb) % 2]
    run = start(verb, VERBS[verb], places)
    begin = time.monotonic()
    run.send_signal(number)
    _, message = run.communicate()
    took = time.monotonic() - begin
    assert took < SOON_S
    assert run.returncode == 128 + number
    assert message.splitlines() == ["stopped; the same command goes on from here"]
    assert left_of(places["mark"]) == []


def test_ctrl_c_in_a_terminal_reaches_all_of_the_group(places: dict[str, Path]) -> None:
    """The terminal sends the signal to the program and to the process that it works in."""
    run = start("textures make oak_natural_plank --out {out}", "textures.run.recipes:finish_of", places)
    for pid in left_of(places["mark"]):
        os.kill(pid, signal.SIGINT)
    _, message = run.communicate(timeout=SOON_S)
    assert run.returncode == 130
    assert message.splitlines() == ["stopped; the same command goes on from here"]


def test_nothing_is_left_of_a_program_that_is_killed(places: dict[str, Path]) -> None:
    run = start("ingest {mesh} --library {out}", "ingest.run.inputs:survey", places)
    run.kill()
    run.communicate()
    begin = time.monotonic()
    while left_of(places["mark"]):
        assert time.monotonic() - begin < SOON_S
        time.sleep(0.02)


def test_nothing_is_left_that_lost_its_parent_meanwhile(tmp_path: Path) -> None:
    """A shell that ends at once leaves a process behind, which the command ends with itself."""
    note, code = tmp_path / "note", "import subprocess, sys; from casa_assets.cli.main import supervised; "
    code += "sys.exit(supervised(lambda: subprocess.call(['sh', '-c', f'sleep 600 & echo $! > {sys.argv[1]}']), print))"
    subprocess.run([sys.executable, "-c", code, note], stdin=subprocess.DEVNULL, timeout=60, check=True)
    left = Path(f"/proc/{note.read_text().strip()}/stat")
    assert not left.exists() or left.read_text().rpartition(")")[2].split()[0] == "Z"


@pytest.mark.representatives(1)
@pytest.mark.parametrize(("number", "code", "message"), [(11, 3, "SIGSEGV"), (9, 2, "want of memory")])
def test_the_death_of_a_worker_is_reported(number: int, code: int, message: str, places: dict[str, Path]) -> None:
    run = start("textures make oak_natural_plank --out {out}", "textures.run.recipes:finish_of", places)
    (working,) = set(left_of(places["mark"])) - {run.pid}
    os.kill(working, number)
    _, told = run.communicate(timeout=SOON_S)
    assert run.returncode == code
    assert message in told
    assert len(told.splitlines()) == 1
