"""A run that keeps its library on a store: the library of a run without one, whatever the store does meanwhile."""

from __future__ import annotations

import shutil
import time
from collections.abc import Generator
from pathlib import Path

import pytest

from casa_assets.errors import OutputError
from casa_assets.library import remote_folder
from casa_assets.library.entry_files import CERTIFICATE, REFUSAL
from casa_assets.library.library import Library
from casa_assets.library.remote_folder import WriterLock
from casa_assets.runs.outcome import Event
from casa_assets.runs.remote import UNFINISHED, StoredRun, books_at, manifest_name
from tests.support.library.faulty_stores import FaultyStore, Killed
from tests.support.library.libraries import BOXES
from tests.support.library.sharded_inputs import public_differences
from tests.unit.runs.remote.test_push_and_pull import broken_entries, files_of, public, remote_on


@pytest.fixture(autouse=True)
def _impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remote_folder, "FIRST_PAUSE_S", 0.001)


def ingested(made: Path, library: Path) -> Generator[Event, None, None]:
    """What `ingest` does where all its work was done before: publishes the entries that are missing, then the books.

    Args:
        made: library that a run has made.
    """
    place = Library(library)
    with place.locked():
        place.sweep()
        folders = [path.parent for name in (CERTIFICATE, REFUSAL) for path in sorted(made.glob(f"*/*/{name}"))]
        for folder in folders:
            target = library / folder.parent.name / folder.name
            is_new = not target.exists()
            if is_new:
                place.publish(shutil.copytree(folder, place.stage(folder.name), dirs_exist_ok=True), target)
            yield Event("accepted" if is_new else "kept", len(folders), folder.name, folder=target)
        for name, book in books_at(made).items():
            shutil.copy(book, library / name)


def run(made: Path, library: Path, store: FaultyStore) -> list[Event]:
    """As `ingest --store` does; what holds the store is tried elsewhere."""
    remote = remote_on(store)
    stored = StoredRun(Library(library), remote, WriterLock(remote))
    list(stored.fetch())
    events = list(stored.sending(ingested(made, library)))
    list(stored.finish())
    return events


def test_a_run_begins_with_what_the_store_has(boxes: Path, tmp_path: Path) -> None:
    store, made = FaultyStore(), boxes / "library"
    assert {event.kind for event in run(made, tmp_path / "one", store)} == {"accepted"}
    assert public(store) == files_of(Library(made))
    assert UNFINISHED not in store.content
    assert {event.kind for event in run(made, tmp_path / "two", store)} == {"kept"}
    assert public_differences(tmp_path / "two", made) == []


def test_what_a_run_removes_is_removed_from_the_store(boxes: Path, tmp_path: Path) -> None:
    store, library = FaultyStore(), Library(tmp_path / "one")
    run(boxes / "library", library.root, store)
    remote = remote_on(store)
    stored = StoredRun(library, remote, WriterLock(remote))
    list(stored.fetch())
    library.forget(next(library.accepted()))
    library.forget(next(library.refused()))
    list(stored.finish())
    assert public(store) == files_of(library)
    assert len(list(library.accepted())) == len(BOXES) - 1


def test_entries_are_sent_while_the_run_goes_on(boxes: Path, tmp_path: Path) -> None:
    store = FaultyStore()
    remote = remote_on(store)
    stored = StoredRun(Library(tmp_path / "one"), remote, WriterLock(remote))
    list(stored.fetch())
    for number, event in enumerate(stored.sending(ingested(boxes / "library", tmp_path / "one"))):
        assert event.folder is not None
        manifest = f"{event.folder.parent.name}/{event.folder.name}/{manifest_name(f'{event.folder.parent.name}/x')}"
        give_up = time.monotonic() + 30
        while manifest not in store.content and time.monotonic() < give_up:
            time.sleep(0.005)
        assert broken_entries(public(store)) == []
        assert len([path for path in store.content if path.endswith((CERTIFICATE, REFUSAL))]) == number + 1
    assert UNFINISHED in store.content


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_run_that_is_killed_at_any_request_is_finished_by_the_next(boxes: Path, tmp_path: Path) -> None:
    number = 0
    while True:
        store, library = FaultyStore(), tmp_path / str(number)
        store.killed_after = number
        try:
            run(boxes / "library", library, store)
            break
        except Killed:
            pass
        store.revive()
        assert broken_entries(public(store)) == [], number
        run(boxes / "library", library, store)
        assert public_differences(library, boxes / "library") == [], number
        assert public(store) == files_of(Library(boxes / "library")), number
        number += 5
    assert number >= 30


def test_a_store_that_is_away_delays_what_is_sent_and_not_the_run(boxes: Path, tmp_path: Path) -> None:
    store = FaultyStore()
    remote = remote_on(store, 0.05)
    stored = StoredRun(Library(tmp_path / "one"), remote, WriterLock(remote))
    list(stored.fetch())
    for _ in stored.sending(ingested(boxes / "library", tmp_path / "one")):
        store.fails = lambda _name, _number: True
    with pytest.raises(OutputError, match="does not answer"):
        list(stored.finish())
    assert public_differences(tmp_path / "one", boxes / "library") == []
    store.revive()
    run(boxes / "library", tmp_path / "one", store)
    assert public(store) == files_of(Library(boxes / "library"))
