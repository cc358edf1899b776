"""Shards of WebDataset: tars in which files of one key belong together: `0001.glb`, and `0001.json` that describes it.

Source: the format as the `webdataset` package reads it. A key is the path up to the first dot of the file's name.
"""

from __future__ import annotations

import json
import posixpath
from collections.abc import Mapping
from dataclasses import replace

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.notes import printable
from casa_assets.ingest.sources.containers.archive import MAX_TEXT_BYTES, MAX_TEXTS_BYTES
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.ingest.sources.package import Package
from casa_assets.ingest.sources.rows import check_types, remarks, source_of
from casa_assets.ingest.sources.untrusted_fields import parse_json, safe_id


class ShardRows:
    """Descriptions of meshes in the JSON members of one tar; ids must differ.

    Args:
        package: folder of the tar. name: of its file.
        texts: content of JSON members by their paths, see Archive.members.
    """

    def __init__(self, package: Package, name: str, texts: Mapping[str, bytes]) -> None:
        self._package, self._name, self._texts = package, name, texts
        self._is_full = sum(map(len, texts.values())) >= MAX_TEXTS_BYTES
        self._ids: dict[str, str] = {}

    def described(self, found: Found) -> Found | Refused:
        """A mesh with the description in its JSON; unchanged if it has no JSON; refused if the JSON is wrong."""
        path = next((p for p in _paths(found.main) if p in self._texts), None)
        if path is None:
            return found
        place = f"{printable(self._name)}!{printable(path, 80)}"
        try:
            row = self._row(path, place)
            uid = self._uid(row, place)
            check_types(row, place)
        except Rejected as error:
            return self._package.refuse(self._name, error)
        if uid:
            self._ids[uid] = place
        source = source_of(row, found.source.path, uid, found.source.hints)
        return replace(found, source=source, notes=remarks(place, row))

    def _row(self, path: str, place: str) -> Mapping[str, object]:
        text = self._texts[path]
        if len(text) > MAX_TEXT_BYTES or (self._is_full and not _is_whole(text)):
            message = f"{place}: over {MAX_TEXT_BYTES} bytes, or over {MAX_TEXTS_BYTES} with the others; shorten it"
            raise Rejected(codes.TOO_LARGE, message)
        row = parse_json(text.decode("utf-8-sig", "replace"), place)
        if not isinstance(row, dict):
            raise Rejected(codes.BAD_ROW, f"{place}: {printable(json.dumps(row), 40)} is not an object; fix it")
        return row

    def _uid(self, row: Mapping[str, object], place: str) -> str:
        """The id that a row states, as text; empty if it states none, since the key distinguishes samples."""
        value = row.get("uid", row.get("id"))
        if value is None:
            return ""
        uid = safe_id(str(value) if type(value) is int else value, place)
        if uid in self._ids:
            raise Rejected(codes.DUPLICATE_ID, f"{place}: id {uid!r} was used by {self._ids[uid]}; rename one")
        return uid


def _paths(mesh: str) -> tuple[str, str]:
    """Where the JSON of a mesh may be: under its name, and under its key."""
    folder, base = posixpath.split(mesh)
    stem, key = posixpath.splitext(base)[0], base.partition(".")[0]
    return posixpath.join(folder, f"{stem}.json"), posixpath.join(folder, f"{key}.json")


def _is_whole(text: bytes) -> bool:
    return text.rstrip().endswith((b"}", b"]"))
