"""Serve the page of a subject, its models and the steps of its state machines, to browsers on this machine.

Models are made in the background, one at a time; the last few are kept in memory.

One port and relative addresses are used, so that it works through `ssh -L` unchanged. The server listens on 127.0.0.1
alone and refuses requests from other sites: the Host header has to name this machine (which excludes a stranger's name
that resolves to it), and POST requests have to come from the page itself. No secret token is needed: only the subject,
kitchens of the registry, and their reports can be requested, and nothing is written except the cache.
"""

from __future__ import annotations

import ipaddress
import json
import os
import re
import sys
import time
import traceback
import webbrowser
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path, PurePosixPath
from threading import Lock, Thread
from typing import Any, ClassVar
from urllib.parse import unquote, urlsplit

from markupsafe import Markup

from casa_assets.errors import CasaError, OutputError
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import draw_surfaces, ordered_surfaces, resolve
from casa_assets.library.entry_files import file_inside
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.files import SHARED
from casa_assets.show.page.page_template import render_template, viewer_script
from casa_assets.show.view.model import REPORT, Model, ShowProgress, parse_step, step_machine, to_json, with_style
from casa_assets.show.view.subject import Kitchen, Subject

HOST = "127.0.0.1"
SSH_PORT = "22"
MAX_BODY_BYTES = 100_000
JSON = "application/json"
# Files beside a scene or an asset that its report shows; nothing else of the disk is served.
KINDS = {".html": "text/html; charset=utf-8", ".png": "image/png", ".js": "text/javascript", ".json": JSON}
MAX_SEED = 2**31
_VIEWER = re.compile(rf"{SHARED}/viewer_[0-9a-f]{{12}}\.js")
_LINK = re.compile(r'(?:src|href|data-model)="([^"]+)"')
KEPT = 8  # models in memory; a kitchen takes some tens of megabytes
Maker = Callable[[Subject, ShowProgress], Model]


def open_in_browser(address: str) -> None:
    """Open a page that is about to be served. A text browser waits for the page, so this does not wait for it."""
    Thread(target=webbrowser.open, args=(address,), daemon=True).start()


class LocalHandler(BaseHTTPRequestHandler):
    """Answers that no browser keeps; `headers_of_all` are those that each answer of a server has besides."""

    protocol_version = "HTTP/1.1"
    headers_of_all: ClassVar[dict[str, str]]

    def send(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        """Send an answer whole; `kind`: its media type."""
        self.send_response(status)
        for name, value in {
            "Content-Type": kind,
            "Content-Length": str(len(body)),
            "Cache-Control": "no-store",
            "X-Content-Type-Options": "nosniff",
            **self.headers_of_all,
        }.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002  the name of the base class
        """Say nothing: the terminal belongs to the command."""


class _Job:
    """A model that was ordered, written by the thread that makes it, read by all; `step`: as for ShowProgress."""

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self.begin = time.monotonic()
        self.step, self.error, self.took = ("waiting for another", 0, 0), "", 0.0
        self.model: Model | None = None

    @property
    def is_over(self) -> bool:
        return self.model is not None or bool(self.error)

    @property
    def progress(self) -> dict[str, Any]:
        """As the page reads it."""
        doing, done, of = self.step
        seconds = self.took or time.monotonic() - self.begin
        facts = {"doing": doing, "done": done, "of": of, "seconds": seconds, "error": self.error}
        return {**facts, "is_ready": self.model is not None}


class Workshop:
    """Models by the id of their subject, for any thread; CasaErrors of `make` are passed on to all who ask."""

    def __init__(self, make: Maker) -> None:
        self._make = make
        self._jobs: OrderedDict[str, _Job] = OrderedDict()
        self._lock, self._bench = Lock(), Lock()

    def order(self, subject: Subject) -> str:
        """Start to make a model unless it is ready or being made; return its id. Failed models are tried again."""
        with self._lock:
            job = self._jobs.get(subject.id)
            if job is None or job.error:
                job = self._jobs[subject.id] = _Job(subject)
                # Ends with the program, whatever it is doing: nothing half-made is left, see Store.
                Thread(target=self._work, args=(job,), daemon=True).start()
            self._jobs.move_to_end(subject.id)
            done = [name for name, one in self._jobs.items() if one.is_over]
            for name in done[: max(0, len(done) - KEPT)]:
                del self._jobs[name]
        return subject.id

    def find(self, model_id: str) -> _Job | None:
        """The job of a model, or None if it was not ordered, or was discarded."""
        with self._lock:
            job = self._jobs.get(model_id)
            if job is not None:
                self._jobs.move_to_end(model_id)
            return job

    def _work(self, job: _Job) -> None:
        def show_progress(doing: str, done: int, of: int) -> None:
            job.step = doing, done, of

        with self._bench:
            try:
                model = self._make(job.subject, show_progress)
            except CasaError as error:
                job.error = str(error)
            except Exception:  # noqa: BLE001  a thread has nobody above it: the page and the terminal show the fault
                traceback.print_exc()
                job.error = "a fault of the program; the terminal shows where"
            else:
                job.took, job.step = time.monotonic() - job.begin, ("ready", 0, 0)
                job.model = model


class ViewServer(ThreadingHTTPServer):
    """A server for one subject, first in a pose or as it begins, and for what the page swaps it for."""

    daemon_threads = True

    def __init__(self, subject: Subject, workshop: Workshop, pose: str = "", port: int = 0) -> None:
        """Bind a port; 0: any that is free. Raises OSError where it is taken."""
        super().__init__((HOST, port), _Handler)
        self.workshop, self.pose, self.subject = workshop, pose, subject
        self.address = f"http://{HOST}:{self.server_port}/"
        self.workshop.order(subject)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Report a fault of the program, but not a browser that closed the connection before its answer."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)


class _Handler(LocalHandler):
    server: ViewServer
    headers_of_all: ClassVar[dict[str, str]] = {
        "Referrer-Policy": "same-origin",
        "Cross-Origin-Resource-Policy": "same-origin",
    }

    def do_GET(self) -> None:
        """The page; `progress/ID`, `model/ID.glb`, `facts/ID`, `report/ID/FILE`."""
        if not self._is_for_us():
            self._refuse(HTTPStatus.FORBIDDEN, "this server answers its own page on this machine alone")
            return
        what, _, rest = unquote(urlsplit(self.path).path).removeprefix("/").partition("/")
        if (what, rest) == ("", ""):
            # It is made again where it was forgotten after many swaps.
            text = page(self.server.workshop.order(self.server.subject), self.server.pose)
            self.send(HTTPStatus.OK, "text/html; charset=utf-8", text.encode())
        elif (what, rest) == ("favicon.ico", ""):
            self.send(HTTPStatus.NO_CONTENT, "image/x-icon", b"")
        elif what in ("model", "facts") and rest:
            model_id = rest.removesuffix(".glb")
            model = self._model(model_id)
            if model is None:
                self._refuse(HTTPStatus.NOT_FOUND, f"{model_id} is not ready")
            elif what == "model":
                self.send(HTTPStatus.OK, "model/gltf-binary", model.glb)
            else:
                self.send(HTTPStatus.OK, JSON, to_json(model.facts))
        elif what == "progress" and rest:
            if (job := self.server.workshop.find(rest)) is None:
                self._refuse(HTTPStatus.NOT_FOUND, f"{rest} is not kept; load the page again")
            else:
                self._send_json(job.progress)
        elif what == "report" and rest:
            self._report(rest)
        else:
            self._refuse(HTTPStatus.NOT_FOUND, "there is no such page")

    def do_POST(self) -> None:
        """`step/ID`: one step of a state machine. `order`: another style, or other surfaces, of the kitchen."""
        length, origin = self.headers.get("Content-Length", ""), self.headers.get("Origin")
        # What is posted has to be JSON from this page; a form of another page can send no JSON without asking.
        is_same = origin is None or origin == f"http://{self.headers.get('Host', '')}"
        is_json = self.headers.get("Content-Type", "").partition(";")[0].strip() == JSON
        if not (self._is_for_us() and is_same and is_json):
            self.close_connection = True  # what was sent is not read
            self._refuse(HTTPStatus.FORBIDDEN, "this server answers its own page on this machine alone")
            return
        if not (length.isascii() and length.isdigit()) or int(length) > MAX_BODY_BYTES:
            self.close_connection = True
            self._refuse(HTTPStatus.BAD_REQUEST, f"say how long it is, at most {MAX_BODY_BYTES} bytes")
            return
        data = self.rfile.read(int(length))
        what, _, rest = unquote(urlsplit(self.path).path).removeprefix("/").partition("/")
        try:
            if what == "step":
                found, step = self._model(rest), parse_step(data)
                if found is None or step.placement not in found.behaviors:
                    raise CasaError(f"{rest} has no state machine {step.placement!r}")
                self._send_json(step_machine(found.behaviors[step.placement], step))
            elif (what, rest) == ("order", ""):
                self._send_json({"id": self._order(data)})
            else:
                self._refuse(HTTPStatus.NOT_FOUND, "there is no such page")
        except CasaError as error:
            self._refuse(HTTPStatus.BAD_REQUEST, str(error))

    def _is_for_us(self) -> bool:
        """True if the browser asked this machine by its address or as `localhost`, on whatever port a tunnel has."""
        try:
            host = urlsplit(f"//{self.headers.get('Host', '')}").hostname or ""
            if host == "localhost":
                return True
            return ipaddress.ip_address(host).is_loopback
        except ValueError:
            return False

    def _report(self, rest: str) -> None:
        """Send the report of a scene or asset, a file that it uses, or the viewer, which is always the present one."""
        model_id, _, name = rest.rpartition("/")
        if _VIEWER.fullmatch(rest):
            self.send(HTTPStatus.OK, KINDS[".js"], viewer_script())
            return
        found = self._model(model_id)
        if found is None:
            self._refuse(HTTPStatus.NOT_FOUND, f"{model_id} is not ready")
            return
        kind = KINDS.get(PurePosixPath(name).suffix)
        if found.folder is None or kind is None or not _is_of_report(found.folder, name):
            self._refuse(HTTPStatus.NOT_FOUND, f"{model_id} has no {name or REPORT}")
            return
        try:
            data = file_inside(found.folder, name, found.folder, "report").read_bytes()
        except (OSError, OutputError):
            self._refuse(HTTPStatus.NOT_FOUND, f"{model_id} has no {name}")
        else:
            self.send(HTTPStatus.OK, kind, data)

    def _order(self, data: bytes) -> str:
        """Start to build another kitchen of the same plan; returns its id. Raises CasaError where it cannot be."""
        try:
            order = json.loads(data)
            job = self.server.workshop.find(str(order["of"]))
            swapped = {str(name): str(finish) for name, finish in dict(order.get("surfaces") or {}).items()}
            style, seed = str(order.get("style") or ""), order.get("random")
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise CasaError("an order names the kitchen as `of`, and a `style`, `surfaces` or `random`") from error
        if job is None or not isinstance(job.subject, Kitchen):
            raise CasaError("only a kitchen has styles and surfaces that can be swapped")
        recipe = _swapped(job.subject.recipe, style, swapped, seed)
        resolve(recipe)  # raises where the plan and the style do not go together
        return self.server.workshop.order(Kitchen(recipe, job.subject.place))

    def _model(self, model_id: str) -> Model | None:
        """A model that is ready, or None."""
        job = self.server.workshop.find(model_id)
        return None if job is None else job.model

    def _refuse(self, status: HTTPStatus, why: str) -> None:
        self.send(status, "text/plain; charset=utf-8", why.encode())

    def _send_json(self, value: Any) -> None:
        self.send(HTTPStatus.OK, JSON, to_json(value))


def _is_of_report(folder: Path, name: str) -> bool:
    """True for the report in a folder, and for what its page shows, loads or links to."""
    if name == REPORT:
        return True
    try:
        text = file_inside(folder, REPORT, folder, "report").read_text(encoding="utf-8")
    except (OSError, OutputError, UnicodeDecodeError):
        return False
    return name in {unescape(link).removeprefix("./") for link in _LINK.findall(text)}


def _swapped(recipe: SceneRecipe, style: str, surfaces: dict[str, str], seed: Any) -> SceneRecipe:
    """Return a recipe in another style, then with surfaces drawn from a seed, or with the given surfaces."""
    made = with_style(recipe, style) if style and style != recipe.style else recipe
    if seed is not None:
        if not isinstance(seed, int) or not 0 <= seed < MAX_SEED:
            raise CasaError(f"random: a whole number from 0 to {MAX_SEED - 1}, got {seed!r}")
        return replace(made, surfaces=draw_surfaces(seed))
    unknown = sorted(set(surfaces) - {surface.value for surface in Surface})
    if unknown:
        raise CasaError(f"no surface {unknown[0]!r}; there are {', '.join(surface.value for surface in Surface)}")
    kept = [] if made is not recipe else list(recipe.surfaces)
    chosen = {**dict(kept), **{Surface(name): finish for name, finish in surfaces.items()}}
    return replace(made, surfaces=ordered_surfaces((s, f) for s, f in chosen.items() if f))


def page(first: str, pose: str = "") -> str:
    """HTML of the page, which first shows the model of this id; in a pose, or as it begins."""
    viewer = Markup(viewer_script().decode())  # noqa: S704  a file of this package
    return render_template("view/page.html", title=first, start={"first": first, "pose": pose}, viewer=viewer)


def tunnel_line(port: int) -> str:
    """The command that makes the page reachable from the machine that a user came from by ssh; empty without ssh."""
    connection = os.environ.get("SSH_CONNECTION", "").split()  # Ref: ssh(1), ENVIRONMENT
    if len(connection) != 4:
        return ""
    user = os.environ.get("USER") or os.environ.get("LOGNAME") or "USER"
    host, ssh_port = connection[2:]
    at_port = "" if ssh_port == SSH_PORT else f"-p {ssh_port} "
    return f"ssh -N {at_port}-L {port}:{HOST}:{port} {user}@{host}"
