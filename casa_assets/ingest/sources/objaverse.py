"""Read Objaverse 1.0 folders (as the `objaverse` package caches them) and Objaverse-XL lists into inputs."""

from __future__ import annotations

import codecs
import gzip
import importlib
import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from casa_assets.errors import CasaError, Rejected, UnknownId
from casa_assets.formats.read.text import printable
from casa_assets.ingest.sources.places import (
    MAX_INDEX_BYTES,
    Folder,
    Found,
    Package,
    Refused,
    unique_hints,
    utf8_escaped,
    words_of_path,
)
from casa_assets.ingest.sources.rows import parse_json, safe_id, spdx_id, text_field, text_list
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Source, SourceKind

INDEX_FILES = frozenset(
    f"{stem}.json{end}" for stem in ("object-paths", "annotations", "lvis-annotations") for end in ("", ".gz")
)


def is_package(names: Sequence[str]) -> bool:
    """True where a folder with these entries is an Objaverse 1.0 package."""
    return "glbs" in names or "object-paths.json" in names or "object-paths.json.gz" in names


def read_package(package: Package) -> Iterator[Found | Refused]:
    """Every GLB under `glbs/`, by name, with what annotations, metadata and LVIS say about it."""
    refused: list[Refused] = []
    annotations = _mapping(package, "annotations", refused)
    metadata: dict[str, Mapping[str, object]] = {}  # annotations of one `glbs/` folder, as `objaverse` caches them
    categories: dict[str, str] = {}  # LVIS category by uid; the first by name where several claim one
    for category, uids in sorted(_mapping(package, "lvis-annotations", refused).items()):
        for uid in uids if isinstance(uids, list) else ():
            if isinstance(uid, str):
                categories.setdefault(uid, printable(category))
    paths = _mapping(package, "object-paths", refused)
    yield from refused
    seen: set[str] = set()
    for folder, name in _glbs(package.files):
        main = f"glbs/{folder}/{name}" if folder else f"glbs/{name}"
        uid = name[: -len(".glb")]
        seen.add(main)
        row = annotations.get(uid)
        if row is None and folder:
            if folder not in metadata:
                metadata[folder] = _mapping(package, f"metadata/{folder}", refused)
            row = metadata[folder].get(uid)
        try:
            package.files.check(main)
            if utf8_escaped(main) != main:
                raise Rejected(codes.BAD_NAME, f"{utf8_escaped(main)}: the name is not UTF-8; rename the file")
            yield package.found(main, _source(main, uid, row, categories.get(uid, "")))
        except Rejected as error:
            yield package.refuse(main, error)
    # the package's own index lists all of Objaverse, downloaded or not; a plain one lists what should be here
    for uid, path in sorted(paths.items()) if package.files.has("object-paths.json") else ():
        if isinstance(path, str) and path in seen:
            continue
        place = f"object-paths.json {printable(uid, 40)!r}"
        try:
            main = package.file(path, place)
            yield package.found(main, _source(main, safe_id(uid, place), annotations.get(uid), categories.get(uid, "")))
        except Rejected as error:
            yield package.refuse("object-paths.json", error)


def _glbs(files: Folder) -> list[tuple[str, str]]:
    """(folder under glbs, file name) of every `.glb`, sorted."""
    out: list[tuple[str, str]] = []
    if not any(entry.is_folder and entry.name == "glbs" for entry in files.scan("")):
        return out
    for entry in files.scan("glbs"):
        if entry.is_folder and not entry.name.lower().endswith(".glb"):
            inner = files.scan(f"glbs/{entry.name}")
            out.extend((entry.name, e.name) for e in inner if e.name.lower().endswith(".glb"))
        elif entry.name.lower().endswith(".glb"):
            out.append(("", entry.name))
    return sorted(out, key=lambda pair: (os.fsencode(pair[0]), os.fsencode(pair[1])))


def _source(main: str, uid: str, row: object, category: str) -> Source:
    entry: Mapping[str, object] = row if isinstance(row, dict) else {}
    user = entry.get("user")
    author = (text_field(user, "displayName") or text_field(user, "username")) if isinstance(user, dict) else ""
    title = text_field(entry, "name")
    return Source(
        kind=SourceKind.OBJAVERSE,
        path=main,
        uid=uid,
        title=title,
        author=author,
        licence=spdx_id(text_field(entry, "license")),
        uri=text_field(entry, "uri") or text_field(entry, "viewerUrl"),
        category=category,
        hints=unique_hints([title], text_list(entry.get("tags")), text_list(entry.get("categories"))),
    )


def _mapping(package: Package, stem: str, refused: list[Refused]) -> Mapping[str, object]:
    """JSON object in `<stem>.json` or `<stem>.json.gz`; empty where there is neither, or it is broken and refused."""
    for name in (f"{stem}.json", f"{stem}.json.gz"):
        if not package.files.has(name):
            continue
        try:
            value = parse_json(_plain(package.read(name), name), name)
            if isinstance(value, dict):
                return value
            raise Rejected(codes.BAD_MANIFEST, f"{name}: not a JSON object; fix it or remove it")
        except Rejected as error:
            refused.append(package.refuse(name, Rejected(codes.BAD_MANIFEST, error.message)))
    return {}


def _plain(data: bytes, name: str) -> bytes:
    """JSON text, gunzipped where it is gzip, no larger than an index may be."""
    if data.startswith(b"\x1f\x8b"):
        try:
            unpacker = zlib.decompressobj(wbits=16 + zlib.MAX_WBITS)
            data = unpacker.decompress(data, MAX_INDEX_BYTES)
        except zlib.error as error:
            raise Rejected(codes.BAD_MANIFEST, f"{name}: broken gzip ({error}); fetch it again") from error
        if unpacker.unconsumed_tail:
            raise Rejected(codes.BAD_MANIFEST, f"{name}: more than {MAX_INDEX_BYTES} bytes unpacked; fix it")
    return data.removeprefix(codecs.BOM_UTF8)


def read_xl(package: Package, name: str) -> Iterator[Found | Refused] | None:
    """Inputs of an Objaverse-XL list (its rows have `fileIdentifier`); None if the file is not such a list."""
    try:
        rows = parse_json(_plain(package.read(name), name), name)
    except Rejected:
        return None
    if not isinstance(rows, list) or not any(isinstance(r, dict) and "fileIdentifier" in r for r in rows):
        return None
    return (_xl_row(package, name, number, row) for number, row in enumerate(rows, start=1))


def _xl_row(package: Package, name: str, number: int, row: object) -> Found | Refused:
    place = f"{name} row {number}"
    try:
        if not isinstance(row, dict):
            raise Rejected(codes.BAD_ROW, f"{place}: not an object; fix it")
        main = package.file(row.get("path"), place)
        title = text_field(row, "name")
        source = Source(
            kind=SourceKind.OBJAVERSE_XL,
            path=main,
            uid=text_field(row, "sha256"),
            title=title,
            author=text_field(row, "author"),
            licence=spdx_id(text_field(row, "license")),
            uri=text_field(row, "fileIdentifier"),
            category=text_field(row, "category"),
            hints=unique_hints([title], text_list(row.get("tags")), words_of_path(main)),
        )
        return package.found(main, source)
    except Rejected as error:
        return package.refuse(name, error)


def download(uids: Sequence[str], category: str, most: int, into: Path) -> Path:
    """Fetch objects by way of the `objaverse` package; what is there already is not fetched again.

    `uids`: which objects; where empty, the first `most` of the LVIS `category`, by uid. `category`: LVIS category, such
    as `Mug`; compared without case. `most`: largest number of objects to fetch. `into`: folder that gets
    `hf-objaverse-v1/`, laid out as that package lays out its cache. Returns the package folder, to be given to
    `discover`. Raises CasaError: the `objaverse` package is not installed, or the network cannot be reached. Raises
    UnknownId: no such LVIS category.
    """
    try:
        library = importlib.import_module("objaverse")
    except ImportError as error:
        raise CasaError("downloading needs the `objaverse` package: pip install objaverse") from error
    # the package takes a folder in no other way
    cache = into.absolute() / "hf-objaverse-v1"
    library.__dict__.update(BASE_PATH=str(cache.parent), _VERSIONED_PATH=str(cache))
    try:
        wanted = list(uids)
        if not wanted:
            listed = library.load_lvis_annotations()
            names = {name.lower(): name for name in listed}
            if category.lower() not in names:
                raise UnknownId("LVIS category", category, listed)
            wanted = sorted(listed[names[category.lower()]])
        wanted = wanted[:most]
        library.load_objects(wanted)
        library.load_annotations(wanted)
    except (OSError, EOFError, gzip.BadGzipFile) as error:
        raise CasaError(f"Objaverse cannot be reached ({error}); check the network, then try again") from error
    return cache
