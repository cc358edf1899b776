"""A library is the same on a store and back, also that of a run, whatever fails; readers find whole entries alone."""

from __future__ import annotations

import hashlib
import itertools
import json
import shutil
import time
from collections.abc import Generator
from pathlib import Path

import pytest

from casa_assets.errors import OutputError
from casa_assets.library import remote_folder, review
from casa_assets.library.entry_files import CERTIFICATE, REFUSAL
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library
from casa_assets.library.remote_folder import WriterLock
from casa_assets.runs.outcome import Event
from casa_assets.runs.remote import (
    UNFINISHED,
    Change,
    Extra,
    RemoteLibrary,
    StoredRun,
    books_at,
    manifest_name,
    pull,
    push,
)
from tests.support.library.faulty_stores import ROOT, FaultyStore, Killed
from tests.support.library.libraries import BOXES, edited, entries_of
from tests.support.library.sharded_inputs import public_differences

URL = "memory://someone:secret@library"


@pytest.fixture(autouse=True)
def _impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remote_folder, "FIRST_PAUSE_S", 0.001)


@pytest.fixture
def library(boxes: Path, tmp_path: Path) -> Library:
    """A library of a few entries that may be changed."""
    shutil.copytree(boxes / "library", tmp_path / "library", ignore=shutil.ignore_patterns(".casa"))
    made = Library(tmp_path / "library")
    with made.locked():
        return made


def remote_on(store: FaultyStore, patience_s: float = 5.0) -> RemoteLibrary:
    return RemoteLibrary(store, ROOT, URL, patience_s)


def pushed(library: Library, store: FaultyStore, extra: Extra = Extra.REFUSE, patience_s: float = 5.0) -> list[Change]:
    """Push; what holds the store is tried elsewhere."""
    remote = remote_on(store, patience_s)
    with library.locked():
        return list(push(library, remote, WriterLock(remote), extra))


def pulled(store: FaultyStore, library: Library, extra: Extra = Extra.REFUSE, is_partial: bool = False) -> list[Change]:
    with library.locked():
        return list(pull(remote_on(store), library, extra, is_partial))


def kinds(changes: list[Change]) -> set[str]:
    return {change.kind for change in changes}


def public(store: FaultyStore) -> dict[str, bytes]:
    return {path: data for path, data in store.content.items() if not path.startswith(".casa/")}


def files_of(library: Library) -> dict[str, bytes]:
    files = (path for path in library.root.rglob("*") if path.is_file())
    return {
        name: path.read_bytes()
        for path in sorted(files)
        if not (name := path.relative_to(library.root).as_posix()).startswith(".casa/")
    }


def broken_entries(content: dict[str, bytes]) -> list[str]:
    """Entries with a manifest that lack a file, or have another one than it names."""
    found = []
    for path, data in content.items():
        if path.endswith("/asset.json"):
            folder = path.removesuffix("/asset.json")
            try:
                files = json.loads(data)["certificate"]["files"]
            except ValueError:  # cut off, which every reader notices
                continue
            digests = {name: hashlib.sha256(content.get(f"{folder}/{name}", b"?")).hexdigest() for name in files}
            found += [folder] if digests != files else []
    return found


def change_entry(library: Library) -> Path:
    """Another version of the first accepted asset: a model with one more line, and one more file."""
    folder = next(library.accepted())
    text = (folder / "model.xml").read_text(encoding="utf-8") + "<!-- another version -->\n"
    (folder / "model.xml").write_text(text, encoding="utf-8")
    (folder / "notes.txt").write_text("new", encoding="utf-8")
    with edited(folder / "asset.json") as data:
        data["certificate"]["files"]["model.xml"] = hashlib.sha256(text.encode()).hexdigest()
        data["certificate"]["files"]["notes.txt"] = hashlib.sha256(b"new").hexdigest()
    return folder


def remove_last(library: Library) -> Path:
    folder = list(library.accepted())[-1]
    library.forget(folder)
    return folder


def test_a_library_goes_there_and_back_and_nothing_is_sent_twice(library: Library, tmp_path: Path) -> None:
    store = FaultyStore()
    assert kinds(pushed(library, store)) == {"copied"}
    assert public(store) == files_of(library)
    assert UNFINISHED not in store.content
    other = Library(tmp_path / "other")
    assert kinds(pulled(store, other)) == {"copied"}
    assert public_differences(other.root, library.root) == []
    assert len(entries_of(other.root)) == len(entries_of(library.root)) > 4
    store.changes.clear()
    assert kinds(pushed(library, store)) == {"kept"}
    assert {path for _, path in store.changes} == {UNFINISHED}
    assert kinds(pulled(store, other)) == {"kept"}


def test_a_store_on_a_disk_is_a_library(library: Library, tmp_path: Path) -> None:
    for _ in range(2):
        remote = RemoteLibrary.open(f"file://{tmp_path}/shared/store")
        with library.locked():
            list(push(library, remote, WriterLock(remote), Extra.REMOVE))
        assert public_differences(tmp_path / "shared" / "store", library.root) == []
        change_entry(library)
        remove_last(library)
    assert list((tmp_path / "shared").rglob("*.part")) == []


def test_an_entry_whose_files_changed_and_kept_their_sizes_is_sent(library: Library) -> None:
    store, folder = FaultyStore(), next(library.accepted())
    pushed(library, store)
    old = (folder / "model.xml").read_bytes()
    new = old[:-1] + b" "
    (folder / "model.xml").write_bytes(new)
    before, after = (hashlib.sha256(data).hexdigest() for data in (old, new))
    manifest = (folder / CERTIFICATE).read_text(encoding="utf-8")
    (folder / CERTIFICATE).write_text(manifest.replace(before, after), encoding="utf-8")
    assert [change.kind for change in pushed(library, store)].count("copied") == 1
    assert public(store) == files_of(library)


def test_a_push_that_is_killed_at_any_request_is_finished_by_the_next(library: Library) -> None:
    """First of a new library, then of one entry that has changed, and one that is gone."""
    requests, before = 0, dict[str, bytes]()
    for _ in range(2):
        for number in itertools.count():
            store = FaultyStore()
            for path, data in before.items():
                store.pipe_file(f"{ROOT}/{path}", data)
            store.killed_after = number
            try:
                pushed(library, store, Extra.REMOVE)
                break
            except Killed:
                pass
            store.revive()
            assert broken_entries(public(store)) == [], number
            pushed(library, store, Extra.REMOVE)
            assert public(store) == files_of(library), number
        assert public(store) == files_of(library)
        requests, before = requests + number, files_of(library)
        change_entry(library)
        remove_last(library)
    assert requests > 40


def test_errors_are_repeated_and_writes_compared(library: Library, tmp_path: Path) -> None:
    store = FaultyStore()
    store.fails = lambda _name, number: number % 3 == 0
    store.cuts = lambda _path, number: number % 7 == 0
    pushed(library, store)
    other = Library(tmp_path / "other")
    pulled(store, other)
    assert public_differences(other.root, library.root) == []


def test_listings_that_lag_behind_lose_nothing(library: Library, tmp_path: Path) -> None:
    store = FaultyStore()
    for lag in (1, 7, 40):
        store.lag = lag
        pushed(library, store, Extra.REMOVE)
        assert broken_entries(public(store)) == []
        change_entry(library)
        (next(library.accepted()) / "notes.txt").unlink()  # made again by the next change
        change_entry(library)
    pushed(library, store, Extra.REMOVE)
    store.revive()
    pushed(library, store, Extra.REMOVE)
    assert public(store) == files_of(library)
    other = Library(tmp_path / "other")
    pulled(store, other)
    assert public_differences(other.root, library.root) == []


def test_a_store_that_never_answers_or_keeps_other_bytes_is_told_with_its_address(library: Library) -> None:
    store = FaultyStore()
    store.fails = lambda _name, _number: True
    with pytest.raises(OutputError, match=r"memory://library: does not answer: .*on fire; run again when it does"):
        pushed(library, store, patience_s=0.05)
    store.revive()
    store.cuts = lambda path, _number: path.endswith(".xml")
    with pytest.raises(OutputError, match=r"keeps other bytes of .*\.xml than were sent, 3 times"):
        pushed(library, store)
    assert broken_entries(public(store)) == []


def test_a_damaged_entry_is_told_and_all_others_are_copied(library: Library, tmp_path: Path) -> None:
    store = FaultyStore()
    folder = next(library.accepted())
    whole = (folder / "model.xml").read_bytes()
    (folder / "model.xml").write_bytes(b"damaged")
    with pytest.raises(OutputError, match=rf"1 of \d entries could not be copied:\n  .*{folder.name}"):
        pushed(library, store)
    assert UNFINISHED in store.content
    manifests = [path for path in public(store) if path.endswith((CERTIFICATE, REFUSAL))]
    assert len(manifests) == len(entries_of(library.root)) - 1
    (folder / "model.xml").write_bytes(whole)
    pushed(library, store)
    assert public(store) == files_of(library)

    name = f"{folder.parent.name}/{folder.name}/model.xml"
    store.pipe_file(f"{ROOT}/{name}", b"damaged")
    other = Library(tmp_path / "other")
    with pytest.raises(OutputError, match=r"model\.xml is not what the certificate says"):
        pulled(store, other)
    assert len(entries_of(other.root)) == len(entries_of(library.root)) - 1


@pytest.mark.parametrize("name", ["asset.json", "reject.json"])
def test_a_manifest_that_was_cut_off_takes_no_place(library: Library, tmp_path: Path, name: str) -> None:
    """Where a store shows what is half written: on a disk and in an object store nothing is."""
    store = FaultyStore()
    pushed(library, store)
    whole = files_of(library)
    path = next(path for path in store.content if path.endswith(name))
    store.pipe_file(f"{ROOT}/{path}", store.content[path][:200])
    assert "failed" in kinds(pulled(store, library, Extra.KEEP))
    assert files_of(library) == whole
    with pytest.raises(OutputError, match="is damaged; make or push the entry again"):
        pulled(store, Library(tmp_path / "other"))
    pushed(library, store)
    assert public(store) == whole


def test_what_the_store_alone_has_is_not_removed_unasked(library: Library) -> None:
    store = FaultyStore()
    pushed(library, store)
    gone = remove_last(library)
    with pytest.raises(
        OutputError, match=rf"memory://library: has an entry that .* lacks, such as .*{gone.name}; .*--delete"
    ):
        pushed(library, store)
    assert f"{gone.parent.name}/{gone.name}/asset.json" in store.content
    assert "removed" in kinds(pushed(library, store, Extra.REMOVE))
    assert public(store) == files_of(library)


def test_an_entry_of_another_category_takes_the_place_of_the_older(library: Library, tmp_path: Path) -> None:
    store, other = FaultyStore(), Library(tmp_path / "other")
    pushed(library, store)
    pulled(store, other)
    old = next(library.accepted())
    new = library.root / "bottle" / f"bottle_{old.name.rpartition('_')[2]}"
    new.parent.mkdir()
    old.rename(new)
    old.parent.rmdir()
    assert "removed" in kinds(pushed(library, store))
    assert public(store) == files_of(library)
    assert "removed" in kinds(pulled(store, other))
    assert public_differences(other.root, library.root) == []


def test_an_unfinished_library_is_not_pulled_unasked(library: Library, tmp_path: Path) -> None:
    store, other = FaultyStore(), Library(tmp_path / "other")
    with pytest.raises(OutputError, match="holds no library"):
        pulled(store, other)
    store.killed_after = 15
    with pytest.raises(Killed):
        pushed(library, store)
    store.revive()
    with pytest.raises(OutputError, match=r"cut off before it had ended.*--partial"):
        pulled(store, other)
    pulled(store, other, is_partial=True)
    assert 0 < len(entries_of(other.root)) < len(entries_of(library.root))
    assert (other.root / "ATTRIBUTION.md").is_file()


def test_no_decision_is_lost_unasked(library: Library, tmp_path: Path) -> None:
    store, other = FaultyStore(), Library(tmp_path / "other")
    entry, second = list(EntryTable(library, read_only=True).entries)[:2]
    pushed(library, store)
    pulled(store, other)
    with library.locked():
        review.decide(library, entry, {"mass_kg": "0.5"})
    pushed(library, store)
    with other.locked():
        review.decide(other, second, {"mass_kg": "0.7"})
    with pytest.raises(OutputError, match=r"review\.csv there has decisions that .* lacks"):
        pushed(other, store)
    pulled(store, other)
    assert len(review.read_overrides(other)) == 2
    pushed(other, store)
    with library.locked():
        review.decide(library, entry, {"mass_kg": "0.6"})
    with pytest.raises(OutputError, match=r"review\.csv decides otherwise on"):
        pulled(store, library)
    pulled(store, library, Extra.REMOVE)
    assert public_differences(other.root, library.root) == []


@pytest.mark.parametrize("name", ["../../stolen.txt", "/tmp/stolen.txt", "a\\b", "", "asset.json", "a/../b"])
def test_a_store_of_a_stranger_writes_nowhere_else(library: Library, tmp_path: Path, name: str) -> None:
    store, other = FaultyStore(), Library(tmp_path / "deep" / "other")
    pushed(library, store)
    folder = next(library.accepted())
    path = f"{ROOT}/{folder.parent.name}/{folder.name}"
    data = json.loads(store.cat_file(f"{path}/asset.json"))
    data["certificate"]["files"][name] = hashlib.sha256(b"x").hexdigest()
    store.pipe_file(f"{path}/asset.json", json.dumps(data).encode())
    if name not in ("", "asset.json"):
        store.pipe_file(f"{path}/{name}", b"x")
    store.pipe_file(f"{ROOT}/..%2f..%2fx/y", b"x")
    before = {p for p in tmp_path.rglob("*") if not p.is_relative_to(other.root)}
    with pytest.raises(OutputError, match="which is no file of the entry"):
        pulled(store, other)
    assert not (other.root / folder.parent.name / folder.name).exists()
    assert {p for p in tmp_path.rglob("*") if not p.is_relative_to(other.root)} - {other.root.parent} == before


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


def begun(library: Path, store: FaultyStore, patience_s: float = 5.0) -> StoredRun:
    """A run that has fetched what the store has; what holds the store is tried elsewhere."""
    remote = remote_on(store, patience_s)
    stored = StoredRun(Library(library), remote, WriterLock(remote))
    list(stored.fetch())
    return stored


def run(made: Path, library: Path, store: FaultyStore) -> list[Event]:
    stored = begun(library, store)
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
    stored = begun(library.root, store)
    library.forget(next(library.accepted()))
    library.forget(next(library.refused()))
    list(stored.finish())
    assert public(store) == files_of(library)
    assert len(list(library.accepted())) == len(BOXES) - 1


def test_entries_are_sent_while_the_run_goes_on(boxes: Path, tmp_path: Path) -> None:
    store = FaultyStore()
    stored = begun(tmp_path / "one", store)
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
    for number in itertools.count(step=5):
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
    assert number >= 30


def test_a_store_that_is_away_delays_what_is_sent_and_not_the_run(boxes: Path, tmp_path: Path) -> None:
    store = FaultyStore()
    stored = begun(tmp_path / "one", store, 0.05)
    for _ in stored.sending(ingested(boxes / "library", tmp_path / "one")):
        store.fails = lambda _name, _number: True
    with pytest.raises(OutputError, match="does not answer"):
        list(stored.finish())
    assert public_differences(tmp_path / "one", boxes / "library") == []
    store.revive()
    run(boxes / "library", tmp_path / "one", store)
    assert public(store) == files_of(Library(boxes / "library"))
