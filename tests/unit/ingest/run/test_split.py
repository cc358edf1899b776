"""A run that takes files apart: one asset of each thing, with an id, a source and a place in the reports of its own."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from casa_assets.ingest.run.run import Options, ingest
from casa_assets.library.entry import entries
from casa_assets.library.entry_files import read_manifest
from casa_assets.library.library import Library
from casa_assets.runs.outcome import Event
from tests.support.library.libraries import BOXES, box_obj

pytestmark = pytest.mark.content("code", "ingest.run", keep=0)


def set_obj() -> str:
    """Two equal milk cartons and a box of cereal that stand apart, an object of the file each; metres."""
    lines: list[str] = []
    placed = (
        ("milk_carton", "milk_carton", -1.0),
        ("cereal_box", "cereal_box", 0.0),
        ("milk_carton.001", "milk_carton", 1.0),
    )
    for number, (name, kind, x) in enumerate(placed):
        lines.append(f"o {name}")
        for line in box_obj(BOXES[kind]).splitlines():
            word, *rest = line.split()
            if word == "v":
                lines.append(f"v {float(rest[0]) + x} {rest[1]} {rest[2]}")
            elif word == "f":
                lines.append("f " + " ".join(str(int(corner.split("/")[0]) + 8 * number) for corner in rest))
    return "\n".join(lines) + "\n"


def run(folder: Path, **options: bool) -> list[Event]:
    return list(ingest([folder / "in"], Options(folder / "library", **options)))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with `in/breakfast.obj`, a set, and `library`, made of its things."""
    folder = tmp_path_factory.mktemp("split")
    (folder / "in").mkdir()
    (folder / "in" / "breakfast.obj").write_text(set_obj(), encoding="ascii")
    run(folder)
    return folder


def test_a_set_is_one_asset_of_each_thing(made: Path) -> None:
    (whole,) = entries(Library(made / "library"))
    assert whole.source_path == "breakfast.obj"
    assert not whole.accepted or "things" in whole.to_decide
    events = run(made, split=True)
    assert sorted(event.path for event in events) == ["breakfast.obj#cereal_box", "breakfast.obj#milk_carton"]
    found = {entry.source_path: entry for entry in entries(Library(made / "library"))}
    assert {path: entry.category for path, entry in found.items()} == {
        "breakfast.obj#cereal_box": "cereal",
        "breakfast.obj#milk_carton": "milk",
    }, "what was made of the whole file is taken away"
    milk = found["breakfast.obj#milk_carton"]
    assert milk.accepted
    assert any("2 equal ones" in issue.message for issue in milk.warnings)
    said = read_manifest(made / "library" / milk.path).asset["provenance"]
    assert (said["path"], said["node"]) == ("breakfast.obj", "milk_carton")
    again = run(made, split=True)
    assert {(event.kind, event.asset_id) for event in again} == {("kept", event.asset_id) for event in events}
    listed = made / "library" / "review.csv"  # there is none where nothing is left to decide
    rows = list(csv.DictReader(listed.read_text(encoding="utf-8").splitlines())) if listed.exists() else []
    assert {row["input"] for row in rows} <= set(found)


def test_a_single_object_of_many_parts_is_left_whole(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "milk_carton.obj").write_text(box_obj(BOXES["milk_carton"]), encoding="ascii")
    (event,) = run(tmp_path, split=True)
    assert (event.kind, event.path) == ("accepted", "milk_carton.obj")
