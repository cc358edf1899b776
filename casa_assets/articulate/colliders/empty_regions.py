"""Is a shape where nothing is seen? What is touched of a one-piece body is coarser than its walls."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.core.typing import Floats

# What is seen bounds what is empty where it is this near, metres; so much of it on a side counts.
NEAR_M, ON_A_SIDE = 0.0005, 0.15
# From so far inside a box, by its size, what is seen does not bound it.
INSIDE = 0.25


def is_empty_region(skin: Floats | None, boxes: Sequence[Floats]) -> bool:
    """Whether nothing is seen in any of some boxes, (2, 3) corners each, in which another part is.

    What is seen may bound a box on one side; on two opposite ones it is a board.

    Args:
        skin: (N, 3) points of what is seen of the body, metres.
    """
    if skin is None:
        return False
    for low, high in boxes:
        near = skin[((skin > low - NEAR_M) & (skin < high + NEAR_M)).all(axis=1)]
        share = (near - low) / np.maximum(high - low, 1e-9)
        side = np.argmin(np.concatenate([share, 1.0 - share], axis=1), axis=1)
        count = np.bincount(side, minlength=6) >= max(1.0, ON_A_SIDE * len(near))
        inner = ((share > INSIDE) & (share < 1.0 - INSIDE)).all(axis=1).any()
        if inner or (count[:3] & count[3:]).any():
            return False
    return True
