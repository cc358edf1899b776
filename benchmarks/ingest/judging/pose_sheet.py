"""All that came out of orientation and scaling, drawn upright on one sheet, the front to the lower left."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw

from casa_assets.errors import CasaError
from casa_assets.ingest.draft import Draft
from casa_assets.model.source import Up
from casa_assets.show.stills.still import render_mesh
from casa_assets.show.stills.studio import View

TILE = 150
COLUMNS = 10


def draw(items: Sequence[tuple[str, Draft]], path: Path) -> None:
    """Write a PNG of all drafts, each with its words below."""
    lines = (len(items) + COLUMNS - 1) // COLUMNS
    sheet = Image.new("RGB", (COLUMNS * TILE, lines * (TILE + 16)), "white")
    pen = ImageDraw.Draw(sheet)
    for number, (words, draft) in enumerate(items):
        x, y = number % COLUMNS * TILE, number // COLUMNS * (TILE + 16)
        try:
            picture = Image.open(io.BytesIO(render_mesh(draft.parts, Up.Z, View(size_px=TILE, passes=4))))
            sheet.paste(picture.convert("RGB"), (x, y))
        except CasaError:
            words = f"{words}: no picture"
        pen.text((x + 3, y + TILE + 2), words, fill="black")
    path.parent.mkdir(parents=True, exist_ok=True)
    sheet.save(path)
