"""Arrange pictures with captions on contact sheets."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from casa_assets.preview import tonemap

_PAGE = (255, 255, 255)
_CELL = (244, 244, 245)
_INK, _FAINT = (32, 34, 37), (112, 117, 124)
_GAP_PX, _MARGIN_PX, _HEADER_PX, _CAPTION_PX = 12, 24, 44, 40


@dataclass(frozen=True)
class SheetCell:
    """One cell: two lines of text under a picture (PNG bytes; empty for an empty frame)."""

    title: str
    subtitle: str
    png: bytes


def contact_sheet(shots: Sequence[SheetCell], heading: str, columns: int = 8, cell_px: int = 192) -> bytes:
    """PNG with all shots in rows, read from the left.

    Args:
        shots: in the order in which they are shown.
        heading: one line at the top.
        columns: pictures in a row.
        cell_px: width and height of a picture.
    """
    columns = max(1, min(columns, len(shots)))
    rows = -(-len(shots) // columns)
    # A narrow page would cut the heading.
    width = max(2 * _MARGIN_PX + columns * (cell_px + _GAP_PX) - _GAP_PX, 480)
    height = 2 * _MARGIN_PX + _HEADER_PX + rows * (cell_px + _CAPTION_PX + _GAP_PX) - _GAP_PX * min(rows, 1)
    page = Image.new("RGB", (width, height), _PAGE)
    pen = ImageDraw.Draw(page)
    room_px = width - 2 * _MARGIN_PX
    pen.text((_MARGIN_PX, _MARGIN_PX), _cut(heading, 22, room_px), fill=_INK, font=ImageFont.load_default(22))
    for i, shot in enumerate(shots):
        x, y = cell_corner(i, columns, cell_px)
        pen.rectangle((x, y, x + cell_px - 1, y + cell_px - 1), fill=_CELL)
        if shot.png:
            page.paste(_fitted(shot.png, cell_px), (x, y))
        pen.text((x, y + cell_px + 4), _cut(shot.title, 13, cell_px), fill=_INK, font=ImageFont.load_default(13))
        pen.text((x, y + cell_px + 21), _cut(shot.subtitle, 12, cell_px), fill=_FAINT, font=ImageFont.load_default(12))
    return tonemap.png(np.asarray(page))


def cell_corner(number: int, columns: int, cell_px: int) -> tuple[int, int]:
    """Return the pixel (x, y) of the upper left corner of a picture on a sheet, by its number from 0."""
    x = _MARGIN_PX + number % columns * (cell_px + _GAP_PX)
    y = _MARGIN_PX + _HEADER_PX + number // columns * (cell_px + _CAPTION_PX + _GAP_PX)
    return x, y


def contact_sheets(
    shots: Sequence[SheetCell], heading: str, per_page: int = 144, columns: int = 8, cell_px: int = 192
) -> tuple[bytes, ...]:
    """As many pages as it takes; with more than one, each says which it is."""
    pages = [shots[i : i + per_page] for i in range(0, len(shots), per_page)] or [()]
    names = [f"{heading}   ({n} of {len(pages)})" if len(pages) > 1 else heading for n in range(1, len(pages) + 1)]
    return tuple(contact_sheet(page, name, columns, cell_px) for page, name in zip(pages, names, strict=True))


def _fitted(png: bytes, cell_px: int) -> Image.Image:
    """The picture made as large as the cell."""
    with Image.open(io.BytesIO(png)) as opened:
        picture = opened.convert("RGB")
    return picture.resize((cell_px, cell_px), Image.Resampling.LANCZOS)


def _cut(text: str, font_px: int, width_px: int) -> str:
    """As much of the text as fits, on one line, with an ellipsis where some is missing."""
    font = ImageFont.load_default(font_px)
    line = " ".join(text.split())[:200]
    if font.getlength(line) <= width_px:
        return line
    while line and font.getlength(f"{line}…") > width_px:
        line = line[:-1]
    return f"{line.rstrip()}…"
