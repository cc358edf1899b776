"""Pictures of a folder into a pack, `<library>/textures/<pack>/`: survey, tile, check, publish."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.errors import CasaError, OutputError, RegistryError, Rejected
from casa_assets.library.entry_files import file_digests, write_files
from casa_assets.library.library import Library
from casa_assets.model.asset.material import Substance
from casa_assets.model.issue import Files, Report
from casa_assets.model.record import Record, Vec2
from casa_assets.model.registry.rows import Finish, Surface
from casa_assets.projects import SETTINGS, project_folder, read_again
from casa_assets.show.stills.pictures import SheetCell, contact_sheet
from casa_assets.textures import pack_pictures
from casa_assets.textures.check import check_pictures, pictures_of
from casa_assets.textures.distance import NEARLY_ALIKE, TextureDescriptor, closest_pairs, describe_texture
from casa_assets.textures.pack_entry import (
    MAX_FILE_BYTES,
    UNKNOWN,
    MapRole,
    MaterialFiles,
    Pack,
    PackPicture,
    PictureDescription,
    PictureRejection,
    RejectedPicture,
    SimilarPair,
    group_maps,
    rejection_row,
    slug,
    unique_ids,
)
from casa_assets.textures.pack_pictures import TiledPicture, tile
from casa_assets.textures.run.pictures import FOLDER, PACK, pack_of
from casa_assets.textures.run.recipes import every_recipe, origin_of


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
            raise Rejected(PictureRejection.UNREADABLE, "is a link that leaves the folder")
        if not path.is_file():
            raise Rejected(PictureRejection.UNREADABLE, "is no regular file")
        if path.stat().st_size > MAX_FILE_BYTES:
            raise Rejected(PictureRejection.TOO_LARGE, f"has over {MAX_FILE_BYTES // 2**20} MiB")
        return path.read_bytes()
    except (OSError, RuntimeError) as error:  # RuntimeError: links in a circle
        raise Rejected(PictureRejection.UNREADABLE, f"cannot be read: {error}") from None


MANIFESTS = ("pack.yaml", "pack.yml", "pack.json")
_KEYS = ("pack", "defaults", "pictures")
_SAME_ASPECT = 0.02  # by which the shape of a map may differ from that of the colour


@dataclass(frozen=True)
class PackOptions:
    """Options of ingesting a folder of pictures.

    library: output folder. pack: its name; None: the folder's. size_px: longer side. flags: of pictures without others.
    """

    library: Path
    pack: str | None = None
    flags: PictureDescription = field(default_factory=PictureDescription)
    size_px: int = pack_pictures.SIZE_PX


@dataclass(frozen=True)
class PackDescription:
    """Description of the pictures of a source."""

    pack: str | None  # name
    defaults: PictureDescription  # for all pictures
    rows: Mapping[str, PictureDescription]  # by file, or by name of the material
    faults: Mapping[str, str]  # pictures with an invalid row, and the error
    used: tuple[str, ...]  # files that are not pictures and were read


@dataclass(frozen=True)
class AcceptedPicture:
    """A picture that can be used."""

    name: str  # of the material
    source: str  # file of the colour, relative to the folder
    sha256: str  # of its bytes
    maps: Mapping[str, str]  # name of a map that it came with -> its file
    fields: PictureDescription
    tile: TiledPicture


def read_description(source: Path) -> PackDescription:
    """Read the descriptions of pictures in pack.yaml (or pack.json) of a folder. Raises RegistryError."""
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


def survey(
    source: Path, description: PackDescription, options: PackOptions, store: Store
) -> tuple[list[AcceptedPicture], tuple[RejectedPicture, ...], tuple[str, ...]]:
    """Pictures of a folder that can be used, those that cannot, and files that are no pictures; each sorted by path."""
    accepted: list[AcceptedPicture] = []
    refusals: list[RejectedPicture] = []
    by_bytes: dict[str, str] = {}
    found = list_files(source)
    groups = pack_pictures.SUFFIX_GROUPS
    shown = [path for suffixes in groups for path in found if Path(path).suffix.lower() in suffixes]
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
            missing = Rejected(PictureRejection.MISSING, "is named in pack.yaml and is not there")
            refusals.append(rejection_row(name, missing))
    read = {*description.used, *(path for files in materials for path in files.maps.values())}
    return accepted, tuple(sorted(refusals, key=lambda r: r.source)), tuple(path for path in found if path not in read)


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
        raise Rejected(PictureRejection.NO_COLOR, f"{files.name} has {', '.join(files.maps)} and no colour")
    data = read_file(folder, source)
    digest = hashlib.sha256(data).hexdigest()
    if digest in by_bytes:
        raise Rejected(PictureRejection.DUPLICATE, f"holds the same bytes as {by_bytes[digest]}")
    by_bytes[digest] = source
    fields = _picture_fields(files, description, options.flags)
    made = _tiled(data, digest, files.maps, folder, options.size_px, store)
    origins = {name: files.maps[MapRole(name)] for name in sorted(made.maps)}
    return AcceptedPicture(files.name, source, digest, origins, fields, made)


def _picture_fields(
    files: MaterialFiles, description: PackDescription, flags: PictureDescription
) -> PictureDescription:
    """Merge the fields stated for a picture: its row, the flags, the defaults of the file."""
    source = files.maps[MapRole.COLOR]
    keys = [key for key in (*description.rows, *description.faults) if key == source or slug(key) == slug(files.name)]
    if keys and keys[0] in description.faults:
        raise Rejected(PictureRejection.BAD_ROW, description.faults[keys[0]])
    row = description.rows[keys[0]] if keys else PictureDescription()
    fields = row.over(flags).over(description.defaults)
    missing = [name for name in ("surface", "tile_m", "licence") if getattr(fields, name) is None]
    if missing:
        raise Rejected(PictureRejection.NOT_DESCRIBED, f"nobody says its {', '.join(missing)}")
    if (fields.substance or UNKNOWN) not in registry.load().substances:
        raise Rejected(PictureRejection.BAD_ROW, f"{fields.substance!r} is no substance of registry/substances.yaml")
    return fields


def _tiled(
    data: bytes, digest: str, maps: Mapping[MapRole, str], folder: Path, size_px: int, store: Store
) -> TiledPicture:
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
    key = digest_of("texture_pack", key_of(pack_pictures.decode, tile, _given), digest, digests, size_px)
    if (kept := store.get(key)) is not None:
        made = TiledPicture.from_json(kept)
    else:
        decoded = pack_pictures.decode(data)
        small = pack_pictures.scaled(decoded.pixels, size_px)
        given, left_out = _given(read, small.shape[1] / small.shape[0], size_px)
        made = tile(small, size_px, given).replace(prompt=decoded.prompt, notes=(*decoded.notes, *left_out))
        store.put(key, made.to_json().encode())
    return made.replace(notes=(*made.notes, *notes))


def _given(
    read: Mapping[MapRole, bytes], aspect: float, size_px: int
) -> tuple[dict[str, pack_pictures.Floats], tuple[str, ...]]:
    """Maps by name, in the order of MapRole, and notes on those that cannot be used.

    read: bytes of the files. aspect: width over height of the colour. size_px: longer side after scaling down.
    """
    planes: dict[MapRole, pack_pictures.Floats] = {}
    notes: list[str] = []
    for role, data in read.items():
        try:
            pixels = pack_pictures.decode_map(data, role)
            if abs(pixels.shape[1] / pixels.shape[0] / aspect - 1.0) > _SAME_ASPECT:
                raise Rejected(PictureRejection.TOO_LONG, "has another shape than the colour")
            planes[role] = pack_pictures.scaled(pixels, size_px)
        except Rejected as error:
            notes.append(_without(role, error))
    ordered = [(role, planes[role]) for role in MapRole if role in planes]
    return {r.value: p if r is MapRole.NORMAL else p[..., :1] for r, p in ordered}, tuple(notes)


def _without(role: MapRole, error: Rejected) -> str:
    return f"its map of the {role.value} was left out: it {error.message}"


SHEET = "sheet.png"
# Version of the format of pack.json.
FORMAT = 3
_LOOK_STEP = 4  # pixels are compared at a quarter of the size
# Longer side of a picture: the first whose files are small enough; photographs pack badly.
SIZES_PX = (1024, 896, 768, 640, 512)


@dataclass(frozen=True)
class PackReport:
    """Outcome of ingesting a pack."""

    folder: Path  # of the pack
    pack: Pack
    changed: bool  # False: the folder held the same bytes already


def ingest_pack(source: Path, options: PackOptions) -> PackReport:
    """Ingest every picture of a folder.

    Unusable pictures are left out with a reason, the others are ingested. Raises CasaError: the folder does not exist,
    or an id is already used in the project that is written to. RegistryError: pack.yaml is not valid YAML or has
    unknown keys. OutputError: the library cannot be written to, another run holds it, or its target folder holds no
    pack.
    """
    if not source.is_dir():
        raise CasaError(f"{source}: {'is no folder; unpack it first' if source.exists() else 'no such folder'}")
    description = read_description(source)
    name = slug(options.pack or description.pack or source.absolute().stem)
    library = Library(options.library)
    target = library.root / FOLDER / name
    _check_place(source, target)
    taken = _taken(library.root, name)
    with library.locked():
        _keep_out_of_git(library)
        taken_in, refused, ignored = survey(source, description, options, Store(library.cache))
        staged = library.stage(name)
        ids = unique_ids(name, [accepted.fields.name or accepted.name for accepted in taken_in])
        _check_ids(ids, taken, name)
        pictures: list[PackPicture] = []
        descriptors: dict[str, TextureDescriptor] = {}
        shots: list[SheetCell] = []
        for id_, accepted in zip(ids, taken_in, strict=True):
            picture, files, descriptors[id_] = _picture(id_, accepted)
            write_files(staged, Files(entries=files))  # at once: a large pack does not fit into memory
            pictures.append(picture)
            size = f"{picture.surface.value}, {picture.tile_m[0]:g} x {picture.tile_m[1]:g} m"
            # The picture in the size of a cell of the contact sheet, PNG.
            pixels = pack_pictures.pixels_of(files[picture.files[0]])
            step = max(1, max(pixels.shape[:2]) // 192)
            height, width = (n - n % step for n in pixels.shape[:2])
            blocks = pixels[:height, :width].reshape(height // step, step, width // step, step, 3)
            shots.append(SheetCell(id_.removeprefix(f"{name}_"), size, pack_pictures.png(blocks.mean(axis=(1, 3)))))
        pairs = closest_pairs(descriptors, below=NEARLY_ALIKE, most=100)
        pack = Pack(
            id=name,
            version=FORMAT,
            pictures=tuple(pictures),
            refused=refused,
            alike=tuple(SimilarPair(first=a, second=b, distance=round(d, 3)) for d, a, b in pairs),
            ignored=ignored,
        )
        page = contact_sheet(shots, f"{name}: {len(pictures)} pictures, {len(refused)} left out")
        write_files(staged, Files(entries={PACK: _text(pack), SHEET: page}))
        report = PackReport(target, pack, _put_if_changed(library, staged, target))
    if _is_in_use(library.root):
        read_again()  # so that this process sees the pack
    return report


def _is_in_use(root: Path) -> bool:
    project = project_folder()
    return project is not None and project.resolve() == root.resolve()


def _check_place(source: Path, target: Path) -> None:
    """Raise OutputError where the pack would take the place of what it is made of, or of something that is no pack."""
    origin, place = source.resolve(), target.resolve()
    if origin.is_relative_to(place) or place.is_relative_to(origin):
        message = "the pack would stand among the pictures that it is made of; move these elsewhere, or choose --pack"
        raise OutputError(str(target), message)
    if target.exists() and not (target / PACK).is_file():
        raise OutputError(str(target), "is there already and is no pack; choose another name with --pack")


def _taken(root: Path, name: str) -> Mapping[str, str]:
    """Ids that a pack in the project in use may not have, with what has them; none in a library."""
    if not _is_in_use(root):
        return {}
    textures = {i: f"a texture of {origin_of(r)}" for i, r in every_recipe().items() if pack_of(r) != name}
    return {**textures, **dict.fromkeys(registry.load().materials, "a finish of materials.yaml")}


def _check_ids(ids: Iterable[str], taken: Mapping[str, str], name: str) -> None:
    """Raise CasaError where an id is taken."""
    for id_ in ids:
        if id_ in taken:
            raise CasaError(f"{id_}: is the id of {taken[id_]}; call the pack {name!r} otherwise, with --pack")


def _keep_out_of_git(library: Library) -> None:
    """Have git pass over what a library keeps for itself, where the library is a project."""
    note = library.private / ".gitignore"
    if (library.root / SETTINGS).is_file() and not note.exists():
        note.write_text("*\n", encoding="utf-8")


def _picture(id_: str, accepted: AcceptedPicture) -> tuple[PackPicture, dict[str, bytes], TextureDescriptor]:
    """The record of a picture, its three files by name, and a descriptor to compare it with others by."""
    fields, tile = accepted.fields, accepted.tile
    assert fields.surface is not None
    assert fields.tile_m is not None
    assert fields.licence is not None
    size = (round(fields.tile_m[0] * tile.kept[0], 4), round(fields.tile_m[1] * tile.kept[1], 4))
    substance = registry.load().substances[fields.substance or UNKNOWN]
    made, checked = _finish(id_, tile, size, (fields.surface, fields.roughness), substance)
    base = made.material.base_color_texture
    assert base is not None
    names = {"color": "base", "metallic_roughness": "roughness", "normal": "normal"}
    files = {f"{id_}_{names[t.name.removeprefix(f'{id_}_')]}.png": t.png for t in made.material.textures}
    paths = tuple(f"{id_}_{role}.png" for role in ("base", "normal", "roughness"))
    notes = list(tile.notes)
    if tile.repaired:
        notes.append(f"was cut to {tile.kept[0]:.0%} x {tile.kept[1]:.0%} and its border repaired")
    if base.width_px < tile.width_px:
        pixels = f"{base.width_px} x {base.height_px} pixels"
        notes.append(f"was scaled down to {pixels}, so that its files are not too large")
    if tile.seam_after > pack_pictures.VISIBLE_SEAM:
        notes.append("its border can still be found by who looks for it")
    picture = PackPicture(
        id=id_,
        source=accepted.source,
        source_sha256=accepted.sha256,
        surface=fields.surface,
        substance=substance.id,
        tile_m=size,
        width_px=base.width_px,
        height_px=base.height_px,
        licence=fields.licence,
        prompt=fields.prompt or tile.prompt or UNKNOWN,
        generator=fields.generator or UNKNOWN,
        author=fields.author or UNKNOWN,
        seam_before=tile.seam_before,
        seam_after=tile.seam_after,
        repaired=tile.repaired,
        given=dict(accepted.maps),
        derived=tuple(name for name in ("normal", "roughness") if name not in accepted.maps),
        files=(paths[0], paths[1], paths[2]),
        sha256=tuple(hashlib.sha256(files[p]).hexdigest() for p in paths),
        notes=tuple(notes),
        faults=tuple(f"{issue.code} {issue.message}" for issue in checked.issues),
    )
    coarse = slice(None, None, _LOOK_STEP)
    return picture, files, describe_texture(pack_pictures.pixels_of(base.png)[coarse, coarse], size)


def _finish(
    name: str, made: TiledPicture, tile_m: Vec2, look: tuple[Surface, float | None], substance: Substance
) -> tuple[Finish, Report]:
    """The finish of a picture and its checks, in the largest size whose files are as small as a check asks for."""
    limits = registry.load().limits
    for size_px in SIZES_PX:
        whole = pack_pictures.finish_of_tile(name, made, tile_m, look, substance, size_px)
        report = check_pictures(pictures_of(whole), limits)
        if "TEX011" not in [issue.code for issue in report.issues]:
            break
    return whole, report


def _text(record: Record) -> bytes:
    return (json.dumps(record.model_dump(mode="json"), sort_keys=True, indent=1, ensure_ascii=False) + "\n").encode()


def _put_if_changed(library: Library, staged: Path, target: Path) -> bool:
    """Put the pack in its place by one rename; False where it is there already, byte for byte."""
    if target.is_dir() and file_digests(target) == file_digests(staged):
        shutil.rmtree(staged.parent)
        return False
    library.put(staged, target)
    return True
