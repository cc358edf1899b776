"""Read manifests (JSON lines or a JSON list, one row per mesh) into inputs."""

from __future__ import annotations

import codecs
import json
import posixpath
from collections.abc import Iterator
from dataclasses import replace

from casa_assets.errors import Rejected
from casa_assets.formats.read.text import printable
from casa_assets.ingest.sources.found import Found, Package, Refused
from casa_assets.ingest.sources.rows import check_types, parse_json, remarks, safe_id, source_of
from casa_assets.model import rejection_codes as codes

# Names that announce a manifest, whatever the state of its content.
NAMES = frozenset({"manifest.jsonl", "manifest.json"})
# A run keeps all of its inputs in memory, to tell the same bytes and to settle copies in their order: 2.3 kB for a row
# of a manifest, so 0.6 GB for this many. The work on them would take a core three weeks.
MAX_ROWS = 250_000
MAX_BROKEN_ROWS = 1000


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
    reader = _Rows(package, name)
    filled = ((n, line) for n, line in enumerate(_lines(data.removeprefix(codecs.BOM_UTF8)), start=1) if line.strip())
    yield from reader.bounded(reader.line(number, line.decode("utf-8", "replace")) for number, line in filled)


def _lines(data: bytes) -> Iterator[bytes]:
    """Lines one by one: a list of all of them could be many times larger than the file."""
    end, start = b"\n" if b"\n" in data else b"\r", 0
    while start <= len(data):
        stop = data.find(end, start)
        stop = len(data) if stop < 0 else stop
        yield data[start:stop]
        start = stop + 1


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
            yield package.refuse(name, Rejected(codes.BAD_MANIFEST, error.message))
        return
    is_manifest = isinstance(rows, list) and any(isinstance(r, dict) and "id" in r and "file" in r for r in rows)
    if not isinstance(rows, list) or not is_manifest:
        if must:
            message = f"{name}: not a list of rows with `id` and `file`; fix it"
            yield package.refuse(name, Rejected(codes.BAD_MANIFEST, message))
        return
    reader = _Rows(package, name)
    yield from reader.bounded(reader.row(f"{name} row {number}", row) for number, row in enumerate(rows, start=1))


class _Rows:
    """Reads rows of one manifest; ids must differ."""

    def __init__(self, package: Package, name: str) -> None:
        self._package, self._name = package, name
        self._ids: dict[str, str] = {}

    def bounded(self, rows: Iterator[Found | Refused]) -> Iterator[Found | Refused]:
        """The rows, until there are more, or more broken ones, than any honest manifest has."""
        broken = 0
        for number, one in enumerate(rows, start=1):
            broken += isinstance(one, Refused) and one.code == codes.BAD_ROW
            if number > MAX_ROWS or broken > MAX_BROKEN_ROWS:
                most, advice = f"{MAX_BROKEN_ROWS} broken rows", "fix the file"
                if number > MAX_ROWS:
                    most = f"{MAX_ROWS} rows, which is what a run holds in memory"
                    advice = "split the file and ingest its parts one after the other into the same library"
                message = (
                    f"{printable(self._name)}: more than {most}; the rows from {number} on were not read, {advice}"
                )
                yield self._package.refuse(self._name, Rejected(codes.BAD_MANIFEST, message))
                return
            yield one

    def line(self, number: int, line: str) -> Found | Refused:
        """One line of a `.jsonl` manifest."""
        place = f"{printable(self._name)} line {number}"
        try:
            return self.row(place, parse_json(line, place))
        except Rejected as error:
            return self._package.refuse(self._name, error)

    def row(self, place: str, row: object) -> Found | Refused:
        """One row; refused with its place where anything in it is wrong."""
        try:
            if not isinstance(row, dict):
                raise Rejected(codes.BAD_ROW, f"{place}: {printable(json.dumps(row), 40)} is not an object; fix it")
            uid = safe_id(row.get("id"), place)
            if uid in self._ids:
                raise Rejected(codes.DUPLICATE_ID, f"{place}: id {uid!r} was used by {self._ids[uid]}; rename one")
            check_types(row, place)
            main = self._package.file(row.get("file"), place)
            self._ids[uid] = place
            stem, folders = posixpath.splitext(posixpath.basename(main))[0], posixpath.dirname(main).split("/")[::-1]
            source = source_of(row, main, uid, [stem, *folders])
            return replace(self._package.found(main, source), notes=remarks(place, row))
        except Rejected as error:
            return self._package.refuse(self._name, error)
