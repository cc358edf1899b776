"""Is it a drawer's box, a cavity, a rack? What one sees looking down on some pieces alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.pieces import SIDES, TOP, Pieces
from casa_assets.articulate.raster import draw

PIXELS = 96


@dataclass(frozen=True)
class Above:
    """Shares of the plan of some pieces, looked at from above.

    Attributes:
        covered: where anything is. low: where the first thing is in the lower half of their height, of all.
        lid: where it is in the upper quarter.
    """

    covered: float
    low: float
    lid: float

    @property
    def is_box(self) -> bool:
        """Open at the top, with a floor: a drawer."""
        return self.low >= 0.45 and self.lid <= 0.45


def from_above(pieces: Pieces, fragments: Sequence[int]) -> Above:
    """Look down on fragments alone."""
    faces = pieces.soup.faces[pieces.faces_of(fragments)]
    low, high = pieces.box(fragments)
    used, local = np.unique(faces, return_inverse=True)
    picture = draw(pieces.soup.points[used], local.reshape(-1, 3), SIDES[TOP], PIXELS)
    height = max(float(high[2] - low[2]), 1e-9)
    share = picture.depth / height
    seen = np.isfinite(share)
    total = float(share.size)
    deep, shallow = seen & (share > 0.5), seen & (share < 0.25)
    return Above(float(seen.sum()) / total, float(deep.sum()) / total, float(shallow.sum()) / total)
