"""Pictures of a folder into `<library>/textures/<pack>/`."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from casa_assets import registry
from casa_assets.cache.store import Store
from casa_assets.errors import CasaError, OutputError
from casa_assets.library.library import Library, file_digests, write_files
from casa_assets.model.asset.material import Substance
from casa_assets.model.issue import Files, Report
from casa_assets.model.record import Record, Vec2
from casa_assets.model.registry.rows import Finish, Surface
from casa_assets.projects import SETTINGS, project_folder, read_again
from casa_assets.show.stills.pictures import SheetCell, contact_sheet
from casa_assets.textures.check import check_pictures, pictures_of
from casa_assets.textures.distance import NEARLY_ALIKE, TextureDescriptor, closest_pairs, describe_texture
from casa_assets.textures.packs import pictures as derive
from casa_assets.textures.packs.entry import UNKNOWN, Pack, PackPicture, SimilarPair, slug, unique_ids
from casa_assets.textures.packs.pictures import TiledPicture, finish_of_tile, pixels_of
from casa_assets.textures.run.packs.pictures import FOLDER, PACK, pack_of
from casa_assets.textures.run.packs.survey import AcceptedPicture, PackOptions, read_description, survey
from casa_assets.textures.run.recipes import every_recipe, origin_of

__all__ = ["PackOptions", "PackReport", "ingest_pack"]

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

    Unusable pictures are left out with a reason, the others are ingested.

    Raises:
        CasaError: the folder does not exist, or an id is already used in the project that is written to.
        RegistryError: pack.yaml is not valid YAML or has unknown keys.
        OutputError: the library cannot be written to, another run holds it, or its target folder holds no pack.
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
        found = survey(source, description, options, Store(library.cache))
        staged = library.stage(name)
        ids = unique_ids(name, [accepted.fields.name or accepted.name for accepted in found.accepted])
        _check_ids(ids, taken, name)
        pictures: list[PackPicture] = []
        descriptors: dict[str, TextureDescriptor] = {}
        shots: list[SheetCell] = []
        for id_, accepted in zip(ids, found.accepted, strict=True):
            picture, files, descriptors[id_] = _picture(id_, accepted)
            write_files(staged, Files(entries=files))  # at once: a large pack does not fit into memory
            pictures.append(picture)
            size = f"{picture.surface.value}, {picture.tile_m[0]:g} x {picture.tile_m[1]:g} m"
            shots.append(SheetCell(id_.removeprefix(f"{name}_"), size, _sheet_picture(files[picture.files[0]])))
        pairs = closest_pairs(descriptors, below=NEARLY_ALIKE, most=100)
        pack = Pack(
            id=name,
            version=FORMAT,
            pictures=tuple(pictures),
            refused=found.refused,
            alike=tuple(SimilarPair(first=a, second=b, distance=round(d, 3)) for d, a, b in pairs),
            ignored=found.ignored,
        )
        page = contact_sheet(shots, f"{name}: {len(pictures)} pictures, {len(found.refused)} left out")
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
    fields, tile = accepted.fields, accepted.prepared.tile
    assert fields.surface is not None
    assert fields.tile_m is not None
    assert fields.licence is not None
    size = (round(fields.tile_m[0] * tile.kept[0], 4), round(fields.tile_m[1] * tile.kept[1], 4))
    known = registry.load()
    substance = known.substances[fields.substance or UNKNOWN]
    made, checked = _finish(id_, tile, size, (fields.surface, fields.roughness), substance)
    base = made.material.base_color_texture
    assert base is not None
    names = {"color": "base", "metallic_roughness": "roughness", "normal": "normal"}
    files = {f"{id_}_{names[t.name.removeprefix(f'{id_}_')]}.png": t.png for t in made.material.textures}
    paths = tuple(f"{id_}_{role}.png" for role in ("base", "normal", "roughness"))
    notes = list(accepted.prepared.notes)
    if tile.repaired:
        notes.append(f"was cut to {tile.kept[0]:.0%} x {tile.kept[1]:.0%} and its border repaired")
    if base.width_px < tile.width_px:
        notes.append(
            f"was scaled down to {base.width_px} x {base.height_px} pixels, so that its files are not too large"
        )
    if tile.seam_after > derive.VISIBLE_SEAM:
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
        prompt=fields.prompt or accepted.prepared.prompt or UNKNOWN,
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
    return picture, files, describe_texture(pixels_of(base.png)[coarse, coarse], size)


def _finish(
    name: str, made: TiledPicture, tile_m: Vec2, look: tuple[Surface, float | None], substance: Substance
) -> tuple[Finish, Report]:
    """The finish of a picture and its checks, in the largest size whose files are as small as a check asks for."""
    limits = registry.load().limits
    for size_px in SIZES_PX:
        whole = finish_of_tile(name, made, tile_m, look, substance, size_px)
        report = check_pictures(pictures_of(whole), limits)
        if "TEX011" not in [issue.code for issue in report.issues]:
            break
    return whole, report


def _text(record: Record) -> bytes:
    data = record.model_dump(mode="json")
    return (json.dumps(data, sort_keys=True, indent=1, ensure_ascii=False) + "\n").encode()


def _sheet_picture(png: bytes) -> bytes:
    """The picture in the size of a cell of the contact sheet, PNG."""
    pixels = pixels_of(png)
    step = max(1, max(pixels.shape[:2]) // 192)
    height, width = (n - n % step for n in pixels.shape[:2])
    blocks = pixels[:height, :width].reshape(height // step, step, width // step, step, 3)
    return derive.png(blocks.mean(axis=(1, 3)))


def _put_if_changed(library: Library, staged: Path, target: Path) -> bool:
    """Put the pack in its place by one rename; False where it is there already, byte for byte."""
    if target.is_dir() and file_digests(target) == file_digests(staged):
        shutil.rmtree(staged.parent)
        return False
    library.put(staged, target)
    return True
