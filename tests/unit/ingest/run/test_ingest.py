"""What a run finds, what it leaves alone, does again, and replaces; files that are taken apart into their things."""

from __future__ import annotations

import csv
import json
import os
import re
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
import typer

from casa_assets import registry
from casa_assets.cli.batch_output import end_inputs
from casa_assets.errors import CasaError, OutputError, UnknownId
from casa_assets.ingest.run import steps
from casa_assets.ingest.run.inputs import Job, Survey, WorkerAnswers, discover_inputs
from casa_assets.ingest.run.run import Options, ingest, tally
from casa_assets.ingest.sources.places import Found
from casa_assets.library.entry import MAX_ROWS_PER_FILE, entries
from casa_assets.library.entry_files import file_digests, read_manifest
from casa_assets.library.library import Library
from casa_assets.model.asset.asset import Asset, Guess
from casa_assets.model.issue import Decision, Issue, Report, Severity
from casa_assets.model.source import Bundle
from casa_assets.runs.outcome import Event, Outcome
from tests.support.asset.box_assets import plain_box
from tests.support.library.libraries import BOXES, box_obj, differences, entries_of

pytestmark = [pytest.mark.content("code", "ingest.run", keep=0), pytest.mark.content("code", "library", keep=0)]

CARTON = "milk/milk_265a5b2e46"


def write_box(folder: Path, name: str = "milk_carton.obj") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(box_obj(BOXES["milk_carton"]), encoding="ascii")
    return folder


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with `in`, one milk carton, and `library`, made of it."""
    folder = tmp_path_factory.mktemp("made")
    assert kinds(run(write_box(folder / "in"), folder / "library")) == ["accepted"]
    assert entries_of(folder / "library") == [CARTON]
    return folder


@pytest.fixture
def copy(made: Path, tmp_path: Path) -> Path:
    return shutil.copytree(made, tmp_path / "copy")


def run(source: Path, library: Path, **options: Any) -> list[Event]:
    return list(ingest([source], Options(library, **options)))


def kinds(events: list[Event]) -> list[str]:
    return [event.kind for event in events]


def edit(path: Path, **changes: object) -> None:
    data = json.loads(path.read_text(encoding="utf-8"))
    for name, value in changes.items():
        (data["certificate"] if name == "cache_key" and "certificate" in data else data)[name] = value
    path.write_text(json.dumps(data), encoding="utf-8")


def test_a_damaged_entry_is_made_again(copy: Path, made: Path) -> None:
    (copy / "library" / CARTON / "asset.json").write_text('{"asset": {}, "certificate": {}}', encoding="utf-8")
    with pytest.raises(OutputError, match=r"asset\.json"):
        list(entries(Library(copy / "library")))
    assert kinds(run(copy / "in", copy / "library")) == ["accepted"]
    assert differences(made / "library", copy / "library") == []


def test_verdicts_replace_each_other_and_passing_ones_are_not_final(copy: Path, made: Path) -> None:
    library = copy / "library"
    edit(library / CARTON / "asset.json", cache_key="that of another version")
    (event,) = run(copy / "in", library, seconds=0.01, force=True)
    assert (event.kind, event.code) == ("rejected", "RUN001") or event.asset_id.startswith("unread_")
    assert event.was_rejected
    assert kinds(run(copy / "in", library)) == ["accepted"]
    assert differences(made / "library", library) == []


def test_an_accepted_asset_is_kept_where_the_new_result_is_worse(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = copy / "library"
    edit(library / CARTON / "asset.json", cache_key="that of another version")
    before = file_digests(library / CARTON)
    works: list[str] = []

    def reject(_: WorkerAnswers, jobs: Sequence[Job]) -> Iterator[tuple[int, Outcome]]:
        for number, job in enumerate(jobs):
            works.append(job.asset_id)
            yield number, Outcome(False, "FLT005", "a scrap of a scan")

    monkeypatch.setattr(WorkerAnswers, "outcomes", reject)
    (event,) = run(copy / "in", library)
    assert (event.kind, event.decision) == ("kept", Decision.ACCEPTED)
    said = f"{event.asset_id} is accepted, the new result was rejected (FLT005); --force replaces it"
    assert event.reason_kept == said
    assert event.folder == library / CARTON
    with pytest.raises(typer.Exit) as ended:
        end_inputs([event], ["carton"])
    assert ended.value.exit_code == 4
    (again,) = run(copy / "in", library)
    assert (again.kind, again.reason_kept) == ("kept", event.reason_kept)
    assert len(works) == 1, "the next run remembers the result"
    assert file_digests(library / CARTON) == before
    assert kinds(run(copy / "in", library, force=True)) == ["rejected"]
    assert entries_of(library) == [f"rejected/{event.asset_id}"]


def test_another_category_replaces_the_entry(copy: Path) -> None:
    (event,) = run(copy / "in", copy / "library", category="cereal")
    assert entries_of(copy / "library") in ([f"cereal/{event.asset_id}"], [f"rejected/{event.asset_id}"])
    assert not (copy / "library" / "milk").exists()


def test_a_place_that_can_be_read_now_is_no_longer_refused(copy: Path, made: Path) -> None:
    good = copy / "in" / "milk_carton.obj"
    text = good.read_text(encoding="ascii")
    good.write_text("", encoding="ascii")
    assert kinds(run(copy / "in", copy / "library")) == ["rejected"]
    assert kinds(run(copy / "in", copy / "library")) == ["kept"]
    good.write_text(text, encoding="ascii")
    assert kinds(run(copy / "in", copy / "library")) == ["kept"]
    assert differences(made / "library", copy / "library") == []


def test_the_library_may_lie_in_the_source(tmp_path: Path) -> None:
    source = write_box(tmp_path / "in")
    library = source / "out" / "library"
    assert kinds(run(source, library)) == ["accepted"]
    assert kinds(run(source, library)) == ["kept"]
    every, inner = (list(discover_inputs([place], source / "another")) for place in (source, library))
    assert [one.main for one in every if isinstance(one, Found)] == ["milk_carton.obj"]
    assert any(isinstance(one, Found) for one in inner), "a library that is named is a source like any other"


@pytest.mark.parametrize("named", ["meshes/milk_carton.obj", "meshes/manifest.jsonl", "meshes"])
def test_what_is_named_is_an_input_though_a_folder_above_it_holds_a_library(tmp_path: Path, named: str) -> None:
    project = tmp_path / "all" / "project"
    meshes = write_box(project / "meshes")
    (meshes / "manifest.jsonl").write_text('{"id": "a", "file": "milk_carton.obj"}\n', encoding="ascii")
    with Library(project).locked():  # as where a pack of textures was put into a project
        pass
    assert len(list(discover_inputs([project / named], project / "out" / "library"))) == 1
    assert list(discover_inputs([project / named], project)) == []
    assert list(discover_inputs([project.parent], project.parent / "library")) == []


def test_the_same_bytes_called_two_kinds_end_the_run_like_any_other(tmp_path: Path) -> None:
    """A row of a manifest calls cereal what the name of another file with the same bytes calls milk."""
    source = write_box(tmp_path / "in")
    write_box(tmp_path / "in", "another.obj")
    (source / "one.jsonl").write_text('{"id": "a", "file": "another.obj", "category": "cereal"}\n', encoding="ascii")
    (source / "board.obj").write_text(box_obj(BOXES["cutting_board"]), encoding="ascii")
    events = {event.path: event for event in run(source, tmp_path / "library")}
    codes = {path: event.code for path, event in events.items()}
    assert codes == {"another.obj": "", "milk_carton.obj": "RUN006", "board.obj": ""}


def test_a_folder_and_its_own_manifest_count_each_row_once(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    manifest = tmp_path / "in" / "manifest.jsonl"
    manifest.write_text('{"id": "a", "file": "a.glb"}\n{"id": "b"}\n', encoding="ascii")
    events = list(ingest([tmp_path / "in", manifest], Options(tmp_path / "library")))
    assert sorted(event.code for event in events) == ["MAN002", "SRC020"]
    assert len(list(entries(Library(tmp_path / "library")))) == 2


def test_very_many_bad_rows_cost_one_file(tmp_path: Path) -> None:
    """The first are told word for word, the others are counted; fixed rows are forgotten by the next run."""
    (tmp_path / "in").mkdir()
    manifest, library = tmp_path / "in" / "manifest.jsonl", tmp_path / "library"
    manifest.write_text("".join(f'{{"id": "n{i}", "file": "n{i}.glb"}}\n' for i in range(5000)), encoding="ascii")
    events = run(tmp_path / "in", library)
    assert len(events) == MAX_ROWS_PER_FILE + 1
    assert (events[-1].count, events[-1].code, events[-1].total) == (5000 - MAX_ROWS_PER_FILE, "SRC020", 5000)
    assert tally(events) == {"rejected": 5000, "kept": 0, "all": 5000}
    files = [path for path in library.rglob("*") if path.is_file() and ".casa" not in path.parts]
    assert {path.name for path in files} == {"rows.jsonl", "library.json", "ATTRIBUTION.md"}
    assert (library / "rejected" / "rows.jsonl").stat().st_size < 50_000
    listed = list(entries(Library(library)))
    assert len(listed) == MAX_ROWS_PER_FILE + 1
    assert listed[-1].message == "4900 more for this reason; fix the first ones and run again"
    assert {event.kind for event in run(tmp_path / "in", library)} == {"kept"}
    manifest.write_text('{"id": "a", "file": "a.glb"}\n', encoding="ascii")
    assert [event.path for event in run(tmp_path / "in", library)] == ["manifest.jsonl"]
    assert len(list(entries(Library(library)))) == 1


def test_names_of_any_kind(tmp_path: Path) -> None:
    source = write_box(tmp_path / os.fsdecode(b"folder\xff"), 'milk\n"<b>[red]\x1b[31m.obj')
    (source / os.fsdecode(b"mug\xff.obj")).touch()
    events = run(source, tmp_path / "library")
    assert sorted(event.kind for event in events) == ["accepted", "rejected"]
    rows = list(entries(Library(tmp_path / "library")))
    assert sorted(row.source_path for row in rows) == ['milk\n"<b>[red]\x1b[31m.obj', "mug\\udcff.obj"]
    lines = (tmp_path / "library" / "ATTRIBUTION.md").read_text(encoding="utf-8")
    assert not re.search(r"(?<!\\)<", lines)  # Markdown shows an escaped one as text
    assert "\x1b" not in lines


def test_what_no_run_can_do_is_told_before_it_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An unknown category, and a machine that cannot draw."""
    with pytest.raises(UnknownId, match="did you mean"):
        run(write_box(tmp_path / "in"), tmp_path / "library", category="mugg")
    assert not (tmp_path / "library").exists()
    (tmp_path / "blocked").mkdir()
    code = "import sys\nsys.modules['mujoco.egl'] = sys.modules['mujoco.osmesa'] = None\n"
    (tmp_path / "blocked" / "sitecustomize.py").write_text(code, encoding="ascii")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "blocked"))
    with pytest.raises(CasaError, match="apt-get install"):
        run(tmp_path / "in", tmp_path / "library")
    assert entries_of(tmp_path / "library") == []
    assert list((tmp_path / "library" / ".casa" / "staging").iterdir()) == []


def test_a_copy_in_other_units_is_turned_away_unless_it_is_wanted(tmp_path: Path) -> None:
    source = write_box(tmp_path / "in")
    x, y, z = BOXES["milk_carton"]
    (source / "milk_copy.obj").write_text(box_obj((100 * x, 100 * y, 100 * z)), encoding="ascii")
    library = tmp_path / "library"
    events = run(source, library)
    assert [(e.path, e.kind, e.code) for e in events] == [
        ("milk_carton.obj", "accepted", ""),
        ("milk_copy.obj", "rejected", "RUN007"),
    ]
    assert events[1].message.startswith(f"duplicate of milk_carton.obj ({events[0].asset_id})")
    assert kinds(run(source, library)) == ["kept", "kept"]
    wanted = run(source, library, keep_duplicates=True)
    assert [(e.path, e.kind) for e in wanted] == [("milk_carton.obj", "kept"), ("milk_copy.obj", "accepted")]
    assert len(entries_of(library)) == 2
    issues = json.loads((library / "library.json").read_text(encoding="utf-8"))["report"]["issues"]
    assert [(i["code"], i["pointer"]) for i in issues if i["pointer"]] == [("LIB001", wanted[1].asset_id)]


def test_where_no_way_up_is_better_files_are_of_the_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Shapes of a table that fit in no pose: report and files are of the same asset."""
    tried: list[tuple[str, ...]] = []
    written: list[Asset] = []

    def build(*words: Any) -> tuple[Asset, tuple[()]]:
        tried.append(words[-1])
        asset = plain_box()
        guess = Guess(subject="up_axis", value="xyz"[len(tried) - 1], confidence=0.5, reason="")
        return asset.replace(provenance=asset.provenance.replace(guesses=(guess,))), ()

    fault = Issue(code="FLT015", severity=Severity.ERROR, pointer="pose", message="it falls over")
    monkeypatch.setattr(steps, "build_asset", build)
    monkeypatch.setattr(steps, "write_package", lambda asset, _: written.append(asset))
    monkeypatch.setattr(steps, "check_package", lambda *_: Report(subject="box", issues=(fault,)))
    (found,) = discover_inputs([write_box(tmp_path / "in")], tmp_path / "library")
    assert isinstance(found, Found)
    job = Job(found, Survey("0" * 64, "object", 1.0, ""), "object_0", tmp_path, {}, "")
    library = Library(tmp_path / "library")
    with library.locked():
        asset, _ = steps._built(job, Bundle(main="a", files={}), registry.load().category("object"), library)
    assert tried == [(), ("x",), ("x", "y")]
    assert written[-1] == asset == written[0]


def set_obj() -> str:
    """Two equal milk cartons and a box of cereal that stand apart, an object of the file each; metres."""
    lines: list[str] = []
    for number, name in enumerate(("milk_carton", "cereal_box", "milk_carton.001")):
        lines.append(f"o {name}")
        for line in box_obj(BOXES[name.partition(".")[0]]).splitlines():
            word, *rest = line.split()
            if word == "v":
                lines.append(f"v {float(rest[0]) + number} {rest[1]} {rest[2]}")
            elif word == "f":
                lines.append("f " + " ".join(str(int(corner.split("/")[0]) + 8 * number) for corner in rest))
    return "\n".join(lines) + "\n"


def test_a_set_is_one_asset_of_each_thing(tmp_path: Path) -> None:
    source, library = tmp_path / "in", tmp_path / "library"
    source.mkdir()
    (source / "breakfast.obj").write_text(set_obj(), encoding="ascii")
    run(source, library)
    (whole,) = entries(Library(library))
    assert whole.source_path == "breakfast.obj"
    assert not whole.accepted or "things" in whole.to_decide
    events = run(source, library, split=True)
    assert sorted(event.path for event in events) == ["breakfast.obj#cereal_box", "breakfast.obj#milk_carton"]
    found = {entry.source_path: entry for entry in entries(Library(library))}
    assert {path: entry.category for path, entry in found.items()} == {
        "breakfast.obj#cereal_box": "cereal",
        "breakfast.obj#milk_carton": "milk",
    }, "what was made of the whole file is taken away"
    milk = found["breakfast.obj#milk_carton"]
    assert milk.accepted
    assert any("2 equal ones" in issue.message for issue in milk.warnings)
    said = read_manifest(library / milk.path).asset["provenance"]
    assert (said["path"], said["node"]) == ("breakfast.obj", "milk_carton")
    again = run(source, library, split=True)
    assert {(event.kind, event.asset_id) for event in again} == {("kept", event.asset_id) for event in events}
    listed = library / "review.csv"  # there is none where nothing is left to decide
    rows = list(csv.DictReader(listed.read_text(encoding="utf-8").splitlines())) if listed.exists() else []
    assert {row["input"] for row in rows} <= set(found)


def test_a_single_object_of_many_parts_is_left_whole(tmp_path: Path) -> None:
    (event,) = run(write_box(tmp_path / "in"), tmp_path / "library", split=True)
    assert (event.kind, event.path) == ("accepted", "milk_carton.obj")
