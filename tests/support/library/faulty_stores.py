"""A store in memory that fails as stores do: writes that are cut off, listings that lag behind, errors, slow calls."""

from __future__ import annotations

import errno
import threading
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

from fsspec.implementations.memory import MemoryFileSystem

ROOT = "/library"


class Killed(BaseException):
    """The process was killed: nothing after it happens."""


class FaultyStore(MemoryFileSystem):  # type: ignore[misc]
    """Files in memory, of this store alone.

    Attributes:
        killed_after: requests that change something and are still done; the one after them is cut off in its middle.
        fails: is given the name of each request and its number among those; true where it fails.
        cuts: is given the path and the number of each write; true where half of the bytes are kept without an error.
        lag: changes that a listing does not show yet. pause_s: of each request.
        counts: requests by name; changes: names and paths of those that changed something.
    """

    cachable = False

    def __init__(self) -> None:
        super().__init__(global_store=False, skip_instance_cache=True)
        self.killed_after: int | None = None
        self.fails: Callable[[str, int], bool] = lambda _name, _number: False
        self.cuts: Callable[[str, int], bool] = lambda _path, _number: False
        self.lag, self.pause_s = 0, 0.0
        self.counts: Counter[str] = Counter()
        self.changes: list[tuple[str, str]] = []
        self._states: list[dict[str, bytes]] = [{}]
        self._guard = threading.RLock()

    @property
    def content(self) -> dict[str, bytes]:
        """Bytes of all files by their path in the library."""
        return {path.removeprefix(f"{ROOT}/"): file.getvalue() for path, file in sorted(self.store.items())}

    def revive(self) -> None:
        """No fault any more."""
        self.killed_after, self.lag, self.pause_s = None, 0, 0.0
        self.fails = self.cuts = lambda _name, _number: False

    def pipe_file(self, path: str, value: bytes, mode: str = "overwrite", **options: Any) -> None:
        with self._guard:
            self._request("pipe_file")
            is_cut = self.cuts(path.removeprefix(f"{ROOT}/"), self.counts["pipe_file"])
            if self._is_last():
                super().pipe_file(path, value[: len(value) // 2], mode, **options)
                raise Killed
            super().pipe_file(path, value[: len(value) // 2] if is_cut else value, mode, **options)
            self._changed("pipe_file", path)

    def rm_file(self, path: str) -> None:
        with self._guard:
            self._request("rm_file")
            if self._is_last():
                raise Killed
            if self._strip_protocol(path) not in self.store:
                raise FileNotFoundError(path)
            super().rm_file(path)
            self._changed("rm_file", path)

    def cat_file(self, path: str, start: int | None = None, end: int | None = None, **options: Any) -> Any:
        with self._guard:
            self._request("cat_file")
            return super().cat_file(path, start, end, **options)

    def info(self, path: str, **options: Any) -> Any:
        with self._guard:
            self._request("info")
            return super().info(path, **options)

    def ls(self, path: str, detail: bool = True, **options: Any) -> Any:
        return self._listed("ls", lambda store: MemoryFileSystem.ls(store, path, detail, **options))

    def find(self, path: str, maxdepth: int | None = None, withdirs: bool = False, **options: Any) -> Any:
        return self._listed("find", lambda store: MemoryFileSystem.find(store, path, maxdepth, withdirs, **options))

    def _listed(self, name: str, look: Callable[[MemoryFileSystem], Any]) -> Any:
        with self._guard:
            self._request(name)
            if not self.lag:
                return look(self)
            old = MemoryFileSystem(global_store=False, skip_instance_cache=True)
            for path, data in self._states[max(0, len(self._states) - 1 - self.lag)].items():
                old.pipe_file(f"{ROOT}/{path}", data)
            return look(old)

    def _request(self, name: str) -> None:
        if self.killed_after is not None and self.killed_after < 0:
            raise Killed
        self.counts[name] += 1
        time.sleep(self.pause_s)
        if self.fails(name, self.counts[name]):
            raise OSError(errno.EIO, "the server is on fire")

    def _is_last(self) -> bool:
        if self.killed_after is None:
            return False
        self.killed_after -= 1
        return self.killed_after < 0

    def _changed(self, name: str, path: str) -> None:
        self.changes.append((name, path.removeprefix(f"{ROOT}/")))
        self._states.append(self.content)
