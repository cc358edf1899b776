"""Where the brand and the first word of a label stand in its picture."""

from __future__ import annotations

import numpy as np
from PIL import Image

from casa_assets.kitchenware.textures.label import Label, Layout, Lettering, front, lines_in_picture
from casa_assets.textures.canvas import rgb

SIZE = (120, 240)
INK, ACCENT = "#101010", "#c02020"
PLAIN = Label(brand="Acme", words=("SOUP", "400 g"), layout=Layout.MINIMAL, ground=("#ffffff",), ink=INK, accent=ACCENT)


def picture(p: Label) -> np.ndarray:
    """(H, W, 3) of the front of a label, 0..1."""
    return np.asarray(front(p, SIZE)[0].resize(SIZE[::-1], Image.Resampling.BOX)) / 255.0


def test_lines_lie_where_their_colour_is_seen() -> None:
    brand, word = lines_in_picture(PLAIN, SIZE)
    assert (brand.text, word.text) == ("Acme", "SOUP")
    seen = picture(PLAIN)
    for line, color in ((brand, ACCENT), (word, INK)):
        inside = line.cover > 0.95
        assert inside.any()
        assert np.abs(seen[inside] - rgb(color)).max() < 0.2
    # The brand stands above the word, and neither covers the other.
    rows = [np.flatnonzero((line.cover > 0.5).any(axis=1)) for line in (brand, word)]
    assert rows[0].max() < rows[1].min()


def test_an_outline_is_no_letter() -> None:
    outlined = PLAIN.replace(lettering=Lettering.OUTLINED, brand_ink=ACCENT)
    brand = lines_in_picture(outlined, SIZE)[0]
    inside = brand.cover > 0.95
    assert np.abs(picture(outlined)[inside] - rgb(ACCENT)).max() < 0.2
