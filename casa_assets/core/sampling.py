"""Random number generators by seed and name, with the same draws on every machine."""

from __future__ import annotations

import hashlib

import numpy as np


def rng_for(seed: int, lane: str) -> np.random.Generator:
    """The generator of one lane, such as `families/microwave/3`.

    Lanes are independent: one more draw for the walls does not move the cups.

    Args:
        seed: >= 0.
        lane: any text.
    """
    digest = hashlib.sha256(lane.encode("utf-8")).digest()
    words = [int.from_bytes(digest[i : i + 4], "little") for i in range(0, 16, 4)]
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, *words])))
