"""A library on disk: its folders, the lock of the one run that writes, and entries that appear whole or not at all.

library/
  <category>/<id>/      model.xml scene.xml meshes/ textures/ usd/ preview.png asset.json
  rejected/<id>/        reject.json and, where one could be made, preview.png
  library.json  ATTRIBUTION.md  report.html
  .casa/                cache/ (results by content) staging/ (half-written, swept at the start) lock
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from casa_assets.core.system import process_name
from casa_assets.errors import OutputError
from casa_assets.library.entry_files import (
    CERTIFICATE,
    PICTURE,
    REFUSAL,
    Identity,
    Refusal,
    read_manifest,
    read_refusal,
    suffix_of,
    write_refusal,
)

REJECTED = "rejected"
LOCK = "lock"
# Arguments of renameat2: paths relative to the working folder; exchange two names. Ref: rename(2), linux/fcntl.h.
AT_FDCWD, RENAME_EXCHANGE = -100, 2


class Library:
    """A folder of assets. Every entry appears whole, by one rename, or not at all."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.private = root / ".casa"
        self.cache = self.private / "cache"
        self.staging = self.private / "staging"

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the library for writing. Raises OutputError where it is not a folder or another run holds it."""
        try:
            self.staging.mkdir(parents=True, exist_ok=True)
            handle = (self.private / LOCK).open("a")
        except OSError as error:
            raise OutputError(str(self.root), f"cannot be written to: {error.strerror}") from error
        with handle:
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise OutputError(str(self.root), "another run is writing to this library; wait for it") from error
            yield

    def sweep(self) -> None:
        """Remove what a killed run left half-written. Call with the lock held and while no worker runs."""
        for path in self.private.iterdir():
            if path.is_dir() and path != self.cache:
                shutil.rmtree(path, ignore_errors=True)
            elif not path.is_dir() and path.name != LOCK:
                path.unlink(missing_ok=True)
        self.staging.mkdir(exist_ok=True)

    def write(self, name: str, text: str) -> None:
        """Replace a file right in the library by one rename."""
        self.private.mkdir(parents=True, exist_ok=True)
        fresh = self.private / f"{name}.{os.getpid()}"
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(self.root / name)

    def folder(self, category: str, asset_id: str) -> Path:
        """Folder of an accepted asset."""
        return self.root / category / asset_id

    def refusal_folder(self, asset_id: str) -> Path:
        """Folder of a rejected input."""
        return self.root / REJECTED / asset_id

    def stage(self, asset_id: str) -> Path:
        """A fresh folder of that name on the same file system, inside one that is private to this process."""
        path = self.staging / f"{asset_id}.{process_name()}" / asset_id  # SimReady asks for the asset's own name
        shutil.rmtree(path.parent, ignore_errors=True)
        path.mkdir(parents=True)
        return path

    def stage_refusal(self, refusal: Refusal, picture: bytes = b"") -> Path:
        """Write the finished entry of a rejected input into the staging folder, and return its folder."""
        staged = self.stage(refusal.id)
        if picture:
            (staged / PICTURE).write_bytes(picture)
        write_refusal(staged, refusal)
        return staged

    def publish(
        self,
        staged: Path,
        target: Path,
        older: Iterable[Path] | None = None,
        identity: Identity | None = None,
    ) -> None:
        """Put a finished entry in its place by one rename, then remove earlier entries of the same producer and input.

        Those may be under another category or among the rejected. If killed in between, the library has two whole
        entries of one input; the next run keeps the current one.

        Args:
            older: folders of earlier entries that the producer may have made of that input, as `by_input` gives them;
                None: they are searched for, which is slow if it is done for each of very many entries.
            identity: of the entry, if it is known; None: it is read.
        Raises:
            OutputError: another producer, or another input, has an entry in that place.
        """
        own, held = identity or identity_of(staged), identity_of(target)
        if own is None:
            raise ValueError(f"{staged} holds no entry of a library")
        if held is not None and held != own:
            message = f"holds what {held.producer.value} made of another input; move it to another library"
            raise OutputError(str(target), message)
        self.put(staged, target)
        for folder in self._candidates(own) if older is None else older:
            if folder != target and _may_be(folder, own):
                self.forget(folder)

    def put(self, staged: Path, target: Path) -> None:
        """Put a finished folder in its place by one rename; an older one is exchanged for it and removed."""
        while True:
            target.parent.mkdir(parents=True, exist_ok=True)
            try:
                exchange(staged, target)
                break
            except FileNotFoundError:  # a neighbour took the last entry of this category away, and the folder with it
                if not staged.exists():
                    raise
        shutil.rmtree(staged.parent, ignore_errors=True)

    def entries_of(self, identity: Identity) -> Iterator[Path]:
        """Folders of what a producer made of an input, under any category, accepted ones first."""
        return (folder for folder in self._candidates(identity) if _may_be(folder, identity))

    def _candidates(self, identity: Identity) -> list[Path]:
        """Folders that are named as entries of an identity are, whether they are there or not, accepted ones first."""
        if not self.root.is_dir():
            return []
        shelves = sorted(p for p in self.root.iterdir() if p.is_dir() and p != self.private)
        rejected = self.root / REJECTED
        folders = [shelf / identity.asset_id(shelf.name) for shelf in shelves if shelf != rejected]
        refused = rejected.iterdir() if rejected.is_dir() else ()
        return folders + sorted(p for p in refused if identity.may_own(p.name))

    def forget(self, folder: Path) -> None:
        """Remove an entry that a newer one has replaced, and with the last of a category the folder of the category."""
        if folder.exists():
            trash = self.staging / f"{folder.name}.{process_name()}.gone"
            shutil.rmtree(trash, ignore_errors=True)
            folder.rename(trash)
            shutil.rmtree(trash)
        with suppress(OSError):  # others are still there, or a worker has just put one there
            folder.parent.rmdir()

    def by_input(self) -> dict[str, tuple[Path, ...]]:
        """Folders of all entries by `Identity.suffix`, which identifies producer and input; accepted ones first."""
        found: dict[str, list[Path]] = {}
        for folder in (*self.accepted(), *self.refused()):
            found.setdefault(suffix_of(folder.name), []).append(folder)
        return {word: tuple(folders) for word, folders in found.items()}

    def accepted(self) -> Iterator[Path]:
        """Folders of all accepted assets, sorted by category and id."""
        for shelf in _folder_names(self.root):
            if shelf not in (REJECTED, self.private.name):
                yield from _folders_with(self.root / shelf, CERTIFICATE)

    def shelf_times(self) -> dict[str, int]:
        """When a folder last came to, or went from, each folder of entries, nanoseconds since 1970, by its name."""
        names = [name for name in _folder_names(self.root) if name != self.private.name]
        return {name: os.stat(self.root / name).st_mtime_ns for name in names}  # noqa: PTH116

    def refused(self) -> Iterator[Path]:
        """Folders of all rejected inputs, sorted by id."""
        yield from _folders_with(self.root / REJECTED, REFUSAL)


def _folder_names(place: Path) -> list[str]:
    """Return the names of the folders in a folder, sorted; empty if it does not exist or cannot be read."""
    try:
        with os.scandir(place) as inside:
            return sorted(entry.name for entry in inside if entry.is_dir())
    except OSError:
        return []


def _folders_with(place: Path, file: str) -> Iterator[Path]:
    """Folders right in a folder that hold a file of that name, sorted."""
    base = str(place)  # Path would take longer than all the rest
    for name in _folder_names(place):
        if os.path.exists(f"{base}/{name}/{file}"):  # noqa: PTH110
            yield place / name


def identity_of(folder: Path) -> Identity | None:
    """Return producer and input of an entry, or None if the entry is missing or damaged."""
    try:
        if (folder / CERTIFICATE).is_file():
            return read_manifest(folder).identity
        refusal = read_refusal(folder)
        return Identity(refusal.producer, refusal.sha256)
    except OutputError:
        return None


def _may_be(folder: Path, identity: Identity) -> bool:
    """Return whether a folder holds an entry of an identity, or one whose identity cannot be read."""
    return folder.is_dir() and identity_of(folder) in (identity, None)


def exchange(fresh: Path, target: Path) -> None:
    """Rename a folder to a name that another one may have, which gets the old name of the first: both at one moment.

    Raises:
        OSError: as `os.rename` does.
    """
    if not target.exists():
        fresh.rename(target)
        return
    libc = ctypes.CDLL(None, use_errno=True)
    code = 0
    if hasattr(libc, "renameat2"):
        code = libc.renameat2(AT_FDCWD, os.fsencode(fresh), AT_FDCWD, os.fsencode(target), RENAME_EXCHANGE)
        if code == 0:
            return
        code = ctypes.get_errno()
    if code not in (0, errno.ENOSYS, errno.EINVAL, errno.ENOTSUP):
        raise OSError(code, os.strerror(code), str(target))
    # A file system that cannot exchange: killed between these two, the input is due again.
    older = fresh.with_name(f"{fresh.name}.old")
    target.rename(older)
    fresh.rename(target)
