"""Serve the page of review to the browser of the person at this machine, and write what is decided to review.csv.

Only this machine can connect, and only with the address that the command prints: it holds a random word, so that no
other page in the same browser can decide anything.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Sequence
from http import HTTPStatus
from http.server import ThreadingHTTPServer
from threading import Lock
from typing import Any, ClassVar
from urllib.parse import unquote

from casa_assets.articulate.decisions import Decisions
from casa_assets.errors import CasaError, OutputError
from casa_assets.pipeline.articulate import review_file
from casa_assets.pipeline.articulate.strip import NAME as STRIP
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library import review
from casa_assets.pipeline.library.entry_files import PICTURE, file_inside, picture_of
from casa_assets.pipeline.library.identity import Producer
from casa_assets.pipeline.local_server import HOST, LocalHandler
from casa_assets.pipeline.reports.entry import Entry, entries
from casa_assets.pipeline.review.articulated import MODELS, articulated_page, script_of
from casa_assets.pipeline.review.page import render_page

# What is decided about all parts of one mesh is longer than what is decided about a whole one.
MAX_BODY_BYTES = 100_000
# Name of the page of articulated meshes, below the address.
ARTICULATED = "articulated"


class ReviewServer(ThreadingHTTPServer):
    """A server for one library.

    Attributes:
        address: what to open in a browser. waiting: entries that a person has to decide about, as the library is now.
        articulated: entries of `casa-assets articulate`, which have a page of their own. written: how often something
            was decided.
    """

    daemon_threads = True

    def __init__(self, library: disk.Library, port: int = 0) -> None:
        """Bind a port; 0: any that is free. Raises OSError where it is taken, OutputError where an entry is damaged."""
        self.library = library
        every = list(entries(library))
        self.articulated = [entry for entry in every if entry.producer == Producer.ARTICULATE]
        others = (entry for entry in every if entry.producer != Producer.ARTICULATE)
        self.waiting: Sequence[Entry] = [entry for entry in others if review.subjects_to_review(entry)]
        self.written = 0
        self.lock = Lock()
        self.token = secrets.token_urlsafe(16)
        super().__init__((HOST, port), _Handler)
        self.address = f"http://{HOST}:{self.server_port}/{self.token}/"


class _Handler(LocalHandler):
    """Answers for the page, its pictures, and what is decided."""

    server: ReviewServer
    headers_of_all: ClassVar[dict[str, str]] = {"Referrer-Policy": "no-referrer"}

    def do_GET(self) -> None:  # noqa: N802  the name of the base class
        """Send a page, the picture of a row by its number, or a picture or the model of an articulated mesh."""
        name = self._name()
        if name == "":
            title = f"Review of {self.server.library.root.resolve().name}"
            page = render_page(self.server.waiting, review.cells(self.server.library), title)
            self.send(HTTPStatus.OK, "text/html; charset=utf-8", page.encode())
        elif name is not None and name.isdigit() and int(name) < len(self.server.waiting):
            folder = self.server.library.root / self.server.waiting[int(name)].path
            try:
                picture = picture_of(folder)
            except OutputError:
                picture = b""
            self.send(HTTPStatus.OK if picture else HTTPStatus.NOT_FOUND, "image/png", picture)
        elif name == ARTICULATED:
            page = articulated_page(self.server.library, self.server.articulated)
            self.send(HTTPStatus.OK, "text/html; charset=utf-8", page.encode())
        elif name is not None and name.startswith(f"{MODELS}/"):
            try:
                script = script_of(
                    self.server.library, self.server.articulated, unquote(name.removeprefix(f"{MODELS}/"))
                )
            except OutputError:
                script = b""
            self.send(HTTPStatus.OK if script else HTTPStatus.NOT_FOUND, "text/javascript", script)
        else:
            picture = self._picture_of_articulated(unquote(name or ""))
            self.send(HTTPStatus.OK if picture else HTTPStatus.NOT_FOUND, "image/png", picture)

    def _picture_of_articulated(self, place: str) -> bytes:
        """The strip or the picture of an articulated mesh by its place in the library; empty where it is neither."""
        folder, _, name = place.rpartition("/")
        if name not in (STRIP, PICTURE) or all(entry.path != folder for entry in self.server.articulated):
            return b""
        path = self.server.library.root / folder
        try:
            return file_inside(path, name, path / name, "the file itself").read_bytes()
        except OutputError:
            return b""

    def do_POST(self) -> None:  # noqa: N802  the name of the base class
        """Write what was decided: a JSON object of `sha256` and words by their names, or `decisions` on parts."""
        length, name = self.headers.get("Content-Length", ""), self._name()
        if name not in ("decide", f"decide_{ARTICULATED}") or not length.isdigit() or int(length) > MAX_BODY_BYTES:
            self.send(HTTPStatus.BAD_REQUEST, "text/plain", b"this is no decision")
            return
        try:
            said: Any = json.loads(self.rfile.read(int(length)))
            with self.server.lock:
                (self._decide if name == "decide" else self._decide_parts)(said)
                self.server.written += 1
        except (ValueError, KeyError, TypeError, AttributeError, StopIteration):
            self.send(HTTPStatus.BAD_REQUEST, "text/plain", b"this is no decision")
        except CasaError as error:
            self.send(HTTPStatus.BAD_REQUEST, "text/plain; charset=utf-8", str(error).encode())
        else:
            self.send(HTTPStatus.OK, "text/plain", b"")

    def _decide(self, said: Any) -> None:
        """Write one row of review.csv. Raises OutputError, or an error of the types of a wrong object."""
        entry = next(entry for entry in self.server.waiting if entry.sha256 == said["sha256"])
        words = {name: str(said.get(name, "")).strip() for name in review.OVERRIDE_NAMES}
        review.decide(self.server.library, entry, words)

    def _decide_parts(self, said: Any) -> None:
        """Write the decisions on one articulated mesh into review.json. Raises likewise, and UnknownId."""
        entry = next(entry for entry in self.server.articulated if entry.sha256 == said["sha256"])
        decisions = Decisions.model_validate(said["decisions"])
        review_file.check_category(decisions)
        review_file.keep(self.server.library, {entry.sha256: decisions})

    def _name(self) -> str | None:
        """What is asked for, below the address; None where somebody does not know it or came by another name."""
        start = f"/{self.server.token}/"
        is_here = self.headers.get("Host") == f"{HOST}:{self.server.server_port}"
        return self.path.removeprefix(start) if is_here and self.path.startswith(start) else None
