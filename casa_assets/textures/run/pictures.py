"""Packs of a project or library: their pictures as recipes of textures, and their files as finishes."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Collection, Iterator
from pathlib import Path

from pydantic import Field, ValidationError

from casa_assets.errors import OutputError
from casa_assets.model.asset.material import ColorSpace, Substance, Texture
from casa_assets.model.record import Id, Record, Sha256
from casa_assets.model.registry.rows import Finish, TextureRecipe
from casa_assets.projects import project_folder, read_once
from casa_assets.textures import pack_pictures
from casa_assets.textures.canvas import Layers
from casa_assets.textures.finish import textured
from casa_assets.textures.pack_entry import MAX_FILE_BYTES, MAX_SIDE_PX, FileName, Pack, PackPicture

# Folder of packs in a project or a library, and the list of its pictures in each.
FOLDER, PACK = "textures", "pack.json"


def load_pack(folder: Path) -> Pack:
    """The pack in a folder. Raises OutputError where pack.json is missing or damaged."""
    try:
        return Pack.from_json((folder / PACK).read_text(encoding="utf-8"))
    except (OSError, ValidationError, ValueError) as error:
        message = f"cannot be read: {str(error).splitlines()[0]}; ingest it again"
        raise OutputError(str(folder / PACK), message) from error


def packs_of(project: Path) -> Iterator[tuple[Path, Pack]]:
    """The packs of a project with their folders, sorted by name. Raises OutputError where a pack.json is damaged."""
    for path in sorted((project / FOLDER).glob(f"*/{PACK}")):
        yield path.parent, load_pack(path.parent)


def credits_of_pictures(names: Collection[str]) -> list[dict[str, str]]:
    """Return a row of credits for each of these ids that is a picture in a pack of the project in use."""
    project = project_folder()
    pictures = (p for _, pack in (packs_of(project) if project is not None else ()) for p in pack.pictures)
    found = {p.id: p for p in pictures if p.id in names}
    rows = sorted(found.items())
    return [{"id": name, "licence": p.licence, "author": p.author, "generator": p.generator} for name, p in rows]


# Kind of a recipe that is not painted, but is a picture of a pack.
KIND = "picture"
_PNG = b"\x89PNG\r\n\x1a\n"
_SPACES = (ColorSpace.SRGB, ColorSpace.RAW, ColorSpace.RAW)


class PictureParams(Record):
    """Params of a recipe of the kind `picture`: which files it is, by value, so that other files are another recipe."""

    pack: Id = Field(description="its id, which is the name of its folder too")
    files: tuple[FileName, FileName, FileName] = Field(
        description="base, normal and roughness, in the folder of the pack"
    )
    sha256: tuple[Sha256, Sha256, Sha256] = Field(description="of each")
    licence: str = Field(description="as the pack has it; kitchens name it too")
    author: str
    generator: str


def recipe_of(pack: str, picture: PackPicture) -> TextureRecipe:
    """A picture of a pack, which is named as its folder, as a recipe."""
    copied = {name: getattr(picture, name) for name in PictureParams.model_fields if name != "pack"}
    return TextureRecipe(
        id=picture.id,
        surface=picture.surface,
        kind=KIND,
        seed=0,
        tile_m=picture.tile_m,
        substance=picture.substance,
        params=PictureParams(pack=pack, **copied).to_json(),
    )


def pack_of(recipe: TextureRecipe) -> str:
    """Name of the pack that a recipe is a picture of; empty where it is painted."""
    return PictureParams.from_json(recipe.params).pack if recipe.kind == KIND else ""


def finish_of_picture(recipe: TextureRecipe, substance: Substance) -> Finish:
    """The finish of a picture of a pack of the project in use. Raises OutputError."""
    rows = zip(PictureParams.from_json(recipe.params).files, read_files(recipe), _SPACES, strict=True)
    return textured(recipe.id, recipe.tile_m, [_texture(*row) for row in rows], substance)


def resized_finish(recipe: TextureRecipe, substance: Substance, size_px: int) -> Finish:
    """Return `finish_of_picture` with its pictures scaled down to at most `size_px` on the longer side."""
    whole = {texture.name: texture for texture in finish_of_picture(recipe, substance).material.textures}
    names = [Path(path).stem for path in PictureParams.from_json(recipe.params).files]
    longest = max(whole[names[0]].width_px, whole[names[0]].height_px)
    textures = []
    for name in names:
        limit = round(size_px * max(whole[name].width_px, whole[name].height_px) / longest)
        pixels = pack_pictures.scaled(pack_pictures.pixels_of(whole[name].png), limit)
        size = {"width_px": pixels.shape[1], "height_px": pixels.shape[0]}
        textures.append(whole[name].replace(png=pack_pictures.png(pixels), **size))
    return textured(recipe.id, recipe.tile_m, textures, substance)


def layers_of_picture(recipe: TextureRecipe, size_px: int) -> Layers:
    """Return a picture as the layers of a recipe, at most `size_px` pixels on the longer side; its relief is flat."""
    base, _, rough = (pack_pictures.scaled(pack_pictures.pixels_of(data), size_px) for data in read_files(recipe))
    return Layers.of(base, base[..., 0] * 0.0, rough[..., 1])


@read_once
def check_files(recipe: TextureRecipe) -> None:
    """Raise OutputError where a file of a picture is missing or is not the one that was written; looked at once."""
    read_files(recipe)


def read_files(recipe: TextureRecipe) -> tuple[bytes, ...]:
    """Bytes of base, normal and roughness, which are those that the recipe names. Raises as `finish_of_picture`."""
    params = PictureParams.from_json(recipe.params)
    project = project_folder()
    if project is None:
        raise OutputError(params.pack, "is a texture pack of a project, and no project is in use")
    folder = project / FOLDER / params.pack
    return tuple(_read(folder / path, digest) for path, digest in zip(params.files, params.sha256, strict=True))


def _read(path: Path, digest: str) -> bytes:
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise OutputError(str(path), f"has over {MAX_FILE_BYTES // 2**20} MiB; ingest the pack again")
        data = path.read_bytes()
    except OSError as error:
        raise OutputError(str(path), f"cannot be read: {error.strerror}; ingest the pack again") from error
    if hashlib.sha256(data).hexdigest() != digest:
        raise OutputError(str(path), "is not the file that was written; ingest the pack again")
    return data


def _texture(path: str, png: bytes, space: ColorSpace) -> Texture:
    """A picture by its file. Raises OutputError where its header is that of no PNG of a size that packs have."""
    width, height = struct.unpack(">II", png[16:24]) if png.startswith(_PNG) and len(png) > 24 else (0, 0)  # IHDR
    if not (0 < width <= MAX_SIDE_PX and 0 < height <= MAX_SIDE_PX):
        raise OutputError(path, "is no PNG that a pack holds; ingest the pack again")
    return Texture(name=path.removesuffix(".png"), png=png, width_px=width, height_px=height, color_space=space)
