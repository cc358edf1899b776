"""Pictures of members: one in each pose, or the first of a category of objects on a sheet."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from casa_assets.core.system import cache_for
from casa_assets.families.build import build_asset, family_of, object_requests, params_of
from casa_assets.formats import mjcf
from casa_assets.formats.gltf import asset_glb
from casa_assets.library.entry_files import write_files
from casa_assets.model.record import Vec3
from casa_assets.show.page.page_template import put_model
from casa_assets.show.stills.pictures import SheetCell, contact_sheet
from casa_assets.show.stills.still import poses, render
from casa_assets.show.stills.studio import View

COLUMNS = 8


@dataclass(frozen=True)
class DrawnMember:
    """A member of a category with its picture: PNG; mass in kg, sides of its box in metres, faces and shapes.

    is_whole: it is no half, wedge, slice or piece. model: script file that shows it in 3D, or empty.
    """

    index: int
    picture: bytes
    mass: float
    sides: Vec3
    faces: int
    shapes: int
    is_whole: bool
    model: str = ""


def draw_members(
    name: str, cache: Path, count: int, seed: int, size_px: int, models: Path | None = None
) -> list[DrawnMember]:
    """Return the first members of a category, with pictures.

    cache: of pictures of finishes. size_px: of a picture. models: folder for their models; None: no models are written.
    Raises UnknownId: there is no such category. OutputError, NoRenderer: it cannot be drawn or written.
    """
    drawn = []
    for request in object_requests([name], count, seed):
        asset = build_asset(family_of(request), params_of(request), cache)
        with tempfile.TemporaryDirectory() as folder:
            write_files(Path(folder), mjcf.write(asset))
            picture = render(Path(folder) / "model.xml", View(size_px=size_px, passes=8))
        x, y, z = (float(side) for side in asset.bounds[1] - asset.bounds[0])
        faces = sum(len(visual.mesh.faces) for link in asset.links for visual in link.visuals)
        shapes = sum(len(link.colliders) for link in asset.links)
        whole = asset.labels.portion is None
        model = (
            "" if models is None else put_model(models, f"{name}_{request.index}", asset_glb(asset, with_layers=True))
        )
        drawn.append(DrawnMember(request.index, picture, asset.mass, (x, y, z), faces, shapes, whole, model))
    return drawn


def write_sheet(name: str, out: Path, count: int, seed: int, size_px: int) -> Path:
    """Draw the first members of a category on one sheet, `<name>.png`; return its path.

    Raises UnknownId: there is no such category. OutputError, NoRenderer: it cannot be drawn or written.
    """
    cells = []
    for member in draw_members(name, cache_for(out), count, seed, size_px):
        size = " x ".join(f"{100 * side:.3g}" for side in member.sides)
        mass = f"{member.mass:.3g} kg" if member.mass >= 1.0 else f"{1000 * member.mass:.3g} g"
        cells.append(SheetCell(f"#{member.index}, {mass}", f"{size} cm", member.picture))
    path = out / f"{name}.png"
    path.write_bytes(contact_sheet(cells, name.replace("_", " "), min(COLUMNS, count), size_px))
    return path


def pictures(folder: Path, out: Path, stem: str, size_px: int) -> Iterator[Path]:
    """Write `<stem>_closed.png`, one picture for each named pose, and `<stem>_touch.png`."""
    model = folder / "model.xml"
    view = View(size_px=size_px, passes=12)
    shots = [("closed", "", False), *((p, p, False) for p in poses(model) if p != "closed"), ("touch", "", True)]
    for name, pose, touched in shots:
        path = out / f"{stem}_{name}.png"
        path.write_bytes(render(model, view, touched, pose))
        yield path
