"""Runs for curators: nothing written, one kind of reject again, folders that are watched, times of stages."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

from casa_assets.pipeline.ingest import survey_table
from casa_assets.pipeline.ingest.job import Event
from casa_assets.pipeline.ingest.run import Options, ingest
from casa_assets.pipeline.ingest.stage_times import StageTimes, throughput
from casa_assets.pipeline.ingest.stages import STAGES
from casa_assets.pipeline.ingest.watch import settled_changes
from casa_assets.pipeline.library import library as disk
from tests.libraries import BOXES, box_obj, tree


def run(source: Path, library: Path, **options: Any) -> list[Event]:
    return list(ingest([source], Options(library, **options)))


def told(events: list[Event]) -> list[tuple[str, str, str]]:
    return sorted((event.path, event.kind, event.code) for event in events)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with `in`: a milk carton, a flat sheet and an unknown box; and `library`, made of them."""
    folder = tmp_path_factory.mktemp("curation")
    (folder / "in").mkdir()
    (folder / "in" / "milk_carton.obj").write_text(box_obj(BOXES["milk_carton"]), encoding="ascii")
    (folder / "in" / "sheet.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding="ascii")
    (folder / "in" / "qwxz.obj").write_text(box_obj((0.11, 0.12, 0.13)), encoding="ascii")
    return folder


def test_a_dry_run_says_what_the_run_says_and_writes_nothing(made: Path) -> None:
    before = tree(made)
    dry = run(made / "in", made / "library", dry_run=True)
    assert tree(made) == before
    wet = run(made / "in", made / "library")
    assert told(dry) == told(wet)
    assert {event.path: event.code for event in wet}["sheet.obj"] == "MSH002"
    assert [event.folder for event in dry] == [None] * 3
    stamps = {path: path.stat().st_mtime_ns for path in sorted((made / "library").rglob("*"))}
    again = run(made / "in", made / "library", dry_run=True)
    assert {event.kind for event in again} == {"kept"}
    assert {path: path.stat().st_mtime_ns for path in sorted((made / "library").rglob("*"))} == stamps


def test_rejects_and_reviews_are_worked_on_again(made: Path) -> None:
    run(made / "in", made / "library")
    assert told(run(made / "in", made / "library", only=frozenset({"MSH002"}))) == [("sheet.obj", "rejected", "MSH002")]
    assert told(run(made / "in", made / "library", only=frozenset({"FLT005"}))) == []
    (unsure,) = run(made / "in", made / "library", only=frozenset({"category"}))
    assert (unsure.path, unsure.kind) == ("qwxz.obj", "review")
    every = told(run(made / "in", made / "library", again=frozenset({"MSH002"})))
    assert every == [("milk_carton.obj", "kept", ""), ("qwxz.obj", "kept", ""), ("sheet.obj", "rejected", "MSH002")]


def test_times_of_stages_are_told_once(made: Path, tmp_path: Path) -> None:
    (event,) = run(made / "in" / "milk_carton.obj", tmp_path / "library")
    assert list(event.seconds) == ["read", *(stage.name for stage in STAGES), "write", "check", "certify"]
    assert all(value >= 0 for value in event.seconds.values())
    (kept,) = run(made / "in" / "milk_carton.obj", tmp_path / "library")
    assert kept.seconds == {}


def test_throughput_sums_up_over_inputs() -> None:
    rows = throughput([{"load": 1.0, "clean": 0.5}, {"load": 3.0}, {}])
    assert [(row.stage, row.inputs, row.seconds) for row in rows] == [("load", 2, 4.0), ("clean", 1, 0.5)]
    assert rows[0].per_second == 0.5
    times = StageTimes()
    with pytest.raises(ValueError, match="x"), times.of("load"):
        raise ValueError("x")
    assert times.seconds["load"] >= 0


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the inputs that were surveyed, one for each time."""
    names: list[str] = []
    find: Callable[..., object] = survey_table.SurveyTable.find

    def counted(self: survey_table.SurveyTable, found: Any) -> object:
        known = find(self, found)
        if known is None:
            names.append(found.main)
        return known

    monkeypatch.setattr(survey_table.SurveyTable, "find", counted)
    return names


def age(folder: Path) -> None:
    """Wait until the files are old enough for what is known of them to be kept: a step of their times."""
    newest = max(path.stat().st_ctime_ns for path in folder.rglob("*"))
    probe = folder.parent / "probe"
    while True:
        probe.write_bytes(b"x")
        if probe.stat().st_ctime_ns > newest + survey_table.MIN_AGE_NS:
            return


def test_an_input_is_read_again_when_anything_of_it_has_changed(tmp_path: Path, read: list[str]) -> None:
    source, library = tmp_path / "in", tmp_path / "library"
    source.mkdir()
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
    source, library = tmp_path / "in", tmp_path / "library"
    source.mkdir()
    (source / "milk_carton.obj").write_text(box_obj(BOXES["milk_carton"]), encoding="ascii")
    run(source, library)
    (disk.Library(library).cache / survey_table.NAME).write_bytes(b"no table at all" * 100)
    (event,) = run(source, library)
    assert event.kind == "kept"


def test_a_folder_is_watched_until_its_files_settle(tmp_path: Path) -> None:
    source = tmp_path / "in"
    (source / "library").mkdir(parents=True)
    (source / "a.obj").write_text("v", encoding="ascii")
    looks = 0

    def pause() -> None:
        """What happens between two looks: a file grows over three of them, then the library is written to."""
        nonlocal looks
        looks += 1
        if looks in (3, 4, 5):
            (source / "b.obj").write_text("v" * looks, encoding="ascii")
        if looks > 5:
            (source / "library" / "made.json").write_text("x" * looks, encoding="ascii")
        if looks > 30:
            raise KeyboardInterrupt

    found: list[int] = []

    def watch() -> None:
        for _ in settled_changes([source], source / "library", pause):
            found.append(looks)

    with pytest.raises(KeyboardInterrupt):
        watch()
    assert found == [1, 6]
    assert len(list(islice(settled_changes([source / "a.obj"], source / "library", lambda: None), 1))) == 1
