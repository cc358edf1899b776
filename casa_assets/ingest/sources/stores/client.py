"""The file systems of fsspec, as far as sources need them: what stands where, and parts of objects.

Stores are reached by what `fsspec` finds for an address: s3, gs, az, http and others, each with the settings of its own
(environment, configuration files). Errors pass as they come; `steady` tries again and turns them into ours.
"""

from __future__ import annotations

import importlib
import os
import posixpath
import re
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol, TypeVar
from urllib.parse import quote, unquote, urlsplit

from casa_assets.errors import CasaError
from casa_assets.ingest.sources.stores.address import StoreRoot

T = TypeVar("T")
# How often a request is made before its object is given up, and how long it and the pauses may take; choices. Together
# they stay below the time after which a worker that does nothing is ended (pipeline/workers/limits.py).
TRIES = 3
REQUEST_S = 60.0
PAUSE_S = 0.5
_S3_TIMES = {"connect_timeout": 10.0, "read_timeout": 50.0}
# The listing of a whole bucket is one call of many requests: a thousand names in each, a fifth of a second.
LISTING_S = 3600.0
# A page that lists more than a hundred thousand files is none that a server makes.
MAX_PAGE_BYTES = 16 << 20
DEEPEST_FOLDER = 64
_LINK = re.compile(rb"""<a\s[^>]*?href\s*=\s*["']([^"']+)["']""", re.IGNORECASE)
# What changes when an object is written anew, best first, by the names that the file systems give it.
_TAGS = ("ETag", "etag", "md5Hash", "content_md5", "Content-MD5", "checksum")
_TIMES = ("LastModified", "last_modified", "Last-Modified", "mtime", "updated", "modified", "created")


class StoreFault(Exception):
    """A store did not give what it was asked for, however often."""


class NoParts(Exception):
    """A web server gives out files as a whole alone."""


@dataclass(frozen=True)
class Info:
    """What stands at a place.

    Attributes:
        size: bytes, as the store says; None where it does not. state: changes when it is written anew; empty: unknown.
    """

    is_folder: bool
    size: int | None = None
    state: str = ""


class Client(Protocol):
    """What stands where on a store, and its bytes; paths are POSIX, from a root on."""

    def info(self, path: str) -> Info:
        """Raises FileNotFoundError where there is nothing."""
        ...

    def scan(self, folder: str) -> dict[str, Info]:
        """What stands in a folder, by name."""
        ...

    def walk(self) -> Iterator[tuple[str, Info | None]]:
        """Path of all files below the root, and what the store says of them; None of a folder that gave no listing."""
        ...

    def part(self, path: str, start: int, end: int) -> bytes:
        """Bytes of an object, never more than asked for. Raises NoParts."""
        ...


def warm() -> None:
    """Load what reads from S3 and web servers, as far as it is installed, once for all workers; nothing connects."""
    for protocol in ("s3", "https"):
        with suppress(ImportError):
            _fsspec().get_filesystem_class(protocol)


def open_client(root: StoreRoot) -> Client:
    """The client of a root; its `path` is not looked at.

    Raises:
        CasaError: no package that is installed reads such an address.
    """
    # Listings that a file system keeps by itself would be those of an earlier run.
    options: dict[str, Any] = {"use_listings_cache": False, "skip_instance_cache": True}
    if root.is_web:
        # Bytes as they are: what a server packs would be unpacked without a bound.
        options |= {"headers": {"Accept-Encoding": "identity"}, "client_kwargs": {"auto_decompress": False}}
    if re.match(r"s3a?://", root.base):
        # Requests are repeated by `steady`, and not by botocore too, whose times would multiply. Servers that give the
        # checksum of a whole object with a part of it (rclone) would be taken to give wrong bytes.
        options["config_kwargs"] = {"retries": {"mode": "standard", "total_max_attempts": 1}, **_S3_TIMES}
        os.environ.setdefault("AWS_RESPONSE_CHECKSUM_VALIDATION", "when_required")
    try:
        system, base = _fsspec().core.url_to_fs(root.base, **options)
    except (ImportError, ValueError) as error:
        why = root.hide(" ".join(str(error).split()))
        raise CasaError(f"{root}: {why}; `casa-assets doctor` says how to install what reads s3 and https") from None
    return _WebClient(system, root) if root.is_web else _ObjectClient(system, base)


def _fsspec() -> Any:
    """The package.

    Not by `import`: keys of results count the versions of what is imported (pipeline/cache/cache_key.py). What carries
    the bytes of a mesh takes no part in what is made of them; their digest is in the key.
    """
    importlib.import_module("fsspec.core")
    importlib.import_module("fsspec.asyn")
    return importlib.import_module("fsspec")


@dataclass(frozen=True)
class _ObjectClient:
    """Buckets, and all else that lists its names with their sizes."""

    system: Any
    base: str

    def info(self, path: str) -> Info:
        return _info(self.system.info(self._at(path)))

    def scan(self, folder: str) -> dict[str, Info]:
        found = self.system.ls(self._at(folder), detail=True)
        return {posixpath.basename(one["name"].rstrip("/")): _info(one) for one in found}

    def walk(self) -> Iterator[tuple[str, Info | None]]:
        prefix = self.base.rstrip("/") + "/"
        for name, one in self.system.find(self.base, detail=True).items():
            if one["type"] != "directory" and name.startswith(prefix) and not name.endswith("/"):
                yield name[len(prefix) :], _info(one)

    def part(self, path: str, start: int, end: int) -> bytes:
        data: bytes = self.system.cat_file(self._at(path), start=start, end=end)
        return data[: end - start]

    def _at(self, path: str) -> str:
        return f"{self.base.rstrip('/')}/{path}" if path else self.base


@dataclass(frozen=True)
class _WebClient:
    """Web servers: a folder is a page of links, and of an object there may be no more than its bytes."""

    system: Any
    root: StoreRoot

    def info(self, path: str) -> Info:
        size, tag = _fsspec().asyn.sync(self.system.loop, self._head, self._at(path))
        return Info(False, size, f"store {tag} {size}" if tag else "")

    def scan(self, folder: str) -> dict[str, Info]:
        here = f"{self._at(folder).removesuffix(self.root.query).rstrip('/')}/"
        parts = urlsplit(here)
        page = self._get(here + self.root.query, 0, MAX_PAGE_BYTES)
        found: dict[str, Info] = {}
        for link in _LINK.findall(page):
            text = link.decode("utf-8", "replace")
            if text.startswith("/") and not text.startswith("//"):
                text = f"{parts.scheme}://{parts.netloc}{text}"
            name = text.removeprefix(here).removeprefix("./")
            if name.rstrip("/") not in ("", ".", "..") and not re.search(r"[?#:]|/.", name):
                found[unquote(name.rstrip("/"))] = Info(name.endswith("/"))
        return found

    def walk(self) -> Iterator[tuple[str, Info | None]]:
        waiting = [("", 0)]
        for folder, depth in waiting:
            try:
                found = steady(self.root / folder, partial(self.scan, folder))
            except (FileNotFoundError, PermissionError, StoreFault):
                if not folder:
                    raise
                yield folder, None
                continue
            for name, one in sorted(found.items()):
                path = f"{folder}/{name}" if folder else name
                if not one.is_folder:
                    yield path, one
                elif depth < DEEPEST_FOLDER:
                    waiting.append((path, depth + 1))

    def part(self, path: str, start: int, end: int) -> bytes:
        return self._get(self._at(path), start, end)

    async def _head(self, url: str) -> tuple[int | None, str]:
        """Size of a file, and its tag or time; a signed address may allow nothing but to get the file."""
        session = await self.system.set_session()
        headers = {"Accept-Encoding": "identity"}
        for ask in (session.head, session.get):
            async with ask(self.system.encode_url(url), headers=headers, allow_redirects=True) as response:
                if response.status >= 400 and ask == session.head and response.status != 404:
                    continue
                response.raise_for_status()
                said = response.headers
                size = said.get("Content-Length", "") if not said.get("Content-Encoding") else ""
                return int(size) if size.isdecimal() else None, said.get("ETag") or said.get("Last-Modified") or ""
        raise AssertionError

    def _get(self, url: str, start: int, end: int) -> bytes:
        data: bytes = _fsspec().asyn.sync(self.system.loop, self._fetch, url, start, end)
        return data

    async def _fetch(self, url: str, start: int, end: int) -> bytes:
        """A part of a file; what a server sends beyond it is not read."""
        session = await self.system.set_session()
        headers = {"Accept-Encoding": "identity"}
        if start or end < MAX_PAGE_BYTES:
            headers["Range"] = f"bytes={start}-{end - 1}"
        async with session.get(self.system.encode_url(url), headers=headers) as response:
            if response.status == 416:
                return b""
            response.raise_for_status()
            if start and response.status != 206:
                raise NoParts
            data = bytearray()
            while len(data) < end - start and (chunk := await response.content.read(1 << 20)):
                data += chunk
            return bytes(data[: end - start])

    def _at(self, path: str) -> str:
        return f"{self.root.base}/{quote(path)}{self.root.query}" if path else f"{self.root.base}{self.root.query}"


def _info(one: Mapping[str, Any]) -> Info:
    tag = next((str(one[key]) for key in _TAGS if one.get(key)), "")
    when = "" if tag else next((str(one[key]) for key in _TIMES if one.get(key)), "")
    size = one.get("size")
    state = f"store {tag}{when} {size}" if tag or when else ""
    return Info(one.get("type") == "directory", size if isinstance(size, int) else None, state)


def steady(place: StoreRoot, call: Callable[[], T], seconds: float = REQUEST_S) -> T:
    """The answer of a store to a call that may be made again.

    Args:
        place: what it is about. seconds: that it may take each time.
    Raises:
        FileNotFoundError, PermissionError, NoParts: at once. StoreFault: it failed each time.
        CasaError: as `call` raises it.
    """
    why = ""
    for number in range(TRIES):
        try:
            return _within(seconds, call)
        except (CasaError, MemoryError, NoParts, StoreFault):
            raise
        except (FileNotFoundError, NotADirectoryError):
            raise FileNotFoundError(str(place)) from None
        except PermissionError:
            raise PermissionError(str(place)) from None
        except Exception as error:  # noqa: BLE001  each client of a store raises classes of its own
            # Errors are not chained: their words may hold passwords.
            if (status := getattr(error, "status", 0)) in (404, 410):
                raise FileNotFoundError(str(place)) from None
            if status in (401, 403):
                raise PermissionError(str(place)) from None
            why = place.hide(" ".join(str(error).split()))[:200] or type(error).__name__
        if number < TRIES - 1:
            time.sleep(PAUSE_S * 2**number)
    raise StoreFault(f"{place}: {why} ({TRIES} times); check the store and the network, then run again")


def _within(seconds: float, call: Callable[[], T]) -> T:
    """The answer of a call; TimeoutError where it takes longer, and its thread is left to itself."""
    answers: list[T] = []
    errors: list[BaseException] = []

    def work() -> None:
        try:
            answers.append(call())
        except BaseException as error:  # noqa: BLE001  raised again where it was called
            errors.append(error)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(seconds)
    if errors:
        raise errors[0]
    if not answers:
        raise TimeoutError(f"no answer within {seconds:.0f} s")
    return answers[0]
