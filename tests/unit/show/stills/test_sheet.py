"""Contact sheets: every picture has its place, pages break, any caption is legible or cut."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image

from casa_assets.show.stills.pictures import SheetCell, contact_sheet, contact_sheets


def shot(color: tuple[int, int, int], title: str = "mug_0123456789") -> SheetCell:
    out = io.BytesIO()
    Image.new("RGB", (32, 32), color).save(out, "PNG")
    return SheetCell(title, "8 x 8 x 10 cm", out.getvalue())


def opened(png: bytes) -> Image.Image:
    return Image.open(io.BytesIO(png)).convert("RGB")


def test_every_picture_is_there_and_the_bytes_repeat() -> None:
    colors = [(200, 40, 40), (40, 200, 40), (40, 40, 200)]
    png = contact_sheet([shot(c) for c in colors], "Three", columns=2, cell_px=64)
    assert contact_sheet([shot(c) for c in colors], "Three", columns=2, cell_px=64) == png
    seen = np.asarray(opened(png)).reshape(-1, 3)
    for color in colors:
        assert np.count_nonzero((seen == color).all(axis=1)) == 64 * 64


def test_a_picture_of_another_shape_fills_its_cell_and_loses_paper() -> None:
    paper = Image.new("RGB", (120, 90), (244, 244, 244))
    paper.paste((200, 40, 40), (50, 30, 80, 50))
    out = io.BytesIO()
    paper.save(out, "PNG")
    sheet = opened(contact_sheet([SheetCell("room", "", out.getvalue())], "One", cell_px=150, height_px=100))
    red = (np.asarray(sheet) == (200, 40, 40)).all(axis=2)
    assert np.ptp(np.flatnonzero(red.any(axis=0))) > 0.85 * 150
    assert np.ptp(np.flatnonzero(red.any(axis=1))) > 0.85 * 100


def test_long_and_strange_captions_are_cut_to_the_cell() -> None:
    plain = opened(contact_sheet([shot((9, 9, 9))], "x", cell_px=64))
    strange = opened(contact_sheet([shot((9, 9, 9), "W" * 5000 + "\n\u202e\x00\U0001f600")], "x", cell_px=64))
    assert strange.size == plain.size
    right = np.asarray(strange)[:, 12 + 64 + 1 :]
    assert (right[60:] == 255).all()


def test_pages_break() -> None:
    pages = contact_sheets([shot((9, 9, 9))] * 7, "Seven", per_page=3, columns=3, cell_px=32)
    assert len(pages) == 3
    assert len(set(pages)) == 3
    assert len(contact_sheets([], "None")) == 1
