"""Tone-map exposures to 8-bit pictures, encode them as PNG, and arrange pictures with captions on contact sheets."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont, ImageOps

from casa_assets.core.numeric import Floats, Mask

Pixels = npt.NDArray[np.uint8]

# Brightness of the background where no shadow falls, how much darker the corners are, and the standard deviation of
# the background's blur as a part of the width. Chosen by eye.
_BACKGROUND_WHITE = 0.965
_VIGNETTE = 0.045
_BLUR_SHARE = 0.010
_PAGE = (255, 255, 255)
_CELL = (244, 244, 245)
_INK, _FAINT = (32, 34, 37), (112, 117, 124)
_GAP_PX, _MARGIN_PX, _HEADER_PX, _CAPTION_PX = 8, 12, 34, 40
_PAPER_NOISE = 3  # by which paper may differ from its corner, of 255


def blur_background(exposure: Floats, background: Mask) -> Floats:
    """Blur the (H, W) background of (H, W, 3) fractions of white within its outline: no steps between shadows."""
    from scipy.ndimage import gaussian_filter  # here, since SciPy loads slowly and contact sheets need only `png`

    sigma_px = _BLUR_SHARE * exposure.shape[0]
    weight = gaussian_filter(background.astype(np.float32), sigma_px)
    soft = gaussian_filter((exposure.mean(axis=2) * background).astype(np.float32), sigma_px) / np.maximum(weight, 1e-6)
    return np.where(background[..., None], soft[..., None], exposure)


def tone_map(exposure: Floats, background: Mask) -> Pixels:
    """(H, W, 3) fractions of white to 8 bit: unshadowed background near white, corners a little darker."""
    lit = float(np.percentile(exposure[background], 98)) if background.any() else 1.0
    tone = np.clip(exposure * (_BACKGROUND_WHITE / max(lit, 0.05)), 0.0, 1.0)
    # Black keeps some form: it starts a little above zero.
    tone = 0.02 + 0.98 * tone**0.92
    height, width = tone.shape[:2]
    y, x = np.mgrid[-1.0 : 1.0 : height * 1j, -1.0 : 1.0 : width * 1j]
    tone *= (1.0 - _VIGNETTE * np.clip((x**2 + (y - 0.1) ** 2) / 2.0, 0.0, 1.0) ** 1.5)[..., None]
    return to_uint8(tone)


def to_uint8(values: Floats) -> Pixels:
    """Values in 0..1, any shape, as 8-bit numbers; what lies outside is clipped."""
    return np.asarray(np.clip(np.rint(values * 255.0), 0, 255), dtype=np.uint8)


def png(pixels: Pixels) -> bytes:
    """(H, W, 3) pixels as PNG, always with the same options."""
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, format="PNG", compress_level=6)
    return out.getvalue()


@dataclass(frozen=True)
class SheetCell:
    """One cell: two lines of text under a picture (PNG bytes; empty for an empty frame)."""

    title: str
    subtitle: str
    png: bytes


def contact_sheet(
    shots: Sequence[SheetCell], heading: str, columns: int = 8, cell_px: int = 192, height_px: int = 0
) -> bytes:
    """PNG with all shots in rows below a line of text; pictures without a height are as high as wide."""
    columns, height_px = max(1, min(columns, len(shots))), height_px or cell_px
    rows = -(-len(shots) // columns)
    # A narrow page would cut the heading.
    width = max(2 * _MARGIN_PX + columns * (cell_px + _GAP_PX) - _GAP_PX, 480)
    height = 2 * _MARGIN_PX + _HEADER_PX + rows * (height_px + _CAPTION_PX + _GAP_PX) - _GAP_PX * min(rows, 1)
    page = Image.new("RGB", (width, height), _PAGE)
    pen = ImageDraw.Draw(page)
    room_px = width - 2 * _MARGIN_PX
    pen.text((_MARGIN_PX, _MARGIN_PX), _cut(heading, 22, room_px), fill=_INK, font=ImageFont.load_default(22))
    for i, shot in enumerate(shots):
        x, y = cell_corner(i, columns, cell_px, height_px)
        pen.rectangle((x, y, x + cell_px - 1, y + height_px - 1), fill=_CELL)
        if shot.png:
            page.paste(_fitted(shot.png, cell_px, height_px), (x, y))
        y += height_px
        pen.text((x, y + 3), _cut(shot.title, 14, cell_px), fill=_INK, font=ImageFont.load_default(14))
        pen.text((x, y + 21), _cut(shot.subtitle, 12, cell_px), fill=_FAINT, font=ImageFont.load_default(12))
    return png(np.asarray(page))


def cell_corner(number: int, columns: int, cell_px: int, height_px: int = 0) -> tuple[int, int]:
    """Return the pixel (x, y) of the upper left corner of a picture on a sheet, by its number from 0."""
    x = _MARGIN_PX + number % columns * (cell_px + _GAP_PX)
    y = _MARGIN_PX + _HEADER_PX + number // columns * ((height_px or cell_px) + _CAPTION_PX + _GAP_PX)
    return x, y


def contact_sheets(
    shots: Sequence[SheetCell], heading: str, per_page: int = 144, columns: int = 8, cell_px: int = 192
) -> tuple[bytes, ...]:
    """As many pages as it takes; with more than one, each says which it is."""
    pages = [shots[i : i + per_page] for i in range(0, len(shots), per_page)] or [()]
    names = [f"{heading}   ({n} of {len(pages)})" if len(pages) > 1 else heading for n in range(1, len(pages) + 1)]
    return tuple(contact_sheet(page, name, columns, cell_px) for page, name in zip(pages, names, strict=True))


def trimmed(picture: Image.Image, width_share: float, margin: float = 0.03) -> Image.Image:
    """Cut plain paper off a picture up to a margin, a share of what is shown; `width_share`: width over height then."""
    pixels = np.asarray(picture.convert("RGB")).astype(np.int16)
    shown = np.abs(pixels - pixels[0, 0]).max(axis=2) > _PAPER_NOISE
    if not shown.any() or shown[[0, -1, -1], [-1, 0, -1]].any():
        return picture
    rows, columns = np.flatnonzero(shown.any(axis=1)), np.flatnonzero(shown.any(axis=0))
    middle = ((columns[0] + columns[-1] + 1) / 2, (rows[0] + rows[-1] + 1) / 2)
    wide, high = (1 + 2 * margin) * np.ptp(columns), (1 + 2 * margin) * np.ptp(rows)
    wide, high = max(wide, high * width_share), max(high, wide / width_share)
    page = Image.fromarray(np.full((round(high), round(wide), 3), pixels[0, 0], dtype=np.uint8))
    page.paste(picture, (round(wide / 2 - middle[0]), round(high / 2 - middle[1])))
    return page


def _fitted(png: bytes, width_px: int, height_px: int) -> Image.Image:
    """The picture made as large as the cell; one of another shape loses paper, or is cut, at two sides."""
    with Image.open(io.BytesIO(png)) as opened:
        picture = opened.convert("RGB")
    if picture.width * height_px != picture.height * width_px:
        picture = trimmed(picture, width_px / height_px)
    return ImageOps.fit(picture, (width_px, height_px), Image.Resampling.LANCZOS)


def _cut(text: str, font_px: int, width_px: int) -> str:
    font = ImageFont.load_default(font_px)
    line = " ".join(text.split())[:200]
    if font.getlength(line) <= width_px:
        return line
    while line and font.getlength(f"{line}…") > width_px:
        line = line[:-1]
    return f"{line.rstrip()}…"
