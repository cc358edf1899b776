"""Meshes in a table -> inputs named `table.parquet!row.glb`, with what the other columns say of them."""

from __future__ import annotations

import json
import pickle
import posixpath
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.formats import SUFFIXES, suffix_of
from casa_assets.ingest.load.notes import printable
from casa_assets.ingest.sources.bounded_reads import utf8_escaped
from casa_assets.ingest.sources.containers.table import COLUMNS, SUFFIX
from casa_assets.ingest.sources.containers.table_rows import FORMATS, IDS, PATHS
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.ingest.sources.manifest import MAX_ROWS
from casa_assets.ingest.sources.other_files import kind_of_other, unread
from casa_assets.ingest.sources.package import MAX_INDEX_BYTES, Package
from casa_assets.ingest.sources.rows import check_types, source_of
from casa_assets.ingest.sources.untrusted_fields import parse_json, safe_id

_CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from casa_assets.ingest.sources.containers.table_rows import main; main()"
)
MAX_LINE_BYTES = 1 << 20
OTHER_TABLES = "tables and settings"


def tabled(package: Package, name: str, others: Counter[str], is_named: bool = False) -> Iterator[Found | Refused]:
    """Inputs in one table; a table without a column of meshes is counted.

    Args:
        is_named: the user pointed at it, so that it has to hold meshes.
    """
    try:
        if utf8_escaped(package.prefix + name) != package.prefix + name:
            raise Rejected(codes.BAD_NAME, f"{utf8_escaped(name)}: the name is not UTF-8; rename the file")
        package.files.check(name)
        lines = _lines(package, name)
        head = next(lines, {})
        if not head.get("column"):
            if is_named:
                raise Rejected(codes.WRONG_TYPE, _no_column(name, head))
            others[OTHER_TABLES] += 1
            return
        yield from _rows(package, name, str(head.get("suffix", "")), lines, others)
    except Rejected as error:
        yield package.refuse(name, error)


def _no_column(name: str, head: Mapping[str, Any]) -> str:
    has = ", ".join(printable(str(column), 40) for column in head.get("columns", ()))
    return f"{printable(name)}: no column of bytes is called {', '.join(COLUMNS)}; it has {has or 'none'}; rename one"


def _lines(package: Package, name: str) -> Iterator[dict[str, Any]]:
    """What `table_rows` prints. Raises Rejected where it ends otherwise than by itself, or prints too much."""
    with subprocess.Popen(
        [sys.executable, "-c", _CODE, json.dumps(sys.path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    ) as child:
        assert child.stdin is not None
        assert child.stdout is not None
        try:
            with child.stdin as to_child:
                to_child.write(pickle.dumps((package.root, name)))
            left = MAX_INDEX_BYTES
            while line := child.stdout.readline(MAX_LINE_BYTES):
                left -= len(line)
                row = parse_json(line, printable(name)) if left >= 0 else None
                if not isinstance(row, dict):
                    message = f"{printable(name)}: a table whose rows say more than {MAX_INDEX_BYTES} bytes; divide it"
                    raise Rejected(codes.TOO_LARGE, message)
                if "fault" in row:
                    raise Rejected(*row["fault"])
                yield row
            child.wait()
        finally:
            child.kill()
    if child.returncode:
        message = f"{printable(name)}: a table whose reader died, by its limits or by a fault; write it anew"
        raise Rejected(codes.BAD_ARCHIVE, message)


def _rows(
    package: Package, name: str, suffix: str, lines: Iterator[Mapping[str, Any]], others: Counter[str]
) -> Iterator[Found | Refused]:
    ids: dict[str, str] = {}
    for number, row in enumerate(lines):
        place = f"{printable(name)} row {number}"
        if number >= MAX_ROWS:
            message = f"{printable(name)}: more than {MAX_ROWS} rows, which is what a run holds in memory; divide it"
            yield package.refuse(name, Rejected(codes.TOO_LARGE, message))
            return
        try:
            uid, key = _names(row, number, place, ids)
            check_types(row, place)
        except Rejected as error:
            yield package.refuse(name, error)
            continue
        stated = _suffix(row)
        main = f"{key}{stated or suffix or '.glb'}"
        path = f"{package.prefix}{name}!{main}"
        if kind := kind_of_other(main, frozenset()):
            others[kind] += 1
        elif (refused := unread(path)) is not None:
            yield refused
        else:
            yield _found(package, name, row, (uid, main, path), number)


def _names(row: Mapping[str, Any], number: int, place: str, ids: dict[str, str]) -> tuple[str, str]:
    """The id that a row states, or nothing, and the name of its file without its suffix; both differ from all others.

    Args:
        ids: takes up the names.
    """
    stated = next(((column, row[column]) for column in IDS if row.get(column) is not None), None)
    if stated is None:
        return "", f"{number:06}"
    column, value = stated
    text = str(value) if type(value) is int else value
    if column in ("__key__", "key") and not _is_safe(text, place):
        return "", f"{number:06}"
    uid = safe_id(text, place)
    if uid in ids:
        raise Rejected(codes.DUPLICATE_ID, f"{place}: id {uid!r} was used by {ids[uid]}; rename one")
    ids[uid] = place
    return uid, uid


def _is_safe(value: object, place: str) -> bool:
    try:
        safe_id(value, place)
    except Rejected:
        return False
    return True


def _suffix(row: Mapping[str, Any]) -> str:
    """Suffix of the file in a row, such as `.obj`; empty if the row does not say it."""
    for column in FORMATS:
        word = f".{str(row.get(column, '')).lower().strip().removeprefix('.')}"
        if word in SUFFIXES:
            return word
    return next((suffix_of(str(row[column])) for column in PATHS if suffix_of(str(row.get(column, "")))), "")


def _found(package: Package, name: str, row: Mapping[str, Any], names: tuple[str, str, str], number: int) -> Found:
    uid, main, path = names
    inner = next((str(row[column]) for column in PATHS if row.get(column)), "").replace("\\", "/")
    stem, folders = posixpath.splitext(posixpath.basename(inner))[0], posixpath.dirname(inner).split("/")[::-1]
    around = [name[: -len(SUFFIX)], *package.prefix.rstrip("/").split("/")[::-1], package.root.name]
    source = source_of(row, path, uid, [stem, *folders, *around])
    return Found(package.root, main, source, archive=name, at=number)
