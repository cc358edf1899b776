"""ingest and articulate take one file into one library: two whole entries, in either order, however often killed."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from casa_assets.library.entry_files import Producer, file_digests, read_asset, read_certificate
from casa_assets.library.library import Library
from casa_assets.runs.limits import trees
from tests.determinism.test_kill import is_staged, kill
from tests.support.library.libraries import ROOT, casa_here, command, tree
from tests.unit.articulate.blocks import microwave
from tests.unit.articulate.test_assemble import obj

pytestmark = [
    pytest.mark.slow,
    pytest.mark.content("code", "ingest.run", keep=0),
    pytest.mark.content("code", "articulate.run", keep=0),
]

Moment = Callable[[Path, str], bool]
ORDERS = [("ingest", "articulate"), ("articulate", "ingest")]


def in_staging(name: str) -> Moment:
    come = is_staged(f"microwave_*/*/{name}")
    return lambda library, verb: come(library)


def is_published(library: Path, verb: str) -> bool:
    names = [path.parent.name for path in library.glob("microwave/*/asset.json")]
    return any(("articulated" in name) == (verb == "articulate") for name in names)


MOMENTS = [*map(in_staging, ("model.xml", "preview.png", "usd", "asset.json")), is_published]


@pytest.fixture
def mesh(tmp_path: Path) -> Path:
    vertices, faces, _ = microwave()
    return obj(tmp_path / "microwave.obj", vertices, faces)


def arguments(verb: str, mesh: Path, library: Path) -> list[object]:
    if verb == "ingest":
        return ["ingest", mesh, "--library", library, "--jobs", 1]
    return ["articulate", mesh, "--library", library, "--up", "+z", "--front", "-y"]


def killed_at(moment: Moment, verb: str, mesh: Path, library: Path) -> None:
    """SIGKILL to a run and all that it started, once it has come to a moment (or to its end)."""
    words = command(*arguments(verb, mesh, library))
    run = subprocess.Popen(words, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while run.poll() is None and not moment(library, verb):
        time.sleep(0.001)
    every = [process.pid for process in trees([run.pid])[run.pid]]  # program, server of the workers, workers
    kill(run.pid, *every)
    run.wait()
    while any(Path(f"/proc/{pid}").exists() for pid in every):  # nothing of it may still be writing
        time.sleep(0.002)


def producers(library: Path) -> list[Producer]:
    """Who made the accepted entries, each of which is whole."""
    found = []
    for folder in Library(library).accepted():
        certificate = read_certificate(folder)
        sums = file_digests(folder)
        assert {path: sums[path] for path in certificate.files} == certificate.files, folder
        assert read_asset(folder).digest == certificate.asset_digest, folder
        found.append(certificate.producer)
    return sorted(found)


def entries(library: Path) -> dict[str, bytes | None]:
    return {path: data for path, data in tree(library).items() if path.startswith("microwave/")}


def test_two_whole_entries_after_one_kill_each_and_alike_in_both_orders(mesh: Path, tmp_path: Path) -> None:
    killed, undisturbed = tmp_path / "killed", tmp_path / "undisturbed"
    take_into_one_library(mesh, killed, ORDERS[0], MOMENTS[:1])
    for verb in ORDERS[1]:
        casa_here(*arguments(verb, mesh, undisturbed))
    assert entries(killed) == entries(undisturbed)


@pytest.mark.certify
@pytest.mark.parametrize("order", ORDERS, ids="_then_".join)
def test_two_whole_entries_however_often_killed(mesh: Path, tmp_path: Path, order: tuple[str, str]) -> None:
    take_into_one_library(mesh, tmp_path / "library", order, MOMENTS)


def take_into_one_library(mesh: Path, library: Path, order: tuple[str, str], moments: Sequence[Moment]) -> None:
    """Let both verbs take a mesh in, each killed at every moment first; assert that two whole entries stay."""
    for verb in order:
        for moment in moments:
            before = producers(library) if library.exists() else []
            killed_at(moment, verb, mesh, library)
            assert set(before) <= set(producers(library)), "what was whole is still there"
        done = casa_here(*arguments(verb, mesh, library))
        assert done.returncode == 0, done.stdout + done.stderr
    assert producers(library) == [Producer.ARTICULATE, Producer.INGEST]
    made = entries(library)
    stamps = {path: (library / path).stat().st_mtime_ns for path in made}
    for verb in order:
        again = casa_here(*arguments(verb, mesh, library))
        assert again.returncode == 0, again.stdout + again.stderr
        assert "kept" in again.stdout or "there already" in again.stdout
    assert entries(library) == made
    assert {path: (library / path).stat().st_mtime_ns for path in made} == stamps, "nothing was made anew"
