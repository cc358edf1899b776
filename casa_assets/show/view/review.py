"""Serve the pages of review to the browser of the person at this machine, and write what is decided to review.csv.

One page shows one asset after the other, with what was guessed and why, and keys to decide; the other is that of the
articulated meshes (`articulate/run/review_page.py`), whose 3D models are made from the entries when they are asked for.

Only this machine can connect, and only with the address that the command prints: it holds a random word, so that no
other page in the same browser can decide anything.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Mapping, Sequence
from contextlib import suppress
from http import HTTPStatus
from http.server import ThreadingHTTPServer
from threading import Lock
from typing import Any, ClassVar
from urllib.parse import unquote

from casa_assets import registry
from casa_assets.articulate.decisions import Decisions
from casa_assets.articulate.run import review_page
from casa_assets.articulate.run.steps import NAME as STRIP
from casa_assets.articulate.run.steps import outcome_of_entry
from casa_assets.errors import CasaError, OutputError
from casa_assets.formats.gltf import asset_glb
from casa_assets.library import review
from casa_assets.library.entry import Entry, entries
from casa_assets.library.entry_files import PICTURE, Producer, file_inside, picture_of, read_asset
from casa_assets.library.library import Library
from casa_assets.library.mesh_decisions import check_category, keep_mesh_decisions
from casa_assets.model.source import UpAxis
from casa_assets.show.page.page_template import (
    SUFFIX,
    PageModels,
    model_script,
    render_template,
    viewer_name,
    viewer_script,
)
from casa_assets.show.view.server import HOST, LocalHandler

# Decisions about all parts of one mesh are longer than those about a whole one.
MAX_BODY_BYTES = 100_000
# Name of the page of articulated meshes, below the address.
ARTICULATED = "articulated"
# Folder of the models and the viewer as that page names it; they are made when they are asked for.
MODELS = "models"
_MODELS = PageModels(f"./{MODELS}", f"./{MODELS}/{viewer_name()}")
COMMAND = "casa-assets articulate SOURCES --library {library}"


class ReviewServer(ThreadingHTTPServer):
    """A server for one library, of entries `waiting` for a person, and of articulated ones on a separate page."""

    daemon_threads = True

    def __init__(self, library: Library, port: int = 0) -> None:
        """Bind a port; 0: any that is free. Raises OSError where it is taken, OutputError where an entry is damaged."""
        self.library = library
        every = list(entries(library))
        self.articulated = [entry for entry in every if entry.producer == Producer.ARTICULATE]
        others = (entry for entry in every if entry.producer != Producer.ARTICULATE)
        self.waiting: Sequence[Entry] = [entry for entry in others if review.subjects_to_review(entry)]
        self.lock = Lock()
        self.token = secrets.token_urlsafe(16)
        super().__init__((HOST, port), _Handler)
        self.address = f"http://{HOST}:{self.server_port}/{self.token}/"


class _Handler(LocalHandler):
    server: ReviewServer
    headers_of_all: ClassVar[dict[str, str]] = {"Referrer-Policy": "no-referrer"}

    def do_GET(self) -> None:  # noqa: N802  the name of the base class
        """Send a page, the picture of a row by its number, or a picture or the model of an articulated mesh."""
        name = self._name()
        kind, body = "image/png", b""
        with suppress(OutputError):
            kind, body = self._found(name) if name is not None else (kind, body)
        self.send(HTTPStatus.OK if body else HTTPStatus.NOT_FOUND, kind, body)

    def _found(self, name: str) -> tuple[str, bytes]:
        """Media type and content that a name below the address leads to; empty if it leads nowhere."""
        library, waiting, articulated = self.server.library, self.server.waiting, self.server.articulated
        if name == "":
            title = f"Review of {library.root.resolve().name}"
            return "text/html; charset=utf-8", render_page(waiting, review.cells(library), title).encode()
        if name == ARTICULATED:
            return "text/html; charset=utf-8", articulated_page(library, articulated).encode()
        if name.startswith(f"{MODELS}/"):
            return "text/javascript", script_of(library, articulated, unquote(name.removeprefix(f"{MODELS}/")))
        if name.isdigit() and int(name) < len(waiting):
            return "image/png", picture_of(library.root / waiting[int(name)].path)
        folder, _, file = unquote(name).rpartition("/")
        if file not in (STRIP, PICTURE) or all(entry.path != folder for entry in articulated):
            return "image/png", b""
        path = library.root / folder
        return "image/png", file_inside(path, file, path / file, "the file itself").read_bytes()

    def do_POST(self) -> None:  # noqa: N802  the name of the base class
        """Write what was decided: a JSON object of `sha256` and words by their names, or `decisions` on parts."""
        length, name = self.headers.get("Content-Length", ""), self._name()
        if name not in ("decide", f"decide_{ARTICULATED}") or not length.isdigit() or int(length) > MAX_BODY_BYTES:
            self.send(HTTPStatus.BAD_REQUEST, "text/plain", b"this is no decision")
            return
        try:
            decided: Any = json.loads(self.rfile.read(int(length)))
            with self.server.lock:
                if name == "decide":
                    entry = next(entry for entry in self.server.waiting if entry.sha256 == decided["sha256"])
                    words = {name: str(decided.get(name, "")).strip() for name in review.OVERRIDE_NAMES}
                    review.decide(self.server.library, entry, words)
                else:
                    entry = next(entry for entry in self.server.articulated if entry.sha256 == decided["sha256"])
                    decisions = Decisions.model_validate(decided["decisions"])
                    check_category(decisions)
                    keep_mesh_decisions(self.server.library, {entry.sha256: decisions})
        except (ValueError, KeyError, TypeError, AttributeError, StopIteration):
            self.send(HTTPStatus.BAD_REQUEST, "text/plain", b"this is no decision")
        except CasaError as error:
            self.send(HTTPStatus.BAD_REQUEST, "text/plain; charset=utf-8", str(error).encode())
        else:
            self.send(HTTPStatus.OK, "text/plain", b"")

    def _name(self) -> str | None:
        """Return the requested path below the address, or None if the token or the Host header is wrong."""
        start = f"/{self.server.token}/"
        is_here = self.headers.get("Host") == f"{HOST}:{self.server.server_port}"
        return self.path.removeprefix(start) if is_here and self.path.startswith(start) else None


def render_page(waiting: Sequence[Entry], decided: Mapping[str, Mapping[str, str]], title: str) -> str:
    """HTML of the page; `decided`: sha256 of an input -> cells of its row in review.csv, by column."""
    data = {
        "rows": [_row(number, entry, decided.get(entry.sha256, {})) for number, entry in enumerate(waiting)],
        "categories": sorted(registry.load().categories),
        "ups": [axis.value for axis in UpAxis],
    }
    return render_template(
        "review/page.html",
        title=title,
        count=len(waiting),
        data=data,
        without_scripts="review.csv of the library",
        scripts=("review/common.js", "review/page.js"),
    )


def _row(number: int, entry: Entry, cells: Mapping[str, str]) -> dict[str, Any]:
    return {
        "number": number,
        "sha256": entry.sha256,
        "id": entry.id,
        "input": entry.source_path,
        "category": entry.category,
        "size_m": [] if entry.summary is None else [round(v, 4) for v in entry.summary.extents],
        "mass_kg": None if entry.summary is None else entry.summary.mass,
        "rejected": f"{entry.code}: {entry.message}" if entry.code else "",
        "decide": list(entry.to_decide),
        "guesses": [
            [g.subject, g.value, g.confidence, g.reason] for g in entry.guesses if g.subject in review.SUBJECTS
        ],
        "set": {name: cells.get(f"set_{name}", "") for name in review.OVERRIDE_NAMES},
    }


def articulated_page(library: Library, entries: Sequence[Entry]) -> str:
    """Return the HTML of the page; entries of which no record is left are not on it."""
    found = [outcome for entry in entries if (outcome := outcome_of_entry(library, entry)) is not None]
    return review_page.render_page(library, found, COMMAND.format(library=library.root), is_served=True, models=_MODELS)


def script_of(library: Library, entries: Sequence[Entry], name: str) -> bytes:
    """A file of the folder of models: the viewer, or the model of an accepted entry; else empty. Raises OutputError."""
    if name == viewer_name():
        return viewer_script()
    entry = next((one for one in entries if one.accepted and f"{one.id}{SUFFIX}" == name), None)
    if entry is None:
        return b""
    return model_script(entry.id, asset_glb(read_asset(library.root / entry.path), with_layers=True))
