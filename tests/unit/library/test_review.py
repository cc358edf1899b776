"""The list of doubtful guesses: what comes onto it, what a person's word does, and words that mean nothing."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from casa_assets.errors import OutputError
from casa_assets.ingest.run.run import Options, ingest
from casa_assets.library.entry import Entry, entries
from casa_assets.library.library import Library
from casa_assets.library.review import NAME, read_overrides, write
from casa_assets.model.source import UpAxis, UserOverride
from casa_assets.runs.outcome import Event
from tests.support.library.libraries import BOXES, box_obj, write_files

pytestmark = pytest.mark.content("code", "library", keep=0)


def run(folder: Path) -> list[Event]:
    return list(ingest([folder / "in"], Options(folder / "library")))


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "library" / NAME).open(encoding="utf-8", newline="") as handle:
        return list(csv.DictReader(handle))


def say(folder: Path, **words: str) -> None:
    """Fill in the first row as a person would."""
    lines = rows(folder)
    lines[0].update({f"set_{name}": value for name, value in words.items()})
    with (folder / "library" / NAME).open("w", encoding="utf-8", newline="") as handle:
        writer = csv.DictWriter(handle, list(lines[0]))
        writer.writeheader()
        writer.writerows(lines)


def only(folder: Path) -> Entry:
    (entry,) = entries(Library(folder / "library"))
    return entry


@pytest.fixture(scope="module")
def unknown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with `in`, a box of which nobody says what it is, and `library`, made of it."""
    folder = tmp_path_factory.mktemp("unknown")
    write_files(folder / "in", {"qwxz.obj": box_obj(BOXES["milk_carton"])})
    assert [e.kind for e in run(folder)] == ["review"]
    return folder


def test_what_nobody_names_is_on_the_list_with_its_reasons(unknown: Path) -> None:
    (row,) = rows(unknown)
    assert row["category"] == "object"
    assert {"category", "mass"} <= set(row["look_at"].split())
    assert float(row["size_m"]) == pytest.approx(max(only(unknown).summary.extents), rel=1e-3)  # type: ignore[union-attr]
    assert {w.pointer for w in only(unknown).warnings if w.code == "REV001"} == set(row["look_at"].split())
    assert read_overrides(Library(unknown / "library")) == {}


def test_a_persons_word_is_obeyed_kept_and_not_asked_for_again(unknown: Path) -> None:
    say(unknown, category="milk", size_m="0.25", mass_kg="1,05", up="z", turn_deg="90")
    assert [e.kind for e in run(unknown)] == ["accepted"]
    entry = only(unknown)
    assert entry.category == "milk"
    assert entry.summary is not None
    assert max(entry.summary.extents) == pytest.approx(0.25)
    assert entry.summary.mass == pytest.approx(1.05)
    confidence = {g.subject: g.confidence for g in entry.guesses}
    assert [confidence[s] for s in ("category", "up_axis", "scale", "mass", "front")] == [1.0] * 5
    (row,) = rows(unknown)
    assert row["set_category"] == "milk"
    assert row["look_at"] == ""
    assert [e.kind for e in run(unknown)] == ["kept"]
    say(unknown, mass_kg="0.9")
    assert [e.kind for e in run(unknown)] == ["accepted"]
    assert only(unknown).summary.mass == pytest.approx(0.9)  # type: ignore[union-attr]


def test_a_list_without_rows_is_taken_away(tmp_path: Path) -> None:
    library = Library(tmp_path)
    library.staging.mkdir(parents=True)
    (tmp_path / NAME).write_text("sha256,set_up\nabc,\n", encoding="utf-8")
    assert write(library, entries(library)) == 0
    assert not (tmp_path / NAME).exists()
    # A ruling on what is not there any more is kept.
    (tmp_path / NAME).write_text("sha256,set_up\nabc,minus_y\n", encoding="utf-8")
    assert write(library, entries(library)) == 1
    assert read_overrides(library) == {"abc": UserOverride(up=UpAxis.MINUS_Y)}


def test_a_word_that_means_nothing_is_said_with_its_row(subtests: pytest.Subtests, tmp_path: Path) -> None:
    for text, place in [
        ("sha256,set_category\nabc,no_such_thing\n", "row 2"),
        ("sha256,set_size_m\nabc,long\n", "row 2"),
        ("sha256,set_size_m\nabc,-1\n", "row 2"),
        ("sha256,set_up\nabc,north\n", "row 2"),
        ("sha256,set_mass_kg\nabc,nan\n", "row 2"),
        ("input,set_up\na.obj,y\n", "sha256"),
        ("sha256,set_up\n,y\n", "sha256"),
    ]:
        with subtests.test(text=text):
            (tmp_path / NAME).write_text(text, encoding="utf-8")
            with pytest.raises(OutputError, match=place):
                read_overrides(Library(tmp_path))
