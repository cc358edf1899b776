"""Test whether a collision shape fills a region where the visible mesh of the body has nothing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.core.typing import Floats

# What is seen bounds what is empty where it is this near, metres; so much of it on a side counts.
BOUND_TOLERANCE_M, MIN_SIDE_SHARE = 0.0005, 0.15
# From so far inside a box, by its size, what is seen does not bound it.
INNER_MARGIN_SHARE = 0.25


def is_empty_region(skin: Floats | None, boxes: Sequence[Floats]) -> bool:
    """Return whether the visible body has no surface inside any of some boxes, (2, 3) corners each.

    Surface may bound a box on one side; on two opposite sides it is a board that fills the box.

    Args:
        skin: (N, 3) points on the visible surface of the body, metres; None counts as not empty.
    """
    if skin is None:
        return False
    for lower, upper in boxes:
        near = skin[((skin > lower - BOUND_TOLERANCE_M) & (skin < upper + BOUND_TOLERANCE_M)).all(axis=1)]
        share = (near - lower) / np.maximum(upper - lower, 1e-9)
        side = np.argmin(np.concatenate([share, 1.0 - share], axis=1), axis=1)
        count = np.bincount(side, minlength=6) >= max(1.0, MIN_SIDE_SHARE * len(near))
        inner = ((share > INNER_MARGIN_SHARE) & (share < 1.0 - INNER_MARGIN_SHARE)).all(axis=1).any()
        if inner or (count[:3] & count[3:]).any():
            return False
    return True
