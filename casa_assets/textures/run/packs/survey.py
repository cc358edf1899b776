"""Survey the pictures of a folder: those that can be used, and the reasons why others cannot."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.errors import RegistryError, Rejected
from casa_assets.model.record import Record
from casa_assets.textures.pack_entry import (
    MAX_FILE_BYTES,
    UNKNOWN,
    MapRole,
    MaterialFiles,
    PictureDescription,
    PictureRejection,
    RejectedPicture,
    group_maps,
    rejection_error,
    rejection_row,
    slug,
)
from casa_assets.textures.pack_pictures import (
    SIZE_PX,
    SUFFIX_GROUPS,
    Floats,
    GivenMaps,
    TiledPicture,
    decode,
    decode_map,
    scaled,
    tile,
)

# Sources --------------------------------------------------------------------------------------------------------------
# The files that a pack is made of: those under a folder; every read is bounded.


def list_files(folder: Path) -> list[str]:
    """POSIX paths of every file under a folder that is not hidden, sorted."""
    files = [path for path in folder.rglob("*") if path.is_symlink() or not path.is_dir()]
    parts = [path.relative_to(folder).parts for path in files]
    return sorted("/".join(names) for names in parts if not any(name.startswith(".") for name in names))


def read_file(folder: Path, name: str) -> bytes:
    """Bytes of a file of a folder. Raises Rejected."""
    path = folder / name
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


# Survey ---------------------------------------------------------------------------------------------------------------
# Survey pictures: what is said of them, those that can be used, and the reasons why others cannot.

MANIFESTS = ("pack.yaml", "pack.yml", "pack.json")
_KEYS = ("pack", "defaults", "pictures")
_SAME_ASPECT = 0.02  # by which the shape of a map may differ from that of the colour


@dataclass(frozen=True)
class PackOptions:
    """Options of ingesting a folder of pictures.

    Attributes:
        library: output folder. pack: name of the pack; None: that of the folder. size_px: longer side of the pictures.
        flags: for every picture that does not state otherwise.
    """

    library: Path
    pack: str | None = None
    flags: PictureDescription = field(default_factory=PictureDescription)
    size_px: int = SIZE_PX


@dataclass(frozen=True)
class PackDescription:
    """Description of the pictures of a source."""

    pack: str | None  # name
    defaults: PictureDescription  # for all pictures
    rows: Mapping[str, PictureDescription]  # by file, or by name of the material
    faults: Mapping[str, str]  # pictures with an invalid row, and the error
    used: tuple[str, ...]  # files that are not pictures and were read


class PreparedPicture(Record):
    """The costly part of one picture, as the store keeps it: the tile, and what was learnt by decoding."""

    tile: TiledPicture
    prompt: str
    notes: tuple[str, ...]


@dataclass(frozen=True)
class AcceptedPicture:
    """A picture that can be used."""

    name: str  # of the material
    source: str  # file of the colour, relative to the folder
    sha256: str  # of its bytes
    maps: Mapping[str, str]  # name of a map that it came with -> its file
    fields: PictureDescription
    prepared: PreparedPicture


@dataclass(frozen=True)
class PackSurvey:
    """Pictures that can be used, those that cannot, and files that are no pictures; each sorted by path."""

    accepted: tuple[AcceptedPicture, ...]
    refused: tuple[RejectedPicture, ...]
    ignored: tuple[str, ...]


def read_description(source: Path) -> PackDescription:
    """Read what pack.yaml (or pack.json) of a folder says of its pictures.

    Raises:
        RegistryError: pack.yaml is no YAML, has a key that nobody knows, or its defaults are wrong. A wrong row is kept
            for its picture.
    """
    used = [name for name in MANIFESTS if (source / name).is_file()][:1]
    pack, defaults = None, PictureDescription()
    rows: dict[str, PictureDescription] = {}
    faults: dict[str, str] = {}
    if used:
        document = registry.read_document(source / used[0])
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
        for name, row in listed.items():
            try:
                rows[name] = registry.read_record(PictureDescription, row or {}, document, ("pictures", name))
            except RegistryError as error:
                faults[name] = str(error)
    return PackDescription(pack, defaults, rows, faults, tuple(used))


def survey(source: Path, description: PackDescription, options: PackOptions, store: Store) -> PackSurvey:
    """Look at every file of a folder; what is wrong with one does not touch the others."""
    accepted: list[AcceptedPicture] = []
    refusals: list[RejectedPicture] = []
    by_bytes: dict[str, str] = {}
    found = list_files(source)
    shown = [path for suffixes in SUFFIX_GROUPS for path in found if Path(path).suffix.lower() in suffixes]
    materials = sorted(group_maps(shown), key=lambda one: min(one.maps.values()))
    for files in materials:
        try:
            accepted.append(_accepted(files, source, by_bytes, description, options, store))
        except Rejected as error:
            colour = files.maps.get(MapRole.COLOR, next(iter(files.maps.values())))
            refusals.append(rejection_row(colour, error))
    present = {name for files in materials for name in (*files.maps.values(), slug(files.name))}
    for name in (*description.rows, *description.faults):
        if name not in present and slug(name) not in present:
            missing = rejection_error(PictureRejection.MISSING, "is named in pack.yaml and is not there")
            refusals.append(rejection_row(name, missing))
    read = {*description.used, *(path for files in materials for path in files.maps.values())}
    ignored = tuple(path for path in found if path not in read)
    return PackSurvey(tuple(accepted), tuple(sorted(refusals, key=lambda r: r.source)), ignored)


def _accepted(
    files: MaterialFiles,
    folder: Path,
    by_bytes: dict[str, str],
    description: PackDescription,
    options: PackOptions,
    store: Store,
) -> AcceptedPicture:
    """A material that can be used. Raises Rejected."""
    source = files.maps.get(MapRole.COLOR)
    if source is None:
        raise rejection_error(PictureRejection.NO_COLOR, f"{files.name} has {', '.join(files.maps)} and no colour")
    data = read_file(folder, source)
    digest = hashlib.sha256(data).hexdigest()
    if digest in by_bytes:
        raise rejection_error(PictureRejection.DUPLICATE, f"holds the same bytes as {by_bytes[digest]}")
    by_bytes[digest] = source
    fields = _picture_fields(files, description, options.flags)
    prepared = _prepared(data, digest, files.maps, folder, options.size_px, store)
    origins = {name: files.maps[MapRole(name)] for name in sorted(prepared.tile.maps)}
    return AcceptedPicture(files.name, source, digest, origins, fields, prepared)


def _picture_fields(
    files: MaterialFiles, description: PackDescription, flags: PictureDescription
) -> PictureDescription:
    """Merge the fields stated for a picture: its row, the flags, the defaults of the file."""
    source = files.maps[MapRole.COLOR]
    keys = [key for key in (*description.rows, *description.faults) if key == source or slug(key) == slug(files.name)]
    if keys and keys[0] in description.faults:
        raise rejection_error(PictureRejection.BAD_ROW, description.faults[keys[0]])
    row = description.rows[keys[0]] if keys else PictureDescription()
    fields = row.over(flags).over(description.defaults)
    missing = [name for name in ("surface", "tile_m", "licence") if getattr(fields, name) is None]
    if missing:
        raise rejection_error(PictureRejection.NOT_DESCRIBED, f"nobody says its {', '.join(missing)}")
    if (fields.substance or UNKNOWN) not in registry.load().substances:
        raise rejection_error(
            PictureRejection.BAD_ROW, f"{fields.substance!r} is no substance of registry/substances.yaml"
        )
    return fields


def _prepared(
    data: bytes, digest: str, maps: Mapping[MapRole, str], folder: Path, size_px: int, store: Store
) -> PreparedPicture:
    """The tile, from the store or made now: a run that was cut off goes on where it was."""
    read: dict[MapRole, bytes] = {}
    notes: list[str] = []
    for role, path in maps.items():
        if role is MapRole.COLOR:
            continue
        try:
            read[role] = read_file(folder, path)
        except Rejected as error:
            notes.append(_without(role, error))
    digests = {role.value: hashlib.sha256(found).hexdigest() for role, found in sorted(read.items())}
    key = digest_of("texture_pack", key_of(decode, tile, _given, PreparedPicture), digest, digests, size_px)
    if (kept := store.get(key)) is not None:
        found = PreparedPicture.from_json(kept)
        return found.replace(notes=(*found.notes, *notes))
    decoded = decode(data)
    small = scaled(decoded.pixels, size_px)
    given, left_out = _given(read, small.shape[1] / small.shape[0], size_px)
    made = PreparedPicture(tile=tile(small, size_px, given), prompt=decoded.prompt, notes=(*decoded.notes, *left_out))
    store.put(key, made.to_json().encode())
    return made.replace(notes=(*made.notes, *notes))


def _given(read: Mapping[MapRole, bytes], aspect: float, size_px: int) -> tuple[GivenMaps, tuple[str, ...]]:
    """Maps by the bytes of their files, and notes on those that cannot be used.

    Args:
        aspect: width over height of the colour. size_px: longer side to which they are scaled down.
    """
    planes: dict[MapRole, Floats] = {}
    notes: list[str] = []
    for role, data in read.items():
        try:
            pixels = decode_map(data, role)
            if abs(pixels.shape[1] / pixels.shape[0] / aspect - 1.0) > _SAME_ASPECT:
                raise rejection_error(PictureRejection.TOO_LONG, "has another shape than the colour")
            planes[role] = scaled(pixels, size_px)
        except Rejected as error:
            notes.append(_without(role, error))
    single = {role.value: plane[..., :1] for role, plane in planes.items() if role is not MapRole.NORMAL}
    return GivenMaps(normal=planes.get(MapRole.NORMAL), **single), tuple(notes)


def _without(role: MapRole, error: Rejected) -> str:
    return f"its map of the {role.value} was left out: it {error.message}"
