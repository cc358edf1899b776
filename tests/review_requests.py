"""Requests to the server of the pages of review."""

from __future__ import annotations

import json
from http.client import HTTPConnection

from casa_assets.pipeline.local_server import HOST
from casa_assets.pipeline.review import ReviewServer


def ask(server: ReviewServer, path: str, body: object = None, host: str = "") -> tuple[int, bytes]:
    """Status and body of an answer; `path` is below the address."""
    connection = HTTPConnection(HOST, server.server_port, timeout=10)
    headers = {"Host": host or f"{HOST}:{server.server_port}"}
    data = None if body is None else json.dumps(body)
    connection.request("GET" if data is None else "POST", path, data, headers)
    answer = connection.getresponse()
    return answer.status, answer.read()
