"""A library on a store: the same folders and files as on a disk, each entry published by its manifest.

    <category>/<id>/asset.json, rejected/<id>/reject.json    the manifest of an entry; without it there is no entry
    library.json  ATTRIBUTION.md  rejected/rows.jsonl ...    the books: what is not in the folder of an entry
    .casa/writers/<name>.json                                whoever writes (writer_lock.py)
    .casa/unfinished.json                                    a run that writes has not ended: books may be older

An object appears whole, but an entry has many. So its manifest is sent last and removed first: a reader who lists
manifests finds whole entries alone, whenever a run is killed. A reader who has read a manifest before its entry is
replaced finds files of another digest than it names, and reads again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.remote.entry_list import (
    DamagedEntry,
    EntryFiles,
    entry_of,
    is_entry_path,
    is_safe_name,
    manifest_name,
)
from casa_assets.pipeline.library.remote.remote_folder import RemoteFolder, StoredFile

PRIVATE = ".casa"
UNFINISHED = f"{PRIVATE}/unfinished.json"
MAX_READ = 3  # times that an entry is read before it is called damaged; it may be replaced meanwhile
MANIFESTS = (disk.CERTIFICATE, disk.REFUSAL)


class RemoteLibrary:
    """A library on a store. Whoever writes holds it by `writer_lock.hold`."""

    def __init__(self, folder: RemoteFolder) -> None:
        self.folder = folder

    @classmethod
    def open(cls, url: str) -> RemoteLibrary:
        """The library at an address. Raises as `RemoteFolder.open`."""
        return cls(RemoteFolder.open(url))

    @property
    def url(self) -> str:
        """Address, as it is shown to people."""
        return self.folder.url

    @property
    def is_unfinished(self) -> bool:
        """True while a run writes, and after one that was cut off."""
        return self.folder.find(UNFINISHED) is not None

    def begin(self) -> None:
        """Write down that a run writes."""
        self.folder.write(UNFINISHED, b"{}\n")

    def end(self) -> None:
        """Write down that the run has ended, and the library is whole."""
        self.folder.remove([UNFINISHED])

    def contents(self) -> tuple[list[str], dict[str, StoredFile]]:
        """Paths of all folders where an entry is, or was begun, sorted, and the books by path; no entry is opened."""
        shelves, top = self.folder.inside()
        found, books = [], {name: stored for name, stored in top.items() if is_book(name)}
        for shelf in shelves:
            if not shelf.startswith("."):
                folders, files = self.folder.inside(shelf)
                found += [path for path in (f"{shelf}/{name}" for name in folders) if is_entry_path(path)]
                books |= {f"{shelf}/{name}": stored for name, stored in files.items() if is_book(f"{shelf}/{name}")}
        return sorted(found), books

    def shelf(self, name: str) -> dict[str, dict[str, StoredFile]]:
        """The files of all entries in a folder right in the library, by the path of the entry, then by name.

        Also those of folders without a manifest.
        """
        entries: dict[str, dict[str, StoredFile]] = {}
        for file, stored in self.folder.files(name).items():
            entry, _, rest = file.partition("/")
            if rest and is_entry_path(f"{name}/{entry}"):
                entries.setdefault(f"{name}/{entry}", {})[rest] = stored
        return entries

    def publish(self, path: str, files: Mapping[str, bytes], there: Mapping[str, StoredFile]) -> int:
        """Send the files of an entry, its manifest last; returns how many bytes were sent.

        Args:
            path: of the entry. files: all of them, by name. there: what the folder of the entry holds.
        """
        manifest = manifest_name(path)
        self.folder.remove(f"{path}/{name}" for name in MANIFESTS if name in there)
        sent = 0
        for name in sorted(files.keys() - {manifest}):
            stored = there.get(name)
            if stored is None or not stored.surely_holds(files[name]):  # what an upload that was cut off sent stays
                self.folder.write(f"{path}/{name}", files[name])
                sent += len(files[name])
        self.folder.remove(f"{path}/{name}" for name in sorted(there.keys() - files.keys() - set(MANIFESTS)))
        self.folder.write(f"{path}/{manifest}", files[manifest])
        return sent + len(files[manifest])

    def forget(self, path: str) -> None:
        """Remove an entry, or what was begun of one: its manifest first."""
        names = self.folder.files(path)
        self.folder.remove(f"{path}/{name}" for name in sorted(names, key=lambda name: (name not in MANIFESTS, name)))

    def fetch(self, path: str, there: Mapping[str, StoredFile], write: Callable[[EntryFiles, bytes], None]) -> bool:
        """Read an entry; False where it is gone.

        Args:
            there: what its folder holds.
            write: is given the entry and its manifest, and fetches the files; raises `Replaced` where one is missing or
                is not what the manifest says.
        Raises:
            DamagedEntry: the entry is damaged, or is replaced again and again.
            OutputError: the store does not answer, or refuses.
        """
        place = f"{self.url}/{path}"
        fault = DamagedEntry(place, "is damaged")
        for _ in range(MAX_READ):
            manifest = self.folder.read(f"{path}/{manifest_name(path)}")
            if manifest is None:
                return False
            try:
                write(entry_of(path, manifest, there, place), manifest)
                return True
            except DamagedEntry as error:
                fault = error
            except Replaced as error:
                fault = DamagedEntry(place, f"{error}; push the entry again, or wait for the run that writes it")
        raise fault


class Replaced(Exception):
    """A file of an entry is not what the manifest says: the entry is being replaced, or is damaged."""


def is_book(path: str) -> bool:
    """True for the path of a file, relative to a library, that is none of an entry and not private."""
    parts = path.split("/")
    return len(parts) <= 2 and is_safe_name(path) and not any(part.startswith(".") for part in parts)


def has_manifest(path: str, names: Iterable[str]) -> bool:
    """True if the folder of an entry holds what makes it one."""
    return manifest_name(path) in names
