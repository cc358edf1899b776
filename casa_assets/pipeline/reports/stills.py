"""Path-traced stills of assets and kitchens that stand on disk already."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from casa_assets.errors import OutputError, UnknownId
from casa_assets.export.mjcf.scene import kitchen as mjcf
from casa_assets.export.usd.scene import kitchen as usd
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.kitchens.scene_files import SCENE_JSON
from casa_assets.pipeline.reports.pictures import models
from casa_assets.preview.photoreal.render import Still, StillSettings, asset_still, scene_stills


@dataclass(frozen=True)
class WrittenStill:
    """A picture file, the still in it, and the folder of the asset or kitchen."""

    path: Path
    still: Still
    subject: Path


def is_scene(folder: Path) -> bool:
    """True if a folder holds a kitchen."""
    return (folder / usd.FILE).is_file() and (folder / SCENE_JSON).is_file()


def draw(
    targets: Sequence[Path],
    output: Path,
    settings: StillSettings,
    pose: str = "",
    cameras: Sequence[str] = (),
) -> Iterator[WrittenStill]:
    """Write stills of each target.

    Args:
        targets: folders of kitchens or assets, model.xml files, libraries.
        output: folder for the pictures, made where it is missing: `<asset>.png`, `<kitchen>_<camera>.png`.
        pose: of the variant set of the USD; empty: as it is. cameras: of kitchens; `eye` and `cutaway` otherwise.
    Raises:
        OutputError: a picture cannot be written, or there is no USD. UnknownId: there is no such pose.
        NoPathTracer: see preview.photoreal.render.
    """
    for target in targets:
        if is_scene(target):
            _check_pose(target / mjcf.FILE, pose)
            for still in scene_stills(target, cameras, settings, pose or "start"):
                yield _put(output / f"{target.resolve().name}_{still.name}.png", still, target)
            continue
        for model in models([target]):
            folder = model.parent
            layer = folder / "usd" / f"{folder.resolve().name}.usda"
            _check_pose(model, pose)
            if not layer.is_file():
                raise OutputError(str(layer), "is missing; stills are drawn from the USD of an asset, make it again")
            name = f"{layer.stem}_{pose}" if pose else layer.stem
            yield _put(output / f"{name}.png", asset_still(layer, settings, pose), folder)


def draw_scene(folder: Path, settings: StillSettings, pose: str, cameras: Sequence[str] = ()) -> Iterator[WrittenStill]:
    """Write stills of a kitchen beside its files, as `photoreal_<camera>.png`, with its pose where that is another.

    Raises:
        OutputError, UnknownId, NoPathTracer: as `draw`.
    """
    _check_pose(folder / mjcf.FILE, pose)
    for still in scene_stills(folder, cameras, settings, pose):
        name = still.name if pose == "start" else f"{still.name}_{pose}"
        yield _put(folder / f"photoreal_{name}.png", still, folder)


def _check_pose(model: Path, pose: str) -> None:
    """Refuse a pose that is no keyframe of a model.xml or scene.xml; USD would draw another without a word."""
    names = [key.get("name", "") for key in etree.parse(str(model)).iterfind("keyframe/key")]
    if pose and pose not in names:
        raise UnknownId(f"pose of {model}", pose, names)


def _put(path: Path, still: Still, subject: Path) -> WrittenStill:
    with writing(path.parent):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(still.png)
    return WrittenStill(path, still, subject)
