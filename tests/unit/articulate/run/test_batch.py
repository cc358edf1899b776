"""Many meshes into one library: what is done is kept, refusals too, and a run that was stopped goes on."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from casa_assets.articulate.run import run as batch
from casa_assets.articulate.run.build import ArticulateRequest
from casa_assets.articulate.run.run import RequestMaker, articulate
from casa_assets.articulate.run.steps import ArticulateOutcome, entry_key, publish_refusal
from casa_assets.errors import Rejected
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.places import Found
from casa_assets.library.entry_files import read_refusal
from casa_assets.runs.limits import Limits
from tests.support.library.libraries import differences
from tests.unit.articulate.blocks import box, drawers, microwave, together
from tests.unit.articulate.test_assemble import obj

pytestmark = pytest.mark.content("code", "articulate.run", keep=0)


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two appliances, the bytes of one of them again, a cube, a file that is no mesh, and a note."""
    folder = tmp_path_factory.mktemp("meshes")
    (folder / "more").mkdir()
    for name, (vertices, faces, _) in {
        "microwave": microwave(),
        "more/drawers": drawers(),
        "more/microwave": microwave(),
        "cube": together(box((0, 0, 0), (1, 1, 1))),
    }.items():
        obj(folder / f"{name}.obj", vertices, faces)
    (folder / "broken.obj").write_text("o nothing\n", encoding="utf-8")
    (folder / "note.txt").write_text("not a mesh", encoding="utf-8")
    return folder


def request_maker(out: Path, force: bool = False) -> RequestMaker:
    def make(found: Found) -> ArticulateRequest:
        return ArticulateRequest(
            Path(found.source.place), out, up=(0, 0, 1), front=(0, -1, 0), force=force, source_file=found
        )

    return make


def run(meshes: Path, out: Path) -> dict[str, ArticulateOutcome]:
    return {str(o.mesh): o for o in articulate([meshes], out, request_maker(out))}


@pytest.fixture(scope="module")
def made(meshes: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The library of an uninterrupted run."""
    out = tmp_path_factory.mktemp("made") / "library"
    others: Counter[str] = Counter()
    busy: list[tuple[str, ...]] = []
    outcomes = list(articulate([meshes], out, request_maker(out), 2, others, lambda names: busy.append(tuple(names))))
    by_name = {str(o.mesh): o for o in outcomes}
    assert {name: o.code for name, o in by_name.items()} == {
        "microwave.obj": "",
        "more/drawers.obj": "",
        "more/microwave.obj": "RUN006",
        "cube.obj": "ART001",
        "broken.obj": by_name["broken.obj"].code,
    }
    assert by_name["broken.obj"].code
    assert {o.total for o in outcomes} == {5}
    assert sum(others.values()) == 1
    assert max(map(len, busy)) == 2, "two are worked on at once, and both are told"
    assert not any(o.kept for o in outcomes)
    return out


def test_a_second_run_keeps_everything_and_writes_nothing(meshes: Path, made: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in made.rglob("*") if path.is_file() and ".casa" not in path.parts}
    again = run(meshes, made)
    assert all(o.kept for o in again.values())
    assert again["microwave.obj"].articulation is not None
    assert again["cube.obj"].code == "ART001"
    after = {path: path.stat().st_mtime_ns for path in made.rglob("*") if path.is_file() and ".casa" not in path.parts}
    assert before == after


def test_a_run_that_was_stopped_goes_on_and_makes_the_same(meshes: Path, made: Path, tmp_path: Path) -> None:
    out = tmp_path / "library"
    running = articulate([meshes], out, request_maker(out), 1)
    done = next(o for o in running if not o.code)
    running.close()
    again = run(meshes, out)
    assert again[str(done.mesh)].kept
    assert not all(o.kept for o in again.values())
    assert differences(made, out) == []


def test_what_takes_too_long_is_rejected(meshes: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, out = tmp_path / "in", tmp_path / "library"
    folder.mkdir()
    (folder / "microwave.obj").write_bytes((meshes / "microwave.obj").read_bytes())
    monkeypatch.setattr(batch, "Limits", lambda _, memory_bytes: Limits(0.5, memory_bytes))
    (first,) = run(folder, out).values()
    assert (first.code, first.kept) == ("RUN001", False)
    assert read_refusal(first.folder).code == "RUN001"
    (second,) = run(folder, out).values()
    assert (second.code, second.kept) == ("RUN001", True)


def test_what_broke_a_limit_is_not_tried_again(meshes: Path, made: Path, tmp_path: Path) -> None:
    folder, out = tmp_path / "in", tmp_path / "library"
    folder.mkdir()
    (folder / "cube.obj").write_bytes((meshes / "cube.obj").read_bytes())
    (found,) = (one for one in discover([folder]) if isinstance(one, Found))
    request = request_maker(out)(found)
    refusals = [read_refusal(path.parent) for path in made.glob("rejected/*/reject.json")]
    (cube,) = (refusal for refusal in refusals if refusal.source.path == "cube.obj")
    key = entry_key(request, cube.sha256, found.source)
    for code, is_kept in {"RUN001": True, "RUN002": True, "RUN003": False}.items():
        publish_refusal(request, key, found.source, Rejected(code, "as an earlier run"))
        (again,) = run(folder, out).values()
        assert (again.kept, again.code) == (is_kept, code if is_kept else "ART001")
        if code == "RUN001":
            (forced,) = articulate([folder], out, request_maker(out, force=True))
            assert (forced.kept, forced.code) == (False, "ART001")
