"""Requests to the servers of `casa-assets view` and of the pages of review."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPConnection
from threading import Thread
from typing import Any

from casa_assets.show.view.review import ReviewServer
from casa_assets.show.view.server import HOST, Maker, ViewServer, Workshop
from casa_assets.show.view.subject import Subject


@contextmanager
def running(server: Any) -> Iterator[Any]:
    """A server in a thread of its own."""
    with server:
        thread = Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


@contextmanager
def serving(subject: Subject, make: Maker, pose: str = "") -> Iterator[ViewServer]:
    """A server on a free port."""
    with running(ViewServer(subject, Workshop(make), pose)) as server:
        yield server


def ask(server: ViewServer | ReviewServer, path: str, body: Any = None, **headers: str) -> tuple[int, bytes]:
    """Status and body of an answer. `headers`: names with an underscore for each dash; take the place of the usual."""
    connection = HTTPConnection(HOST, server.server_port, timeout=20)
    usual = {"Host": f"{HOST}:{server.server_port}", "Content-Type": "application/json"}
    given = {name.replace("_", "-"): value for name, value in headers.items()}
    data = None if body is None else json.dumps(body)
    connection.request("GET" if data is None else "POST", f"/{path.removeprefix('/')}", data, {**usual, **given})
    answer = connection.getresponse()
    return answer.status, answer.read()
