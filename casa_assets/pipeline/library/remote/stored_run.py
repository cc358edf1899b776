"""A run whose library is kept on a store: it begins with what the store has, and sends each entry as it is made.

The library on this disk is whole at any time and everything is sent from it. A store that does not answer for a while
delays what is sent and not the run; what could not be sent by its end is sent then, or by the next run.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Generator, Iterator, Set
from contextlib import closing, contextmanager
from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.pipeline.ingest.job import Event
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.remote.change import Change, Extra
from casa_assets.pipeline.library.remote.entry_list import DamagedEntry, entry_folders, entry_path
from casa_assets.pipeline.library.remote.pull import pull
from casa_assets.pipeline.library.remote.push import push, push_entry
from casa_assets.pipeline.library.remote.remote_library import RemoteLibrary
from casa_assets.pipeline.library.remote.writer_lock import WriterLock

SENDERS = 4  # a run on this machine makes far fewer entries a second than these send
AGAIN_S = 5.0  # pause after a request that failed for as long as requests are repeated
END_S = 20.0  # for requests that are under way where a run is stopped


class StoredRun:
    """One run, in the order `fetch`, `sending`, `finish`.

    Args:
        library: on this disk. remote: the same on the store. lock: by which the caller holds it.
    """

    def __init__(self, library: disk.Library, remote: RemoteLibrary, lock: WriterLock) -> None:
        self._library, self._remote, self._lock = library, remote, lock
        self._before: Set[str] = frozenset()

    def fetch(self) -> Iterator[Change]:
        """Bring what the store has and the library lacks; where both have an entry, that of the store counts."""
        with self._library.locked():
            yield from pull(self._remote, self._library, Extra.KEEP)
        self._before = entry_folders(self._library).keys()

    def sending(self, events: Generator[Event, None, None]) -> Generator[Event, None, None]:
        """Pass the events of the run on, and send the entry of each that is new."""
        has_begun = False
        with closing(events), self._senders() as send:
            for event in events:
                if not has_begun:
                    self._remote.begin()
                    has_begun = True
                if event.kind != "kept" and event.folder is not None:
                    send(event.folder)
                yield event

    def finish(self) -> Iterator[Change]:
        """Send what is still to be sent, then the books, and remove from the store what the run has removed."""
        with self._library.locked():
            gone = frozenset(self._before - entry_folders(self._library).keys())
            yield from push(self._library, self._remote, self._lock, Extra.KEEP, gone)

    @contextmanager
    def _senders(self) -> Iterator[Callable[[Path], None]]:
        """Threads that send entries in the background; what is given to them is the folder of one."""
        waiting: queue.SimpleQueue[Path | None] = queue.SimpleQueue()
        ended = threading.Event()
        work = [
            threading.Thread(target=self._send, args=(waiting, ended), name="store-send", daemon=True)
            for _ in range(SENDERS)
        ]
        for thread in work:
            thread.start()
        try:
            yield waiting.put
        finally:  # `finish` sends the rest, with more threads
            ended.set()
            for _ in work:
                waiting.put(None)
            for thread in work:
                thread.join(END_S)

    def _send(self, waiting: queue.SimpleQueue[Path | None], ended: threading.Event) -> None:
        while (folder := waiting.get()) is not None and not ended.is_set():
            try:
                self._lock.check()
                push_entry(folder, self._remote, self._remote.folder.files(entry_path(folder)))
            except DamagedEntry:
                pass  # `finish` tells
            except OutputError:
                waiting.put(folder)
                ended.wait(AGAIN_S)
