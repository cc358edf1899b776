"""What a path tracer leaves behind where it goes wrong: black pixels and fireflies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter, rank_filter

from casa_assets.preview.tonemap import Pixels

BLACK = 2  # 8-bit value; the tone curve gives anything that some light reaches more
FIREFLY_STEP = 100  # 8-bit brightness of a pixel above all but one of its 24 neighbours, and above their median


@dataclass(frozen=True)
class PictureFaults:
    """Numbers of pixels.

    Attributes:
        black: that no light has reached. fireflies: far brighter than all that is round them.
    """

    black: int
    fireflies: int

    def __bool__(self) -> bool:
        """True if there are any."""
        return bool(self.black or self.fireflies)


def picture_faults(pixels: Pixels) -> PictureFaults:
    """Count the faults of a (height, width, 3) picture."""
    brightest = pixels.max(axis=2).astype(np.int16)
    black = int((brightest < BLACK).sum())
    # The third brightest of 5 x 5: a firefly and its fringe are two of them.
    others, middle = rank_filter(brightest, rank=-3, size=5), median_filter(brightest, size=5)
    firefly = (brightest - others > FIREFLY_STEP) & (brightest - middle > FIREFLY_STEP)
    return PictureFaults(black, int(firefly.sum()))
