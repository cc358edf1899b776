"""Rows of entries and their tables in Parquet parts: the same answers, the same bytes, kept where nothing changed."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pyarrow.parquet
import pytest

from benchmarks.books import synthetic_entries
from casa_assets.errors import CasaError, OutputError
from casa_assets.pipeline.dedup.search import rows_of, search_rows
from casa_assets.pipeline.library.library import Library
from casa_assets.pipeline.reports.entry import Entry
from casa_assets.pipeline.tables import parquet
from casa_assets.pipeline.tables.conditions import BadCondition, Condition, meets, parse, with_default
from casa_assets.pipeline.tables.row import COLUMNS, TableRow, row_of
from tests.assets import ball, rigid_mug
from tests.built_libraries import keep

pytestmark = pytest.mark.content("code", "pipeline.tables", keep=0)

COUNT = 3_000
CONDITIONS = [
    ["category=mug"],
    ["category=mug,bowl", "verdict=accepted"],
    ["category!=mug", "faces<500"],
    ["reason=FLT005"],
    ["reason=GEO004"],
    ["reason!=RUN007", "verdict=rejected"],
    ["size<=0.1", "size>0.05"],
    ["mass>=2.5", "source=folder"],
    ["colliders=7"],
    ["decide=scale,mass"],
    ["licence=CC-BY-4.0", "split=test", "warnings>1"],
]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A table of a library; only to read."""
    folder = tmp_path_factory.mktemp("tables")
    library = Library(folder / "library")
    library.private.mkdir(parents=True)
    parquet.write_index([library], folder / "tables", entries_of=lambda _: synthetic_entries(COUNT))
    return folder


def of_parts(made: Path, conditions: Sequence[Condition] = ()) -> list[TableRow]:
    tables = made / "tables"
    return [row for row in parquet.read_rows(tables, parquet.read_index(tables)) if meets(row, conditions)]


def of_entries(conditions: Sequence[Condition] = ()) -> list[TableRow]:
    rows = map(row_of, synthetic_entries(COUNT))
    return [row for row in rows if meets(row, conditions)]


def expected(texts: Sequence[str]) -> set[str]:
    """Ids of the entries that meet conditions, told by Python alone."""
    tests: dict[str, Callable[[Entry], bool]] = {
        "category=mug": lambda e: e.category == "mug",
        "category=mug,bowl": lambda e: e.category in ("mug", "bowl"),
        "verdict=accepted": lambda e: e.decision.value == "accepted",
        "category!=mug": lambda e: e.category != "mug",
        "faces<500": lambda e: e.summary is not None and e.summary.faces < 500,
        "reason=FLT005": lambda e: "FLT005" in (e.code, *e.advice),
        "reason=GEO004": lambda e: "GEO004" in e.advice,
        "reason!=RUN007": lambda e: e.code != "RUN007",
        "verdict=rejected": lambda e: not e.accepted,
        "size<=0.1": lambda e: e.summary is not None and max(e.summary.extents) <= 0.1,
        "size>0.05": lambda e: e.summary is not None and max(e.summary.extents) > 0.05,
        "mass>=2.5": lambda e: e.summary is not None and e.summary.mass >= 2.5,
        "source=folder": lambda e: e.source == "folder",
        "colliders=7": lambda e: e.summary is not None and e.summary.colliders == 7,
        "decide=scale,mass": lambda e: bool({"scale", "mass"} & set(e.to_decide)),
        "licence=CC-BY-4.0": lambda e: e.licence == "CC-BY-4.0",
        "split=test": lambda e: e.split == "test",
        "warnings>1": lambda e: len(e.warnings) > 1,
    }
    every = any(text.startswith(("verdict", "reason", "id")) for text in texts)
    entries = (e for e in synthetic_entries(COUNT) if e.accepted or every)
    return {e.id for e in entries if all(tests[text](e) for text in texts)}


def test_conditions_find_what_fits(subtests: pytest.Subtests, made: Path) -> None:
    for texts in CONDITIONS:
        with subtests.test(texts=texts):
            conditions = with_default([parse(text) for text in texts])
            rows = of_entries(conditions)
            assert {row.id for row in rows} == expected(texts)
            assert rows, "a condition that nothing meets tells nothing"
            assert sorted((row.id, row.message, row.summary) for row in of_parts(made, conditions)) == sorted(
                (row.id, row.message, row.summary) for row in rows
            )


def test_a_row_says_what_its_entry_says(made: Path) -> None:
    rows = {row.id: row for row in of_parts(made)}
    assert len(rows) == COUNT
    for entry in synthetic_entries(COUNT):
        row = rows[entry.id]
        for name in (
            "category",
            "path",
            "code",
            "decision",
            "accepted",
            "advice",
            "to_decide",
            "warning_count",
            "colors",
        ):
            assert getattr(row, name) == getattr(entry, name), name
        assert (row.checks.applying, row.checks.passed) == (entry.checks.applying, entry.checks.passed)
        if entry.summary is None:
            assert row.summary is None
        else:
            assert row.summary is not None
            assert (row.summary.extents, row.summary.mass) == (entry.summary.extents, entry.summary.mass)


def test_words_find_the_same_in_both(subtests: pytest.Subtests, made: Path) -> None:
    for words in ["", "red mugs", "fruit", "antique"]:
        with subtests.test(words=words):
            conditions = with_default([parse("mass>0.01")])
            found = [search_rows(rows, made, words, 7) for rows in (of_entries(conditions), of_parts(made, conditions))]
            told = [[(hit.id, hit.score, hit.reason) for hit in one.hits] for one in found]
            assert told[0] == told[1]
            assert len(told[0]) == 7
            assert found[0].count == found[1].count > 7
            if not words:
                assert told[0] == sorted(told[0])


def test_what_is_no_condition_is_told(subtests: pytest.Subtests) -> None:
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
            parse(text)


def test_hostile_values_are_only_compared(made: Path) -> None:
    for text in ("category=x' OR '1'='1", 'author="; DROP TABLE entries', "id=%"):
        conditions = [parse(text)]
        assert of_entries(conditions) == of_parts(made, conditions) == []
    assert len(of_entries()) == COUNT


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


class TestParts:
    """Two libraries of real folders."""

    @pytest.fixture
    def libraries(self, tmp_path: Path) -> list[Library]:
        return [
            Library(keep(tmp_path / name / "library", [asset])) for name, asset in (("a", rigid_mug()), ("b", ball()))
        ]

    def test_same_entries_same_bytes(self, libraries: list[Library], tmp_path: Path) -> None:
        parquet.write_index(libraries, tmp_path / "tables")
        first = files(tmp_path / "tables")
        assert len(first) == 3
        schema = pyarrow.parquet.read_schema(next((tmp_path / "tables").glob("*.parquet")))
        types = {field.name: str(field.type) for field in schema}
        assert list(types) == [*COLUMNS, "library"]
        assert (types["mass_kg"], types["faces"], types["message"]) == ("double", "int64", "string")
        parquet.write_index(libraries[::-1], tmp_path / "tables", force=True)
        assert files(tmp_path / "tables") == first
        rows = of_parts(tmp_path)
        assert {(row.id, row.library) for row in rows} == {
            (rigid_mug().id, "../a/library"),
            (ball().id, "../b/library"),
        }

    def test_what_did_not_change_is_kept(self, libraries: list[Library], tmp_path: Path) -> None:
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
        assert Counter(row.library for row in of_parts(tmp_path)) == {"../a/library": 1, "../b/library": 2}
        assert len(list(tables.glob("*.parquet"))) == 2, "the part of before has gone"
        next(tables.glob("*.parquet")).unlink()
        parquet.write_index(libraries, tables)
        assert len(of_parts(tmp_path)) == 3, "a part that is missing is written again"

    def test_a_library_that_is_not_named_goes(self, libraries: list[Library], tmp_path: Path) -> None:
        parquet.write_index(libraries, tmp_path / "tables")
        (tmp_path / "tables" / "mine.parquet").write_bytes(b"of somebody else")
        parquet.write_index(libraries[:1], tmp_path / "tables")
        assert [row.id for row in of_parts(tmp_path)] == [rigid_mug().id]
        assert sorted(path.suffix for path in (tmp_path / "tables").iterdir()) == ["", ".json", ".parquet", ".parquet"]

    def test_killed_before_the_end_it_is_what_it_was(
        self, libraries: list[Library], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        class Killed(BaseException):
            """As if the process had ended."""

        def killed(*_: object) -> None:
            raise Killed

        parquet.write_index(libraries[:1], tmp_path / "tables")
        with monkeypatch.context() as patch:
            patch.setattr(parquet, "_publish", killed)
            with pytest.raises(Killed):
                parquet.write_index(libraries, tmp_path / "tables")
        assert [row.id for row in of_parts(tmp_path)] == [rigid_mug().id]
        parquet.write_index(libraries, tmp_path / "tables")
        assert len(of_parts(tmp_path)) == 2

    def test_large_parts_are_divided_and_sorted(
        self, libraries: list[Library], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(parquet, "PART_ROWS", 1_000)
        monkeypatch.setattr(parquet, "GROUP_ROWS", 200)
        tables = tmp_path / "tables"
        written = parquet.write_index(libraries[:1], tables, entries_of=lambda _: synthetic_entries(2_500))
        (one,) = written.index.libraries
        assert [part.rows for part in one.parts] == [1_000, 1_000, 500]
        file = pyarrow.parquet.ParquetFile(tables / one.parts[0].name)
        assert file.metadata.num_row_groups == 5
        keys = [(row.category, row.id) for row in parquet.read_sorted(tables, written.index)]
        assert keys == sorted(keys)
        assert len(keys) == 2_500

    def test_a_table_of_nothing(self, tmp_path: Path) -> None:
        library = Library(tmp_path / "library")
        library.private.mkdir(parents=True)
        assert parquet.write_index([library], tmp_path / "tables").index.rows == 0
        assert (
            of_parts(tmp_path)
            == list(parquet.read_sorted(tmp_path / "tables", parquet.read_index(tmp_path / "tables")))
            == []
        )

    def test_what_is_wrong_is_told(self, libraries: list[Library], tmp_path: Path) -> None:
        tables = tmp_path / "tables"
        with pytest.raises(OutputError, match=r"no index\.json; give the folder that `casa-assets library index`"):
            parquet.read_index(tmp_path)
        with pytest.raises(OutputError, match="one library twice"):
            parquet.write_index([libraries[0], libraries[0]], tables)
        with Library(tables).locked(), pytest.raises(OutputError, match="another run is writing"):
            parquet.write_index(libraries, tables)
        parquet.write_index(libraries, tables)
        told = json.loads((tables / "index.json").read_text(encoding="utf-8"))
        name = told["libraries"][0]["parts"][0]["name"]
        (tables / name).write_bytes(b"PAR1 and no more")
        with pytest.raises(OutputError, match="write the table again"):
            of_parts(tmp_path)
        told["libraries"][0]["parts"][0]["name"] = "../a/library/mug"
        (tables / "index.json").write_text(json.dumps(told), encoding="utf-8")
        with pytest.raises(OutputError, match="leaves the folder"):
            parquet.read_index(tables)
        (tables / "index.json").write_text(json.dumps({**told, "columns": ["id"]}), encoding="utf-8")
        with pytest.raises(OutputError, match="was written by another version"):
            parquet.read_index(tables)
        (tables / "index.json").write_text("{}", encoding="utf-8")
        with pytest.raises(OutputError, match="is damaged at columns"):
            parquet.read_index(tables)

    def test_without_pyarrow_the_extra_is_named(
        self, libraries: list[Library], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def absent(module: str, extra: str, purpose: str) -> None:
            raise CasaError(f"{purpose} needs {module}: {extra}")

        monkeypatch.setattr(parquet, "require", absent)
        with pytest.raises(CasaError, match="Parquet needs pyarrow: parquet"):
            parquet.write_index(libraries, tmp_path / "tables")


def test_rows_are_those_that_the_library_has_now(tmp_path: Path) -> None:
    library = Library(keep(tmp_path / "library", [rigid_mug()]))
    assert [row.id for row in rows_of(library)] == [rigid_mug().id]
    keep(library.root, [ball()])
    assert {row.id for row in rows_of(library)} == {rigid_mug().id, ball().id}
    assert [row.id for row in rows_of(library, [parse("category=mug")])] == [rigid_mug().id]
