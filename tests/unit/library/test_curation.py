"""Runs for curators: nothing written, one kind of reject again, and inputs that have changed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from casa_assets.ingest.run import inputs as answers
from casa_assets.ingest.run.run import Options, ingest
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library
from casa_assets.runs.outcome import Event
from tests.support.library.libraries import BOXES, box_obj, put_boxes, tree, write_files
from tests.support.library.sharded_inputs import SHEET

pytestmark = pytest.mark.content("code", "ingest.run", keep=0)


def run(source: Path, library: Path, **options: Any) -> list[Event]:
    return list(ingest([source], Options(library, **options)))


def told(events: list[Event]) -> list[tuple[str, str, str]]:
    return sorted((event.path, event.kind, event.code) for event in events)


class Made(NamedTuple):
    """A folder with `in`: a milk carton, a copy of that file, a flat sheet and an unknown box; and `library`."""

    folder: Path
    dry: list[Event]
    wet: list[Event]

    def again(self, **options: Any) -> list[tuple[str, str, str]]:
        return told(run(self.folder / "in", self.folder / "library", **options))


KEPT = [
    ("milk_carton.obj", "kept", ""),
    ("qwxz.obj", "kept", ""),
    ("sheet.obj", "kept", "MSH002"),
    ("twin.obj", "kept", "RUN006"),
]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    folder = tmp_path_factory.mktemp("curation")
    carton, unknown = box_obj(BOXES["milk_carton"]), box_obj((0.11, 0.12, 0.13))
    texts = {"milk_carton.obj": carton, "twin.obj": carton, "sheet.obj": SHEET, "qwxz.obj": unknown}
    write_files(folder / "in", texts)
    before = tree(folder)
    dry = run(folder / "in", folder / "library", dry_run=True)
    assert tree(folder) == before
    return Made(folder, dry, run(folder / "in", folder / "library"))


def test_a_dry_run_says_what_the_run_says_and_writes_nothing(made: Made) -> None:
    assert told(made.dry) == told(made.wet)
    assert [event.folder for event in made.dry] == [None] * 4
    stamps = {path: path.stat().st_mtime_ns for path in sorted(made.folder.rglob("*"))}
    assert made.again(dry_run=True) == KEPT
    assert {path: path.stat().st_mtime_ns for path in sorted(made.folder.rglob("*"))} == stamps


def test_rejects_and_reviews_are_worked_on_again(made: Made) -> None:
    assert made.again(only=frozenset({"FLT005"})) == []
    assert made.again(only=frozenset({"RUN006"})) == KEPT[3:], "it is still a copy, though that file is left out"
    both = frozenset({"MSH002", "category"})
    assert made.again(only=both) == [("qwxz.obj", "review", ""), ("sheet.obj", "rejected", "MSH002")]
    assert made.again(again=frozenset({"MSH002"})) == [*KEPT[:2], ("sheet.obj", "rejected", "MSH002"), KEPT[3]]


def test_what_a_person_has_taken_away_or_decided_is_made_anew(made: Made) -> None:
    library = made.folder / "library"
    ids = {event.path: event.asset_id for event in made.wet}
    (layer,) = library.glob(f"*/*/usd/{ids['milk_carton.obj']}.usda")
    before = layer.read_bytes()
    layer.unlink()
    (library / "ATTRIBUTION.md").unlink()
    EntryTable(Library(library))  # another command looks at the library in the meantime
    assert made.again() == [("milk_carton.obj", "accepted", ""), *KEPT[1:]]
    assert layer.read_bytes() == before
    assert (library / "ATTRIBUTION.md").is_file()
    shutil.rmtree(layer.parents[1])
    shutil.rmtree(library / "rejected" / ids["sheet.obj"])
    rows = (library / "review.csv").read_text(encoding="utf-8").splitlines()
    number = rows[0].split(",").index("set_category")
    edited = [",".join([*row.split(",")[:number], "bread", *row.split(",")[number + 1 :]]) for row in rows[1:]]
    (library / "review.csv").write_text("\n".join([rows[0], *edited]) + "\n", encoding="utf-8")
    found = {path: kind for path, kind, _ in made.again()}
    assert found.pop("qwxz.obj") in ("accepted", "review", "rejected")
    assert found == {"milk_carton.obj": "accepted", "sheet.obj": "rejected", "twin.obj": "kept"}
    assert layer.read_bytes() == before
    (box,) = (e for e in EntryTable(Library(library)).entries if e.source_path == "qwxz.obj")
    assert box.category == "bread"
    assert {kind for _, kind, _ in made.again()} == {"kept"}


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the inputs that were surveyed, one for each time."""
    names: list[str] = []
    find: Callable[..., object] = answers.SurveyTable.find

    def counted(self: answers.SurveyTable, found: Any) -> object:
        known = find(self, found)
        if known is None:
            names.append(found.main)
        return known

    monkeypatch.setattr(answers.SurveyTable, "find", counted)
    return names


def age(folder: Path) -> None:
    """Wait until the files are old enough for what is known of them to be kept: a step of their times."""
    newest = max(path.stat().st_ctime_ns for path in folder.rglob("*"))
    probe = folder.parent / "probe"
    while True:
        probe.write_bytes(b"x")
        if probe.stat().st_ctime_ns > newest + answers.MIN_AGE_NS:
            return


def test_an_input_is_read_again_when_anything_of_it_has_changed(tmp_path: Path, read: list[str]) -> None:
    source, library = put_boxes(tmp_path / "in", "milk_carton"), tmp_path / "library"
    mesh = source / "milk_carton.obj"
    mesh.write_text("mtllib paint.mtl\n" + box_obj(BOXES["milk_carton"]), encoding="ascii")
    age(source)
    (first,) = run(source, library)
    read.clear()
    (second,) = run(source, library)
    assert (read, second.kind, second.asset_id) == ([], "kept", first.asset_id)
    (source / "paint.mtl").write_text("newmtl a\nKd 1 0 0\n", encoding="ascii")
    age(source)
    (third,) = run(source, library)
    assert read == ["milk_carton.obj"], "a file that was missing is there now"
    assert third.asset_id != first.asset_id
    read.clear()
    stamp = mesh.stat()
    mesh.write_text(mesh.read_text(encoding="ascii").replace("v ", "v  ", 1)[:-1] + "\n", encoding="ascii")
    os.utime(mesh, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    run(source, library, dry_run=True)
    assert read == ["milk_carton.obj"]


def test_a_table_of_surveys_that_is_none_is_made_anew(tmp_path: Path) -> None:
    source, library = put_boxes(tmp_path / "in", "milk_carton"), tmp_path / "library"
    run(source, library)
    (Library(library).cache / answers.SURVEYS).write_bytes(b"no table at all" * 100)
    (event,) = run(source, library)
    assert event.kind == "kept"
