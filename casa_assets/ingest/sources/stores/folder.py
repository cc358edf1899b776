"""A folder on a store, read by the same calls and within the same bounds as one on the disk."""

from __future__ import annotations

import hashlib
import io
import os
import posixpath
from collections.abc import Callable, Iterator
from itertools import islice
from typing import IO, TYPE_CHECKING, TypeVar

from casa_assets.errors import CasaError, Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.formats import PACKED_SUFFIXES, SUFFIXES, UNREAD_SUFFIXES, suffix_of
from casa_assets.ingest.load.notes import printable
from casa_assets.ingest.sources.containers.archive import archive_suffix
from casa_assets.ingest.sources.found import Refused
from casa_assets.ingest.sources.places import Entry
from casa_assets.ingest.sources.stores.address import StoreRoot
from casa_assets.ingest.sources.stores.client import (
    DEEPEST_FOLDER,
    LISTING_S,
    REQUEST_S,
    Client,
    Info,
    NoParts,
    StoreFault,
    open_client,
    steady,
)

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer as Buffer

T = TypeVar("T")
# A run holds this many inputs in memory at most (manifest.MAX_ROWS), and each may have a few files beside it.
MAX_OBJECTS = 2_000_000
PIECE_BYTES = 16 << 20  # of one request
FILE_SUFFIXES = SUFFIXES | UNREAD_SUFFIXES.keys() | PACKED_SUFFIXES | {".json", ".jsonl", ".parquet"}
UNKNOWN = "?"  # state of an object of which the store says nothing that would change with it


class _Store:
    """What this process knows of one store: its client, and what it has said of its objects.

    Attributes:
        listing: what stands in each folder, where all of it was listed.
    """

    def __init__(self, root: StoreRoot) -> None:
        self.root = root
        self.listing: dict[str, dict[str, Info]] | None = None
        self._known: dict[str, Info | None] = {}
        self._scanned: dict[str, dict[str, Info]] = {}
        self._client: Client | None = None

    def knows(self, path: str) -> bool:
        """True where the state of a path can be told without asking the store, or was asked for before."""
        return self.listing is not None or path in self._known or path in self._scanned

    def ask(self, path: str, call: Callable[[Client], T], seconds: float = REQUEST_S) -> T:
        """The answer of the store. Raises Rejected: MISSING_FILE, UNREADABLE, STORE_FAILED."""
        place = self.root / path
        try:
            return steady(place, lambda: call(self.client), seconds)
        except FileNotFoundError as error:
            message = f"{printable(str(place), 200)}: there is no such object; add it or fix the name"
            raise Rejected(codes.MISSING_FILE, message) from error
        except PermissionError as error:
            message = (
                f"{printable(str(place), 200)}: may not be read; give the credentials for it to the store's client"
            )
            raise Rejected(codes.UNREADABLE, message) from error
        except NoParts as error:
            message = f"{printable(str(place), 200)}: its server gives no parts of files; download it and name the file"
            raise Rejected(codes.STORE_FAILED, message) from error
        except StoreFault as error:
            raise Rejected(codes.STORE_FAILED, printable(str(error), 400)) from error

    @property
    def client(self) -> Client:
        """Opened once; the first call of it may connect."""
        if self._client is None:
            self._client = open_client(self.root)
        return self._client

    def info(self, path: str) -> Info | None:
        """What stands at a place; None where there is nothing. Raises Rejected as `ask`."""
        if self.listing is not None:
            if path in self.listing:
                return Info(is_folder=True)
            folder, name = posixpath.split(path)
            found = self.listing.get(folder, {}).get(name)
            if found is None or found.size is not None or not self.root.is_web:
                return found
        if path not in self._known:
            try:
                self._known[path] = self.ask(path, lambda client: client.info(path))
            except Rejected as error:
                if error.code != codes.MISSING_FILE:
                    raise
                self._known[path] = None
        return self._known[path]

    def scan(self, folder: str) -> dict[str, Info]:
        """What stands in a folder, by name. Raises Rejected as `ask`."""
        if self.listing is not None:
            return self.listing.get(folder, {})
        if folder not in self._scanned:
            self._scanned[folder] = self.ask(folder, lambda client: client.scan(folder))
        return self._scanned[folder]

    def state(self, path: str) -> str:
        """Text that changes when an object is written anew; empty where there is none, UNKNOWN where nobody says."""
        try:
            info = Info(is_folder=True) if path in self._scanned else self.info(path)
            if info is None:
                return ""
            if not info.is_folder:
                return info.state or UNKNOWN
            names = "\0".join(sorted(self.scan(path)))
        except Rejected:
            return UNKNOWN
        return f"store {hashlib.sha256(names.encode('utf-8', 'surrogateescape')).hexdigest()}"


# By process, base and query: a client does not outlive a fork, so each process has its own.
_STORES: dict[tuple[int, str, str], _Store] = {}


def _store(root: StoreRoot) -> _Store:
    """The store of a root, whatever the path."""
    return _STORES.setdefault((os.getpid(), root.base, root.query), _Store(StoreRoot(root.base, root.query)))


def state_at(address: str) -> str:
    """State of what stands at an address that this process has looked at, see `_Store.state`.

    Args:
        address: as it is written down, without secrets.
    """
    for (process, _, _), store in _STORES.items():
        below = "" if address == str(store.root) else address.removeprefix(f"{store.root}/")
        if process == os.getpid() and below != address and store.knows(below):
            return store.state(below)
    return UNKNOWN


class StoreFolder:
    """A folder on a store; see places.Folder.

    Args:
        looked_at: takes up the addresses of all objects that are looked at, missing ones too.
    Raises:
        CasaError: fsspec, or what it needs for the address, is not installed; from all methods.
    """

    def __init__(self, root: StoreRoot, looked_at: set[str] | None = None) -> None:
        self._root, self._looked_at = root, looked_at
        self._store = _store(root)

    def read(self, path: str, max_bytes: float) -> bytes:
        """See Place."""
        info = self._file(self._look(path))
        whole, name = self._at(path), printable(posixpath.basename(path))
        size = info.size
        if size is not None and size > max_bytes:
            message = (
                f"{name}: {size} bytes, more than the {max(0, int(max_bytes))} left of --max-size; simplify it first"
            )
            raise Rejected(codes.TOO_LARGE, message)
        most = int(max_bytes) if size is None else size
        data = bytearray()
        while size != 0 and len(data) <= most:
            start = len(data)
            # One byte more than there should be, in the last request, tells an object that has grown.
            end = most + 1 if size is None or most - start <= PIECE_BYTES else start + PIECE_BYTES
            piece = self._store.ask(whole, lambda client: _part(client, whole, start, end, size))  # noqa: B023
            data += piece
            if len(piece) < end - start:
                break
        if len(data) > max_bytes:
            raise Rejected(codes.TOO_LARGE, f"{name}: more than the {most} bytes left of --max-size; simplify it first")
        if size is not None and len(data) != size:
            raise Rejected(codes.STORE_FAILED, f"{self._root / path}: changed while it was being read; run again")
        return bytes(data)

    def has(self, path: str) -> bool:
        """See Place."""
        return self._store.info(self._at(self._look(path))) is not None

    def is_inside(self, folder: str) -> bool:
        """See Place. There are no links on a store."""
        return True

    def listing(self, folder: str) -> list[str]:
        """See Place."""
        try:
            return [entry.name for entry in self.scan(self._look(folder))]
        except Rejected:
            return []

    def scan(self, folder: str) -> list[Entry]:
        """See Folder."""
        whole = self._at(folder)
        found = self._store.scan(whole)
        names = sorted(found, key=os.fsencode)
        return [Entry(name, found[name].is_folder, not found[name].is_folder) for name in names]

    def check(self, path: str) -> None:
        """See Folder."""
        self._file(path)

    def open(self, path: str, block: int) -> IO[bytes]:
        """See Folder."""
        info = self._file(path)
        if info.size is None:
            message = f"{self._root / path}: its server does not say how large it is; download it and name the file"
            raise Rejected(codes.STORE_FAILED, message)
        return io.BufferedReader(_Object(self._store, self._at(path), info.size), block)

    def identity(self, path: str) -> str:
        """See Folder."""
        return str(self._root / path)

    def is_file(self) -> bool:
        """True where the root is a file; what earlier runs of this process knew of it is forgotten.

        Raises:
            CasaError: nothing stands there, or the store does not answer.
        """
        for root in (self._root, self._root.parent):
            _STORES.pop((os.getpid(), root.base, root.query), None)
        self._store = _store(self._root)
        if self._root.is_web and not _is_file_name(self._root.name):
            return False
        try:
            info = self._store.info("")
        except Rejected as error:
            raise CasaError(error.message) from error
        if info is None:
            raise CasaError(f"{self._root}: there is nothing at this address; fix it, or put meshes there")
        return not info.is_folder

    def list_all(self) -> Iterator[Refused]:
        """List all that stands below the root, for this process; yields what no folder could hold, or was not listed.

        Raises:
            CasaError: the store does not answer, or holds more than a run can.
        """
        try:
            found = dict(self._store.ask("", lambda client: _walked(self._root, client), LISTING_S))
        except Rejected as error:
            raise CasaError(error.message) from error
        folders: dict[str, dict[str, Info]] = {"": {}}
        faults: dict[str, tuple[str, str]] = {}
        for path, info in found.items():
            if info is None:
                faults[path] = codes.UNREADABLE, "the folder cannot be listed; check the store, then run again"
            elif fault := _fault(path):
                faults[path] = fault
            else:
                _put(folders, path, info)
        for path in sorted(found.keys() & folders.keys()):
            faults[path] = codes.BAD_NAME, "an object with the name of a folder; rename one of them"
        self._store.listing = folders
        for path, (code, why) in sorted(faults.items()):
            yield Refused(printable(path, 400), code, f"{printable(path, 200)}: {why}")

    def _file(self, path: str) -> Info:
        """What a store says of a file. Raises Rejected: MISSING_FILE, NOT_A_FILE, and as `_Store.ask`."""
        info = self._store.info(self._at(path))
        name = printable(posixpath.basename(path))
        if info is None:
            raise Rejected(codes.MISSING_FILE, f"{name}: there is no such file; add it or fix the name")
        if info.is_folder:
            raise Rejected(codes.NOT_A_FILE, f"{name}: a folder, not a regular file; put the file itself there")
        return info

    def _at(self, path: str) -> str:
        return posixpath.normpath(posixpath.join(self._root.path, path)) if path else self._root.path

    def _look(self, path: str) -> str:
        if self._looked_at is not None:
            self._looked_at.add(str(self._root / path))
        return path


class _Object(io.RawIOBase):
    """An object as a file to seek in; what is read is what was there when it was opened, or an error."""

    def __init__(self, store: _Store, path: str, size: int) -> None:
        self._store, self._path, self._size, self._at = store, path, size, 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._at

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        self._at = max(0, offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._size}[whence])
        return self._at

    def readinto(self, buffer: Buffer) -> int:
        view = memoryview(buffer).cast("B")
        start, end = self._at, min(self._at + min(len(view), PIECE_BYTES), self._size)
        if end <= start:
            return 0
        data = self._store.ask(self._path, lambda client: _part(client, self._path, start, end, self._size))
        view[: len(data)] = data
        self._at += len(data)
        return len(data)


def _part(client: Client, path: str, start: int, end: int, size: int | None) -> bytes:
    """Bytes of an object. Raises OSError where there are fewer than its size says."""
    data = client.part(path, start, end)
    if size is not None and len(data) < min(end, size) - start:
        raise OSError(f"gave {len(data)} of {min(end, size) - start} bytes from byte {start} on")
    return data


def _walked(root: StoreRoot, client: Client) -> list[tuple[str, Info | None]]:
    found = list(islice(client.walk(), MAX_OBJECTS + 1))
    if len(found) > MAX_OBJECTS:
        raise CasaError(f"{root}: holds more than {MAX_OBJECTS} objects; name a folder of it, or pack them into shards")
    return found


def _fault(path: str) -> tuple[str, str] | None:
    """Code of what makes the name of an object one that no folder could hold, and the reason; None where nothing is."""
    parts = path.split("/")
    if len(parts) > DEEPEST_FOLDER + 1:
        return codes.UNREADABLE, "folders nested too deep; move it"
    if ".." in parts or "." in parts:
        return codes.PATH_TRAVERSAL, "the name of this object leaves its folder; rename it"
    if "" in parts or "\0" in path:
        return codes.BAD_NAME, "a name that no file can have; rename it"
    return None


def _is_file_name(name: str) -> bool:
    """True for a name on a web server that is one of a file, as far as sources know files."""
    suffix = suffix_of(name)
    return bool(archive_suffix(name)) or suffix in FILE_SUFFIXES


def _put(folders: dict[str, dict[str, Info]], path: str, info: Info) -> None:
    """Enter an object into the listing of its folder, and that folder into the one around it."""
    folder, name = posixpath.split(path)
    is_new = folder not in folders
    names = folders.setdefault(folder, {})
    if name not in names or info.is_folder:
        names[name] = info
    if is_new:
        _put(folders, folder, Info(is_folder=True))
