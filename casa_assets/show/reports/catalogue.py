"""The catalogue: one HTML page with pictures of every preset, closed and open, of objects, and of every texture."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from PIL import Image

from casa_assets import registry
from casa_assets.core.numeric import significant
from casa_assets.core.system import cache_for
from casa_assets.errors import BatchFault, UnknownId
from casa_assets.families.build import WORKER_BYTES, FamilyRequest, build_asset, params_of, warm
from casa_assets.families.object_sheets import draw_members
from casa_assets.formats import mjcf
from casa_assets.formats.gltf import asset_glb
from casa_assets.library.entry_files import write_files
from casa_assets.model.registry.category import NumberBasis, SizeRange
from casa_assets.model.registry.rows import Surface
from casa_assets.registry.families import family, family_names, object_family, object_files, object_names
from casa_assets.runs.engine import run_batch
from casa_assets.runs.limits import WorkerFailure
from casa_assets.show.page.page_template import ModelFiles, put_model, put_viewer, render_template
from casa_assets.show.stills.still import poses, render
from casa_assets.show.stills.studio import View
from casa_assets.textures.run.check import shots
from casa_assets.textures.run.recipes import recipes

PAGE, FAMILIES, OBJECTS, TEXTURES, MODELS = "index.html", "families", "objects", "textures", "models"
PICTURE_PX, OBJECT_PX, SWATCH_PX = 320, 144, 160
OBJECT_MEMBERS = 6  # of each category of objects that are drawn
SWATCH_M = 0.6  # metres of surface that a swatch shows
QUALITY = 82
# Where numbers of a category come from, as registry/categories.yaml says it.
SOURCES = {
    NumberBasis.USUAL: "our estimate",
    NumberBasis.TRADE: "sizes and net weights it is sold in",
    NumberBasis.PORTION: "portion weights of food composition tables (class of USDA FoodData Central)",
    NumberBasis.REFERENCE: "the reference runtime (RoboCasa)",
}


def wanted(names: Sequence[str] = ()) -> list[FamilyRequest | str]:
    """Presets of families and names of object categories that the page shows; all without names. Raises UnknownId."""
    of_families, of_objects = family_names(), object_names()
    for name in names:
        if name not in of_families and name not in of_objects:
            raise UnknownId("family or category of objects", name, [*of_families, *of_objects])
    chosen = [name for name in of_families if not names or name in names]
    presets = [FamilyRequest(name, preset=preset) for name in chosen for preset in family(name).presets]
    return [*presets, *(name for name in of_objects if not names or name in names)]


def make(
    out: Path, jobs: int = 0, names: Sequence[str] = (), swatches: bool = True, in_3d: bool = True
) -> Iterator[str]:
    """Write `<out>/index.html` and its pictures; yields a line for each thing that is done, the page last.

    Raises UnknownId, or BatchFault where some could not be drawn by a fault of the program; the page has the others.
    """
    requests = wanted(names)
    for folder in (FAMILIES, OBJECTS, TEXTURES):
        (out / folder).mkdir(parents=True, exist_ok=True)
    work = partial(_draw, out=out, viewer=f"{MODELS}/{put_viewer(out / MODELS)}" if in_3d else "")
    drawn: dict[int, dict[str, Any]] = {}
    faults: dict[str, str] = {}
    for number, answer in run_batch(work, requests, out, jobs, warm, WORKER_BYTES):
        title = title_of(requests[number])
        if isinstance(answer, WorkerFailure):
            faults[title] = answer.text
        else:
            drawn[number] = answer
        yield title
    shown: dict[Surface, list[str]] = {}
    for surface, rows in recipes().items() if swatches else ():
        shown[surface] = []
        for shot in shots(list(rows.values()), cache_for(out), SWATCH_M, SWATCH_PX):
            (out / TEXTURES / f"{shot.title}.webp").write_bytes(_webp(_opened(shot.png)))
            shown[surface].append(shot.title)
        yield f"{len(rows)} textures of {surface.value}s"
    members, categories = (
        [drawn[number] for number in sorted(drawn) if isinstance(requests[number], kind)]
        for kind in (FamilyRequest, str)
    )
    (out / PAGE).write_text(page(members, categories, shown), encoding="utf-8")
    yield f"{out / PAGE}"
    if faults:
        raise BatchFault(faults, "\n".join(faults.values()))


def title_of(request: FamilyRequest | str) -> str:
    """Name of what is drawn, for a line about it."""
    return request if isinstance(request, str) else request.title


def _draw(request: FamilyRequest | str, out: Path, viewer: str) -> dict[str, Any]:
    """Draw one of `wanted`, a preset in all its poses; `viewer`: its path below `out`, empty if there are no models."""
    if isinstance(request, str):
        return _draw_objects(request, out, viewer)
    asset = build_asset(family(request.family), params_of(request), cache_for(out))
    name, paths = f"{request.family}_{request.preset}", []
    with tempfile.TemporaryDirectory(prefix="catalogue") as folder:
        write_files(Path(folder), mjcf.write(asset))
        model = Path(folder) / "model.xml"
        named = [pose for pose in poses(model) if pose != "closed"]
        for pose in ("", *named[:2]):
            path = f"{FAMILIES}/{name}{'_' + pose if pose else ''}.webp"
            png = render(model, View(size_px=PICTURE_PX, passes=14), False, pose)
            (out / path).write_bytes(_webp(_opened(png)))
            paths.append(path)
    script = put_model(out / MODELS, name, asset_glb(asset, with_layers=True)) if viewer else ""
    files = ModelFiles(name, f"{MODELS}/{script}", viewer) if script else None
    return member_row(request, paths, asset.mass, (asset.bounds[1] - asset.bounds[0]).tolist(), files)


def member_row(
    request: FamilyRequest, pictures: Sequence[str], mass: float, size: Sequence[float], model: ModelFiles | None = None
) -> dict[str, Any]:
    """A preset of a family as the page shows it; pictures, relative to the page: closed first, then each named pose."""
    sides = " x ".join(f"{side:.2f}" for side in size)
    return {
        "family": request.family,
        "pictures": pictures,
        "caption": f"{request.preset}, {sides}, {mass:.3g} kg",
        "model": model,
        "title": f"{family(request.family).title}, {request.preset.replace('_', ' ')}",
    }


def _draw_objects(name: str, out: Path, viewer: str) -> dict[str, Any]:
    members = draw_members(name, cache_for(out), OBJECT_MEMBERS, 0, OBJECT_PX, out / MODELS if viewer else None)
    whole = [member for member in members if member.is_whole] or members
    path = f"{OBJECTS}/{name}.webp"
    strip = Image.new("RGB", (OBJECT_PX * len(members), OBJECT_PX))
    for place, member in enumerate(members):
        strip.paste(_opened(member.picture), (OBJECT_PX * place, 0))
    (out / path).write_bytes(_webp(strip))
    return category_row(
        name,
        path,
        [member.mass for member in whole],
        [max(member.sides) for member in whole],
        [member.faces for member in members],
        [member.shapes for member in members],
        [ModelFiles(f"{name}_{m.index}", f"{MODELS}/{m.model}", viewer) for m in members if m.model],
    )


def category_row(
    name: str,
    strip: str,
    masses: Sequence[float],
    sides: Sequence[float],
    faces: Sequence[int],
    shapes: Sequence[int],
    models: Sequence[ModelFiles] = (),
) -> dict[str, Any]:
    """A category of objects as the page shows it.

    Args:
        strip: file with the pictures of its first members side by side, relative to the page.
        masses, sides: kg, and metres of the longest side, of the whole members, else of all; faces, shapes: of each.
    """
    made, usual = object_family(name), registry.load().categories[name]
    group = next(group for group, names in object_files().items() if name in names)
    uses = [use.value for use in usual.affords]
    return {
        "name": name,
        "title": made.title,
        "group": group,
        "form": made.form,
        "about": made.description,
        "strip": strip,
        "models": models,
        "count": len(faces),
        "rows": [
            ("longest side, cm", *_compared(sides, usual.longest_m, 100), SOURCES[usual.basis.size]),
            ("mass, g", *_compared(masses, usual.mass_kg, 1000), SOURCES[usual.basis.mass]),
        ],
        "counts": f"{median(faces):.0f} faces, {median(shapes):.0f} collision shapes (medians)",
        "uses": ", ".join(uses),
        "words": " ".join((name, made.title, group, made.form, *usual.aliases, *uses)).lower(),
    }


def _compared(values: Sequence[float], usual: SizeRange, factor: float) -> tuple[str, str]:
    """The least and the largest of several values in another unit, and the usual ones."""
    numbers = (min(values), max(values), usual.low, usual.high, usual.typical)
    least, largest, low, high, typical = (f"{significant(factor * number, 3):.12g}" for number in numbers)
    return f"{least} to {largest}", f"{low} to {high}, typically {typical}"


def _opened(png: bytes) -> Image.Image:
    with Image.open(io.BytesIO(png)) as image:
        return image.convert("RGB")


def _webp(image: Image.Image) -> bytes:
    out = io.BytesIO()
    image.save(out, "WEBP", quality=QUALITY)
    return out.getvalue()


def page(
    members: Sequence[Mapping[str, Any]],
    categories: Sequence[Mapping[str, Any]],
    swatches: Mapping[Surface, Sequence[str]],
) -> str:
    """HTML of the page, of `member_row`s and `category_row`s. `swatches`: ids of the textures of each surface."""
    names = dict.fromkeys(member["family"] for member in members)
    return render_template(
        "catalogue/catalogue.html",
        title="Catalogue",
        families=[
            {"name": n, "title": family(n).title, "members": [one for one in members if one["family"] == n]}
            for n in names
        ],
        member_count=len(members),
        categories=categories,
        texture_count=sum(map(len, swatches.values())),
        surfaces=[{"name": surface.value, "textures": names} for surface, names in swatches.items()],
        swatch_m=f"{SWATCH_M:g}",
        swatch_px=SWATCH_PX,
        object_px=OBJECT_PX,
    )
