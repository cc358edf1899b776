"""The catalogue of objects: one HTML page with pictures of each category, its sizes and masses beside the usual."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median

from PIL import Image

from casa_assets import registry
from casa_assets.core.cache_folder import cache_for
from casa_assets.core.rounding import significant
from casa_assets.errors import BatchFault
from casa_assets.model.registry.category import Category, NumberBasis, SizeRange
from casa_assets.pipeline.families.object_sheets import DrawnMember, draw_members
from casa_assets.pipeline.families.run import WORKER_BYTES
from casa_assets.pipeline.reports.page_template import render_template
from casa_assets.pipeline.viewer.model_files import ModelFiles
from casa_assets.pipeline.viewer.viewer_file import put_viewer
from casa_assets.pipeline.workers.batch import run_batch
from casa_assets.pipeline.workers.limits import WorkerFailure
from casa_assets.registry.objects import object_family, object_files, object_names

WARM = "casa_assets.pipeline.families.run:warm"
PAGE, STRIPS, MODELS = "objects.html", "objects", "models"
PICTURE_PX, QUALITY = 144, 80
# Where numbers of a category come from, as registry/categories.yaml says it.
SOURCES = {
    NumberBasis.USUAL: "our estimate",
    NumberBasis.TRADE: "sizes and net weights it is sold in",
    NumberBasis.PORTION: "portion weights of food composition tables (class of USDA FoodData Central)",
    NumberBasis.REFERENCE: "the reference runtime (RoboCasa)",
}


@dataclass(frozen=True)
class DrawnCategory:
    """A category with its first members, without their pictures, which stand side by side in one file.

    Attributes:
        strip: path of that file relative to the page.
        masses, sides: kg, and metres of the longest side, of the whole members; of all where none is whole.
        faces, shapes: of each member. models: what shows each in 3D; empty where nothing does.
    """

    name: str
    strip: str
    masses: tuple[float, ...]
    sides: tuple[float, ...]
    faces: tuple[int, ...]
    shapes: tuple[int, ...]
    models: tuple[ModelFiles, ...] = ()


def make(out: Path, count: int, jobs: int = 0, names: Sequence[str] = (), in_3d: bool = True) -> Iterator[str]:
    """Write `<out>/objects.html` and its pictures; yields a line for each category that is done.

    Args:
        out: folder, made where it is missing. count: members of each. jobs: processes; 0 for one per core.
        names: categories; all where none is given. in_3d: with models that the page shows in 3D.
    Raises:
        UnknownId: there is no such category.
        BatchFault: some could not be drawn by a fault of the program; the page has the others.
    """
    for name in names:
        object_family(name)
    wanted = list(names or object_names())
    (out / STRIPS).mkdir(parents=True, exist_ok=True)
    viewer = f"{MODELS}/{put_viewer(out / MODELS)}" if in_3d else ""
    work = partial(_draw, out=out, count=count, viewer=viewer)
    drawn: dict[int, DrawnCategory] = {}
    faults: dict[str, str] = {}
    for number, answer in run_batch(work, wanted, out, jobs, WARM, WORKER_BYTES):
        if isinstance(answer, WorkerFailure):
            faults[wanted[number]] = answer.text
        else:
            drawn[number] = answer
        yield wanted[number]
    (out / PAGE).write_text(page([drawn[number] for number in sorted(drawn)]), encoding="utf-8")
    yield f"{out / PAGE}"
    if faults:
        raise BatchFault(faults, "\n".join(faults.values()))


def page(found: Sequence[DrawnCategory]) -> str:
    """HTML of the page; a box at its top hides what does not have the words that are typed into it."""
    group_of = {name: group for group, names in object_files().items() for name in names}
    known = registry.load().categories
    return render_template(
        "catalogue/objects.html",
        title="Objects",
        categories=[_shown(row, known[row.name], group_of[row.name]) for row in found],
        picture_px=PICTURE_PX,
    )


def _shown(row: DrawnCategory, category: Category, group: str) -> dict[str, object]:
    """What the template shows of a category."""
    member_family = object_family(row.name)
    uses = [use.value for use in category.affords]
    return {
        "name": row.name,
        "title": member_family.title,
        "group": group,
        "form": member_family.form,
        "about": member_family.description,
        "strip": row.strip,
        "models": row.models,
        "count": len(row.faces),
        "rows": [
            ("longest side, cm", _span(row.sides, 100), _usual(category.longest_m, 100), SOURCES[category.basis.size]),
            ("mass, g", _span(row.masses, 1000), _usual(category.mass_kg, 1000), SOURCES[category.basis.mass]),
        ],
        "counts": f"{median(row.faces):.0f} faces, {median(row.shapes):.0f} collision shapes (medians)",
        "uses": ", ".join(uses),
        "words": " ".join((row.name, member_family.title, group, member_family.form, *category.aliases, *uses)).lower(),
    }


def _span(values: Sequence[float], factor: float) -> str:
    """The least and the largest of several values in another unit."""
    return f"{_three_digits(factor * min(values))} to {_three_digits(factor * max(values))}"


def _usual(span: SizeRange, factor: float) -> str:
    low, high, typical = (_three_digits(factor * value) for value in (span.low, span.high, span.typical))
    return f"{low} to {high}, typically {typical}"


def _three_digits(value: float) -> str:
    """A number with three digits and no exponent, such as 0.05, 61.2 or 3950."""
    return f"{significant(value, 3):.12g}"


def _draw(name: str, out: Path, count: int, viewer: str) -> DrawnCategory:
    """The first members of a category, their pictures side by side in one file.

    Args:
        viewer: path of the viewer below `out`; empty where there are no models.
    """
    members = draw_members(name, cache_for(out), count, 0, PICTURE_PX, out / MODELS if viewer else None)
    whole = [member for member in members if member.is_whole] or members
    path = f"{STRIPS}/{name}.webp"
    (out / path).write_bytes(_strip(members))
    return DrawnCategory(
        name,
        path,
        tuple(member.mass for member in whole),
        tuple(max(member.sides) for member in whole),
        tuple(member.faces for member in members),
        tuple(member.shapes for member in members),
        tuple(ModelFiles(f"{name}_{m.index}", f"{MODELS}/{m.model}", viewer) for m in members if m.model),
    )


def _strip(members: Sequence[DrawnMember]) -> bytes:
    """The pictures of members from left to right, WebP."""
    strip = Image.new("RGB", (PICTURE_PX * len(members), PICTURE_PX))
    for place, member in enumerate(members):
        with Image.open(io.BytesIO(member.picture)) as picture:
            strip.paste(picture.convert("RGB"), (PICTURE_PX * place, 0))
    out = io.BytesIO()
    strip.save(out, "WEBP", quality=QUALITY)
    return out.getvalue()
