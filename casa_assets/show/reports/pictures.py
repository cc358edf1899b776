"""Pictures of assets and kitchens on disk: drawn by MuJoCo, contact sheets, path-traced stills."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from casa_assets.core.system import replace_file
from casa_assets.errors import OutputError, UnknownId
from casa_assets.formats.mjcf import kitchen as mjcf
from casa_assets.formats.usd import kitchen as usd
from casa_assets.library.entry_files import checked_model
from casa_assets.library.library import Library
from casa_assets.model.kitchen.files import SCENE_JSON
from casa_assets.runs.outcome import writing
from casa_assets.show.stills.photoreal import StillSettings, asset_still, scene_stills
from casa_assets.show.stills.pictures import SheetCell, contact_sheets
from casa_assets.show.stills.still import render, render_turntable
from casa_assets.show.stills.studio import View


@dataclass(frozen=True)
class Picture:
    """A written picture file, what it shows, and the folder of the asset or kitchen; None for a sheet of many."""

    path: Path
    title: str
    subject: Path | None = None


def draw(
    targets: Sequence[Path],
    output: Path,
    size_px: int,
    colliders: bool = False,
    turntable: bool = False,
    pose: str = "",
) -> Iterator[Picture]:
    """Write a picture of each asset that the targets name, see `models`, and a contact sheet where there are several.

    Raises:
        OutputError: a picture cannot be written, or a file is no MJCF. CannotDraw, NoRenderer: as `still.render`.
    """
    shots: list[SheetCell] = []
    for model in models(targets):
        name = model.parent.name
        png = render(model, View(size_px=size_px), collision=colliders, pose=pose)
        words = [name, *(["colliders"] if colliders else []), *([pose] if pose else [])]
        path = _put(output / f"{'_'.join(words)}.png", png)
        shots.append(SheetCell(name, model.parent.parent.name, png))
        yield Picture(path, name, model.parent)
        if turntable:
            yield Picture(_put(output / f"{name}.webp", render_turntable(model)), name, model.parent)
    if len(shots) > 1:
        for i, page in enumerate(contact_sheets(shots, f"{len(shots)} assets")):
            yield Picture(_put(output / f"sheet_{i + 1:02d}.png", page), f"sheet {i + 1}")


def models(targets: Sequence[Path]) -> Iterator[Path]:
    """Every model.xml that asset folders, files and libraries name; the latter sorted. OutputError for another file."""
    for target in targets:
        if target.is_file():
            if target.suffix.lower() != ".xml":
                raise OutputError(str(target), "is no MJCF; name a model.xml, or a folder that holds one")
            yield target
        elif (target / "model.xml").is_file():
            yield checked_model(target / "model.xml")
        else:
            yield from sorted(checked_model(p / "model.xml") for p in Library(target).accepted())


def draw_stills(
    targets: Sequence[Path], output: Path, settings: StillSettings, pose: str = "", cameras: Sequence[str] = ()
) -> Iterator[Picture]:
    """Write path-traced stills of kitchens, and of assets as `models` finds them, in a pose of their USD.

    Raises:
        OutputError: a picture cannot be written, or there is no USD. UnknownId: there is no such pose.
        NoPathTracer: there is no Blender, or it failed.
    """
    for target in targets:
        if (target / usd.FILE).is_file() and (target / SCENE_JSON).is_file():
            _check_pose(target / mjcf.FILE, pose)
            name = target.resolve().name
            for still in scene_stills(target, cameras, settings, pose or "start"):
                yield Picture(_put(output / f"{name}_{still.name}.png", still.png), name, target)
            continue
        for model in models([target]):
            folder, name = model.parent, model.parent.resolve().name
            layer = folder / "usd" / f"{name}.usda"
            _check_pose(model, pose)
            if not layer.is_file():
                raise OutputError(str(layer), "is missing; stills are drawn from the USD of an asset, make it again")
            png = asset_still(layer, settings, pose).png
            yield Picture(_put(output / f"{'_'.join(filter(None, (name, pose)))}.png", png), name, folder)


def draw_scene(folder: Path, settings: StillSettings, pose: str, cameras: Sequence[str] = ()) -> Iterator[Picture]:
    """Write stills of a kitchen into its folder, named `photoreal_<camera>[_<pose>].png`; raises as `draw_stills`."""
    _check_pose(folder / mjcf.FILE, pose)
    for still in scene_stills(folder, cameras, settings, pose):
        name = still.name if pose == "start" else f"{still.name}_{pose}"
        yield Picture(_put(folder / f"photoreal_{name}.png", still.png), folder.name, folder)


def _check_pose(model: Path, pose: str) -> None:
    """Refuse a pose that is no keyframe of a model.xml or scene.xml; USD would draw another without a word."""
    names = [key.get("name", "") for key in etree.parse(str(model)).iterfind("keyframe/key")]
    if pose and pose not in names:
        raise UnknownId(f"pose of {model}", pose, names)


def _put(path: Path, data: bytes) -> Path:
    with writing(path.parent):
        return replace_file(path, data)
