"""What an entry of a library consists of: the file that makes it an entry, and the files that this one names."""

from __future__ import annotations

import hashlib
import json
import posixpath
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_files import PICTURE, file_inside

# As `model.record.Id`: ids, and the folders of categories.
_ID = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
PARTS_OF_ENTRY = 2  # category and id


class DamagedEntry(OutputError):
    """An entry cannot be copied: a file is missing, or is not what the manifest says."""


@dataclass(frozen=True)
class EntryFiles:
    """Files of one entry.

    Attributes:
        path: folder, relative to the library, such as `mug/mug_e1b7e22aee`.
        digests: sha256 of all files but the manifest, by their path in the entry; empty where nothing states it.
    """

    path: str
    digests: Mapping[str, str]

    @property
    def manifest(self) -> str:
        """Name of the file without which the folder is no entry."""
        return manifest_name(self.path)


def entry_path(folder: Path) -> str:
    """Path of the folder of an entry on this disk, relative to its library."""
    return f"{folder.parent.name}/{folder.name}"


def entry_folders(library: disk.Library) -> dict[str, Path]:
    """Folders of all entries of a library on this disk by their paths relative to it, accepted ones first."""
    return {entry_path(folder): folder for folder in (*library.accepted(), *library.refused())}


def manifest_name(path: str) -> str:
    """Name of the file that makes the folder of an entry one: asset.json, of a rejected input reject.json."""
    return disk.REFUSAL if path.partition("/")[0] == disk.REJECTED else disk.CERTIFICATE


def is_entry_path(path: str) -> bool:
    """True for the path of a folder, relative to a library, that can be that of an entry."""
    parts = path.split("/")
    return len(parts) == PARTS_OF_ENTRY and all(_ID.fullmatch(part) for part in parts)


def is_safe_name(name: str) -> bool:
    """True for a relative path that stays inside its folder and is written in one way only."""
    plain = name == posixpath.normpath(name) and not name.startswith(("/", "../")) and name not in ("", ".", "..")
    return plain and name.isprintable() and "\\" not in name


def entry_at(folder: Path) -> EntryFiles:
    """The files of an entry on this disk. Raises OutputError where its manifest is damaged."""
    path = entry_path(folder)
    if folder.parent.name == disk.REJECTED:
        return EntryFiles(path, {PICTURE: ""} if (folder / PICTURE).exists() else {})
    return EntryFiles(path, _named(disk.read_section(folder, "certificate"), str(folder / disk.CERTIFICATE)))


def entry_of(path: str, manifest: bytes, stored: Mapping[str, object], place: str) -> EntryFiles:
    """The files of an entry on a store.

    Args:
        path: of the entry. manifest: bytes of its manifest. stored: names of files that its folder has.
        place: where the manifest was read, for errors.
    Raises:
        DamagedEntry: the manifest is damaged, or names files outside of the entry.
    """
    is_refusal = manifest_name(path) == disk.REFUSAL
    try:
        certificate = json.loads(manifest)["code" if is_refusal else "certificate"]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise DamagedEntry(place, "is damaged; push the entry again") from error
    if is_refusal:
        return EntryFiles(path, {PICTURE: ""} if PICTURE in stored else {})
    return EntryFiles(path, _named(certificate, place))


def _named(certificate: object, place: str) -> dict[str, str]:
    files = certificate.get("files") if isinstance(certificate, dict) else None
    if not isinstance(files, dict) or not all(isinstance(digest, str) for digest in files.values()):
        raise DamagedEntry(place, "names no files; make the entry again")
    for name in files:
        if not is_safe_name(name) or name == disk.CERTIFICATE:
            raise DamagedEntry(place, f"names {name!r:.120}, which is no file of the entry; make it again")
    return files


def read_file(folder: Path, name: str, digest: str) -> bytes:
    """A file of an entry on this disk.

    Raises:
        OutputError: it is missing, leads out of the entry, or has another digest (unless that is empty).
    """
    data = file_inside(folder, name, folder, "files").read_bytes()
    if digest and hashlib.sha256(data).hexdigest() != digest:
        raise OutputError(str(folder / name), "is not what the certificate says; remove its folder and run again")
    return data
