"""Serve the page of review to the browser of the person at this machine, and write what is decided to review.csv.

Only this machine can connect, and only with the address that the command prints: it holds a random word, so that no
other page in the same browser can decide anything.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Sequence
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Lock
from typing import Any

from casa_assets.errors import OutputError
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library import review
from casa_assets.pipeline.library.entry_files import picture_of
from casa_assets.pipeline.reports.entry import Entry, entries
from casa_assets.pipeline.review.page import render_page

HOST = "127.0.0.1"
MAX_BODY_BYTES = 10_000


class ReviewServer(ThreadingHTTPServer):
    """A server for one library.

    Attributes:
        address: what to open in a browser. waiting: entries that a person has to decide about, as the library is now.
        written: how often something was decided.
    """

    daemon_threads = True

    def __init__(self, library: disk.Library, port: int = 0) -> None:
        """Bind a port; 0: any that is free. Raises OSError where it is taken, OutputError where an entry is damaged."""
        self.library = library
        self.waiting: Sequence[Entry] = [entry for entry in entries(library) if review.subjects_to_review(entry)]
        self.written = 0
        self.lock = Lock()
        self.token = secrets.token_urlsafe(16)
        super().__init__((HOST, port), _Handler)
        self.address = f"http://{HOST}:{self.server_port}/{self.token}/"


class _Handler(BaseHTTPRequestHandler):
    """Answers for the page, its pictures, and what is decided."""

    server: ReviewServer
    # What is behind a name of ours that a page elsewhere has made point here, is not served.
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        """Send the page, or the picture of a row by its number."""
        name = self._name()
        if name == "":
            title = f"Review of {self.server.library.root.resolve().name}"
            page = render_page(self.server.waiting, review.cells(self.server.library), title)
            self._send(HTTPStatus.OK, "text/html; charset=utf-8", page.encode())
        elif name is not None and name.isdigit() and int(name) < len(self.server.waiting):
            folder = self.server.library.root / self.server.waiting[int(name)].path
            try:
                picture = picture_of(folder)
            except OutputError:
                picture = b""
            self._send(HTTPStatus.OK if picture else HTTPStatus.NOT_FOUND, "image/png", picture)
        else:
            self._send(HTTPStatus.NOT_FOUND, "text/plain", b"there is no such page")

    def do_POST(self) -> None:
        """Write one row: a JSON object of `sha256` and words by their names, such as `category`."""
        length = self.headers.get("Content-Length", "")
        if self._name() != "decide" or not length.isdigit() or int(length) > MAX_BODY_BYTES:
            self._send(HTTPStatus.BAD_REQUEST, "text/plain", b"this is no decision")
            return
        try:
            said: Any = json.loads(self.rfile.read(int(length)))
            entry = next(entry for entry in self.server.waiting if entry.sha256 == said["sha256"])
            words = {name: str(said.get(name, "")).strip() for name in review.OVERRIDE_NAMES}
            with self.server.lock:
                review.decide(self.server.library, entry, words)
                self.server.written += 1
        except (ValueError, KeyError, TypeError, AttributeError, StopIteration):
            self._send(HTTPStatus.BAD_REQUEST, "text/plain", b"this is no decision")
        except OutputError as error:
            self._send(HTTPStatus.BAD_REQUEST, "text/plain; charset=utf-8", str(error).encode())
        else:
            self._send(HTTPStatus.OK, "text/plain", b"")

    def _name(self) -> str | None:
        """What is asked for, below the address; None where somebody does not know it or came by another name."""
        start = f"/{self.server.token}/"
        is_here = self.headers.get("Host") == f"{HOST}:{self.server.server_port}"
        return self.path.removeprefix(start) if is_here and self.path.startswith(start) else None

    def _send(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        self.send_response(status)
        for name, value in (
            ("Content-Type", kind),
            ("Content-Length", str(len(body))),
            ("Cache-Control", "no-store"),
            ("X-Content-Type-Options", "nosniff"),
            ("Referrer-Policy", "no-referrer"),
        ):
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002  the name of the base class
        """Say nothing: the terminal belongs to the command."""
