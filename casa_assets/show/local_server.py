"""Common parts of the servers of pages: they answer this machine alone, and print nothing on the terminal."""

from __future__ import annotations

import webbrowser
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from threading import Thread
from typing import ClassVar

HOST = "127.0.0.1"


def open_in_browser(address: str) -> None:
    """Open a page that is about to be served. A text browser waits for the page, so this does not wait for it."""
    Thread(target=webbrowser.open, args=(address,), daemon=True).start()


class LocalHandler(BaseHTTPRequestHandler):
    """Answers that no browser keeps.

    Attributes:
        headers_of_all: name -> value of headers that each answer of a server has besides.
    """

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
