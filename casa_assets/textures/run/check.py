"""Recipes through every check of textures, with finishes as files and contact sheets of swatches."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from casa_assets import registry
from casa_assets.errors import BatchFault
from casa_assets.model.issue import Report
from casa_assets.model.registry.rows import Surface, TextureRecipe
from casa_assets.runs.engine import run_batch
from casa_assets.runs.limits import WorkerFailure
from casa_assets.show.stills.pictures import SheetCell, contact_sheets
from casa_assets.textures.check import check_pictures, check_set, pictures_of
from casa_assets.textures.distance import TextureDescriptor, describe_texture
from casa_assets.textures.finish import swatch
from casa_assets.textures.run.recipes import find_recipe, finish_of, layers_of, recipes

COLUMNS = 10
PER_PAGE = 100


def write_finish(recipe: TextureRecipe, folder: Path, cache: Path, size_px: int) -> tuple[Path, ...]:
    """Write the colour, metallic-roughness and normal picture of a recipe; size_px: longer side."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for texture in finish_of(recipe, cache, size_px).material.textures:
        path = folder / f"{texture.name}.png"
        path.write_bytes(texture.png)
        written.append(path)
    return tuple(written)


def shots(recipes: Sequence[TextureRecipe], cache: Path, side_m: float, side_px: int) -> Iterator[SheetCell]:
    """One cell per recipe: a lit cut of `side_m` metres, `side_px` wide, with the id and the size of the picture."""
    for recipe in recipes:
        finish = finish_of(recipe, cache)
        size = f"{recipe.kind}, {recipe.tile_m[0]:g} x {recipe.tile_m[1]:g} m"
        pictures = pictures_of(finish)
        texture = finish.material.metallic_roughness_texture
        assert texture is not None
        with Image.open(io.BytesIO(texture.png)) as image:
            metallic = float(np.asarray(image.convert("RGB"))[..., 2].mean() / 255)
        out = io.BytesIO()
        Image.fromarray(swatch(pictures, metallic, side_m, side_px), "RGB").save(out, "PNG", compress_level=6)
        yield SheetCell(recipe.id, size, out.getvalue())


def pages(cells: Sequence[SheetCell], heading: str, side_px: int = 192) -> tuple[bytes, ...]:
    """PNG pages of ten by ten cells."""
    return contact_sheets(cells, heading, per_page=PER_PAGE, columns=COLUMNS, cell_px=side_px)


COMPARISON_PX = 256
DEFAULT_JOBS = 2
WORKER_BYTES = 1_000_000_000  # of memory, that painting and checking a finish may take


@dataclass(frozen=True)
class CheckedTexture:
    """A recipe that was checked: its report, and a descriptor to compare it with others by."""

    recipe: TextureRecipe
    report: Report
    look: TextureDescriptor


def check_one(texture_recipe: TextureRecipe, cache: Path) -> CheckedTexture:
    """Paint a recipe, or take it from the store at `cache`, and check it."""
    report = check_pictures(pictures_of(finish_of(texture_recipe, cache)), registry.load().limits)
    small = layers_of(texture_recipe, COMPARISON_PX)
    descriptor = describe_texture(small.albedo, texture_recipe.tile_m, small.roughness, small.height_m)
    return CheckedTexture(texture_recipe, report, descriptor)


def check_recipes(selected: Sequence[TextureRecipe], cache: Path, jobs: int = DEFAULT_JOBS) -> Iterator[CheckedTexture]:
    """Recipes in the order given; jobs: at once, 0: one per core. Raises BatchFault, CasaError."""
    answers: dict[int, CheckedTexture | WorkerFailure] = {}
    due = 0
    check = partial(check_one, cache=cache)
    for number, answer in run_batch(check, selected, cache, jobs, warm, WORKER_BYTES):
        answers[number] = answer
        while due in answers:
            checked = answers[due]
            if isinstance(checked, CheckedTexture):
                yield checked
            due += 1
    faults = {selected[n].id: a for n, a in sorted(answers.items()) if isinstance(a, WorkerFailure)}
    if faults:
        raise BatchFault(faults, "\n".join(failure.text for failure in faults.values()))


def warm() -> None:
    """Load what every worker needs, once for all of them."""
    registry.load()
    recipes()


def check_sets(checked: Sequence[CheckedTexture]) -> tuple[Report, ...]:
    """Report of each set of which every recipe was checked."""
    limits = registry.load().limits
    found = []
    for surface, rows in recipes().items():
        looks = {c.recipe.id: c.look for c in checked if c.recipe.surface is surface}
        if looks and len(looks) == len(rows):
            found.append(check_set(surface.value, looks, limits))
    return tuple(found)


def select_recipes(names: Sequence[str], surfaces: Sequence[Surface]) -> tuple[TextureRecipe, ...]:
    """Recipes by id; of whole sets where no id is given; all where no set is given either. Raises UnknownId."""
    if names:
        return tuple(find_recipe(name) for name in names)
    return tuple(r for s in (surfaces or tuple(Surface)) for r in recipes()[s].values())
