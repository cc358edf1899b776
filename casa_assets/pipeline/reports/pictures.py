"""Pictures of assets that stand on disk already, and contact sheets of many."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from casa_assets.errors import OutputError
from casa_assets.pipeline.ingest.job import writing
from casa_assets.pipeline.library.entry_files import checked_model
from casa_assets.pipeline.library.library import Library
from casa_assets.preview.pictures import SheetCell, contact_sheets
from casa_assets.preview.still import render, render_turntable
from casa_assets.preview.studio import View


@dataclass(frozen=True)
class Picture:
    """A written picture file, what it shows, and the folder of the asset; None for a sheet of many."""

    path: Path
    title: str
    asset: Path | None = None


def draw(
    targets: Sequence[Path],
    output: Path,
    size_px: int,
    colliders: bool = False,
    turntable: bool = False,
    pose: str = "",
) -> Iterator[Picture]:
    """Write a picture of each asset, and a contact sheet where there are several.

    Args:
        targets: asset folders, model.xml files, or libraries.
        output: folder for the pictures, made where it is missing.
        size_px: width and height. colliders: show the collision shapes.
        turntable: also an animated picture of each. pose: keyframe of the pictures; empty: joints at zero.
    Raises:
        OutputError: a picture cannot be written, or a file is no MJCF. CannotDraw, NoRenderer: see preview.still.
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


def _put(path: Path, data: bytes) -> Path:
    """The path, once the bytes stand there."""
    with writing(path.parent):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return path


def models(targets: Sequence[Path]) -> Iterator[Path]:
    """Every model.xml that the targets name, in their order, libraries sorted by id. OutputError for another file."""
    for target in targets:
        if target.is_file():
            if target.suffix.lower() != ".xml":
                raise OutputError(str(target), "is no MJCF; name a model.xml, or a folder that holds one")
            yield target
        elif (target / "model.xml").is_file():
            yield checked_model(target / "model.xml")
        else:
            yield from sorted(checked_model(p / "model.xml") for p in Library(target).accepted())
