"""Manifests (JSON lines or a JSON list, one row per mesh) -> inputs."""

from __future__ import annotations

import codecs
import json
import posixpath
from collections.abc import Iterator, Mapping

from casa_assets.errors import Rejected
from casa_assets.ingest import codes
from casa_assets.ingest.load.notes import clean
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.ingest.sources.licence import spdx
from casa_assets.ingest.sources.package import Package
from casa_assets.ingest.sources.rows import hints, parse_json, safe_id, word, words
from casa_assets.model.source import Source, SourceKind

# Names that announce a manifest, whatever the state of its content.
NAMES = frozenset({"manifest.jsonl", "manifest.json"})


def read_lines(package: Package, name: str, is_named: bool) -> Iterator[Found | Refused]:
    """Inputs of a `.jsonl` manifest; nothing where it is some other `.jsonl`.

    Args:
        package: folder of the manifest.
        name: its file name.
        is_named: the user pointed at it, so that it has to be a manifest.
    """
    try:
        data = package.read(name)
    except Rejected as error:
        yield package.refuse(name, error)
        return
    if not (is_named or name.lower() in NAMES or b'"file"' in data):
        return
    text = data.removeprefix(codecs.BOM_UTF8).decode("utf-8", "replace")
    reader = _Rows(package, name)
    for number, line in enumerate(text.splitlines() if "\n" not in text else text.split("\n"), start=1):
        if line.strip():
            yield reader.line(number, line)


def read_list(package: Package, name: str, is_named: bool) -> Iterator[Found | Refused]:
    """Inputs of a `.json` list whose rows have `id` and `file`; nothing where it is some other JSON."""
    must = is_named or name.lower() in NAMES
    try:
        data = package.read(name)
        if not must and not data.removeprefix(codecs.BOM_UTF8).lstrip().startswith(b"["):
            return
        rows = parse_json(data.removeprefix(codecs.BOM_UTF8), name)
    except Rejected as error:
        if must:
            yield package.refuse(name, Rejected(codes.BAD_MANIFEST, error.says))
        return
    is_manifest = isinstance(rows, list) and any(isinstance(r, dict) and "id" in r and "file" in r for r in rows)
    if not isinstance(rows, list) or not is_manifest:
        if must:
            says = f"{name}: not a list of rows with `id` and `file`; mend it"
            yield package.refuse(name, Rejected(codes.BAD_MANIFEST, says))
        return
    reader = _Rows(package, name)
    for number, row in enumerate(rows, start=1):
        yield reader.row(f"{name} row {number}", row)


class _Rows:
    """Reads rows of one manifest; ids must differ."""

    def __init__(self, package: Package, name: str) -> None:
        self._package, self._name = package, name
        self._ids: dict[str, str] = {}

    def line(self, number: int, line: str) -> Found | Refused:
        """One line of a `.jsonl` manifest."""
        place = f"{clean(self._name)} line {number}"
        try:
            return self.row(place, parse_json(line, place))
        except Rejected as error:
            return self._package.refuse(self._name, error)

    def row(self, place: str, row: object) -> Found | Refused:
        """One row; refused with its place where anything in it is wrong."""
        try:
            if not isinstance(row, dict):
                raise Rejected(codes.BAD_ROW, f"{place}: {clean(json.dumps(row), 40)} is not an object; mend it")
            uid = safe_id(row.get("id"), place)
            if uid in self._ids:
                raise Rejected(codes.DUPLICATE_ID, f"{place}: id {uid!r} was used by {self._ids[uid]}; rename one")
            self._check_types(row, place)
            main = self._package.file(row.get("file"), place)
            self._ids[uid] = place
            return self._package.found(main, _source(uid, main, row))
        except Rejected as error:
            return self._package.refuse(self._name, error)

    def _check_types(self, row: Mapping[str, object], place: str) -> None:
        for key in ("prompt", "category", "generator", "license", "licence", "name", "title", "author", "uri"):
            value = row.get(key)
            if value is not None and not isinstance(value, str):
                says = f"{place}: {key} {clean(repr(value), 40)} is not text; mend it"
                raise Rejected(codes.BAD_ROW, says)


def _source(uid: str, main: str, row: Mapping[str, object]) -> Source:
    is_generated = bool(word(row, "prompt") or word(row, "generator"))
    title = word(row, "name") or word(row, "title")
    stem, folders = posixpath.splitext(posixpath.basename(main))[0], posixpath.dirname(main).split("/")[::-1]
    return Source(
        kind=SourceKind.TEXT_TO_3D if is_generated else SourceKind.MANIFEST,
        path=main,
        uid=uid,
        title=title,
        author=word(row, "author"),
        licence=spdx(word(row, "license") or word(row, "licence")),
        uri=word(row, "uri") or word(row, "url"),
        prompt=word(row, "prompt"),
        generator=word(row, "generator"),
        category=word(row, "category"),
        hints=hints([title], words(row.get("tags")), [word(row, "prompt")], [stem], folders, [uid]),
    )
