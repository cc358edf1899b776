"""A sheet of pictures of the first members of a category of objects."""

from __future__ import annotations

import tempfile
from pathlib import Path

from casa_assets.export import mjcf
from casa_assets.pipeline.families.run import build_asset, family_of, object_requests, params_of
from casa_assets.pipeline.library import library as disk
from casa_assets.preview.camera import View
from casa_assets.preview.sheet import SheetCell, contact_sheet
from casa_assets.preview.still import render

COLUMNS = 8


def write_sheet(name: str, out: Path, count: int, seed: int, size_px: int) -> Path:
    """Draw the first members of a category on one sheet, `<name>.png`; return its path.

    Args:
        out: folder, which exists. size_px: of a picture.
    Raises:
        UnknownId: there is no such category. OutputError, NoRenderer: it cannot be drawn or written.
    """
    cells = []
    for request in object_requests([name], count, seed):
        asset = build_asset(family_of(request), params_of(request), out / ".cache")
        with tempfile.TemporaryDirectory() as folder:
            disk.write_files(Path(folder), mjcf.write(asset))
            picture = render(Path(folder) / "model.xml", View(size_px=size_px, passes=8))
        size = " x ".join(f"{100 * side:.3g}" for side in asset.bounds[1] - asset.bounds[0])
        cells.append(SheetCell(f"#{request.index}, {1000 * asset.mass:.3g} g", f"{size} cm", picture))
    path = out / f"{name}.png"
    path.write_bytes(contact_sheet(cells, name.replace("_", " "), min(COLUMNS, count), size_px))
    return path
