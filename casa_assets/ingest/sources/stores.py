"""Folders on stores (S3, web servers, all that fsspec opens), read by the same calls and bounds as those on a disk.

fsspec finds the client of an address, and that its credentials. Added are guarantees that fsspec does not give: a
request is repeated and ends, no more bytes are taken than were asked for, a server that is away is not taken for a
file that is missing, and no password is shown.
"""

from __future__ import annotations

import hashlib
import importlib
import io
import os
import posixpath
import re
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from threading import Thread
from typing import IO, TYPE_CHECKING, Any, TypeVar
from urllib.parse import quote, unquote, urlsplit

from casa_assets.errors import CasaError, Rejected
from casa_assets.formats.read.formats import PACKED_SUFFIXES, SUFFIXES, UNREAD_SUFFIXES, suffix_of
from casa_assets.formats.read.text import printable
from casa_assets.ingest.sources.places import Entry, Folder, StoreRoot, archive_suffix, too_large
from casa_assets.model import rejection_codes as codes

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer as Buffer

T = TypeVar("T")
# How often a request is made before its object is given up, and how long it and the pauses may take; choices. Together
# they stay below the time after which a worker that does nothing is ended (runs/limits.py).
TRIES = 3
REQUEST_S = 60.0
PAUSE_S = 0.5
# The listing of a whole bucket is one call of many requests: a thousand names in each, a fifth of a second.
LISTING_S = 3600.0
PIECE_BYTES = 16 << 20  # of one request
# A page that lists more than a hundred thousand files is none that a server makes.
MAX_PAGE_BYTES = 16 << 20
DEEPEST_FOLDER = 64
# A run holds this many inputs in memory at most (rows.MAX_ROWS), and each may have a few files beside it.
MAX_OBJECTS = 2_000_000
FILE_SUFFIXES = SUFFIXES | UNREAD_SUFFIXES.keys() | PACKED_SUFFIXES | {".json", ".jsonl", ".parquet"}
UNKNOWN = "?"  # state of an object of which the store says nothing that would change with it
_LINK = re.compile(rb"""<a\s[^>]*?href\s*=\s*["']([^"']+)["']""", re.IGNORECASE)
# What changes when an object is written again, best first, by the names that the file systems give it.
_TAGS = ("ETag", "etag", "md5Hash", "content_md5", "Content-MD5", "checksum")
_TIMES = ("LastModified", "last_modified", "Last-Modified", "mtime", "updated", "modified", "created")


@dataclass(frozen=True)
class Info:
    """A file or folder of a store; `size`: bytes, or None. `state`: changes whenever it is written; empty: unknown."""

    is_folder: bool
    size: int | None = None
    state: str = ""


def warm() -> None:
    """Load what reads from S3 and web servers, as far as it is installed, once for all workers; nothing connects."""
    for protocol in ("s3", "https"):
        with suppress(ImportError):
            _fsspec().get_filesystem_class(protocol)


def _fsspec() -> Any:
    """Return the fsspec package.

    Not by `import`: keys of results count the versions of imported packages (cache/cache_key.py). A package
    that only transfers the bytes of a mesh does not affect the results made from them; their digest is in the key.
    """
    importlib.import_module("fsspec.core")
    importlib.import_module("fsspec.asyn")
    return importlib.import_module("fsspec")


def open_system(url: str, **options: Any) -> tuple[Any, str]:
    """The file system of fsspec for an address, and the path in it. Raises as `fsspec.core.url_to_fs`.

    Nothing that was listed before counts, since others write too. Callers repeat requests, so botocore does not.
    """
    options |= {"use_listings_cache": False, "skip_instance_cache": True}
    if re.match(r"s3a?://", url):
        retries = {"mode": "standard", "total_max_attempts": 1}
        options["config_kwargs"] = {**options.get("config_kwargs", {}), "retries": retries}
    system, path = _fsspec().core.url_to_fs(url, **options)
    return system, path


def _within(seconds: float, call: Callable[[], T]) -> T:
    """The answer of a call; TimeoutError if it takes longer, and its thread is left to itself."""
    answer: Future[T] = Future()

    def work() -> None:
        try:
            answer.set_result(call())
        except BaseException as error:  # noqa: BLE001  raised again by `result`
            answer.set_exception(error)

    Thread(target=work, daemon=True).start()
    try:
        return answer.result(seconds)
    except TimeoutError:
        if answer.done():  # the call's own
            raise
        raise TimeoutError(f"no answer within {seconds:.0f} s") from None


class _Store:
    """A store in this process: its client and answers, paths from its root on. `listing`: all names, once listed."""

    def __init__(self, root: StoreRoot) -> None:
        self.root = root
        self.listing: dict[str, dict[str, Info]] | None = None
        self._known: dict[str, Info | None] = {}
        self._scanned: dict[str, dict[str, Info]] = {}

    @cached_property
    def _client(self) -> tuple[Any, str]:
        """File system and the root's path in it. Raises CasaError: no installed package reads such an address."""
        options: dict[str, Any] = {}
        if self.root.is_web:
            # Bytes as they are: what a server packs would be unpacked without a bound.
            options = {"headers": {"Accept-Encoding": "identity"}, "client_kwargs": {"auto_decompress": False}}
        elif re.match(r"s3a?://", self.root.base):
            # Servers that give the checksum of a whole object with a part of it (rclone) would seem to be wrong.
            options["config_kwargs"] = {"connect_timeout": 10.0, "read_timeout": 50.0}
            os.environ.setdefault("AWS_RESPONSE_CHECKSUM_VALIDATION", "when_required")
        try:
            system, base = open_system(self.root.base, **options)
        except (ImportError, ValueError) as error:
            why = self.root.hide(" ".join(str(error).split()))
            advice = "`casa-assets doctor` says how to install what reads s3 and https"
            raise CasaError(f"{self.root}: {why}; {advice}") from None
        return system, self.root.base if self.root.is_web else base.rstrip("/")

    def knows(self, path: str) -> bool:
        """Return whether the state of a path is known without asking the store, or because it was asked before."""
        return self.listing is not None or path in self._known or path in self._scanned

    def info(self, path: str) -> Info | None:
        """Return the info of a file or folder, or None if it does not exist. Raises Rejected as `ask`."""
        if self.listing is not None:
            if path in self.listing:
                return Info(is_folder=True)
            folder, name = posixpath.split(path)
            found = self.listing.get(folder, {}).get(name)
            if found is None or found.size is not None or not self.root.is_web:
                return found
        if path not in self._known:
            try:
                self._known[path] = self.ask(path, lambda: _info(self._client[0].info(self._at(path))))
            except Rejected as error:
                if error.code != codes.MISSING_FILE:
                    raise
                self._known[path] = None
        return self._known[path]

    def scan(self, folder: str) -> dict[str, Info]:
        """Return the content of a folder, by name. Raises Rejected as `ask`."""
        if self.listing is not None:
            return self.listing.get(folder, {})
        if folder not in self._scanned:
            self._scanned[folder] = self.ask(folder, lambda: (self._links if self.root.is_web else self._ls)(folder))
        return self._scanned[folder]

    def walk(self) -> Iterator[tuple[str, Info | None]]:
        """Path of all files, and what is known of them; None for a folder of a web server that gave no listing."""
        if not self.root.is_web:
            system, base = self._client
            for name, one in system.find(base, detail=True).items():
                if one["type"] != "directory" and name.startswith(f"{base}/") and not name.endswith("/"):
                    yield name.removeprefix(f"{base}/"), _info(one)
            return
        waiting = [""]
        for folder in waiting:
            try:
                found = self.scan(folder)
            except Rejected:
                if not folder:
                    raise
                yield folder, None
                continue
            for name, info in sorted(found.items()):
                path = f"{folder}/{name}" if folder else name
                if not info.is_folder:
                    yield path, info
                elif path.count("/") < DEEPEST_FOLDER:
                    waiting.append(path)

    def part(self, path: str, start: int, end: int, size: int | None) -> bytes:
        """Bytes of an object, no more than asked for. Raises Rejected, also if there are fewer than its size says."""

        def read() -> bytes:
            if self.root.is_web:
                data = self._fetched(self._at(path), start, end)
            else:
                data = bytes(self._client[0].cat_file(self._at(path), start=start, end=end))[: end - start]
            if size is not None and len(data) < min(end, size) - start:
                raise OSError(f"gave {len(data)} of {min(end, size) - start} bytes from byte {start} on")
            return data

        return self.ask(path, read)

    def state(self, path: str) -> str:
        """Return text that changes when an object is rewritten; empty if there is no object, UNKNOWN if unknown."""
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

    def ask(self, path: str, call: Callable[[], T], seconds: float = 0.0) -> T:
        """The answer of the store to a call about a path that may be made again; `seconds` for each, 0: REQUEST_S.

        Raises Rejected: MISSING_FILE, UNREADABLE; STORE_FAILED: it failed each time. CasaError: as `call` raises it.
        """
        place = str(self.root / path)
        name, why = printable(place, 200), ""
        for number in range(TRIES):
            try:
                return _within(seconds or REQUEST_S, call)
            except (CasaError, MemoryError):
                raise
            except Exception as error:  # noqa: BLE001  each client of a store raises its own classes
                # Errors are not chained: their words may hold passwords. fsspec calls any web failure a missing file.
                fault = (error.__cause__ if self.root.is_web else None) or error
                status = getattr(fault, "status", 0)
                if isinstance(fault, FileNotFoundError | NotADirectoryError) or status in (404, 410):
                    message = f"{name}: there is no such object; add it or fix the name"
                    raise Rejected(codes.MISSING_FILE, message) from None
                if isinstance(fault, PermissionError) or status in (401, 403):
                    message = f"{name}: may not be read; give the credentials for it to the store's client"
                    raise Rejected(codes.UNREADABLE, message) from None
                why = self.root.hide(" ".join(str(fault).split()))[:200] or type(fault).__name__
            if number < TRIES - 1:
                time.sleep(PAUSE_S * 2**number)
        message = f"{place}: {why} ({TRIES} times); check the store and the network, then run again"
        raise Rejected(codes.STORE_FAILED, printable(message, 400))

    def _ls(self, folder: str) -> dict[str, Info]:
        found = self._client[0].ls(self._at(folder), detail=True)
        return {posixpath.basename(one["name"].rstrip("/")): _info(one) for one in found}

    def _links(self, folder: str) -> dict[str, Info]:
        """A folder of a web server: a page of links."""
        here = f"{self._at(folder).removesuffix(self.root.query).rstrip('/')}/"
        parts = urlsplit(here)
        found: dict[str, Info] = {}
        for link in _LINK.findall(self._fetched(here + self.root.query, 0, MAX_PAGE_BYTES)):
            text = link.decode("utf-8", "replace")
            if text.startswith("/") and not text.startswith("//"):
                text = f"{parts.scheme}://{parts.netloc}{text}"
            name = text.removeprefix(here).removeprefix("./")
            if name.rstrip("/") not in ("", ".", "..") and not re.search(r"[?#:]|/.", name):
                found[unquote(name.rstrip("/"))] = Info(name.endswith("/"))
        return found

    def _fetched(self, url: str, start: int, end: int) -> bytes:
        """A part of a file of a web server; unlike with fsspec's own call, what is sent beyond it is not read."""
        system = self._client[0]

        async def fetch() -> bytes:
            session = await system.set_session()
            headers = {"Accept-Encoding": "identity"}
            if start or end < MAX_PAGE_BYTES:
                headers["Range"] = f"bytes={start}-{end - 1}"
            async with session.get(system.encode_url(url), headers=headers) as response:
                if response.status == 416:
                    return b""
                response.raise_for_status()
                if start and response.status != 206:
                    place = printable(self.root.hide(url), 200)
                    message = f"{place}: its server gives no parts of files; download it and name the file"
                    raise Rejected(codes.STORE_FAILED, message)
                data = bytearray()
                while len(data) < end - start and (chunk := await response.content.read(1 << 20)):
                    data += chunk
                return bytes(data[: end - start])

        fetched: bytes = _fsspec().asyn.sync(system.loop, fetch)
        return fetched

    def _at(self, path: str) -> str:
        if self.root.is_web:
            return f"{self.root.base}/{quote(path)}{self.root.query}" if path else f"{self.root.base}{self.root.query}"
        base = self._client[1]
        return f"{base}/{path}" if path else base


def _info(one: Mapping[str, Any]) -> Info:
    changes = next((str(one[key]) for key in (*_TAGS, *_TIMES) if one.get(key)), "")
    size = one.get("size")
    state = f"store {changes} {size}" if changes else ""
    return Info(one.get("type") == "directory", size if isinstance(size, int) else None, state)


# By process, base and query: a client does not outlive a fork, so each process has its own.
_STORES: dict[tuple[int, str, str], _Store] = {}


def _store(root: StoreRoot) -> _Store:
    return _STORES.setdefault((os.getpid(), root.base, root.query), _Store(StoreRoot(root.base, root.query)))


def state_at(address: str) -> str:
    """State of an object at an address, without secrets, that this process has looked at; see `_Store.state`."""
    for (process, _, _), store in _STORES.items():
        below = "" if address == str(store.root) else address.removeprefix(f"{store.root}/")
        if process == os.getpid() and below != address and store.knows(below):
            return store.state(below)
    return UNKNOWN


class _StoreFolder(Folder):
    """A folder on a store; `looked_at`: see `folder_of`. Raises CasaError: what reads the address is not installed."""

    def __init__(self, root: StoreRoot, looked_at: set[str] | None = None) -> None:
        self._root, self._looked_at = root, looked_at
        self._store = _store(root)

    def read(self, path: str, max_bytes: float) -> bytes:
        size = self._file(self._look(path)).size
        whole, name = self._at(path), printable(posixpath.basename(path))
        if size is not None and size > max_bytes:
            raise too_large(name, size, max_bytes)
        most = int(max_bytes) if size is None else size
        data = bytearray()
        while size != 0 and len(data) <= most:
            start = len(data)
            # One byte more than there should be, in the last request, shows an object that has grown.
            end = most + 1 if size is None or most - start <= PIECE_BYTES else start + PIECE_BYTES
            data += self._store.part(whole, start, end, size)
            if len(data) < end:
                break
        if len(data) > max_bytes:
            raise Rejected(codes.TOO_LARGE, f"{name}: more than the {most} bytes left of --max-size; simplify it first")
        if size is not None and len(data) != size:
            raise Rejected(codes.STORE_FAILED, f"{self._root / path}: changed while it was being read; run again")
        return bytes(data)

    def has(self, path: str) -> bool:
        return self._store.info(self._at(self._look(path))) is not None

    def listing(self, folder: str) -> list[str]:
        try:
            return [entry.name for entry in self.scan(self._look(folder))]
        except Rejected:
            return []

    def scan(self, folder: str) -> list[Entry]:
        found = sorted(self._store.scan(self._at(folder)).items(), key=lambda item: os.fsencode(item[0]))
        return [Entry(name, info.is_folder, not info.is_folder) for name, info in found]

    def check(self, path: str) -> None:
        self._file(path)

    def open(self, path: str, block: int) -> IO[bytes]:
        if (size := self._file(path).size) is None:
            message = f"{self._root / path}: its server does not say how large it is; download it and name the file"
            raise Rejected(codes.STORE_FAILED, message)
        return io.BufferedReader(_Object(self._store, self._at(path), size), block)

    def identity(self, path: str) -> str:
        return str(self._root / path)

    def _file(self, path: str) -> Info:
        """Return the store's info of a file. Raises Rejected: MISSING_FILE, NOT_A_FILE, and as `_Store.ask`."""
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


def list_all(root: StoreRoot) -> list[tuple[str, str, str]] | None:
    """List all below a root, for this process; what earlier runs of it knew is forgotten.

    Returns path, code and reason of what no folder could hold, sorted; None: the root is a file. Raises CasaError:
    there is nothing, the store does not answer, or it holds more than a run can.
    """
    for one in (root, root.parent):
        _STORES.pop((os.getpid(), one.base, one.query), None)
    store = _store(root)
    try:
        if not root.is_web or archive_suffix(root.name) or suffix_of(root.name) in FILE_SUFFIXES:
            info = store.info("")
            if info is None:
                raise CasaError(f"{root}: there is nothing at this address; fix it, or put meshes there")
            if not info.is_folder:
                return None
        found = dict(store.ask("", lambda: list(islice(store.walk(), MAX_OBJECTS + 1)), LISTING_S))
    except Rejected as error:
        raise CasaError(error.message) from error
    if len(found) > MAX_OBJECTS:
        message = f"holds more than {MAX_OBJECTS} objects; name a folder of it, or pack them into shards"
        raise CasaError(f"{root}: {message}")
    folders: dict[str, dict[str, Info]] = {"": {}}
    faults: dict[str, tuple[str, str]] = {}
    for path, info in found.items():
        if info is None:
            faults[path] = codes.UNREADABLE, "the folder cannot be listed; check the store, then run again"
        elif fault := _fault(path):
            faults[path] = fault
        else:
            _put(folders, path, info)
    for path in found.keys() & folders.keys():
        faults[path] = codes.BAD_NAME, "an object with the name of a folder; rename one of them"
    store.listing = folders
    return [(path, code, why) for path, (code, why) in sorted(faults.items())]


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
        end = min(self._at + min(len(view), PIECE_BYTES), self._size)
        if end <= self._at:
            return 0
        data = self._store.part(self._path, self._at, end, self._size)
        view[: len(data)] = data
        self._at += len(data)
        return len(data)


def _fault(path: str) -> tuple[str, str] | None:
    """Code and reason if no folder could hold the name of an object; else None."""
    parts = path.split("/")
    if len(parts) > DEEPEST_FOLDER + 1:
        return codes.UNREADABLE, "folders nested too deep; move it"
    if ".." in parts or "." in parts:
        return codes.PATH_TRAVERSAL, "the name of this object leaves its folder; rename it"
    if "" in parts or "\0" in path:
        return codes.BAD_NAME, "a name that no file can have; rename it"
    return None


def _put(folders: dict[str, dict[str, Info]], path: str, info: Info) -> None:
    """Enter an object into the listing of its folder, and that folder into the one around it."""
    folder, name = posixpath.split(path)
    is_new = folder not in folders
    names = folders.setdefault(folder, {})
    if name not in names or info.is_folder:
        names[name] = info
    if is_new:
        _put(folders, folder, Info(is_folder=True))


def store_folder(root: StoreRoot, looked_at: set[str] | None = None) -> Folder:
    """A folder on a store; see `folder_of`."""
    return _StoreFolder(root, looked_at)
