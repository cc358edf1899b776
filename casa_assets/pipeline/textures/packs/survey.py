"""Survey a folder of pictures: pack.yaml, the pictures that can be used, and the reasons why others cannot."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.errors import RegistryError, Rejected
from casa_assets.model.record import Record
from casa_assets.pipeline.cache.cache_key import digest_of, key_of
from casa_assets.pipeline.cache.store import Store
from casa_assets.textures.packs.decode import SUFFIXES, decode
from casa_assets.textures.packs.derive import SIZE_PX, TiledPicture, tile
from casa_assets.textures.packs.entry import UNKNOWN, PictureDescription, RejectedPicture
from casa_assets.textures.packs.limits import MAX_FILE_BYTES
from casa_assets.textures.packs.rejections import PictureRejection, rejection_error, rejection_row

MANIFESTS = ("pack.yaml", "pack.yml", "pack.json")
_KEYS = ("pack", "defaults", "pictures")
_MAX_PROMPT_BYTES = 4000


@dataclass(frozen=True)
class PackOptions:
    """Options of ingesting a folder of pictures.

    Attributes:
        library: output folder. pack: name of the pack; the name of the folder where it is None.
        flags: what holds for every picture that does not say otherwise.
        size_px: longer side of the pictures.
    """

    library: Path
    pack: str | None = None
    flags: PictureDescription = field(default_factory=PictureDescription)
    size_px: int = SIZE_PX


@dataclass(frozen=True)
class PackDescription:
    """Content of pack.yaml.

    Attributes:
        pack: name, or None. defaults: for all pictures.
        rows: by source. faults: sources whose row is wrong, and how.
        used: files that are no pictures and were read.
    """

    pack: str | None
    defaults: PictureDescription
    rows: Mapping[str, PictureDescription]
    faults: Mapping[str, str]
    used: tuple[str, ...]


class PreparedPicture(Record):
    """The costly part of one picture, as the store keeps it: the tile, and what decoding told."""

    tile: TiledPicture
    prompt: str
    notes: tuple[str, ...]


@dataclass(frozen=True)
class AcceptedPicture:
    """A picture that can be used: file relative to the folder, sha256 of its bytes, what is said of it, its tile."""

    source: str
    sha256: str
    fields: PictureDescription
    prepared: PreparedPicture


@dataclass(frozen=True)
class PackSurvey:
    """Pictures that can be used, those that cannot, and files that are no pictures; each sorted by path."""

    accepted: tuple[AcceptedPicture, ...]
    refused: tuple[RejectedPicture, ...]
    ignored: tuple[str, ...]


def read_description(folder: Path) -> PackDescription:
    """Read pack.yaml (or pack.json) of a folder, and a prompt beside each picture (`oak.txt` for `oak.png`).

    Raises:
        RegistryError: the file is no YAML, has a key that nobody knows, or its defaults are wrong. A wrong row is kept
            for its picture.
    """
    used = [name for name in MANIFESTS if (folder / name).is_file()][:1]
    pack, defaults = None, PictureDescription()
    rows: dict[str, PictureDescription] = {}
    faults: dict[str, str] = {}
    if used:
        document = registry.read_document(folder / used[0])
        top = document.value if isinstance(document.value, dict) else {}
        if not isinstance(document.value, dict):
            raise document.fault((), "a mapping with pack, defaults, pictures", type(document.value).__name__)
        for key in top:
            if key not in _KEYS:
                raise document.fault((key,), f"one of {', '.join(_KEYS)}", repr(key))
        pack = str(top["pack"]) if top.get("pack") is not None else None
        defaults = registry.read_record(PictureDescription, top.get("defaults") or {}, document, ("defaults",))
        listed: Any = top.get("pictures") or {}
        if not isinstance(listed, dict):
            raise document.fault(("pictures",), "a mapping of file names to rows", type(listed).__name__)
        for source, row in listed.items():
            try:
                rows[source] = registry.read_record(PictureDescription, row or {}, document, ("pictures", source))
            except RegistryError as error:
                faults[source] = str(error)
    for path in _files(folder):
        picture = next((p for s in SUFFIXES if (p := path.with_suffix(s)).is_file()), None)
        if path.suffix.lower() == ".txt" and picture is not None and path.stat().st_size <= _MAX_PROMPT_BYTES:
            source = picture.relative_to(folder).as_posix()
            prompt = " ".join(path.read_text(encoding="utf-8", errors="replace").split())
            rows[source] = rows.get(source, PictureDescription()).over(PictureDescription(prompt=prompt))
            used.append(path.relative_to(folder).as_posix())
    return PackDescription(pack, defaults, rows, faults, tuple(used))


def survey(folder: Path, description: PackDescription, options: PackOptions, store: Store) -> PackSurvey:
    """Look at every file under a folder; what is wrong with one does not touch the others."""
    found: list[AcceptedPicture] = []
    refusals: list[RejectedPicture] = []
    ignored: list[str] = []
    by_bytes: dict[str, str] = {}
    present: list[str] = []
    for path in _files(folder):
        source = path.relative_to(folder).as_posix()
        if path.suffix.lower() not in SUFFIXES:
            if source not in description.used:
                ignored.append(source)
            continue
        present.append(source)
        try:
            data = _bytes(path, folder)
            digest = hashlib.sha256(data).hexdigest()
            if digest in by_bytes:
                raise rejection_error(PictureRejection.DUPLICATE, f"holds the same bytes as {by_bytes[digest]}")
            by_bytes[digest] = source
            fields = _picture_fields(source, description, options.flags)
            found.append(AcceptedPicture(source, digest, fields, _prepared(data, digest, options.size_px, store)))
        except Rejected as error:
            refusals.append(rejection_row(source, error))
    for source in description.rows:
        if source not in present:
            refusals.append(
                rejection_row(
                    source, rejection_error(PictureRejection.MISSING, "is named in pack.yaml and is not there")
                )
            )
    return PackSurvey(tuple(found), tuple(sorted(refusals, key=lambda r: r.source)), tuple(ignored))


def _files(folder: Path) -> Iterator[Path]:
    for path in sorted(folder.rglob("*")):
        hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
        if not hidden and (path.is_symlink() or not path.is_dir()):
            yield path


def _bytes(path: Path, folder: Path) -> bytes:
    try:
        if not path.resolve(strict=True).is_relative_to(folder.resolve()):
            raise rejection_error(PictureRejection.UNREADABLE, "is a link that leaves the folder")
        if not path.is_file():
            raise rejection_error(PictureRejection.UNREADABLE, "is no regular file")
        if path.stat().st_size > MAX_FILE_BYTES:
            raise rejection_error(PictureRejection.TOO_LARGE, f"has over {MAX_FILE_BYTES // 2**20} MiB")
        return path.read_bytes()
    except (OSError, RuntimeError) as error:  # RuntimeError: links in a circle
        raise rejection_error(PictureRejection.UNREADABLE, f"cannot be read: {error}") from None


def _picture_fields(source: str, description: PackDescription, flags: PictureDescription) -> PictureDescription:
    """Merge the fields stated for a picture: its row, then the flags, then the defaults of the file."""
    if source in description.faults:
        raise rejection_error(PictureRejection.BAD_ROW, description.faults[source])
    fields = description.rows.get(source, PictureDescription()).over(flags).over(description.defaults)
    missing = [name for name in ("surface", "tile_m", "licence") if getattr(fields, name) is None]
    if missing:
        raise rejection_error(PictureRejection.NOT_DESCRIBED, f"nobody says its {', '.join(missing)}")
    if (fields.substance or UNKNOWN) not in registry.load().substances:
        raise rejection_error(
            PictureRejection.BAD_ROW, f"{fields.substance!r} is no substance of registry/substances.yaml"
        )
    return fields


def _prepared(data: bytes, digest: str, size_px: int, store: Store) -> PreparedPicture:
    """The tile, from the store or made now: a run that was cut off goes on where it was."""
    key = digest_of("texture_pack", key_of(decode, tile, PreparedPicture), digest, size_px)
    if (kept := store.get(key)) is not None:
        return PreparedPicture.from_json(kept)
    decoded = decode(data)
    prepared = PreparedPicture(tile=tile(decoded.pixels, size_px), prompt=decoded.prompt, notes=decoded.notes)
    store.put(key, prepared.to_json().encode())
    return prepared
