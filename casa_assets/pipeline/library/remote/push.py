"""Copy a library to a store: what is missing there or differs, then the books, then away with what was replaced."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import groupby
from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.remote import decisions
from casa_assets.pipeline.library.remote.change import Change, Extra, check_extra, check_failed, superseded
from casa_assets.pipeline.library.remote.entry_list import DamagedEntry, entry_at, entry_folders, read_file
from casa_assets.pipeline.library.remote.parallel import in_threads
from casa_assets.pipeline.library.remote.remote_folder import StoredFile
from casa_assets.pipeline.library.remote.remote_library import RemoteLibrary, has_manifest, is_book
from casa_assets.pipeline.library.remote.writer_lock import WriterLock


def push(
    library: disk.Library, remote: RemoteLibrary, lock: WriterLock, extra: Extra, gone: frozenset[str] = frozenset()
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
    removed = superseded(lacking, own) | (lacking & gone)
    names = {path: remote.folder.files(path).keys() for path in sorted(lacking - removed)}
    foreign = {path for path, found in names.items() if has_manifest(path, found)}
    if extra is Extra.REFUSE:
        check_extra(remote.url, str(library.root), foreign)
        decisions.check_push(library, remote)
    # What has no manifest is what an upload that was cut off left. Some stores also list folders without a file.
    removed |= {path for path, found in names.items() if found} - foreign
    removed |= foreign if extra is Extra.REMOVE else set()
    lock.check()
    remote.begin()
    failed = []
    for shelf, paths in groupby(sorted(own), key=lambda path: path.split("/")[0]):
        for change in _push_shelf(shelf, {path: own[path] for path in paths}, remote, lock, len(own)):
            failed += [change] if change.kind == "failed" else []
            yield change
    for path in sorted(removed):
        lock.check()
        remote.forget(path)
        yield Change("removed", path, len(own))
    check_failed(remote.url, failed)
    _push_books(library, remote, books, lock)
    remote.end()


def _push_shelf(
    shelf: str, folders: Mapping[str, Path], remote: RemoteLibrary, lock: WriterLock, total: int
) -> Iterator[Change]:
    entries = remote.shelf(shelf)

    def copy(path: str) -> Change:
        lock.check()
        try:
            sent = push_entry(folders[path], remote, entries.get(path, {}))
        except DamagedEntry as error:
            return Change("failed", path, total, message=str(error))
        return Change("kept" if sent is None else "copied", path, total, sent or 0)

    yield from in_threads(copy, sorted(folders), remote.folder.close)


def push_entry(folder: Path, remote: RemoteLibrary, there: Mapping[str, StoredFile]) -> int | None:
    """Send an entry unless the store has it; returns how many bytes were sent, None where it was there.

    Args:
        folder: of the entry. there: what its folder on the store holds, by name.
    Raises:
        DamagedEntry: a file of it is missing or is not what its certificate says; nothing was published.
        OutputError: the store does not answer, or refuses.
    """
    try:
        entry = entry_at(folder)
        digests = {**entry.digests, entry.manifest: ""}
        sizes = {name: (folder / name).stat().st_size for name in digests}
        manifest = read_file(folder, entry.manifest, "")
    except (OutputError, OSError) as error:
        raise DamagedEntry(str(folder), str(error)) from error
    if sizes == {name: stored.size for name, stored in there.items()}:
        path = f"{entry.path}/{entry.manifest}"
        if remote.folder.holds(path, manifest, there[entry.manifest]):
            return None
    try:
        files = {name: read_file(folder, name, digest) for name, digest in digests.items()}
    except (OutputError, OSError) as error:
        raise DamagedEntry(str(folder), str(error)) from error
    return remote.publish(entry.path, files, there)


def _push_books(
    library: disk.Library, remote: RemoteLibrary, there: Mapping[str, StoredFile], lock: WriterLock
) -> None:
    """Send the books that the store lacks or that differ, and remove those that the library lacks."""
    own = books_at(library.root)
    for name, path in own.items():
        lock.check()
        data = path.read_bytes()
        if not remote.folder.holds(name, data, there.get(name)):
            remote.folder.write(name, data)
    remote.folder.remove(sorted(there.keys() - own.keys()))


def books_at(root: Path) -> dict[str, Path]:
    """The books of a library on this disk by their path in it, sorted."""
    folders = [root, *(path for path in root.iterdir() if path.is_dir() and not path.name.startswith("."))]
    files = (path for folder in folders for path in folder.iterdir() if path.is_file() and not path.is_symlink())
    found = {path.relative_to(root).as_posix(): path for path in files}
    return {name: found[name] for name in sorted(found) if is_book(name)}
