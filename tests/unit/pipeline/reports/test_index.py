"""The index holds every entry, and can be had as Parquet."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pyarrow.parquet
import pytest

from casa_assets.errors import OutputError
from casa_assets.model.ingest.source import Source, SourceKind
from casa_assets.pipeline.library.identity import Producer
from casa_assets.pipeline.library.library import Library, Refusal, write_refusal
from casa_assets.pipeline.tables import index
from casa_assets.pipeline.tables.row import COLUMNS


@pytest.fixture
def library(tmp_path: Path) -> Library:
    made = Library(tmp_path / "library")
    with made.locked():
        for name in ("b_0123456789", "a_0123456789"):
            source = Source(kind=SourceKind.FOLDER, path=f"{name}.glb", title="a 'quoted' title")
            staged = made.stage(name)
            record = Refusal(
                id=name,
                code="SRC001",
                message="no",
                category="mug",
                producer=Producer.INGEST,
                cache_key="r",
                sha256="0" * 64,
                source=source,
            )
            write_refusal(staged, record)
            made.publish(staged, made.refusal_folder(name))
    return made


def test_rows(library: Library) -> None:
    assert index.rebuild(library) == 2
    base = sqlite3.connect(library.root / index.NAME)
    rows = base.execute("SELECT id, status, code, mass_kg, title FROM entries").fetchall()
    base.close()
    same = ("rejected", "SRC001", None, "a 'quoted' title")
    assert rows == [("a_0123456789", *same), ("b_0123456789", *same)]


def test_rebuilt_it_is_the_same(library: Library) -> None:
    index.rebuild(library)
    path = library.root / index.NAME
    first = path.read_bytes()
    path.unlink()
    index.rebuild(library)
    assert path.read_bytes() == first
    assert [p.name for p in library.root.iterdir() if p.name.startswith("index")] == ["index.sqlite"]


def test_two_entries_of_one_name_are_an_error_that_names_them(library: Library) -> None:
    (library.root / "rejected" / "a_0123456789").rename(library.root / "rejected" / "c_0123456789")
    path = library.root / "rejected" / "c_0123456789" / "reject.json"
    path.write_text(path.read_text(encoding="utf-8").replace("a_0123456789", "b_0123456789"), encoding="utf-8")
    with pytest.raises(OutputError, match="b_0123456789"):
        index.rebuild(library)


def test_parquet(library: Library, tmp_path: Path) -> None:
    target = tmp_path / "new" / "rows.parquet"
    assert index.export_parquet(library, target) == 2
    table = pyarrow.parquet.read_table(target)
    assert table.column("id").to_pylist() == ["a_0123456789", "b_0123456789"]
    types = {field.name: str(field.type) for field in table.schema}
    assert list(types) == [*COLUMNS, "library"]
    assert (types["mass_kg"], types["faces"], types["message"]) == ("double", "int64", "string")


def test_parquet_that_cannot_be_written(library: Library, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be written"):
        index.export_parquet(library, tmp_path / "file" / "rows.parquet")
