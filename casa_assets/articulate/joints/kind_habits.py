"""Prior probabilities by kind of object: at which edge its doors are hinged, and how many of its fronts are drawers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats


@dataclass(frozen=True)
class Habits:
    """Shares of the doors of a kind that hinge at each edge, and share of its fronts that are drawers."""

    left: float
    right: float
    bottom: float
    top: float
    drawers: float


# Set from what makers list and from safety standards (doors of ovens and dishwashers fold down; microwaves carry their
# controls at the right and hinge at the left; loaders of washing machines hinge at the left), rounded, and never below
# one in a hundred.
HABITS: Mapping[str, Habits] = {
    "microwave": Habits(0.86, 0.02, 0.1, 0.02, 0.03),
    "toaster_oven": Habits(0.03, 0.02, 0.94, 0.01, 0.04),
    "wall_oven": Habits(0.05, 0.03, 0.91, 0.01, 0.05),
    "range": Habits(0.03, 0.03, 0.93, 0.01, 0.3),
    "dishwasher": Habits(0.01, 0.01, 0.97, 0.01, 0.04),
    "refrigerator": Habits(0.45, 0.52, 0.02, 0.01, 0.2),
    "base_cabinet": Habits(0.48, 0.48, 0.02, 0.02, 0.4),
    "wall_cabinet": Habits(0.43, 0.43, 0.02, 0.12, 0.03),
    "tall_cabinet": Habits(0.49, 0.49, 0.01, 0.01, 0.15),
    "drawer_stack": Habits(0.45, 0.45, 0.05, 0.05, 0.95),
    "sink_base": Habits(0.49, 0.49, 0.01, 0.01, 0.2),
    "island_base": Habits(0.49, 0.49, 0.01, 0.01, 0.45),
    "washing_machine": Habits(0.93, 0.05, 0.01, 0.01, 0.4),
    "dryer": Habits(0.45, 0.49, 0.05, 0.01, 0.1),
    "safe": Habits(0.46, 0.5, 0.03, 0.01, 0.02),
    "desk": Habits(0.45, 0.45, 0.05, 0.05, 0.85),
    "table": Habits(0.4, 0.4, 0.1, 0.1, 0.9),
    "nightstand": Habits(0.47, 0.47, 0.04, 0.02, 0.8),
    "wardrobe": Habits(0.49, 0.49, 0.01, 0.01, 0.3),
}
# Of what has no habits of its own.
ANY_HABITS = Habits(0.4, 0.36, 0.18, 0.06, 0.3)


def edge_shares(kinds: Mapping[str, float]) -> Floats:
    """Return the (4,) probabilities of a hinge at the left, right, bottom and top of a door.

    Args:
        kinds: probability of each kind that the thing may be; the rest of 1 is any thing.
    """
    rows = [(p, HABITS.get(kind, ANY_HABITS)) for kind, p in kinds.items()]
    rows.append((max(0.0, 1.0 - sum(kinds.values())), ANY_HABITS))
    shares = sum(p * np.array([h.left, h.right, h.bottom, h.top]) for p, h in rows)
    found: Floats = np.asarray(shares) / np.sum(shares)
    return found


def drawer_share(kinds: Mapping[str, float]) -> float:
    """Return the probability that a front is a drawer.

    Args:
        kinds: as for `edge_shares`.
    """
    rest = max(0.0, 1.0 - sum(kinds.values()))
    total = sum(kinds.values()) + rest
    share = sum(p * HABITS.get(kind, ANY_HABITS).drawers for kind, p in kinds.items()) + rest * ANY_HABITS.drawers
    return float(share / total)


def share_with_fronts(kinds: Mapping[str, float]) -> float:
    """Return the probability that a thing is of a kind that has doors or drawers on its front."""
    return sum(p for kind, p in kinds.items() if kind in HABITS)
