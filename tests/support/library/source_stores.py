"""Stores that sources lie on: one in memory that fails as stores do, and a web server over a folder."""

from __future__ import annotations

import http.server
import re
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import fsspec
from fsspec.implementations.memory import MemoryFileSystem

PROTOCOL = "trial"


class TrialSystem(MemoryFileSystem):  # type: ignore[misc]
    """Files in memory that all clients of this process share, under `trial://`.

    Attributes:
        reads: path, start and end of every read. before: is called before every request with its name and path, and
            may raise or wait. changed: is given the path and the bytes of each read, and gives those that are sent.
        hidden: what a listing says that is not there, and what is left out of it.
    """

    protocol = PROTOCOL
    store: ClassVar[dict[str, Any]] = {}
    pseudo_dirs: ClassVar[list[str]] = [""]
    reads: ClassVar[list[tuple[str, int, int]]] = []
    before: ClassVar[Callable[[str, str], None]] = staticmethod(lambda _name, _path: None)
    changed: ClassVar[Callable[[str, bytes], bytes]] = staticmethod(lambda _path, data: data)

    @classmethod
    def begin(cls) -> None:
        """Empty and sound."""
        cls.store.clear()
        cls.pseudo_dirs[:] = [""]
        cls.reads.clear()
        cls.before = staticmethod(lambda _name, _path: None)
        cls.changed = staticmethod(lambda _path, data: data)

    @classmethod
    def _strip_protocol(cls, path: str) -> str:
        return str(super()._strip_protocol(path.replace(f"{PROTOCOL}://", "memory://", 1)))

    def info(self, path: str, **options: Any) -> dict[str, Any]:
        self.before("info", path)
        found: dict[str, Any] = super().info(path, **options)
        return found

    def find(self, path: str, *arguments: Any, **options: Any) -> Any:
        self.before("find", path)
        return super().find(path, *arguments, **options)

    def cat_file(self, path: str, start: int | None = None, end: int | None = None, **options: Any) -> bytes:
        self.before("cat_file", path)
        self.reads.append((path, start or 0, -1 if end is None else end))
        return self.changed(path, super().cat_file(path, start=start, end=end, **options))


fsspec.register_implementation(PROTOCOL, TrialSystem, clobber=True)


def put(folder: Path, url: str = f"{PROTOCOL}://data/things") -> str:
    system = TrialSystem()
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            system.pipe_file(f"{url}/{path.relative_to(folder).as_posix()}", path.read_bytes())
    return url


class _Handler(http.server.SimpleHTTPRequestHandler):
    """Files of a folder, in parts where `has_parts`, with pages that list folders."""

    has_parts = True
    log: ClassVar[list[str]] = []

    def log_message(self, format: str, *words: Any) -> None:  # noqa: A002
        self.log.append(format % words)

    def do_GET(self) -> None:
        path = Path(self.translate_path(self.path))
        wanted = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
        if not self.has_parts or wanted is None or not path.is_file():
            super().do_GET()
            return
        data = path.read_bytes()
        start, end = int(wanted[1]), min(int(wanted[2]) + 1, len(data))
        self.send_response(206 if start < end else 416)
        part = data[start:end]
        self.send_header("Content-Length", str(len(part)))
        self.end_headers()
        self.wfile.write(part)


@contextmanager
def web_server(folder: Path, has_parts: bool = True, log: list[str] | None = None) -> Iterator[str]:
    """Serve a folder on this machine; gives its address."""
    kind = type("Handler", (_Handler,), {"has_parts": has_parts, "log": [] if log is None else log})
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(kind, directory=str(folder)))
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
