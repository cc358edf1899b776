"""Finishes into files, and into contact sheets of swatches of true size."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from casa_assets.model.registry.finish import Finish
from casa_assets.model.registry.texture_recipe import TextureRecipe
from casa_assets.pipeline.textures.recipes import finish_of
from casa_assets.preview.pictures import SheetCell, contact_sheets
from casa_assets.textures.check import pictures_of
from casa_assets.textures.make import SIZE_PX
from casa_assets.textures.swatch import swatch

COLUMNS = 10
PER_PAGE = 100


def write_finish(recipe: TextureRecipe, folder: Path, cache: Path, size_px: int = SIZE_PX) -> tuple[Path, ...]:
    """Write the colour, metallic-roughness and normal picture of a recipe.

    Args:
        recipe: recipe. folder: made where it is missing. cache: folder of the store. size_px: longer side.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for texture in finish_of(recipe, cache, size_px).material.textures:
        path = folder / f"{texture.name}.png"
        path.write_bytes(texture.png)
        written.append(path)
    return tuple(written)


def shots(
    recipes: Sequence[TextureRecipe], cache: Path, side_m: float = 1.0, side_px: int = 192
) -> Iterator[SheetCell]:
    """One cell per recipe: a lit cut of `side_m` metres, with the id and the size of the picture.

    Args:
        recipes: recipes. cache: folder of the store. side_m: of a cut, metres. side_px: of a cell.
    """
    for recipe in recipes:
        finish = finish_of(recipe, cache)
        size = f"{recipe.kind}, {recipe.tile_m[0]:g} x {recipe.tile_m[1]:g} m"
        yield SheetCell(recipe.id, size, _png(finish, side_m, side_px))


def pages(cells: Sequence[SheetCell], heading: str, side_px: int = 192) -> tuple[bytes, ...]:
    """PNG pages of ten by ten cells."""
    return contact_sheets(cells, heading, per_page=PER_PAGE, columns=COLUMNS, cell_px=side_px)


def _png(made: Finish, side_m: float, side_px: int) -> bytes:
    pictures = pictures_of(made)
    texture = made.material.metallic_roughness_texture
    assert texture is not None
    with Image.open(io.BytesIO(texture.png)) as image:
        metallic = float(np.asarray(image.convert("RGB"))[..., 2].mean() / 255)
    out = io.BytesIO()
    Image.fromarray(swatch(pictures, metallic, side_m, side_px), "RGB").save(out, "PNG", compress_level=6)
    return out.getvalue()
