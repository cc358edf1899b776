"""Addresses of folders and files on stores, and how they are written down: without passwords and signatures."""

from __future__ import annotations

import posixpath
import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from urllib.parse import unquote, urlsplit

_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+(?:://|::)")
_USER = re.compile(r"(?<=://)[^/@\s]*@")
_WEB = ("http://", "https://")


def is_url(text: str) -> bool:
    """True for an address such as `s3://bucket/meshes`; no path of a file that is there looks so."""
    return _URL.match(text) is not None


@dataclass(frozen=True)
class StoreRoot:
    """A folder on a store, or a file where somebody named one.

    Attributes:
        base: URL as the user named it, with the user and password that may stand in it.
        query: of a web address, with its `?`; it is sent with every request below it. It may be a signature.
        path: POSIX, from there on.
    """

    base: str = field(repr=False)
    query: str = field(default="", repr=False)
    path: str = ""

    def __truediv__(self, path: str) -> StoreRoot:
        return replace(self, path=posixpath.normpath(posixpath.join(self.path, path))) if path else self

    def __str__(self) -> str:
        """The address, as it may be shown and written down."""
        public = hide_secrets(self.base)
        return f"{public}/{self.path}" if self.path else public

    def hide(self, text: str) -> str:
        """Text, such as that of an error, without the secrets of this address or of any other."""
        user = urlsplit(self.base).netloc.rpartition("@")[0]
        for secret in (f"{user}@" if user else "", self.query):
            text = text.replace(secret, "") if secret else text
        return hide_secrets(text)

    @property
    def is_web(self) -> bool:
        """True for http and https, whose names are quoted and whose folders are pages."""
        return self.base.startswith(_WEB)

    @property
    def name(self) -> str:
        """Last name of the path; of a bucket its own, of a web server none."""
        if self.path:
            return posixpath.basename(self.path)
        last = self.base.rpartition("/")[2]
        if self.is_web:
            return unquote(last) if urlsplit(self.base).path else ""
        return last

    @property
    def parent(self) -> StoreRoot:
        """The folder around it."""
        if self.path:
            return replace(self, path=posixpath.dirname(self.path))
        return replace(self, base=self.base.rpartition("/")[0])


def root_of(text: str) -> Path | StoreRoot:
    """What a user named: a path, or an address; `file:` addresses are paths."""
    if not is_url(text):
        return Path(text)
    if text.lower().startswith("file://"):
        return Path(unquote(urlsplit(text).path))
    if text.startswith(_WEB):
        parts = urlsplit(text)
        query = f"?{parts.query}" if parts.query else ""
        return StoreRoot(f"{parts.scheme}://{parts.netloc}{parts.path.rstrip('/')}", query)
    return StoreRoot(text if text.endswith("://") else text.rstrip("/"))


def hide_secrets(text: str) -> str:
    """Text without the users, passwords and queries of the addresses in it."""
    text = _USER.sub("", text)
    return re.sub(r"(https?://[^\s?'\"]*)\?[^\s'\"]*", r"\1", text)
