"""Conditions on entries, and their tables in Parquet parts: the same bytes, kept where nothing changed."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pyarrow.parquet
import pytest

from casa_assets.errors import CasaError, OutputError
from casa_assets.library import parquet
from casa_assets.library.entry import Entry
from casa_assets.library.library import Library
from casa_assets.library.search import BadCondition, Condition, meets, parse_condition, with_default
from tests.support.asset.assets import ball, rigid_mug
from tests.support.library.built_libraries import keep
from tests.support.library.synthetic_entries import synthetic_entries

pytestmark = pytest.mark.content("code", "library", keep=0)

COUNT = 3_000
# Conditions, and what Python alone asks of an entry that meets them.
CONDITIONS: dict[tuple[str, ...], Callable[[Entry], bool]] = {
    ("category=mug",): lambda e: e.accepted and e.category == "mug",
    ("category=mug,bowl", "verdict=accepted"): lambda e: (
        e.category in ("mug", "bowl") and e.decision.value == "accepted"
    ),
    ("category!=mug", "faces<500"): lambda e: e.category != "mug" and e.summary is not None and e.summary.faces < 500,
    ("reason=FLT005",): lambda e: "FLT005" in (e.code, *e.advice),
    ("reason!=RUN007", "verdict=rejected"): lambda e: e.code != "RUN007" and not e.accepted,
    ("size<=0.1", "size>0.05"): lambda e: e.summary is not None and 0.05 < max(e.summary.extents) <= 0.1,
    ("mass>=2.5", "source=folder"): lambda e: e.summary is not None and e.summary.mass >= 2.5 and e.source == "folder",
    ("decide=scale,mass",): lambda e: bool({"scale", "mass"} & set(e.to_decide)),
    ("licence=CC-BY-4.0", "split=test", "warnings>1"): lambda e: (
        e.licence == "CC-BY-4.0" and e.split == "test" and len(e.warnings) > 1
    ),
}


def rows_in(tables: Path) -> list[dict[str, Any]]:
    """The rows of a table, in the order of its parts; read by pyarrow, as others do."""
    said = json.loads((tables / "index.json").read_text(encoding="utf-8"))
    names = [part["name"] for library in said["libraries"] for part in library["parts"]]
    return [row for name in names for row in pyarrow.parquet.read_table(tables / name).to_pylist()]


def fitting(conditions: Sequence[Condition] = ()) -> list[Entry]:
    return [entry for entry in synthetic_entries(COUNT) if meets(entry, conditions)]


def test_conditions_find_what_fits(subtests: pytest.Subtests) -> None:
    for texts, is_meant in CONDITIONS.items():
        with subtests.test(texts=texts):
            found = fitting(with_default([parse_condition(text) for text in texts]))
            assert found == [entry for entry in synthetic_entries(COUNT) if is_meant(entry)]
            assert found, "a condition that nothing meets tells nothing"


def test_a_row_says_what_its_entry_says(tmp_path: Path) -> None:
    library = Library(tmp_path / "library")
    library.private.mkdir(parents=True)
    parquet.write_index([library], tmp_path / "tables", entries_of=lambda _: synthetic_entries(COUNT))
    rows = {row["id"]: row for row in rows_in(tmp_path / "tables")}
    assert len(rows) == COUNT
    for entry in synthetic_entries(COUNT):
        row, told, summary = rows[entry.id], entry.checks, entry.summary
        same = ("category", "path", "code", "message", "title", "author", "licence", "split", "source", "digest")
        assert {name: row[name] for name in same} == {name: getattr(entry, name) for name in same}
        assert (row["status"], row["warnings"]) == (entry.decision.value, len(entry.warnings))
        assert (row["advice"].split(), row["decide"].split()) == ([*entry.advice], [*entry.to_decide])
        assert row["colors"] == " ".join(f"{name}={share}" for name, share in entry.colors)
        checks = [row[name] for name in ("checks_passed", "checks", "checks_not_run", "checks_not_applicable")]
        assert checks == [told.passed, told.applying, told.not_run, told.not_applicable]
        sizes = [row[name] for name in ("size_x_m", "size_y_m", "size_z_m", "mass_kg", "faces", "colliders")]
        numbers = (*summary.extents, summary.mass, summary.faces, summary.colliders) if summary else (None,) * 6
        assert sizes == [*numbers]


def test_what_is_no_condition_is_told(subtests: pytest.Subtests) -> None:
    for text in ("category=x' OR '1'='1", 'author="; DROP TABLE entries', "id=%"):
        assert fitting([parse_condition(text)]) == [], "hostile values are only compared"
    for text, words in [
        ("mug", "is no condition; write a field"),
        ("categroy=mug", "did you mean category"),
        ("category>mug", "is a word, and is compared with = or !="),
        ("size=0.1", "size is compared with >"),
        ("mass<heavy", "'heavy' is no number"),
        ("mass<nan", "'nan' is no number"),
        ("verdict=good", "is no verdict; they are accepted, review, rejected"),
        ("reason=FLT 005", "is no reason"),
    ]:
        with subtests.test(text=text, words=words), pytest.raises(BadCondition, match=words):
            parse_condition(text)


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.fixture
def libraries(tmp_path: Path) -> list[Library]:
    assets = {"a": rigid_mug(), "b": ball()}
    return [Library(keep(tmp_path / name / "library", [asset])) for name, asset in assets.items()]


def test_same_entries_same_bytes(libraries: list[Library], tmp_path: Path) -> None:
    parquet.write_index(libraries, tmp_path / "tables")
    first = files(tmp_path / "tables")
    assert len(first) == 3
    schema = pyarrow.parquet.read_schema(next((tmp_path / "tables").glob("*.parquet")))
    types = {field.name: str(field.type) for field in schema}
    assert list(types) == [*parquet.COLUMNS, "library"]
    assert (types["mass_kg"], types["faces"], types["message"]) == ("double", "int64", "string")
    parquet.write_index(libraries[::-1], tmp_path / "tables", force=True)
    assert files(tmp_path / "tables") == first
    rows = {row["id"]: row["library"] for row in rows_in(tmp_path / "tables")}
    assert rows == {rigid_mug().id: "../a/library", ball().id: "../b/library"}


def test_what_did_not_change_is_kept(libraries: list[Library], tmp_path: Path) -> None:
    tables = tmp_path / "tables"
    assert parquet.write_index(libraries, tables).kept == ()
    read: list[str] = []

    def noted(library: Library) -> Iterator[Entry]:
        read.append(library.root.parent.name)
        return parquet.stream_entries(library)

    assert parquet.write_index(libraries, tables, entries_of=noted).kept == ("../a/library", "../b/library")
    keep(libraries[1].root, [rigid_mug()])
    assert parquet.write_index(libraries, tables, entries_of=noted).kept == ("../a/library",)
    assert read == ["b"]
    assert Counter(row["library"] for row in rows_in(tables)) == {"../a/library": 1, "../b/library": 2}
    assert len(list(tables.glob("*.parquet"))) == 2, "the part of before has gone"
    next(tables.glob("*.parquet")).unlink()
    parquet.write_index(libraries, tables)
    assert len(rows_in(tables)) == 3, "a part that is missing is written again"


def test_killed_before_the_end_it_is_what_it_was(
    libraries: list[Library], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parquet.write_index(libraries[:1], tmp_path / "tables")
    with monkeypatch.context() as patch:
        patch.setattr(parquet, "_publish", Mock(side_effect=KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            parquet.write_index(libraries, tmp_path / "tables")
    assert [row["id"] for row in rows_in(tmp_path / "tables")] == [rigid_mug().id]
    parquet.write_index(libraries, tmp_path / "tables")
    assert len(rows_in(tmp_path / "tables")) == 2


def test_large_parts_are_divided_and_sorted(
    libraries: list[Library], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parquet, "PART_ROWS", 1_000)
    monkeypatch.setattr(parquet, "GROUP_ROWS", 200)
    tables = tmp_path / "tables"
    written = parquet.write_index(libraries[:1], tables, entries_of=lambda _: synthetic_entries(2_500))
    (one,) = written.index.libraries
    assert [part.rows for part in one.parts] == [1_000, 1_000, 500]
    file = pyarrow.parquet.ParquetFile(tables / one.parts[0].name)
    assert file.metadata.num_row_groups == 5
    found = [(row["category"], row["id"]) for row in rows_in(tables)]
    keys = [key for i in range(0, 2_500, 1_000) for key in sorted(found[i : i + 1_000])]
    assert found == keys  # each part is sorted
    assert len(keys) == 2_500


def test_what_is_wrong_is_told(libraries: list[Library], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tables = tmp_path / "tables"
    with pytest.raises(OutputError, match="one library twice"):
        parquet.write_index([libraries[0], libraries[0]], tables)
    with Library(tables).locked(), pytest.raises(OutputError, match="another run is writing"):
        parquet.write_index(libraries, tables)
    absent = Mock(side_effect=CasaError("pyarrow is missing"))
    monkeypatch.setattr(parquet, "require", absent)
    with pytest.raises(CasaError, match="pyarrow is missing"):
        parquet.write_index(libraries, tables)
    assert {*absent.call_args.args, *absent.call_args.kwargs.values()} == {"pyarrow", "parquet", "Parquet"}


def test_a_damaged_table_is_written_again(libraries: list[Library], tmp_path: Path) -> None:
    tables = tmp_path / "tables"
    parquet.write_index(libraries, tables)
    before = files(tables)
    for text in ("", "{}", before["index.json"].decode().replace("a/library", "c/library"), '{"columns": ["id"]}'):
        (tables / "index.json").write_text(text, encoding="utf-8")
        assert parquet.write_index(libraries, tables).kept == ()
        assert files(tables) == before
