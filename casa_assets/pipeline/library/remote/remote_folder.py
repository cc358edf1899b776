"""A folder on a store that fsspec opens: an object store such as S3, or a disk. Every access to a store is here.

A request that fails for a reason that may pass (no answer, an overloaded server) is repeated for a while. What is
written is looked up again and compared. Addresses are told without the user and password that they may contain.
"""

from __future__ import annotations

import functools
import hashlib
import os
import re
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, ParamSpec, TypeVar

from casa_assets.errors import OutputError
from casa_assets.ingest.sources.places import hide_secrets
from casa_assets.pipeline.optional_packages import require
from casa_assets.pipeline.process_name import process_name

P = ParamSpec("P")
T = TypeVar("T")
# Seconds for which a request is repeated: a server that is started again within them is not noticed.
PATIENCE_S = 120.0
# Seconds for the first one: most often the address is wrong, and the user waits.
FIRST_PATIENCE_S = 20.0
FIRST_PAUSE_S, LAST_PAUSE_S = 0.2, 10.0
# Times that a file is sent before the store is said to keep other bytes than it was sent.
MAX_SENT = 3
# What no repetition mends: rights, names, a store that lacks the operation.
_LASTING = (PermissionError, IsADirectoryError, NotADirectoryError, FileExistsError)
_MD5 = re.compile(r"[0-9a-f]{32}")
# Options of file systems. Requests are repeated here and not by botocore too, whose times would multiply. Many files
# are on their way at once, so the parts of one are not: it would be asked for its size first.
_OPTIONS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "file": {"auto_mkdir": True},
        "s3": {"config_kwargs": {"retries": {"mode": "standard", "total_max_attempts": 1}}, "max_concurrency": 1},
    }
)


@dataclass(frozen=True, slots=True)
class StoredFile:
    """A file as the store lists it.

    Attributes:
        size: in bytes. md5: hex digits, as an object store may give them (ETag); empty where it tells none. They are
            not always the MD5 of the bytes, such as with encryption, so only equal ones prove something.
    """

    size: int
    md5: str = ""

    def surely_holds(self, data: bytes) -> bool:
        """True if the store says so much of the file that it holds these bytes."""
        return self.size == len(data) and self.md5 == _md5(data)


class RemoteFolder:
    """A folder on a store. Paths are relative to it, with `/`; methods may be called from several threads.

    Args:
        system: file system of fsspec. path: of the folder in it. url: as the user wrote it.
        patience_s: seconds for which a request is repeated.
    """

    def __init__(self, system: Any, path: str, url: str, patience_s: float = PATIENCE_S) -> None:
        self._system, self._path, self._patience_s = system, path.rstrip("/"), patience_s
        self._is_disk = "file" in _protocols(system)
        self._closed, self._has_answered = threading.Event(), False
        self.url = hide_secrets(url)

    @classmethod
    def open(cls, url: str, patience_s: float = PATIENCE_S) -> RemoteFolder:
        """The folder at an address such as `s3://bucket/library`.

        Raises:
            OutputError: the address cannot be understood, or names a kind of store that no installed package opens.
            CasaError: fsspec is not installed.
        """
        require("fsspec", "stores", f"{hide_secrets(url)}: a library on a store")
        from fsspec.core import url_to_fs
        from fsspec.utils import get_protocol

        protocol = get_protocol(url)
        if "::" in url or protocol in ("http", "https"):
            raise OutputError(
                hide_secrets(url), "is no store that can be written to; give an address such as s3://bucket/lib"
            )
        # Stores are written to by others too, so nothing that was listed before counts.
        options = {**_OPTIONS.get(protocol, {}), "use_listings_cache": False, "skip_instance_cache": True}
        if protocol == "s3":
            require("s3fs", "stores", f"{hide_secrets(url)}: a library on a store")
        try:
            system, path = url_to_fs(url, **options)
        except ImportError as error:
            raise OutputError(hide_secrets(url), f"needs a package that is not installed: {error}") from error
        except (ValueError, TypeError, KeyError) as error:
            raise OutputError(hide_secrets(url), f"is no address of a store: {error}") from error
        return cls(system, path, url, patience_s)

    def close(self) -> None:
        """Let no request be repeated any more: the run has ended."""
        self._closed.set()

    def inside(self, folder: str = "") -> tuple[list[str], dict[str, StoredFile]]:
        """Names of the folders right in a folder, sorted, and the files there by name; empty where it is not there."""
        rows: Iterable[Mapping[str, Any]] = self._ask(self._system.ls, self._full(folder), detail=True) or ()
        prefix = f"{self._full(folder)}/"
        named = [(row["name"].rstrip("/").removeprefix(prefix), row) for row in rows]
        named = [(name, row) for name, row in named if name and "/" not in name]
        files = {name: _stored(row) for name, row in named if row.get("type") == "file"}
        return sorted({name for name, row in named if row.get("type") == "directory"}), files

    def files(self, folder: str = "") -> dict[str, StoredFile]:
        """All files below a folder by their path relative to it; empty where there is no such folder."""
        rows: Mapping[str, Mapping[str, Any]] = self._ask(self._system.find, self._full(folder), detail=True) or {}
        prefix = f"{self._full(folder)}/"
        return {
            path.removeprefix(prefix): _stored(row)
            for path, row in rows.items()
            if row.get("type") == "file" and path.startswith(prefix) and not path.endswith("/")
        }

    def find(self, path: str) -> StoredFile | None:
        """A file; None where it is not there."""
        row = self._ask(self._system.info, self._full(path))
        return None if row is None or row.get("type") != "file" else _stored(row)

    def read(self, path: str) -> bytes | None:
        """The bytes of a file; None where it is not there."""
        data = self._ask(self._system.cat_file, self._full(path))
        return None if data is None else bytes(data)

    def write(self, path: str, data: bytes) -> None:
        """Put a file in place of an older one, and look whether the store holds it.

        Raises:
            OutputError: the store cannot be written to, or keeps other bytes than it is sent.
        """
        for _ in range(MAX_SENT):
            answer = self._ask(self._put, self._full(path), data)
            if answer == _md5(data) or self.holds(path, data, self.find(path)):
                return
        message = f"keeps other bytes of {path} than were sent, {MAX_SENT} times; look at the store, then run again"
        raise OutputError(self.url, message)

    def holds(self, path: str, data: bytes, stored: StoredFile | None) -> bool:
        """True if a file holds these bytes; it is read where what the store says of it does not tell.

        Args:
            stored: the file as it was listed.
        """
        if stored is None or stored.size != len(data):
            return False
        return stored.surely_holds(data) or self.read(path) == data

    def remove(self, paths: Iterable[str]) -> None:
        """Remove files, in their order, as far as they are there."""
        for path in paths:
            self._ask(self._system.rm_file, self._full(path))
            if self._is_disk:  # other stores have no folders
                self._remove_empty(Path(self._full(path)).parent)

    def _remove_empty(self, folder: Path) -> None:
        while folder.is_relative_to(self._path) and folder != Path(self._path):
            try:
                folder.rmdir()
            except OSError:  # another file is in it
                return
            folder = folder.parent

    def _put(self, path: str, data: bytes) -> str:
        """Write a file; returns the MD5 of what was received, empty where the store does not tell."""
        if not self._is_disk:
            answer = self._system.pipe_file(path, data)
            return _stored(answer).md5 if isinstance(answer, Mapping) else ""
        # On a disk a file grows while it is written. An object appears whole.
        fresh = f"{path}.{process_name()}.part"
        self._system.pipe_file(fresh, data)
        os.replace(fresh, path)  # noqa: PTH105
        return ""

    def _full(self, path: str) -> str:
        return f"{self._path}/{path}" if path else self._path

    def _ask(self, call: Callable[P, T], *args: P.args, **options: P.kwargs) -> T | None:
        """What a request answers; None where the file or folder is not there. Repeats what may pass.

        Raises:
            OutputError: the store refuses, or has not answered for as long as the folder is patient.
        """
        patience_s = self._patience_s if self._has_answered else min(self._patience_s, FIRST_PATIENCE_S)
        end = time.monotonic() + patience_s
        for pause in _pauses():
            try:
                answer = call(*args, **options)
                self._has_answered = True
                return answer
            except FileNotFoundError as error:
                if _is_whole_store_missing(error):
                    raise OutputError(self.url, f"is not there: {_words(error)}; make the bucket first") from error
                return None
            except _LASTING as error:
                raise OutputError(self.url, f"refuses: {_words(error)}; look at rights and credentials") from error
            except _passing() as error:
                if time.monotonic() + pause > end or self._closed.wait(pause):
                    raise OutputError(self.url, f"does not answer: {_words(error)}; run again when it does") from error
            except _refusals() as error:
                raise OutputError(self.url, f"cannot be used: {_words(error)}") from error
        raise AssertionError("pauses have no end")


def _pauses() -> Iterator[float]:
    pause = FIRST_PAUSE_S
    while True:
        yield pause
        pause = min(2 * pause, LAST_PAUSE_S)


@functools.cache
def _passing() -> tuple[type[Exception], ...]:
    """Exceptions of requests that may succeed a little later: OSError, and those of the packages that are there."""
    found: list[type[Exception]] = [OSError, EOFError]
    try:
        from botocore.exceptions import ConnectionError as NoConnection
        from botocore.exceptions import HTTPClientError
        from botocore.parsers import ResponseParserError

        found += [NoConnection, HTTPClientError, ResponseParserError]
    except ImportError:
        pass
    try:
        from aiohttp import ClientError

        found.append(ClientError)
    except ImportError:
        pass
    return tuple(found)


@functools.cache
def _refusals() -> tuple[type[Exception], ...]:
    """Exceptions of requests that cannot succeed: no credentials, a name that cannot be."""
    found: list[type[Exception]] = [ValueError, NotImplementedError]
    try:
        from botocore.exceptions import BotoCoreError

        found.append(BotoCoreError)
    except ImportError:
        pass
    return tuple(found)


def _is_whole_store_missing(error: FileNotFoundError) -> bool:
    """True if it is the bucket that is missing, not a file in it. Ref: error codes of Amazon S3."""
    response = getattr(error.__cause__, "response", None) or {}
    return bool(response.get("Error", {}).get("Code") == "NoSuchBucket")


def _words(error: BaseException) -> str:
    """What an exception says, without users and passwords in addresses, on one line."""
    return hide_secrets(" ".join(str(error).split())) or type(error).__name__


def _protocols(system: Any) -> tuple[str, ...]:
    named = system.protocol
    return (named,) if isinstance(named, str) else tuple(named)


def _stored(row: Mapping[str, Any]) -> StoredFile:
    tag = str(row.get("ETag") or "").strip('"')
    return StoredFile(int(row.get("size") or 0), tag if _MD5.fullmatch(tag) else "")


def _md5(data: bytes) -> str:
    return hashlib.md5(data, usedforsecurity=False).hexdigest()
