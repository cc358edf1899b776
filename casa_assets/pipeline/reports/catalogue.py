"""The catalogue: one HTML page with a picture of every family and preset, closed and open, and of every texture."""

from __future__ import annotations

import io
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PIL import Image

from casa_assets.core.cache_folder import cache_for
from casa_assets.errors import BatchFault
from casa_assets.export import mjcf
from casa_assets.export.gltf import EVERYTHING, asset_glb
from casa_assets.model.registry.finish import Surface
from casa_assets.pipeline.families.run import WORKER_BYTES, FamilyRequest, build_asset, params_of
from casa_assets.pipeline.library.library import write_files
from casa_assets.pipeline.reports.object_catalogue import MODELS, PAGE
from casa_assets.pipeline.reports.page_template import render_template
from casa_assets.pipeline.textures.recipes import recipes
from casa_assets.pipeline.textures.sheet import shots
from casa_assets.pipeline.viewer.model_files import ModelFiles, put_model
from casa_assets.pipeline.viewer.viewer_file import put_viewer
from casa_assets.pipeline.workers.batch import run_batch
from casa_assets.pipeline.workers.limits import WorkerFailure
from casa_assets.preview.still import poses, render
from casa_assets.preview.studio import View
from casa_assets.registry.families import families, family

WARM = "casa_assets.pipeline.families.run:warm"
PICTURE_PX, SWATCH_PX = 320, 160
SWATCH_M = 0.6  # metres of surface that a swatch shows
QUALITY = 82


@dataclass(frozen=True)
class MemberPictures:
    """A member of a family with its picture files, relative to the page: closed first, then each named pose.

    Attributes:
        model: what shows it in 3D; None where nothing does.
    """

    request: FamilyRequest
    pictures: tuple[str, ...]
    mass: float
    size: tuple[float, float, float]
    model: ModelFiles | None = None


def make(
    out: Path, jobs: int = 0, names: Sequence[str] = (), textures: bool = True, in_3d: bool = True
) -> Iterator[str]:
    """Write `<out>/index.html` and its pictures; yields a line for each thing that is done.

    Args:
        out: folder, made where it is missing. jobs: processes; 0 for one per core.
        names: families; all where none is given. textures: also the swatches. in_3d: with models that the
            page shows in 3D.
    Raises:
        UnknownId: there is no such family.
        BatchFault: some could not be drawn by a fault of the program; the page has the others.
    """
    requests = [FamilyRequest(f.name, preset=p) for f in families().values() for p in f.presets]
    requests = [w for w in requests if not names or w.family in names]
    for name in names:
        family(name)
    (out / "families").mkdir(parents=True, exist_ok=True)
    work = partial(_draw, out=out, viewer=f"{MODELS}/{put_viewer(out / MODELS)}" if in_3d else "")
    drawn: dict[int, MemberPictures] = {}
    faults: dict[str, str] = {}
    for number, answer in run_batch(work, requests, out, jobs, WARM, WORKER_BYTES):
        if isinstance(answer, WorkerFailure):
            faults[requests[number].title] = answer.text
        else:
            drawn[number] = answer
        yield requests[number].title
    found = [drawn[number] for number in sorted(drawn)]
    swatches: dict[Surface, list[str]] = {}
    if textures:
        (out / "textures").mkdir(parents=True, exist_ok=True)
        for surface, rows in recipes().items():
            swatches[surface] = []
            for shot in shots(list(rows.values()), cache_for(out), SWATCH_M, SWATCH_PX):
                (out / "textures" / f"{shot.title}.webp").write_bytes(_webp(shot.png))
                swatches[surface].append(shot.title)
            yield f"{len(rows)} textures of {surface.value}s"
    objects = PAGE if (out / PAGE).is_file() else ""
    (out / "index.html").write_text(page(found, swatches, objects), encoding="utf-8")
    yield f"{out / 'index.html'}"
    if faults:
        raise BatchFault(faults, "\n".join(faults.values()))


def _draw(request: FamilyRequest, out: Path, viewer: str) -> MemberPictures:
    """One preset in all its poses; `viewer` is the path of the viewer below `out`, empty where there are no models."""
    asset = build_asset(family(request.family), params_of(request), cache_for(out))
    folder = Path(tempfile.mkdtemp(prefix="catalogue"))
    try:
        write_files(folder, mjcf.write(asset))
        model = folder / "model.xml"
        named = [pose for pose in poses(model) if pose != "closed"]
        paths = []
        for pose in ("", *named[:2]):
            path = f"families/{request.family}_{request.preset}{'_' + pose if pose else ''}.webp"
            (out / path).write_bytes(_webp(render(model, View(size_px=PICTURE_PX, passes=14), False, pose)))
            paths.append(path)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    low, high = asset.bounds
    x, y, z = (float(v) for v in high - low)
    name = f"{request.family}_{request.preset}"
    script = put_model(out / MODELS, name, asset_glb(asset, EVERYTHING)) if viewer else ""
    files = ModelFiles(name, f"{MODELS}/{script}", viewer) if script else None
    return MemberPictures(request, tuple(paths), asset.mass, (x, y, z), files)


def page(found: Sequence[MemberPictures], swatches: dict[Surface, list[str]], objects: str = "") -> str:
    """HTML of the page.

    Args:
        found: members, in the order of their families. swatches: ids of the textures of each surface.
        objects: path of the page of objects; empty where there is none.
    """
    names = dict.fromkeys(member.request.family for member in found)
    shown = [
        {
            "name": name,
            "title": family(name).title,
            "members": [
                {
                    "pictures": member.pictures,
                    "caption": _caption(member),
                    "model": member.model,
                    "title": f"{family(name).title}, {member.request.preset.replace('_', ' ')}",
                }
                for member in found
                if member.request.family == name
            ],
        }
        for name in names
    ]
    return render_template(
        "catalogue/families.html",
        title="Catalogue",
        families=shown,
        member_count=len(found),
        texture_count=sum(map(len, swatches.values())),
        surfaces=[{"name": surface.value, "textures": names} for surface, names in swatches.items()],
        swatch_m=f"{SWATCH_M:g}",
        swatch_px=SWATCH_PX,
        objects=objects,
    )


def _caption(member: MemberPictures) -> str:
    size = " x ".join(f"{v:.2f}" for v in member.size)
    return f"{member.request.preset}, {size}, {member.mass:.3g} kg"


def _webp(png: bytes) -> bytes:
    out = io.BytesIO()
    with Image.open(io.BytesIO(png)) as image:
        image.convert("RGB").save(out, "WEBP", quality=QUALITY)
    return out.getvalue()
