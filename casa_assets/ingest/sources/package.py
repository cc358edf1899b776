"""Package folders: where one lies, and how a file that it names becomes a Found."""

from __future__ import annotations

import posixpath
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.notes import printable
from casa_assets.ingest.sources.bounded_reads import utf8_escaped
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.ingest.sources.places import Folder, StoreRoot, folder_of
from casa_assets.model.source import Source

# The largest index in the wild (Objaverse 1.0 object paths) is 80 MB unpacked.
MAX_INDEX_BYTES = 128 * 1024 * 1024


@dataclass(frozen=True)
class Package:
    """A folder that says something about the meshes in it.

    Attributes:
        root: the folder: absolute, or on a store.
        prefix: the folder relative to what the user named, POSIX, empty or ending in `/`.
    """

    root: Path | StoreRoot
    prefix: str

    @cached_property
    def files(self) -> Folder:
        """The folder, to read and list."""
        return folder_of(self.root)

    def read(self, name: str) -> bytes:
        """Bytes of an index file of the package. Raises Rejected as bounded_reads.read_file."""
        return self.files.read(name, MAX_INDEX_BYTES)

    def refuse(self, name: str, error: Rejected) -> Refused:
        """Refusal that points at a file of the package."""
        return Refused(utf8_escaped(self.prefix + name), error.code, error.message)

    def file(self, value: object, place: str) -> str:
        """POSIX path, relative to the package, of a file that a row names; it exists and may be read.

        Raises:
            Rejected: BAD_ROW, PATH_TRAVERSAL, MISSING_FILE, LINK_OUTSIDE, NOT_A_FILE, UNREADABLE.
        """
        if not isinstance(value, str) or not value.strip() or "\0" in value:
            raise Rejected(codes.BAD_ROW, f"{place}: no usable file name ({printable(repr(value), 40)}); fix it")
        path = value.strip()
        if "\\" in path and not self.files.has(path):
            path = path.replace("\\", "/")
        whole = posixpath.normpath(path)
        if path.startswith("/") or re.match(r"[A-Za-z]:", path) or (whole.startswith("..") and whole[2:3] in ("", "/")):
            raise Rejected(codes.PATH_TRAVERSAL, f"{place}: {printable(path, 80)!r} leaves the package; fix it")
        try:
            self.files.check(whole)
        except Rejected as error:
            raise Rejected(error.code, f"{place}: {error.message}") from error
        except UnicodeError as error:
            raise Rejected(codes.BAD_NAME, f"{place}: a name that no file can have; fix it") from error
        return whole

    def found(self, main: str, source: Source) -> Found:
        """Found for a file of the package; the source's path is set here."""
        return Found(self.root, main, source.replace(path=self.prefix + main))
