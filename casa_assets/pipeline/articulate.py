"""One static mesh -> a folder with the appliance that opens; the mesh is read and worked on in a child process."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from casa_assets import registry
from casa_assets.articulate.assemble import Brief, assemble
from casa_assets.articulate.frame import guess_frame
from casa_assets.articulate.infer import infer
from casa_assets.articulate.pieces import TOP
from casa_assets.articulate.plan import Articulation
from casa_assets.articulate.size import metres_per_unit
from casa_assets.articulate.soup import soup_of
from casa_assets.errors import CasaError, Rejected
from casa_assets.export import mjcf
from casa_assets.export.usd.document import write as write_usd
from casa_assets.ingest.load import load
from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.model.asset import Asset
from casa_assets.model.category import Category
from casa_assets.model.provenance import Guess, Provenance
from casa_assets.model.record import Vec3
from casa_assets.model.source import RawModel, Up
from casa_assets.pipeline import library as disk
from casa_assets.pipeline.isolation.pool import Died, Limits, Pool
from casa_assets.pipeline.worker import PREVIEW_PX, thumbnail
from casa_assets.preview.camera import View
from casa_assets.preview.still import render

NOTHING_MOVES = "ART001"
# Side of the frame guess that a stated up axis makes the top.
_TOPS = {Up.Z: TOP, Up.Y: 1, Up.X: 3}


@dataclass(frozen=True)
class Wish:
    """What the user asks for.

    Attributes:
        mesh: file. out: folder, made where it is missing. category: id, or empty to go by names.
        up, front: directions in axes of the file, None to guess. size_m: longest side, 0 to guess.
    """

    mesh: Path
    out: Path
    category: str = ""
    up: Vec3 | None = None
    front: Vec3 | None = None
    size_m: float = 0.0


@dataclass(frozen=True)
class Done:
    """What became of it: the folder, the decisions, and how large it was taken to be and why; or a refusal."""

    folder: Path | None
    found: Articulation | None = None
    size: str = ""
    code: str = ""
    says: str = ""


def articulate(wish: Wish) -> Done:
    """Take one mesh apart, in a child process with limits.

    Raises:
        CasaError: the file cannot be found, or this machine cannot start a worker.
    """
    limits = registry.load().limits
    bounds = Limits(limits["input_seconds"], int(limits["input_memory_bytes"]))
    with Pool(1, bounds, "casa_assets.pipeline.worker:warm") as pool:
        for _, answer in pool.run("casa_assets.pipeline.articulate:work", [wish]):
            if isinstance(answer, Died):
                return Done(None, code="RUN003", says=answer.says)
            assert isinstance(answer, Done)
            return answer
    raise CasaError("no worker answered")


def work(wish: Wish) -> Done:
    """Read, take apart, write; runs in the child."""
    try:
        asset, found, size = build(wish)
    except Rejected as error:
        return Done(None, code=error.code, says=error.says)
    folder = wish.out / asset.id
    folder.mkdir(parents=True, exist_ok=True)
    disk.write_files(folder, mjcf.write(asset))
    picture = render(folder / "model.xml", View(size_px=PREVIEW_PX))
    (folder / "preview.png").write_bytes(picture)
    disk.write_files(folder, write_usd(asset, thumbnail(picture)))
    (folder / "decisions.json").write_text(found.to_json() + "\n", encoding="utf-8")
    return Done(folder, found, size)


def build(wish: Wish) -> tuple[Asset, Articulation, str]:
    """The asset of a mesh, the decisions, and words on its size.

    Raises:
        Rejected: the file cannot be read, or nothing of it moves (ART001).
    """
    known = registry.load()
    one = _found(wish.mesh)
    bundle = collect(one, known.limits)
    model = load(bundle, known.limits)
    soup = soup_of(*triangles(model))
    stated = None if model.up is None else _TOPS[model.up]
    frame = guess_frame(soup, wish.up, wish.front, stated)
    category, sure, because = kind_of(one, wish.category)
    longest = float(np.ptp(soup.points, axis=0).max())
    unit, certain, size = metres_per_unit(longest, model.metres_per_unit, category.longest_m if sure > 0.2 else None)
    if wish.size_m:
        unit, certain, size = wish.size_m / longest, 1.0, "given"
    frame = frame.replace(metres=soup.diagonal * unit)
    placed = soup.placed(frame.rotation, np.array(frame.origin), frame.scale)
    found = infer(placed, frame, category.id if sure > 0.2 else "")
    if not found.parts:
        raise Rejected(NOTHING_MOVES, f"{wish.mesh.name}: no moving part found")
    guesses = (
        Guess(subject="category", value=category.id, confidence=round(sure, 2), because=because),
        Guess(subject="scale", value=f"{unit:.6g} m per unit", confidence=certain, because=size),
    )
    source = one.source
    provenance = Provenance(
        source=source.kind.value,
        path=source.path,
        sha256=bundle.sha256,
        title=source.title,
        author=source.author,
        licence=source.licence,
        uri=source.uri,
        guesses=guesses,
    )
    brief = Brief(
        asset_id=f"{category.id}_{bundle.sha256[:10]}",
        metres=soup.diagonal * unit,
        category=category,
        classes=known.classes_of(category),
        substance=known.substances[category.substance],
        provenance=provenance,
    )
    return assemble(model, placed, found, brief), found, size


def triangles(model: RawModel) -> tuple[np.ndarray, np.ndarray]:
    """All parts of a model as one set: (V, 3) vertices and (F, 3) faces, in order."""
    starts = np.cumsum([0, *(len(p.mesh.vertices) for p in model.parts[:-1])])
    faces = [p.mesh.faces.astype(np.int64) + s for p, s in zip(model.parts, starts, strict=True)]
    return np.concatenate([p.mesh.vertices for p in model.parts]), np.concatenate(faces)


def kind_of(one: Found, ordered: str) -> tuple[Category, float, str]:
    """Category of an input, how sure, and why: the user's word, then its name, then none."""
    known = registry.load()
    if ordered:
        return known.fixtures.get(ordered) or known.category(ordered), 1.0, "given on the command line"
    for hint in (one.source.category, *one.source.hints):
        words = hint.lower().replace("-", "_")
        best = next((c for name, c in sorted(known.fixtures.items(), key=lambda i: -len(i[0])) if name in words), None)
        if best is not None:
            return best, 0.8, f"{best.id!r} in {hint!r}"
    return known.category(registry.FALLBACK), 0.1, "nothing names it"


def _found(mesh: Path) -> Found:
    for one in discover([mesh]):
        if isinstance(one, Refused):
            raise Rejected(one.code, one.says)
        return one
    raise Rejected("SRC001", f"{mesh}: no mesh")
