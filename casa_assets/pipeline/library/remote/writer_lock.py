"""One writer at a time for a library on a store, without comparing the clocks of machines.

Each writer has an object of its own, which it rewrites every `BEAT_S` seconds with a higher number. A run that wants
to write puts its object there, then lists all: alone, it may write. Of two that begin at once each sees the other, and
both step back. What another one left is watched for `SILENCE_S` seconds, measured by the watching machine alone: a
number that rises is that of a run which goes on; one that stands still was killed or lost, and its object is removed.
On the machine of the lost run, its process is looked for in place of waiting.

A writer that was stopped for longer than that (a machine that slept) finds its object gone, and ends. This takes a
store that lists at once what was written, as S3 and its likes do; on one whose lists lag behind two runs may both
write. Entries stay whole then too, as each has its manifest last, and the last one to be written counts.
"""

from __future__ import annotations

import os
import secrets
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pydantic import ValidationError

from casa_assets.errors import OutputError
from casa_assets.model.record import Record
from casa_assets.pipeline.library.remote.remote_folder import RemoteFolder

FOLDER = ".casa/writers"
BEAT_S, SILENCE_S, LOOK_S = 10.0, 90.0, 3.0


class Writer(Record):
    """A run that writes.

    Attributes:
        host: name of its machine. boot, space: start of that machine, and the space of its process numbers: where both
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
        return cls(
            host=os.uname().nodename,
            boot=_text(Path("/proc/sys/kernel/random/boot_id")),
            space=_link(Path("/proc/self/ns/pid")),
            process=os.getpid(),
            started=_started(os.getpid()),
        )

    @property
    def is_running(self) -> bool | None:
        """True if it runs on this machine, False if it ran here and does no more, None where that cannot be told."""
        own = Writer.own()
        if not self.boot or (self.boot, self.space) != (own.boot, own.space):
            return None
        return _started(self.process) == self.started


class WriterLock:
    """Right of this process to write to a library on a store, see `hold`."""

    def __init__(self, folder: RemoteFolder, beat_s: float = BEAT_S, silence_s: float = SILENCE_S) -> None:
        self._folder, self._beat_s, self._silence_s = folder, beat_s, silence_s
        self._path = f"{FOLDER}/{secrets.token_hex(8)}.json"
        self._writer = Writer.own()
        self._ended, self._lost = threading.Event(), False
        self._last_beat_s = _clock()
        self._guard = threading.Lock()

    def check(self) -> None:
        """Make sure that this run still holds the library; to be called before something is published or removed.

        Raises:
            OutputError: another run has taken it over, because this one was silent for too long.
        """
        if _clock() - self._last_beat_s > self._silence_s / 3:
            self._beat()
        if self._lost:
            message = "another run has taken the library over, because this one stood still; run again when that ends"
            raise OutputError(self._folder.url, message)

    def acquire(self, told: Callable[[str], None]) -> None:
        """See `hold`."""
        while True:
            self._write()
            others = [path for path in _paths(self._folder) if path != self._path]
            if not others:
                return
            # Out of the way of another that begins too: it would wait for this one, and this one for it.
            self._folder.remove([self._path])
            for path in others:
                self._wait_until_gone(path, told)

    def release(self) -> None:
        """Let others write."""
        self._ended.set()
        with self._guard:
            self._folder.remove([self._path])

    def beat_until_released(self) -> None:
        """Tell others that this run goes on; runs in a thread of its own."""
        while not self._ended.wait(self._beat_s):
            with suppress(OutputError):  # `check` tells; the store may answer again
                self._beat()

    def _beat(self) -> None:
        with self._guard:
            if self._ended.is_set() or self._lost:
                return
            if self._path not in _paths(self._folder):
                self._lost = True
                return
            self._write()

    def _write(self) -> None:
        begin_s = _clock()
        self._writer = self._writer.replace(beat=self._writer.beat + 1)
        self._folder.write(self._path, f"{self._writer.model_dump_json()}\n".encode())
        self._last_beat_s = begin_s

    def _wait_until_gone(self, path: str, told: Callable[[str], None]) -> None:
        """Wait for what another run left; it is removed if that is lost. Raises OutputError where it goes on."""
        first: Writer | None = None
        begin_s = _clock()
        while (now := _read(self._folder, path)) is not None:
            first = first or now
            if now.beat != first.beat or now.is_running:
                message = f"process {now.process} on {now.host} is writing to this library; wait for it, then run again"
                raise OutputError(self._folder.url, message)
            if now.is_running is False or _clock() - begin_s > self._silence_s:
                self._folder.remove([path])
                return
            told(f"looking for {self._silence_s:.0f} s whether process {now.process} on {now.host} still writes")
            time.sleep(min(LOOK_S, self._beat_s))


@contextmanager
def hold(
    folder: RemoteFolder, told: Callable[[str], None] = lambda _: None, lock: WriterLock | None = None
) -> Iterator[WriterLock]:
    """Hold a library on a store for writing.

    Args:
        told: called with what is waited for. lock: with other times than usual.
    Raises:
        OutputError: another run is writing to it, or the store cannot be written to.
    """
    lock = lock or WriterLock(folder)
    try:
        lock.acquire(told)
        threading.Thread(target=lock.beat_until_released, name="store-lock", daemon=True).start()
        yield lock
    finally:
        folder.close()
        with suppress(OutputError):  # the next run removes it; what ended this one is to be told
            lock.release()


def _paths(folder: RemoteFolder) -> list[str]:
    return [f"{FOLDER}/{name}" for name in folder.inside(FOLDER)[1] if name.endswith(".json")]


def _read(folder: RemoteFolder, path: str) -> Writer | None:
    """What a writer says of itself; None where it is gone. One that says nothing sensible is nobody's."""
    data = folder.read(path)
    if data is None:
        return None
    try:
        return Writer.model_validate_json(data)
    except ValidationError:
        return Writer(host="?", boot="", space="", process=0, started=0)


def _clock() -> float:
    """Seconds since the start of this machine, those that it slept included."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


def _started(process: int) -> int:
    """Ticks between the start of the machine and that of a process; 0 where there is none. Ref: proc(5), stat."""
    text = _text(Path(f"/proc/{process}/stat"))
    fields = text.rpartition(")")[2].split()
    # A process that has ended and was not waited for yet is none.
    return int(fields[19]) if len(fields) > 19 and fields[0] not in ("Z", "X") else 0


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError):
        return ""


def _link(path: Path) -> str:
    try:
        return str(path.readlink())
    except OSError:
        return ""
