"""Libraries on stores: push, pull, and runs that keep their library there, entry by entry.

    <category>/<id>/asset.json, rejected/<id>/reject.json    the manifest of an entry; without it there is no entry
    library.json  ATTRIBUTION.md  rejected/rows.jsonl ...    the books: what is not in the folder of an entry
    .casa/writers/<name>.json                                whoever writes (library/remote_folder.py)
    .casa/unfinished.json                                    a run that writes has not ended: books may be older

An object appears whole, but an entry has many. So its manifest is sent last and removed first: a reader who lists
manifests finds whole entries alone, whenever a run is killed. A reader who has read a manifest before its entry is
replaced finds files of another digest than it names, and reads again.
"""

from __future__ import annotations

import hashlib
import json
import os
import posixpath
import re
import shutil
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Set
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from enum import Enum
from itertools import groupby, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal, TypeVar

from casa_assets.core.system import process_name
from casa_assets.errors import OutputError
from casa_assets.library import review
from casa_assets.library.entry_files import CERTIFICATE, PICTURE, REFUSAL, file_inside, suffix_of
from casa_assets.library.library import REJECTED, Library
from casa_assets.library.library_report import write_reports
from casa_assets.library.mesh_decisions import NAME as MESHES_NAME
from casa_assets.library.mesh_decisions import keep_mesh_decisions, mesh_decisions
from casa_assets.library.remote_folder import RemoteFolder, StoredFile, WriterLock
from casa_assets.runs.outcome import Event, writing

T = TypeVar("T")
R = TypeVar("R")
UNFINISHED = ".casa/unfinished.json"
MANIFESTS = (CERTIFICATE, REFUSAL)
DECISIONS = (review.NAME, MESHES_NAME)
MAX_READ = 3  # times that an entry is read before it is called damaged; it may be replaced meanwhile
THREADS = 16  # requests at once: most of their time is waiting
SENDERS = 4  # a run on this machine makes far fewer entries a second than these send
# As `model.record.Id`: ids, and the folders of categories.
_ID = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")


class Extra(Enum):
    """How to treat entries that exist only on the side that is written to."""

    REFUSE = "refuse"  # they end the run before anything is written
    REMOVE = "remove"
    KEEP = "keep"


@dataclass(frozen=True)
class Change:
    """One entry is done with.

    Attributes:
        kind: copied, kept (was there already), removed, or failed, and then message says why.
        path: folder of the entry, relative to the library. total: entries of the run.
        bytes_copied: as far as they had to be.
    """

    kind: Literal["copied", "kept", "removed", "failed"]
    path: str
    total: int
    bytes_copied: int = 0
    message: str = ""


class DamagedEntry(OutputError):
    """An entry cannot be copied: a file is missing, or is not what the manifest says."""


class Replaced(Exception):
    """A file of an entry is not what the manifest says: the entry is being replaced, or is damaged."""


def entry_path(folder: Path) -> str:
    """Path of the folder of an entry on this disk, relative to its library."""
    return f"{folder.parent.name}/{folder.name}"


def entry_folders(library: Library) -> dict[str, Path]:
    """Folders of all entries of a library on this disk by their paths relative to it, accepted ones first."""
    return {entry_path(folder): folder for folder in (*library.accepted(), *library.refused())}


def manifest_name(path: str) -> str:
    """Name of the file that makes the folder of an entry one: asset.json, of a rejected input reject.json."""
    return REFUSAL if path.partition("/")[0] == REJECTED else CERTIFICATE


def _is_entry_path(path: str) -> bool:
    """True for the path of a folder, relative to a library, that can be that of an entry: category and id."""
    parts = path.split("/")
    return len(parts) == 2 and all(_ID.fullmatch(part) for part in parts)


def _is_safe_name(name: str) -> bool:
    """True for a relative path that stays inside its folder and is written in one way only."""
    plain = name == posixpath.normpath(name) and not name.startswith(("/", "../")) and name not in ("", ".", "..")
    return plain and name.isprintable() and "\\" not in name


def _is_book(path: str) -> bool:
    """Return whether a path relative to a library is that of a file outside all entries that is not private."""
    parts = path.split("/")
    return len(parts) <= 2 and _is_safe_name(path) and not any(part.startswith(".") for part in parts)


def books_at(root: Path) -> dict[str, Path]:
    """The books of a library on this disk by their path in it, sorted."""
    folders = [root, *(path for path in root.iterdir() if path.is_dir() and not path.name.startswith("."))]
    files = (path for folder in folders for path in folder.iterdir() if path.is_file() and not path.is_symlink())
    found = {path.relative_to(root).as_posix(): path for path in files}
    return {name: found[name] for name in sorted(found) if _is_book(name)}


def digests_of(path: str, manifest: bytes, names: Iterable[str], place: str) -> dict[str, str]:
    """The sha256 of all files of an entry but its manifest, by name; empty if nothing states it.

    `path`: of the entry. `manifest`: its bytes. `names`: of files that its folder has. `place`: of the manifest, for
    errors. Raises DamagedEntry: the manifest is damaged, or names files outside of the entry.
    """
    is_refusal = manifest_name(path) == REFUSAL
    try:
        stated = json.loads(manifest)["code" if is_refusal else "certificate"]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise DamagedEntry(place, "is damaged; make or push the entry again") from error
    if is_refusal:
        return {PICTURE: ""} if PICTURE in names else {}
    files = stated.get("files") if isinstance(stated, dict) else None
    if not isinstance(files, dict) or not all(isinstance(digest, str) for digest in files.values()):
        raise DamagedEntry(place, "names no files; make the entry again")
    for name in files:
        if not _is_safe_name(name) or name == CERTIFICATE:
            raise DamagedEntry(place, f"names {name!r:.120}, which is no file of the entry; make it again")
    return files


def read_file(folder: Path, name: str, digest: str) -> bytes:
    """A file of an entry on this disk.

    Raises OutputError: it is missing, leads out of the entry, or has another digest (unless that is empty).
    """
    data = file_inside(folder, name, folder, "files").read_bytes()
    if digest and hashlib.sha256(data).hexdigest() != digest:
        raise OutputError(str(folder / name), "is not what the certificate says; remove its folder and run again")
    return data


def entry_at(folder: Path) -> tuple[bytes, dict[str, str]]:
    """Manifest of an entry on this disk, and the digests of its other files. Raises OutputError, OSError."""
    path = entry_path(folder)
    manifest = read_file(folder, manifest_name(path), "")
    names = [PICTURE] if (folder / PICTURE).exists() else []
    return manifest, digests_of(path, manifest, names, str(folder / manifest_name(path)))


class RemoteLibrary(RemoteFolder):
    """A library on a store. Whoever writes holds it by `remote_folder.hold`."""

    @property
    def is_unfinished(self) -> bool:
        """True while a run writes, and after one that was cut off."""
        return self.find(UNFINISHED) is not None

    def begin(self) -> None:
        """Write down that a run writes. Its end removes UNFINISHED."""
        self.write(UNFINISHED, b"{}\n")

    def contents(self) -> tuple[list[str], dict[str, StoredFile]]:
        """Paths of all folders with an entry, or with what was begun of one, sorted, and the books by path."""
        shelves, top = self.inside()
        found, books = [], {name: stored for name, stored in top.items() if _is_book(name)}
        for shelf in shelves:
            if not shelf.startswith("."):
                folders, files = self.inside(shelf)
                found += [path for path in (f"{shelf}/{name}" for name in folders) if _is_entry_path(path)]
                books |= {f"{shelf}/{name}": stored for name, stored in files.items() if _is_book(f"{shelf}/{name}")}
        return sorted(found), books

    def shelf(self, name: str) -> dict[str, dict[str, StoredFile]]:
        """The files of all entries in a folder right in the library, by the path of the entry, then by name.

        Also those of folders without a manifest.
        """
        entries: dict[str, dict[str, StoredFile]] = {}
        for file, stored in self.files(name).items():
            entry, _, rest = file.partition("/")
            if rest and _is_entry_path(f"{name}/{entry}"):
                entries.setdefault(f"{name}/{entry}", {})[rest] = stored
        return entries

    def publish(self, path: str, files: Mapping[str, bytes], there: Mapping[str, StoredFile]) -> int:
        """Send the files of an entry, its manifest last; returns how many bytes were sent.

        `path`: of the entry. `files`: all of them, by name. `there`: what the folder of the entry holds.
        """
        manifest = manifest_name(path)
        self.remove(f"{path}/{name}" for name in MANIFESTS if name in there)
        sent = 0
        for name in sorted(files.keys() - {manifest}):
            stored = there.get(name)
            if stored is None or not stored.surely_holds(files[name]):  # what an upload that was cut off sent stays
                self.write(f"{path}/{name}", files[name])
                sent += len(files[name])
        self.remove(f"{path}/{name}" for name in sorted(there.keys() - files.keys() - set(MANIFESTS)))
        self.write(f"{path}/{manifest}", files[manifest])
        return sent + len(files[manifest])

    def forget(self, path: str) -> None:
        """Remove an entry, or what was begun of one: its manifest first."""
        names = self.files(path)
        self.remove(f"{path}/{name}" for name in sorted(names, key=lambda name: (name not in MANIFESTS, name)))


def push(
    library: Library, remote: RemoteLibrary, lock: WriterLock, extra: Extra, gone: Set[str] = frozenset()
) -> Iterator[Change]:
    """Make the library on a store equal to one on this disk; yields a Change for each entry, as it is done with.

    Killed at any moment and run again, it goes on. Books that the library lacks are removed from the store.

    Args:
        library: which the caller holds. lock: by which the caller holds the store.
        extra: what becomes of entries that the store alone has; those that have been replaced are always removed.
        gone: paths of entries that were removed from the library: they are removed from the store too.
    Raises:
        OutputError: the store has entries or decisions that the library lacks; it does not answer, or refuses; or an
            entry of the library is damaged: all others are copied then.
    """
    own = entry_folders(library)
    there, books = remote.contents()
    lacking = set(there) - own.keys()
    removed = _superseded(lacking, own) | (lacking & gone)
    names = {path: remote.files(path).keys() for path in sorted(lacking - removed)}
    foreign = {path for path, found in names.items() if manifest_name(path) in found}
    if extra is Extra.REFUSE:
        _check_extra(remote.url, str(library.root), foreign)
        with _fetched_decisions(library, remote) as held:
            known, others = _decided(library), _decided(held)
        for name in DECISIONS:
            if missing := [digest for digest, decision in others[name].items() if known[name].get(digest) != decision]:
                message = f"{name} there has decisions that {library.root} lacks, such as on {min(missing)[:10]}"
                raise OutputError(remote.url, f"{message}; pull first, or overwrite them with --delete")
    # What has no manifest is what an upload that was cut off left. Some stores also list folders without a file.
    removed |= {path for path, found in names.items() if found} - foreign
    removed |= foreign if extra is Extra.REMOVE else set()
    lock.check()
    remote.begin()
    failed = []
    for shelf, paths in groupby(sorted(own), key=lambda path: path.split("/")[0]):
        entries = remote.shelf(shelf)

        def copy(path: str, entries: Mapping[str, Mapping[str, StoredFile]] = entries) -> Change:
            lock.check()
            try:
                sent = push_entry(own[path], remote, entries.get(path, {}))
            except DamagedEntry as error:
                return Change("failed", path, len(own), message=str(error))
            return Change("kept" if sent is None else "copied", path, len(own), sent or 0)

        for change in _in_threads(copy, list(paths), remote):
            failed += [change] if change.kind == "failed" else []
            yield change
    for path in sorted(removed):
        lock.check()
        remote.forget(path)
        yield Change("removed", path, len(own))
    _check_failed(remote.url, failed)
    own_books = books_at(library.root)
    for name, book in own_books.items():
        lock.check()
        data = book.read_bytes()
        if not remote.holds(name, data, books.get(name)):
            remote.write(name, data)
    remote.remove([*sorted(books.keys() - own_books.keys()), UNFINISHED])


def push_entry(folder: Path, remote: RemoteLibrary, there: Mapping[str, StoredFile]) -> int | None:
    """Send an entry unless the store has it; returns how many bytes were sent, None if it was there.

    Args:
        folder: of the entry. there: what its folder on the store holds, by name.
    Raises:
        DamagedEntry: a file of it is missing or is not what its certificate says; nothing was published.
        OutputError: the store does not answer, or refuses.
    """
    name = manifest_name(entry_path(folder))
    path = f"{entry_path(folder)}/{name}"
    try:
        manifest, digests = entry_at(folder)
        sizes = {file: (folder / file).stat().st_size for file in (*digests, name)}
    except (OutputError, OSError) as error:
        raise DamagedEntry(str(folder), str(error)) from error
    is_alike = sizes == {file: stored.size for file, stored in there.items()}
    if is_alike and remote.holds(path, manifest, there[name]):
        return None
    try:
        files = {file: read_file(folder, file, digest) for file, digest in {**digests, name: ""}.items()}
    except (OutputError, OSError) as error:
        raise DamagedEntry(str(folder), str(error)) from error
    return remote.publish(entry_path(folder), files, there)


def pull(remote: RemoteLibrary, library: Library, extra: Extra, is_partial: bool = False) -> Iterator[Change]:
    """Make a library on this disk equal to one on a store; yields a Change for each entry, as it is done with.

    Killed at any moment and run again, it goes on. With `Extra.KEEP` what the library alone has stays, a damaged entry
    of the store is left out, and books that the store lacks stay.

    Args:
        library: which the caller holds.
        extra: what becomes of entries that the library alone has; those that have been replaced are always removed.
        is_partial: the run that writes to the store may not have ended; what it has not written yet is left out.
    Raises:
        OutputError: the store holds no library, or one that is not finished; the library has entries or decisions that
            the store lacks; the store does not answer, or refuses; or an entry there is damaged: all others are copied.
    """
    there, books = remote.contents()
    is_unfinished, is_mirror = remote.is_unfinished, extra is not Extra.KEEP
    if is_mirror and not (there or books):
        raise OutputError(remote.url, "holds no library; look at the address")
    if is_mirror and is_unfinished and not is_partial:
        message = "a run is writing to this library, or was cut off before it had ended; run that again"
        raise OutputError(remote.url, f"{message}, or take what there is with --partial")
    lacking = entry_folders(library).keys() - set(there)
    replaced = _superseded(lacking, there)
    if extra is Extra.REFUSE:
        _check_extra(str(library.root), remote.url, lacking - replaced)
    with writing(library.root):
        _take_over_decisions(library, remote, is_overwritten=extra is Extra.REMOVE)
        failed = []
        for shelf in sorted({path.split("/")[0] for path in there}):
            for change in _pull_shelf(shelf, remote, library, len(there)):
                failed += [change] if change.kind == "failed" else []
                yield change
        for path in sorted(lacking if extra is Extra.REMOVE else replaced):
            library.forget(library.root / path)
            yield Change("removed", path, len(there))
        if is_mirror:
            _check_failed(remote.url, failed)
        _pull_books(library, remote, books, is_mirror)
    if is_unfinished and is_mirror:  # the books there are older than the entries
        write_reports(library)


def _pull_shelf(shelf: str, remote: RemoteLibrary, library: Library, total: int) -> Iterator[Change]:
    entries = {path: names for path, names in remote.shelf(shelf).items() if manifest_name(path) in names}

    def fetch(path: str) -> tuple[Change, Path | None]:
        try:
            if _is_current(path, library, remote, entries[path]):
                return Change("kept", path, total), None
            size, staged = _fetched(path, library, remote, entries[path])
            return Change("copied", path, total, size), staged
        except DamagedEntry as error:
            return Change("failed", path, total, message=str(error)), None

    for change, staged in _in_threads(fetch, sorted(entries), remote):
        if staged is not None:
            library.put(staged, library.root / change.path)
        if staged is not None or change.kind != "copied":  # else the entry has gone from the store
            yield change


def _is_current(path: str, library: Library, remote: RemoteLibrary, stored: Mapping[str, StoredFile]) -> bool:
    """True if the library has the entry of the store, with all its files."""
    folder, name = library.root / path, manifest_name(path)
    try:
        manifest, digests = entry_at(folder)
        sizes = {file: (folder / file).stat().st_size for file in digests}
    except (OutputError, OSError):
        return False
    if any(file in stored and stored[file].size != size for file, size in sizes.items()):
        return False
    return remote.holds(f"{path}/{name}", manifest, stored[name])


def _fetched(
    path: str, library: Library, remote: RemoteLibrary, stored: Mapping[str, StoredFile]
) -> tuple[int, Path | None]:
    """Bytes that were fetched of an entry, and its copy in the staging folder; None if it has gone from the store.

    Raises DamagedEntry: the entry is damaged, or is replaced again and again. OutputError: the store does not answer,
    or refuses.
    """
    place, shelf, id_ = f"{remote.url}/{path}", *path.split("/")
    staged = library.staging / f"{shelf}.{id_}.{process_name()}" / id_
    fault = DamagedEntry(place, "is damaged")
    for _ in range(MAX_READ):
        if (manifest := remote.read(f"{path}/{manifest_name(path)}")) is None:
            return 0, None
        shutil.rmtree(staged.parent, ignore_errors=True)
        staged.mkdir(parents=True)
        size = len(manifest)
        try:
            for file, digest in digests_of(path, manifest, stored, place).items():
                size += _bring(f"{path}/{file}", digest, library.root / path, file, staged / file, remote)
        except DamagedEntry as error:
            fault = error
        except Replaced as error:
            fault = DamagedEntry(place, f"{error}; push the entry again, or wait for the run that writes it")
        else:
            (staged / manifest_name(path)).write_bytes(manifest)
            return size, staged
    raise fault


def _bring(path: str, digest: str, own: Path, name: str, target: Path, remote: RemoteFolder) -> int:
    """Copy a file of an entry: that of the library if it is the same, else that of the store; returns bytes fetched.

    `path`: on the store. `own`: folder of the entry in the library. `name`: in it.
    """
    data, size = None, 0
    with suppress(OutputError):
        data = read_file(own, name, digest) if digest else None
    if data is None:
        data = remote.read(path)
        if data is None:
            raise Replaced(f"{name} is missing")
        if digest and hashlib.sha256(data).hexdigest() != digest:
            raise Replaced(f"{name} is not what the certificate says")
        size = len(data)
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(data)
    return size


def _pull_books(library: Library, remote: RemoteLibrary, there: Mapping[str, StoredFile], is_mirror: bool) -> None:
    """Fetch the books that differ; decisions are taken over before."""
    own = books_at(library.root)
    for name in sorted(there.keys() - set(DECISIONS)):
        path = library.root / name
        if name in own and remote.holds(name, own[name].read_bytes(), there[name]):
            continue
        if (data := remote.read(name)) is not None:
            path.parent.mkdir(exist_ok=True)
            fresh = library.private / f"{path.name}.{os.getpid()}"
            fresh.write_bytes(data)
            fresh.replace(path)
    for name in own.keys() - there.keys() - set(DECISIONS) if is_mirror else ():
        own[name].unlink()


def _take_over_decisions(library: Library, remote: RemoteLibrary, is_overwritten: bool) -> None:
    """Take the decisions on the store over into a library; its own on other inputs stay.

    `is_overwritten`: take the files of the store as they are, whatever was decided here. Raises OutputError: both
    decide differently about an input; nothing is changed then.
    """
    with _fetched_decisions(library, remote) as there:
        own, others = _decided(library), _decided(there)
        for name in DECISIONS if not is_overwritten else ():
            if differing := [d for d in own[name].keys() & others[name].keys() if own[name][d] != others[name][d]]:
                message = f"{name} decides otherwise on {min(differing)[:10]} than {library.root / name}"
                raise OutputError(remote.url, f"{message}; change one, or take those of the store with --delete")
        for name in DECISIONS:
            if is_overwritten or own[name].keys() <= others[name].keys():
                if (there.root / name).exists():
                    (there.root / name).replace(library.root / name)
                else:
                    (library.root / name).unlink(missing_ok=True)
        if not is_overwritten:
            review.adopt(library, [there])
            keep_mesh_decisions(library, mesh_decisions(there))


def _decided(library: Library) -> dict[str, Mapping[str, object]]:
    """Return the decisions of a library, by the name of the file, then by the digest of the input."""
    return {review.NAME: review.read_overrides(library), MESHES_NAME: mesh_decisions(library)}


@contextmanager
def _fetched_decisions(library: Library, remote: RemoteLibrary) -> Iterator[Library]:
    """A folder with the files of the store on decisions, as far as it has them."""
    with TemporaryDirectory(dir=library.private, prefix="decisions.") as folder:
        for name in DECISIONS:
            if (data := remote.read(name)) is not None:
                (Path(folder) / name).write_bytes(data)
        yield Library(Path(folder))


class StoredRun:
    """A run whose library is kept on a store, in the order `fetch`, `sending`, `finish`.

    The library on this disk is whole at any time and everything is sent from it. A store that does not answer for a
    while delays what is sent and not the run; what could not be sent by its end is sent then, or by the next run.

    Args:
        library: on this disk. remote: the same on the store. lock: by which the caller holds it.
    """

    def __init__(self, library: Library, remote: RemoteLibrary, lock: WriterLock) -> None:
        self._library, self._remote, self._lock = library, remote, lock
        self._before: Set[str] = frozenset()

    def fetch(self) -> Iterator[Change]:
        """Bring what the store has and the library lacks; if both have an entry, that of the store counts."""
        with self._library.locked():
            yield from pull(self._remote, self._library, Extra.KEEP)
        self._before = entry_folders(self._library).keys()

    def sending(self, events: Generator[Event, None, None]) -> Generator[Event, None, None]:
        """Pass the events of the run on, and send the entry of each that is new in the background."""
        has_begun = False
        senders = ThreadPoolExecutor(SENDERS, thread_name_prefix="store-send")
        try:
            with closing(events):
                for event in events:
                    if not has_begun:
                        self._remote.begin()
                        has_begun = True
                    if event.kind != "kept" and event.folder is not None:
                        senders.submit(self._send, event.folder)
                    yield event
        except BaseException:  # the run is stopped
            self._remote.close()
            raise
        finally:  # `finish` sends the rest, with more threads
            senders.shutdown(cancel_futures=True)

    def finish(self) -> Iterator[Change]:
        """Send what is still to be sent, then the books, and remove from the store what the run has removed."""
        with self._library.locked():
            gone = self._before - entry_folders(self._library).keys()
            yield from push(self._library, self._remote, self._lock, Extra.KEEP, gone)

    def _send(self, folder: Path) -> None:
        with suppress(OutputError):  # `finish` tries again, and tells
            self._lock.check()
            push_entry(folder, self._remote, self._remote.files(entry_path(folder)))


def _superseded(extra: Iterable[str], other: Iterable[str]) -> set[str]:
    """Those of the entries on one side alone in whose place the other side has one of the same producer and input.

    `extra`, `other`: paths of entries.
    """
    known = {suffix_of(path.rpartition("/")[2]) for path in other}
    return {path for path in extra if suffix_of(path.rpartition("/")[2]) in known}


def _check_extra(place: str, other: str, paths: Iterable[str]) -> None:
    """Raise OutputError if one side has entries that are neither on the other side nor superseded there."""
    if found := sorted(paths):
        count = f"{len(found)} entries" if len(found) > 1 else "an entry"
        message = f"has {count} that {other} lacks, such as {found[0]}"
        raise OutputError(place, f"{message}; copy the other way first, or remove what is lacking there with --delete")


def _check_failed(place: str, failed: list[Change]) -> None:
    """Raise OutputError if some entries could not be copied."""
    if failed:
        few = "\n".join(f"  {change.message}" for change in failed[:3])
        raise OutputError(place, f"{len(failed)} of {failed[0].total} entries could not be copied:\n{few}")


def _in_threads(call: Callable[[T], R], items: Iterable[T], folder: RemoteFolder) -> Iterator[R]:
    """Yield what the call gives for each item, as they finish; an exception of a call ends all.

    No more items are taken than are worked on, so what they hold does not add up.

    `folder`: closed if an exception ends it, so that no request is repeated.
    """
    left = iter(items)
    open_: set[Future[R]] = set()
    with ThreadPoolExecutor(THREADS, thread_name_prefix="store") as threads:
        try:
            while True:
                open_ |= {threads.submit(call, item) for item in islice(left, THREADS - len(open_))}
                if not open_:
                    return
                done, open_ = wait(open_, return_when=FIRST_COMPLETED)
                yield from (future.result() for future in done)
        except BaseException:
            folder.close()
            for future in open_:
                future.cancel()
            raise
