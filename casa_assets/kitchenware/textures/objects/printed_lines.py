"""Labels as a kind of texture; where their brand and first word are in the picture, by painting it without them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from casa_assets.ext.textures import PrintedLine, TextureKind
from casa_assets.kitchenware.textures.objects.label import FINER, Label, Layout, front, paint

# A pixel belongs to a line where leaving the line out changes it by more than this, sRGB 0..255.
CHANGED = 24
# A pixel belongs to the letters themselves, and not to their outline, where it has their colour to this.
SAME_COLOR = 40
BLANK = " "


def lines_in_picture(p: Label, size_px: tuple[int, int]) -> tuple[PrintedLine, ...]:
    """The brand and the first word of a label where they are seen, what is painted over them left out.

    Args:
        size_px: (H, W) of the picture.
    """
    whole = np.asarray(front(p, size_px)[0], dtype=np.int16)
    without = {p.brand: p.replace(brand=BLANK)}
    if p.words:
        without[p.words[0]] = p.replace(words=(BLANK, *p.words[1:]))
    found = []
    for text, rest in without.items():
        letters = _letters(whole, np.asarray(front(rest, size_px)[0], dtype=np.int16))
        rows, columns = size_px
        cover = letters.reshape(rows, FINER, columns, FINER).mean(axis=(1, 3), dtype=np.float32)
        found.append(PrintedLine(text, cover, p.layout is Layout.UPRIGHT))
    return tuple(found)


def _letters(whole: npt.NDArray[np.int16], blank: npt.NDArray[np.int16]) -> npt.NDArray[np.bool_]:
    """(H, W) what has the colour of the letters among all that a line changes; an outline has another one."""
    changed: npt.NDArray[np.bool_] = np.abs(whole - blank).max(axis=2) > CHANGED
    letters = np.zeros_like(changed)
    if changed.any():
        box = ndimage.find_objects(changed.astype(np.int8))[0]  # a distance over all of the picture would take longer
        within, colors = np.pad(changed[box], 1), whole[box]
        deepest = np.unravel_index(int(ndimage.distance_transform_edt(within)[1:-1, 1:-1].argmax()), colors.shape[:2])
        letters[box] = changed[box] & (np.abs(colors - colors[deepest]).max(axis=2) <= SAME_COLOR)
    return letters


LABEL = TextureKind("label", Label, paint, lines_in_picture)
