"""A folder of pictures into `<library>/textures/<pack>/`, and such a pack back into finishes."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from casa_assets import registry
from casa_assets.errors import CasaError, OutputError
from casa_assets.model.asset.material import ColorSpace, Material, Substance, Texture
from casa_assets.model.files import Files
from casa_assets.model.record import Record
from casa_assets.model.registry.finish import Finish
from casa_assets.pipeline.cache.store import Store
from casa_assets.pipeline.library.library import Library, file_digests, write_files
from casa_assets.pipeline.textures.pack_survey import AcceptedPicture, PackOptions, read_description, survey
from casa_assets.preview.sheet import SheetCell, contact_sheet
from casa_assets.textures.distance import NEARLY_ALIKE, TextureDescriptor, closest_pairs, describe_texture
from casa_assets.textures.finish import finish
from casa_assets.textures.packs import derive
from casa_assets.textures.packs.derive import layers, pixels_of
from casa_assets.textures.packs.entry import UNKNOWN, Pack, PackPicture, SimilarPair
from casa_assets.textures.packs.naming import slug, unique_ids

__all__ = ["PackOptions", "PackReport", "ingest_pack", "load_finishes", "load_pack"]

FOLDER, PACK, SHEET = "textures", "pack.json", "sheet.png"
# Version of the format of pack.json.
FORMAT = 2
_LOOK_STEP = 4  # pixels are compared at a quarter of the size


@dataclass(frozen=True)
class PackReport:
    """Outcome of ingesting a pack.

    Attributes:
        folder: where the pack is. pack: its pictures and refusals.
        changed: whether the folder was written; False where it held the same bytes already.
    """

    folder: Path
    pack: Pack
    changed: bool


def ingest_pack(folder: Path, options: PackOptions) -> PackReport:
    """Take in every picture under a folder. One bad picture is left out with its reason, the others go on.

    Raises:
        CasaError: the folder is not there.
        RegistryError: pack.yaml is no YAML or has keys that nobody knows.
        OutputError: the library cannot be written to, or another run holds it.
    """
    if not folder.is_dir():
        raise CasaError(f"{folder}: no such folder")
    description = read_description(folder)
    name = slug(options.pack or description.pack or folder.absolute().name)
    library = Library(options.library)
    with library.locked():
        found = survey(folder, description, options, Store(library.cache))
        staged = library.stage(name)
        ids = unique_ids(name, [accepted.fields.name or Path(accepted.source).stem for accepted in found.accepted])
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
        target = library.root / FOLDER / name
        return PackReport(target, pack, _put_if_changed(library, staged, target))


def load_pack(folder: Path) -> Pack:
    """The pack in a folder. Raises OutputError where pack.json is missing or damaged."""
    try:
        return Pack.from_json((folder / PACK).read_text(encoding="utf-8"))
    except (OSError, ValidationError, ValueError) as error:
        raise OutputError(
            str(folder / PACK), f"cannot be read: {str(error).splitlines()[0]}; ingest it again"
        ) from error


def load_finishes(folder: Path, substances: Mapping[str, Substance]) -> dict[str, Finish]:
    """Every picture of a pack as a finish, by id.

    Args:
        folder: `<library>/textures/<pack>`.
        substances: of the registry.
    Raises:
        OutputError: a file is missing, or is not the one that was written.
    """
    return {p.id: _finish(folder, p, substances[p.substance]) for p in load_pack(folder).pictures}


def _picture(id_: str, accepted: AcceptedPicture) -> tuple[PackPicture, dict[str, bytes], TextureDescriptor]:
    """The record of a picture, its three files by name, and a descriptor to compare it with others by."""
    fields, tile = accepted.fields, accepted.prepared.tile
    assert fields.surface is not None
    assert fields.tile_m is not None
    assert fields.licence is not None
    base = pixels_of(tile.base)
    size = (round(fields.tile_m[0] * tile.kept[0], 4), round(fields.tile_m[1] * tile.kept[1], 4))
    texture_layers = layers(base, fields.surface, fields.roughness)
    substance = registry.load().substances[fields.substance or UNKNOWN]
    images = finish(id_, size, texture_layers, substance).material.textures
    names = {"color": "base", "metallic_roughness": "roughness", "normal": "normal"}
    files = {f"{id_}_{names[t.name.removeprefix(f'{id_}_')]}.png": t.png for t in images}
    paths = tuple(f"{id_}_{role}.png" for role in ("base", "normal", "roughness"))
    notes = list(accepted.prepared.notes)
    if tile.repaired:
        notes.append(f"was cut to {tile.kept[0]:.0%} x {tile.kept[1]:.0%} and its border repaired")
    if tile.seam_after > derive.VISIBLE_SEAM:
        notes.append("its border can still be found by who looks for it")
    picture = PackPicture(
        id=id_,
        source=accepted.source,
        source_sha256=accepted.sha256,
        surface=fields.surface,
        substance=substance.id,
        tile_m=size,
        width_px=tile.width_px,
        height_px=tile.height_px,
        licence=fields.licence,
        prompt=fields.prompt or accepted.prepared.prompt or UNKNOWN,
        generator=fields.generator or UNKNOWN,
        author=fields.author or UNKNOWN,
        seam_before=tile.seam_before,
        seam_after=tile.seam_after,
        repaired=tile.repaired,
        derived=("normal", "roughness"),
        files=(paths[0], paths[1], paths[2]),
        sha256=tuple(hashlib.sha256(files[p]).hexdigest() for p in paths),
        notes=tuple(notes),
    )
    coarse = slice(None, None, _LOOK_STEP)
    return picture, files, describe_texture(base[coarse, coarse], size)


def _finish(folder: Path, picture: PackPicture, substance: Substance) -> Finish:
    spaces = (ColorSpace.SRGB, ColorSpace.RAW, ColorSpace.RAW)
    textures = []
    for path, digest, space in zip(picture.files, picture.sha256, spaces, strict=True):
        try:
            data = (folder / path).read_bytes()
        except OSError as error:
            raise OutputError(str(folder / path), f"cannot be read: {error.strerror}; ingest the pack again") from error
        if hashlib.sha256(data).hexdigest() != digest:
            raise OutputError(str(folder / path), "is not the file that was written; ingest the pack again")
        width, height = int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")  # IHDR
        name = path.removesuffix(".png")
        textures.append(Texture(name=name, png=data, width_px=width, height_px=height, color_space=space))
    return Finish(
        id=picture.id,
        material=Material(
            id=picture.id,
            base_color=(1.0, 1.0, 1.0, 1.0),
            metallic=1.0,  # multiplied with the blue of the picture, which is 0
            roughness=1.0,
            base_color_texture=textures[0],
            normal_texture=textures[1],
            metallic_roughness_texture=textures[2],
            tile_m=picture.tile_m,
            substance=substance.id,
        ),
        substance=substance,
    )


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
