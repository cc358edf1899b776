"""Meshes in an archive -> inputs named `archive.zip!member`; what else it holds is counted.

In a tar a JSON member of the same name as a mesh describes it, as in a shard of WebDataset.
"""

from __future__ import annotations

import posixpath
from collections import Counter
from collections.abc import Iterator

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.sources.bounded_reads import utf8_escaped
from casa_assets.ingest.sources.containers.archive import Archive, Member, archive_suffix
from casa_assets.ingest.sources.containers.webdataset import ShardRows
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.ingest.sources.other_files import HIDDEN, kind_of_other, unread
from casa_assets.ingest.sources.package import Package
from casa_assets.ingest.sources.untrusted_fields import unique_hints
from casa_assets.model.source import Source, SourceKind


def archived(package: Package, name: str, others: Counter[str]) -> Iterator[Found | Refused]:
    """Inputs in one archive of a folder; refused as a whole where it is broken, too large, or leaves its folder."""
    path = package.prefix + name
    try:
        if utf8_escaped(path) != path:
            raise Rejected(codes.BAD_NAME, f"{utf8_escaped(name)}: the name is not UTF-8; rename the file")
        texts: dict[str, bytes] = {}
        members = Archive(name, package.files).members(texts)
    except Rejected as error:
        yield Refused(utf8_escaped(path), error.code, error.message)
        return
    rows = ShardRows(package, name, texts)
    in_folder: dict[str, set[str]] = {}
    for member in members:
        folder, base = posixpath.split(member.path)
        in_folder.setdefault(folder, set()).add(base.lower())
    for member in members:
        folders, base = member.path.split("/")[:-1], posixpath.basename(member.path)
        place = utf8_escaped(f"{path}!{member.path}")
        if any(part.startswith(".") or part == "__MACOSX" for part in (*folders, base)):
            others[HIDDEN] += 1
        elif kind := kind_of_other(base, in_folder[posixpath.dirname(member.path)]):
            others[kind] += 1
        elif archive_suffix(base):
            message = f"{utf8_escaped(base)}: an archive within an archive; unpack the outer one and name the folder"
            yield Refused(place, codes.BAD_ARCHIVE, message)
        elif (refused := unread(place)) is not None:
            yield refused
        else:
            yield rows.described(_found(package, name, member, place))


def _found(package: Package, name: str, member: Member, place: str) -> Found:
    stem, suffix = posixpath.splitext(posixpath.basename(member.path))[0], archive_suffix(name)
    around = [*posixpath.dirname(member.path).split("/")[::-1], name[: -len(suffix)]]
    outer = package.prefix.rstrip("/").split("/")[::-1]
    hints = unique_hints([stem], around, outer, [package.root.name])
    source = Source(kind=SourceKind.FOLDER, path=place, hints=hints)
    return Found(package.root, member.path, source, archive=name, at=member.at)
