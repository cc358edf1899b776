"""The books of a library open the certificates of what is new, and say what they would say of all of them."""

from __future__ import annotations

import os
import shutil
import sqlite3
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest

from casa_assets.cache.store import Store
from casa_assets.errors import OutputError
from casa_assets.library import entry_files, pairs
from casa_assets.library.entry import entries
from casa_assets.library.entry_files import CERTIFICATE, _json
from casa_assets.library.entry_table import NAME, EntryTable
from casa_assets.library.library import Library
from casa_assets.library.library_report import write_reports
from casa_assets.library.pairs import MAX_DESCRIPTOR_DISTANCE, ShapeIndex, nearby_pairs, read_rows
from casa_assets.mesh.registration import descriptor_distance
from casa_assets.model.asset.asset import Asset, ShapeDescriptor
from casa_assets.model.issue import CheckResult, Status, tally
from tests.support.library.built_libraries import keep, similar_pairs
from tests.support.library.libraries import edited
from tests.unit.library.test_alike import COPY, FIRST, LARGE, OTHER

pytestmark = pytest.mark.content("code", "library", keep=0)


@pytest.fixture
def library(tmp_path: Path) -> Library:
    return Library(keep(tmp_path / "library", [FIRST, OTHER, LARGE]))


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the entries whose files were opened, one for each time."""
    names: list[str] = []
    read: Callable[[Path], dict[str, object]] = _json

    def counted(path: Path) -> dict[str, object]:
        names.append(path.parent.name)
        return read(path)

    monkeypatch.setattr(entry_files, "_json", counted)
    return names


def test_only_what_is_new_is_opened(library: Library, opened: list[str]) -> None:
    write_reports(library)
    assert {FIRST.id, OTHER.id, LARGE.id} <= set(opened)
    opened.clear()
    write_reports(library)
    assert opened == []
    keep(library.root, [COPY])
    opened.clear()
    write_reports(library)
    certificates = [name for name in opened if name != COPY.id]
    # The new one is laid over those of near form, whose surfaces are read for that; nothing else is.
    assert len(certificates) <= 3
    opened.clear()
    write_reports(library)
    assert opened == []


def test_the_books_are_those_of_a_library_made_at_once(library: Library, tmp_path: Path) -> None:
    write_reports(library)
    keep(library.root, [COPY])
    shutil.rmtree(library.folder("mug", OTHER.id))
    write_reports(library)
    at_once = Library(keep(tmp_path / "at_once", [FIRST, LARGE, COPY]))
    write_reports(at_once)
    for name in ("library.json", "ATTRIBUTION.md"):
        assert (library.root / name).read_bytes() == (at_once.root / name).read_bytes(), name


def test_the_table_says_what_the_certificates_say(library: Library, tmp_path: Path) -> None:
    keep(library.root, [COPY])
    for _ in range(2):
        table = EntryTable(library)
        assert list(table.rows) == list(read_rows(library))
        assert [(e.id, e.checks, e.guesses) for e in table.entries] == [
            (e.id, tally(e.results), e.guesses) for e in entries(library)
        ]
        assert table.alike(Store(library.cache)) == list(
            similar_pairs(list(read_rows(library)), Store(tmp_path / "other"))
        )


@pytest.mark.parametrize("out_of_numbers", [(FIRST, COPY), (FIRST, LARGE, OTHER), (FIRST, LARGE, OTHER, COPY)])
@pytest.mark.parametrize("in_steps", [False, True])
def test_two_out_of_numbers_are_no_pair(
    library: Library, tmp_path: Path, out_of_numbers: tuple[Asset, ...], in_steps: bool
) -> None:
    if in_steps:
        say_producer(library, [asset for asset in out_of_numbers if asset is not COPY])
        EntryTable(library).alike(Store(library.cache))
    keep(library.root, [COPY])
    say_producer(library, out_of_numbers)
    every = list(similar_pairs(list(read_rows(library)), Store(tmp_path / "other")))
    wanted = [pair for pair in every if not {pair.one, pair.other} <= {asset.id for asset in out_of_numbers}]
    assert len(wanted) < len(every)
    assert EntryTable(library).alike(Store(library.cache)) == wanted


def say_producer(library: Library, assets: Iterable[Asset]) -> None:
    for asset in assets:
        with edited(library.folder("mug", asset.id) / CERTIFICATE) as data:
            data["certificate"]["producer"] = "family"


def test_results_of_checks_are_kept(library: Library, opened: list[str]) -> None:
    measured = CheckResult(code="AST001", status=Status.PASSED, number=0.1, limit=1.0, unit="m")
    absent = CheckResult(code="KIN001", status=Status.NOT_APPLICABLE, reason="it has no joint")
    with edited(library.folder("mug", FIRST.id) / CERTIFICATE) as data:
        data["certificate"]["report"]["results"] = [one.model_dump(mode="json") for one in (measured, absent)]
    EntryTable(library)
    opened.clear()
    table = EntryTable(library)
    kept = list(table.with_results(table.entries))
    assert opened == []
    assert kept == list(entries(library))
    assert (measured, absent) in [entry.results for entry in kept]


def test_what_was_written_anew_is_read_anew(library: Library) -> None:
    EntryTable(library)
    path = library.folder("mug", FIRST.id) / CERTIFICATE
    stamp = path.stat()
    with edited(path) as data:
        data["asset"]["provenance"]["title"] = "Another"
    os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    assert {e.id: e.title for e in EntryTable(library).entries}[FIRST.id] == "Another"


def test_a_damaged_entry_is_told_or_left_out(library: Library) -> None:
    (library.folder("mug", FIRST.id) / CERTIFICATE).write_text("{", encoding="utf-8")
    with pytest.raises(OutputError, match=FIRST.id):
        EntryTable(library)
    assert FIRST.id not in {row.id for row in EntryTable(library, skip_damaged=True).rows}


@pytest.mark.parametrize("damage", [b"", b"no table", None])
def test_a_table_that_is_none_is_made_anew(library: Library, damage: bytes | None) -> None:
    before = EntryTable(library)
    path = library.cache / NAME
    if damage is None:
        with sqlite3.connect(path) as base:
            base.execute("UPDATE entries SET entry = 'x'")
    else:
        path.write_bytes(damage)
    assert EntryTable(library).entries == before.entries
    assert EntryTable(library).rows == before.rows


@pytest.mark.parametrize("outside", [7, 1000], ids=["most in a tree", "none in a tree"])
def test_near_forms_of_an_index_are_those_by_pairs(outside: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pairs, "MOST_OUTSIDE", outside)
    rng = np.random.default_rng(5)
    base = rng.uniform(0.2, 2.0, (40, 51))
    rows = np.concatenate([base, base + rng.normal(0.0, 0.02, base.shape)]).round(4).tolist()
    names = ("pair_distances", "center_distances", "axis_spread")
    parts = [dict(zip(names, (tuple(r[:32]), tuple(r[32:48]), tuple(r[48:])), strict=True)) for r in rows]
    forms = [ShapeDescriptor(radius=0.1, **part) for part in parts]
    table = ShapeIndex()
    for number, one in enumerate(forms):
        table.add(one)
        assert number in table.near(one)
    slow = [
        [j for j, other in enumerate(forms) if descriptor_distance(one, other) <= MAX_DESCRIPTOR_DISTANCE]
        for one in forms
    ]
    assert [table.near(one) for one in forms] == slow
    assert [(i, j) for i, row in enumerate(slow) for j in row if i < j] == nearby_pairs(forms)
    assert any(len(row) > 1 for row in slow)
