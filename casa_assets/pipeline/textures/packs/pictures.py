"""Packs of a project or library: their pictures as recipes of textures, and their files as finishes."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from pydantic import ValidationError

from casa_assets.errors import OutputError
from casa_assets.model.asset.material import ColorSpace, Material, Substance, Texture
from casa_assets.model.record import Id, Record, Sha256, Vec2
from casa_assets.model.registry.rows import Finish, TextureRecipe
from casa_assets.projects import project_folder, read_once
from casa_assets.textures.canvas import Layers
from casa_assets.textures.packs import pictures as derive
from casa_assets.textures.packs.entry import MAX_FILE_BYTES, MAX_SIDE_PX, FileName, Pack, PackPicture

# Read -----------------------------------------------------------------------------------------------------------------
# Read the packs of a project, or of a library.

# Folder of packs in a project or a library, and the file in each that says what it holds.
FOLDER, PACK = "textures", "pack.json"


def load_pack(folder: Path) -> Pack:
    """The pack in a folder. Raises OutputError where pack.json is missing or damaged."""
    try:
        return Pack.from_json((folder / PACK).read_text(encoding="utf-8"))
    except (OSError, ValidationError, ValueError) as error:
        raise OutputError(
            str(folder / PACK), f"cannot be read: {str(error).splitlines()[0]}; ingest it again"
        ) from error


def packs_of(project: Path) -> Iterator[tuple[Path, Pack]]:
    """The packs of a project with their folders, sorted by name. Raises OutputError where a pack.json is damaged."""
    for path in sorted((project / FOLDER).glob(f"*/{PACK}")):
        yield path.parent, load_pack(path.parent)


def credits_of_pictures(names: Collection[str]) -> list[dict[str, str]]:
    """Return a row of credits for each of these ids that is a picture in a pack of the project in use."""
    project = project_folder()
    pictures = (p for _, pack in (packs_of(project) if project is not None else ()) for p in pack.pictures)
    found = {p.id: p for p in pictures if p.id in names}
    return [
        {"id": name, "licence": p.licence, "author": p.author, "generator": p.generator}
        for name, p in sorted(found.items())
    ]


# Pictures -------------------------------------------------------------------------------------------------------------
# Pictures of packs: those of the project in use as recipes of textures, and their files as finishes.

# Kind of a recipe that is not painted, but is a picture of a pack.
KIND = "picture"
_PNG = b"\x89PNG\r\n\x1a\n"
_SPACES = (ColorSpace.SRGB, ColorSpace.RAW, ColorSpace.RAW)


class PictureParams(Record):
    """Params of a recipe of the kind `picture`: which files it is, by value, so that other files are another recipe.

    Attributes:
        pack: its id, which is the name of its folder too.
        files: base, normal and roughness, in the folder of the pack. sha256: of each.
        licence, author, generator: as the pack has them; kitchens name them too.
    """

    pack: Id
    files: tuple[FileName, FileName, FileName]
    sha256: tuple[Sha256, Sha256, Sha256]
    licence: str
    author: str
    generator: str


def load_finishes(folder: Path, substances: Mapping[str, Substance]) -> dict[str, Finish]:
    """Every picture of a pack as a finish, by id.

    Args:
        folder: `<library>/textures/<pack>`.
        substances: of the registry.
    Raises:
        OutputError: a file is missing, or is not the one that was written.
    """
    recipes = [recipe_of(folder.name, picture) for picture in load_pack(folder).pictures]
    return {recipe.id: finish_of_picture(recipe, substances[recipe.substance], folder) for recipe in recipes}


def recipe_of(pack: str, picture: PackPicture) -> TextureRecipe:
    """A picture of a pack as a recipe.

    Args:
        pack: name of the folder of the pack.
    """
    return TextureRecipe(
        id=picture.id,
        surface=picture.surface,
        kind=KIND,
        seed=0,
        tile_m=picture.tile_m,
        substance=picture.substance,
        params=PictureParams(
            pack=pack,
            files=picture.files,
            sha256=picture.sha256,
            licence=picture.licence,
            author=picture.author,
            generator=picture.generator,
        ).to_json(),
    )


def pack_of(recipe: TextureRecipe) -> str:
    """Name of the pack that a recipe is a picture of; empty where it is painted."""
    return PictureParams.from_json(recipe.params).pack if recipe.kind == KIND else ""


def finish_of_picture(recipe: TextureRecipe, substance: Substance, folder: Path | None = None) -> Finish:
    """The finish of a picture.

    Args:
        recipe: of the kind `picture`. substance: its own.
        folder: of the pack; None: that in the project in use.
    Raises:
        OutputError: a file is missing, or is not the one that was written.
    """
    params = PictureParams.from_json(recipe.params)
    textures = [
        _texture(path, data, space)
        for path, data, space in zip(params.files, read_files(recipe, folder), _SPACES, strict=True)
    ]
    return _finish(recipe.id, recipe.tile_m, textures, substance)


def resized_finish(recipe: TextureRecipe, substance: Substance, size_px: int) -> Finish:
    """Return `finish_of_picture` with its pictures scaled down to at most `size_px` on the longer side."""
    whole = finish_of_picture(recipe, substance)
    textures = []
    for texture in whole.material.textures:
        limit = round(size_px * max(texture.width_px, texture.height_px) / _longest(whole))
        pixels = derive.scaled(derive.pixels_of(texture.png), limit)
        textures.append(texture.replace(png=derive.png(pixels), width_px=pixels.shape[1], height_px=pixels.shape[0]))
    by_name = {texture.name: texture for texture in textures}
    names = [Path(path).stem for path in PictureParams.from_json(recipe.params).files]
    return _finish(recipe.id, recipe.tile_m, [by_name[name] for name in names], substance)


def layers_of_picture(recipe: TextureRecipe, size_px: int) -> Layers:
    """Return a picture as the layers of a recipe, at most `size_px` pixels on the longer side; its relief is flat."""
    base, _, rough = (derive.scaled(derive.pixels_of(data), size_px) for data in read_files(recipe))
    return Layers.of(base, base[..., 0] * 0.0, rough[..., 1])


@read_once
def check_files(recipe: TextureRecipe) -> None:
    """Raise OutputError where a file of a picture is missing or is not the one that was written; looked at once."""
    read_files(recipe)


def read_files(recipe: TextureRecipe, folder: Path | None = None) -> tuple[bytes, ...]:
    """Bytes of base, normal and roughness, which are those that the recipe names. Raises as `finish_of_picture`."""
    params = PictureParams.from_json(recipe.params)
    place = folder or _folder(params.pack)
    return tuple(_read(place / path, digest) for path, digest in zip(params.files, params.sha256, strict=True))


def _folder(pack: str) -> Path:
    project = project_folder()
    if project is None:
        raise OutputError(pack, "is a texture pack of a project, and no project is in use")
    return project / FOLDER / pack


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


def _finish(name: str, tile_m: Vec2, textures: list[Texture], substance: Substance) -> Finish:
    base, normal, roughness = textures
    return Finish(
        id=name,
        material=Material(
            id=name,
            base_color=(1.0, 1.0, 1.0, 1.0),
            metallic=1.0,  # multiplied with the blue of the picture
            roughness=1.0,
            base_color_texture=base,
            normal_texture=normal,
            metallic_roughness_texture=roughness,
            tile_m=tile_m,
            substance=substance.id,
        ),
        substance=substance,
    )


def _longest(finish: Finish) -> int:
    base = finish.material.base_color_texture
    assert base is not None
    return max(base.width_px, base.height_px)
