"""The catalogue: one HTML page with a picture of every family and preset, closed and open, and of every texture."""

from __future__ import annotations

import html
import io
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PIL import Image

from casa_assets.errors import BatchFault
from casa_assets.export import mjcf
from casa_assets.model.registry.finish import Surface
from casa_assets.pipeline.families.run import WORKER_BYTES, FamilyRequest, build_asset, params_of
from casa_assets.pipeline.library.library import write_files
from casa_assets.pipeline.textures.recipes import recipes
from casa_assets.pipeline.textures.sheet import shots
from casa_assets.pipeline.workers.batch import run_batch
from casa_assets.pipeline.workers.limits import WorkerFailure
from casa_assets.preview.camera import View
from casa_assets.preview.still import poses, render
from casa_assets.registry.families import families, family

WARM = "casa_assets.pipeline.families.run:warm"
PICTURE_PX, SWATCH_PX = 320, 160
SWATCH_M = 0.6  # metres of surface that a swatch shows
QUALITY = 82
STYLE = """
:root { color-scheme: light dark; font-family: system-ui, sans-serif; }
body { margin: 2rem auto; max-width: 1500px; padding: 0 1rem; }
nav { columns: 14rem; margin-bottom: 2rem; }
.cells { display: flex; flex-wrap: wrap; gap: 14px; }
figure { margin: 0; width: min-content; }
figure img { border-radius: 6px; display: block; }
figcaption { font-size: .8rem; padding: 4px 2px 10px; overflow-wrap: anywhere; }
.pair { display: flex; gap: 2px; }
h2 { border-bottom: 1px solid #8886; padding-bottom: 4px; }
h2 small { color: #888; font-weight: normal; }
"""


@dataclass(frozen=True)
class MemberPictures:
    """A member of a family with its picture files, relative to the page: closed first, then each named pose."""

    wish: FamilyRequest
    pictures: tuple[str, ...]
    mass: float
    size: tuple[float, float, float]


def make(out: Path, jobs: int = 0, names: Sequence[str] = (), textures: bool = True) -> Iterator[str]:
    """Write `<out>/index.html` and its pictures; yields a line for each thing that is done.

    Args:
        out: folder, made where it is missing. jobs: processes; 0 for one per core.
        names: families; all where none is given. textures: also the swatches.
    Raises:
        UnknownId: there is no such family.
        BatchFault: some could not be drawn by a fault of the program; the page has the others.
    """
    wishes = [FamilyRequest(f.name, preset=p) for f in families().values() for p in f.presets]
    wishes = [w for w in wishes if not names or w.family in names]
    for name in names:
        family(name)
    (out / "families").mkdir(parents=True, exist_ok=True)
    drawn: dict[int, MemberPictures] = {}
    faults: dict[str, str] = {}
    for number, answer in run_batch(partial(_draw, out=out), wishes, out, jobs, WARM, WORKER_BYTES):
        if isinstance(answer, WorkerFailure):
            faults[wishes[number].title] = answer.text
        else:
            drawn[number] = answer
        yield wishes[number].title
    found = [drawn[number] for number in sorted(drawn)]
    swatches: dict[Surface, list[str]] = {}
    if textures:
        (out / "textures").mkdir(parents=True, exist_ok=True)
        for surface, rows in recipes().items():
            swatches[surface] = []
            for shot in shots(list(rows.values()), out / ".cache", SWATCH_M, SWATCH_PX):
                (out / "textures" / f"{shot.title}.webp").write_bytes(_webp(shot.png))
                swatches[surface].append(shot.title)
            yield f"{len(rows)} textures of {surface.value}s"
    (out / "index.html").write_text(page(found, swatches), encoding="utf-8")
    yield f"{out / 'index.html'}"
    if faults:
        raise BatchFault(faults, "\n".join(faults.values()))


def _draw(wish: FamilyRequest, out: Path) -> MemberPictures:
    """One preset in all its poses."""
    asset = build_asset(family(wish.family), params_of(wish), out / ".cache")
    folder = Path(tempfile.mkdtemp(prefix="catalogue"))
    try:
        write_files(folder, mjcf.write(asset))
        model = folder / "model.xml"
        named = [pose for pose in poses(model) if pose != "closed"]
        paths = []
        for pose in ("", *named[:2]):
            path = f"families/{wish.family}_{wish.preset}{'_' + pose if pose else ''}.webp"
            (out / path).write_bytes(_webp(render(model, View(size_px=PICTURE_PX, passes=14), False, pose)))
            paths.append(path)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    low, high = asset.bounds
    x, y, z = (float(v) for v in high - low)
    return MemberPictures(wish, tuple(paths), asset.mass, (x, y, z))


def page(found: Sequence[MemberPictures], swatches: dict[Surface, list[str]]) -> str:
    """The page's HTML."""
    parts = ["<!doctype html><html lang=en><meta charset=utf-8><title>casa-assets catalogue</title>"]
    parts += [f"<style>{STYLE}</style><h1>Catalogue</h1>"]
    parts += [f"<p>{len({s.wish.family for s in found})} families, {len(found)} presets, "]
    parts += [f"{sum(map(len, swatches.values()))} textures. Sizes in metres, masses in kilograms.</p><nav>"]
    parts += [
        f'<a href="#{name}">{name.replace("_", " ")}</a><br>' for name in dict.fromkeys(s.wish.family for s in found)
    ]
    parts += [f'<a href="#{s.value}">{s.value} textures</a><br>' for s in swatches]
    parts += ["</nav>"]
    for name in dict.fromkeys(s.wish.family for s in found):
        parts += [f'<h2 id="{name}">{html.escape(family(name).title)} <small>{name}</small></h2><div class=cells>']
        parts += [_cell(s) for s in found if s.wish.family == name]
        parts += ["</div>"]
    for surface, names in swatches.items():
        about = f"{len(names)}, each {SWATCH_M:g} m wide"
        parts += [f'<h2 id="{surface.value}">{surface.value.title()} <small>{about}</small></h2>']
        parts += ["<div class=cells>"]
        for name in names:
            image = f'<img loading=lazy width={SWATCH_PX} height={SWATCH_PX} src="textures/{name}.webp" alt="{name}">'
            parts += [f"<figure>{image}<figcaption>{name}</figcaption></figure>"]
        parts += ["</div>"]
    return "\n".join(parts) + "\n"


def _cell(shown: MemberPictures) -> str:
    images = "".join(f'<img loading=lazy width=190 height=190 src="{p}" alt="{p}">' for p in shown.pictures)
    size = " x ".join(f"{v:.2f}" for v in shown.size)
    caption = f"{shown.wish.preset}, {size}, {shown.mass:.3g} kg"
    return f"<figure><div class=pair>{images}</div><figcaption>{caption}</figcaption></figure>"


def _webp(png: bytes) -> bytes:
    out = io.BytesIO()
    with Image.open(io.BytesIO(png)) as image:
        image.convert("RGB").save(out, "WEBP", quality=QUALITY)
    return out.getvalue()
