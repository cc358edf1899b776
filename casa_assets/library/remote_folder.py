"""A folder on a store that fsspec opens, such as S3 or a disk, and the lock of its one writer.

A request that fails for a reason that may pass (no answer, an overloaded server) is repeated for a while. After a
write, the stored file is looked up and compared. Addresses are shown without the user and password that they may
contain.

Writers are kept apart without comparing the clocks of machines. Each has a separate object, which it rewrites every
`BEAT_S` seconds with a higher number. A run that wants to write puts its object there, then lists all: if it is alone,
it may write. If two begin at once, each sees the other, and both step back. The object of another run is watched for
`SILENCE_S` seconds by the clock of the watching machine: if its number rises, that run goes on; if not, the run was
killed or lost, and its object is removed. On the machine of the lost run its process is looked for instead of waiting.
A writer that was stopped for longer than that (a machine that slept) finds its object gone, and ends. This takes a
store that lists at once what was written, as S3 and its likes do. On a store whose lists lag, two runs may both write;
entries stay whole then too, as each has its manifest last.
"""

from __future__ import annotations

import functools
import hashlib
import os
import re
import secrets
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ParamSpec, Self, TypeVar

from pydantic import ValidationError

from casa_assets.core.system import process_name, require
from casa_assets.errors import OutputError
from casa_assets.ingest.sources.places import hide_secrets
from casa_assets.ingest.sources.stores import open_system
from casa_assets.model.record import Record

P = ParamSpec("P")
T = TypeVar("T")
# Seconds for which a request is repeated: a server that is started again within them is not noticed.
PATIENCE_S = 120.0
# Seconds for the first one: most often the address is wrong, and the user waits.
FIRST_PATIENCE_S = 20.0
FIRST_PAUSE_S, LAST_PAUSE_S = 0.2, 10.0
# Times that a file is sent before the store is said to keep other bytes than it was sent.
MAX_SENT = 3
WRITERS = ".casa/writers"
BEAT_S, SILENCE_S, LOOK_S = 10.0, 90.0, 3.0
# What no repetition mends: rights, names.
_REFUSED = (PermissionError, IsADirectoryError, NotADirectoryError, FileExistsError)
# Names of exceptions, and of their bases, of requests that may succeed a little later: of Python, aiohttp, botocore.
_PASSING = frozenset(
    {"OSError", "EOFError", "ClientError", "ConnectionError", "HTTPClientError", "ResponseParserError"}
)
# Of requests that cannot succeed: a store that lacks the operation, no credentials, a name that cannot be.
_LASTING = frozenset({"ValueError", "NotImplementedError", "BotoCoreError"})
_MD5 = re.compile(r"[0-9a-f]{32}")


@dataclass(frozen=True, slots=True)
class StoredFile:
    """A file as the store lists it.

    Attributes:
        size: in bytes. md5: hex digits, as an object store may give them (ETag); empty if it does not. They are not
            always the MD5 of the bytes, such as with encryption, so only equal ones prove something.
    """

    size: int
    md5: str = ""

    def surely_holds(self, data: bytes) -> bool:
        """Return whether the listed size and MD5 prove that the file holds these bytes."""
        return self.size == len(data) and self.md5 == _md5(data)


class RemoteFolder:
    """A folder on a store. Paths are relative to it, with `/`; methods may be called from several threads.

    Args:
        system: file system of fsspec. path: of the folder in it. url: as the user wrote it.
        patience_s: seconds for which a request is repeated.
    """

    def __init__(self, system: Any, path: str, url: str, patience_s: float = PATIENCE_S) -> None:
        self._system, self._path, self._patience_s = system, path.rstrip("/"), patience_s
        self._is_disk = "file" in ((system.protocol,) if isinstance(system.protocol, str) else system.protocol)
        self._closed, self._has_answered = threading.Event(), False
        self.url = hide_secrets(url)

    @classmethod
    def open(cls, url: str) -> Self:
        """The folder at an address such as `s3://bucket/library`.

        Raises OutputError: the address cannot be understood, or names a kind of store that no installed package opens.
        CasaError: fsspec is not installed.
        """
        shown = hide_secrets(url)
        require("fsspec", "stores", f"{shown}: a library on a store")
        protocol = url.partition("://")[0] if "://" in url else "file"
        if "::" in url or protocol in ("http", "https"):
            raise OutputError(shown, "is no store that can be written to; give an address such as s3://bucket/lib")
        if protocol == "s3":
            require("s3fs", "stores", f"{shown}: a library on a store")
        # Many files are on their way at once, so the parts of one are not: it would be asked for its size first.
        every: dict[str, dict[str, Any]] = {"file": {"auto_mkdir": True}, "s3": {"max_concurrency": 1}}
        try:
            system, path = open_system(url, **every.get(protocol, {}))
        except ImportError as error:
            raise OutputError(shown, f"needs a package that is not installed: {error}") from error
        except (ValueError, TypeError, KeyError) as error:
            raise OutputError(shown, f"is no address of a store: {error}") from error
        return cls(system, path, url)

    def close(self) -> None:
        """Let no request be repeated any more: the run has ended."""
        self._closed.set()

    def inside(self, folder: str = "") -> tuple[list[str], dict[str, StoredFile]]:
        """Names of the folders right in a folder, sorted, and the files there by name; empty if it is not there."""
        rows: Iterable[Mapping[str, Any]] = self._ask(self._system.ls, self._full(folder), detail=True) or ()
        prefix = f"{self._full(folder)}/"
        named = [(row["name"].rstrip("/").removeprefix(prefix), row) for row in rows]
        named = [(name, row) for name, row in named if name and "/" not in name]
        files = {name: _stored(row) for name, row in named if row.get("type") == "file"}
        return sorted({name for name, row in named if row.get("type") == "directory"}), files

    def files(self, folder: str = "") -> dict[str, StoredFile]:
        """All files below a folder by their path relative to it; empty if there is no such folder."""
        rows: Mapping[str, Mapping[str, Any]] = self._ask(self._system.find, self._full(folder), detail=True) or {}
        prefix = f"{self._full(folder)}/"
        return {
            path.removeprefix(prefix): _stored(row)
            for path, row in rows.items()
            if row.get("type") == "file" and path.startswith(prefix) and not path.endswith("/")
        }

    def find(self, path: str) -> StoredFile | None:
        """A file; None if it is not there."""
        row = self._ask(self._system.info, self._full(path))
        return None if row is None or row.get("type") != "file" else _stored(row)

    def read(self, path: str) -> bytes | None:
        """The bytes of a file; None if it is not there."""
        data = self._ask(self._system.cat_file, self._full(path))
        return None if data is None else bytes(data)

    def write(self, path: str, data: bytes) -> None:
        """Put a file in place of an older one, and look whether the store holds it.

        Raises OutputError: the store cannot be written to, or keeps other bytes than it is sent.
        """
        for _ in range(MAX_SENT):
            answer = self._ask(self._put, self._full(path), data)
            if answer == _md5(data) or self.holds(path, data, self.find(path)):
                return
        message = f"keeps other bytes of {path} than were sent, {MAX_SENT} times; look at the store, then run again"
        raise OutputError(self.url, message)

    def holds(self, path: str, data: bytes, stored: StoredFile | None) -> bool:
        """Return whether a file holds these bytes; it is read if its listed size and MD5 do not decide.

        `stored`: the file as it was listed.
        """
        if stored is None or stored.size != len(data):
            return False
        return stored.surely_holds(data) or self.read(path) == data

    def remove(self, paths: Iterable[str]) -> None:
        """Remove files, in their order, as far as they are there; on a disk also folders that are empty then."""
        for path in paths:
            self._ask(self._system.rm_file, self._full(path))
            folder = Path(self._full(path)).parent
            with suppress(OSError):  # another file is in it
                while self._is_disk and folder.is_relative_to(self._path) and folder != Path(self._path):
                    folder.rmdir()
                    folder = folder.parent

    def _put(self, path: str, data: bytes) -> str:
        """Write a file; returns the MD5 of the bytes received, empty if the store does not report it."""
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
        """Return the answer to a request, or None if the file or folder is not there. Repeats after passing errors.

        Raises OutputError: the store refuses, or has not answered for as long as the folder is patient.
        """
        patience_s = self._patience_s if self._has_answered else min(self._patience_s, FIRST_PATIENCE_S)
        end, pause = time.monotonic() + patience_s, FIRST_PAUSE_S
        while True:
            try:
                answer = call(*args, **options)
                self._has_answered = True
                return answer
            except FileNotFoundError as error:
                response = getattr(error.__cause__, "response", None) or {}
                if response.get("Error", {}).get("Code") == "NoSuchBucket":  # of Amazon's S3 and its likes
                    raise OutputError(self.url, f"is not there: {_words(error)}; make the bucket first") from error
                return None
            except _REFUSED as error:
                raise OutputError(self.url, f"refuses: {_words(error)}; look at rights and credentials") from error
            except Exception as error:
                kinds = {kind.__name__ for kind in type(error).__mro__}
                if kinds.isdisjoint(_PASSING):
                    if kinds.isdisjoint(_LASTING):
                        raise
                    raise OutputError(self.url, f"cannot be used: {_words(error)}") from error
                if time.monotonic() + pause > end or self._closed.wait(pause):
                    raise OutputError(self.url, f"does not answer: {_words(error)}; run again when it does") from error
            pause = min(2 * pause, LAST_PAUSE_S)


def _words(error: BaseException) -> str:
    """Return the message of an exception on one line, without users and passwords in addresses."""
    return hide_secrets(" ".join(str(error).split())) or type(error).__name__


def _stored(row: Mapping[str, Any]) -> StoredFile:
    tag = str(row.get("ETag") or "").strip('"')
    return StoredFile(int(row.get("size") or 0), tag if _MD5.fullmatch(tag) else "")


def _md5(data: bytes) -> str:
    return hashlib.md5(data, usedforsecurity=False).hexdigest()


class Writer(Record):
    """A run that writes.

    Attributes:
        host: name of its machine. boot, space: start of that machine, and the space of its process numbers: if both
            are those of this process, `process` means the same here.
        process: number. started: when it began, in ticks after the start of the machine. beat: rises while it runs.
    """

    host: str
    boot: str
    space: str
    process: int
    started: int
    beat: int = 0

    @classmethod
    def own(cls) -> Writer:
        """This process."""
        boot, space = _machine()
        number = os.getpid()
        return cls(host=os.uname().nodename, boot=boot, space=space, process=number, started=_started(number))

    @property
    def is_running(self) -> bool | None:
        """True if it runs on this machine, False if it ran here and has ended, None if that is unknown."""
        if not self.boot or (self.boot, self.space) != _machine():
            return None
        return _started(self.process) == self.started


class WriterLock:
    """Right of this process to write to a library on a store, see `hold`."""

    def __init__(self, folder: RemoteFolder, beat_s: float = BEAT_S, silence_s: float = SILENCE_S) -> None:
        self._folder, self._beat_s, self._silence_s = folder, beat_s, silence_s
        self._path = f"{WRITERS}/{secrets.token_hex(8)}.json"
        self._writer = Writer.own()
        self._ended, self._lost = threading.Event(), False
        self._last_beat_s = _clock()
        self._guard = threading.Lock()

    def check(self) -> None:
        """Make sure that this run still holds the library; to be called before something is published or removed.

        Raises OutputError: another run has taken it over, because this one was silent for too long.
        """
        if _clock() - self._last_beat_s > self._silence_s / 3:
            self._beat()
        if self._lost:
            message = "another run has taken the library over, because this one stood still; run again when that ends"
            raise OutputError(self._folder.url, message)

    def acquire(self, report: Callable[[str], None]) -> None:
        """See `hold`."""
        while True:
            self._write()
            others = [path for path in self._paths() if path != self._path]
            if not others:
                return
            # Out of the way of another that begins too: it would wait for this one, and this one for it.
            self._folder.remove([self._path])
            for path in others:
                self._wait_until_gone(path, report)

    def release(self) -> None:
        """Let others write."""
        self._ended.set()
        with self._guard:
            self._folder.remove([self._path])

    def beat_until_released(self) -> None:
        """Keep showing others that this run goes on; runs in a separate thread."""
        while not self._ended.wait(self._beat_s):
            with suppress(OutputError):  # `check` tells; the store may answer again
                self._beat()

    def _beat(self) -> None:
        with self._guard:
            if self._ended.is_set() or self._lost:
                return
            if self._path not in self._paths():
                self._lost = True
                return
            self._write()

    def _write(self) -> None:
        begin_s = _clock()
        self._writer = self._writer.replace(beat=self._writer.beat + 1)
        self._folder.write(self._path, f"{self._writer.model_dump_json()}\n".encode())
        self._last_beat_s = begin_s

    def _paths(self) -> list[str]:
        return [f"{WRITERS}/{name}" for name in self._folder.inside(WRITERS)[1] if name.endswith(".json")]

    def _wait_until_gone(self, path: str, report: Callable[[str], None]) -> None:
        """Wait for what another run left; it is removed if that is lost. Raises OutputError if it goes on."""
        first: Writer | None = None
        begin_s = _clock()
        while (data := self._folder.read(path)) is not None:
            try:
                now = Writer.model_validate_json(data)
            except ValidationError:  # one that says nothing sensible is nobody's
                now = Writer(host="?", boot="", space="", process=0, started=0)
            first = first or now
            if now.beat != first.beat or now.is_running:
                message = f"process {now.process} on {now.host} is writing to this library; wait for it, then run again"
                raise OutputError(self._folder.url, message)
            if now.is_running is False or _clock() - begin_s > self._silence_s:
                self._folder.remove([path])
                return
            report(f"looking for {self._silence_s:.0f} s whether process {now.process} on {now.host} still writes")
            time.sleep(min(LOOK_S, self._beat_s))


@contextmanager
def hold(
    folder: RemoteFolder, report: Callable[[str], None] = lambda _: None, lock: WriterLock | None = None
) -> Iterator[WriterLock]:
    """Hold a library on a store for writing.

    `report`: called with a message on what is waited for. `lock`: with other times than usual. Raises OutputError:
    another run is writing to it, or the store cannot be written to.
    """
    lock = lock or WriterLock(folder)
    try:
        lock.acquire(report)
        threading.Thread(target=lock.beat_until_released, name="store-lock", daemon=True).start()
        yield lock
    finally:
        folder.close()
        with suppress(OutputError):  # the next run removes it; what ended this one is to be reported
            lock.release()


def _clock() -> float:
    """Seconds since the start of this machine, those that it slept included."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


@functools.cache
def _machine() -> tuple[str, str]:
    """Return ids of this machine's boot and of its process number space; empty if the system does not give them."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        return boot, str(Path("/proc/self/ns/pid").readlink())
    except (OSError, UnicodeDecodeError):
        return "", ""


def _started(process: int) -> int:
    """Return the ticks from machine start to the start of a process; 0 if it does not run. Ref: proc(5), stat."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
    except OSError:
        return 0
    # A process that has ended and was not waited for yet is none.
    return int(fields[19]) if len(fields) > 19 and fields[0] not in ("Z", "X") else 0
