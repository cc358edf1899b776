"""Copy a library from a store to this disk: what is missing here or differs, then the books."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.derived_files import write_reports
from casa_assets.pipeline.library.remote import decisions
from casa_assets.pipeline.library.remote.change import Change, Extra, check_extra, check_failed, superseded
from casa_assets.pipeline.library.remote.entry_list import DamagedEntry, EntryFiles, entry_at, entry_folders, read_file
from casa_assets.pipeline.library.remote.parallel import in_threads
from casa_assets.pipeline.library.remote.push import books_at
from casa_assets.pipeline.library.remote.remote_folder import StoredFile
from casa_assets.pipeline.library.remote.remote_library import RemoteLibrary, Replaced, has_manifest
from casa_assets.pipeline.process_name import process_name


def pull(remote: RemoteLibrary, library: disk.Library, extra: Extra, is_partial: bool = False) -> Iterator[Change]:
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
    is_unfinished = remote.is_unfinished
    if extra is not Extra.KEEP:
        _check_source(remote, bool(there or books), is_unfinished and not is_partial)
    own = entry_folders(library)
    lacking = own.keys() - set(there)
    replaced = superseded(lacking, there)
    if extra is Extra.REFUSE:
        check_extra(str(library.root), remote.url, lacking - replaced)
    with writing(library.root):
        decisions.take_over(library, remote, is_overwritten=extra is Extra.REMOVE)
        failed = []
        for shelf in sorted({path.split("/")[0] for path in there}):
            for change in _pull_shelf(shelf, remote, library, len(there)):
                failed += [change] if change.kind == "failed" else []
                yield change
        for path in sorted(lacking if extra is Extra.REMOVE else replaced):
            library.forget(own[path])
            yield Change("removed", path, len(there))
        if extra is not Extra.KEEP:
            check_failed(remote.url, failed)
        _pull_books(library, remote, books, is_mirror=extra is not Extra.KEEP)
    if is_unfinished and extra is not Extra.KEEP:  # the books there are older than the entries
        write_reports(library)


def _check_source(remote: RemoteLibrary, is_library: bool, is_refused: bool) -> None:
    if not is_library:
        raise OutputError(remote.url, "holds no library; look at the address")
    if is_refused:
        message = "a run is writing to this library, or was cut off before it had ended; run that again"
        raise OutputError(remote.url, f"{message}, or take what there is with --partial")


def _pull_shelf(shelf: str, remote: RemoteLibrary, library: disk.Library, total: int) -> Iterator[Change]:
    entries = {path: names for path, names in remote.shelf(shelf).items() if has_manifest(path, names)}
    fetch = _Fetch(remote, library, entries)
    for path, copied in in_threads(fetch, sorted(entries), remote.folder.close):
        if isinstance(copied, DamagedEntry):
            yield Change("failed", path, total, message=str(copied))
        elif copied is None:
            yield Change("kept", path, total)
        elif copied.is_there:
            library.put(copied.staged, library.root / path)
            yield Change("copied", path, total, copied.size)


@dataclass
class _Copy:
    """A copy of an entry in the staging folder; is_there: False where the entry has gone from the store."""

    staged: Path
    size: int = 0
    is_there: bool = True


@dataclass(frozen=True)
class _Fetch:
    """Fetches entries of one shelf into the staging folder. entries: their files on the store."""

    remote: RemoteLibrary
    library: disk.Library
    entries: Mapping[str, Mapping[str, StoredFile]]

    def __call__(self, path: str) -> tuple[str, _Copy | DamagedEntry | None]:
        """Path and staged copy of an entry; None where the library has it, an error where it is damaged there."""
        if self._is_current(path):
            return path, None
        shelf, _, name = path.partition("/")
        made = _Copy(self.library.staging / f"{shelf}.{name}.{process_name()}" / name)

        def write(entry: EntryFiles, manifest: bytes) -> None:
            shutil.rmtree(made.staged.parent, ignore_errors=True)
            made.staged.mkdir(parents=True)
            made.size = len(manifest)
            for file, digest in entry.digests.items():
                self._bring(entry.path, file, digest, made)
            (made.staged / entry.manifest).write_bytes(manifest)

        try:
            made.is_there = self.remote.fetch(path, self.entries[path], write)
        except DamagedEntry as error:
            return path, error
        return path, made

    def _bring(self, path: str, file: str, digest: str, made: _Copy) -> None:
        """One file: that of the library where it is the same, else that of the store."""
        data: bytes | None = None
        with suppress(OutputError):
            data = read_file(self.library.root / path, file, digest) if digest else None
        if data is None:
            data = self.remote.folder.read(f"{path}/{file}")
            if data is None:
                raise Replaced(f"{file} is missing")
            if digest and hashlib.sha256(data).hexdigest() != digest:
                raise Replaced(f"{file} is not what the certificate says")
            made.size += len(data)
        target = made.staged / file
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)

    def _is_current(self, path: str) -> bool:
        """True if the library has the entry of the store, with all its files."""
        folder, stored = self.library.root / path, self.entries[path]
        try:
            entry = entry_at(folder)
            manifest = read_file(folder, entry.manifest, "")
            sizes = {name: (folder / name).stat().st_size for name in entry.digests}
        except (OutputError, OSError):
            return False
        if any(name in stored and stored[name].size != size for name, size in sizes.items()):
            return False
        return self.remote.folder.holds(f"{path}/{entry.manifest}", manifest, stored[entry.manifest])


def _pull_books(library: disk.Library, remote: RemoteLibrary, there: Mapping[str, StoredFile], is_mirror: bool) -> None:
    """Fetch the books that differ. Decisions are taken over before, see decisions.py."""
    own = books_at(library.root)
    for name in sorted(there.keys() - set(decisions.NAMES)):
        path = library.root / name
        if name in own and remote.folder.holds(name, own[name].read_bytes(), there[name]):
            continue
        if (data := remote.folder.read(name)) is not None:
            path.parent.mkdir(exist_ok=True)
            fresh = library.private / f"{path.name}.{os.getpid()}"
            fresh.write_bytes(data)
            fresh.replace(path)
    for name in own.keys() - there.keys() - set(decisions.NAMES) if is_mirror else ():
        own[name].unlink()
