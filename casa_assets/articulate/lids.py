"""What lies on top of a vessel and lifts: a round cover with a knob in its middle, or one over an open vessel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.controls import is_round
from casa_assets.articulate.hollow import from_above
from casa_assets.articulate.pieces import FRONT, LEFT, TOP, Pieces, face_on
from casa_assets.articulate.soup import Floats

# A lid is at least so wide, diagonals, at most so thick by its width, and at most this part of all surface.
LEAST, THICK, MOST_AREA = 0.12, 0.5, 0.3
# So much of its square is seen from above; under a bail less, where a knob tells.
BARE, BARE_UNDER_BAIL = 0.6, 0.2
# Its knob sits so near to its middle and is so small, by its width.
MIDDLE, KNOB = 0.12, 0.4
# A vessel has something in the upper quarter of its height in at most this part of its plan.
MOUTH = 0.35
# Between a lid and what it lies on there is at most so much air, diagonals.
GAP = 0.015


@dataclass(frozen=True)
class Lid:
    """Fragments of a lid and of its knob, and the corners of all in the frame."""

    fragments: list[int]
    knob: list[int]
    low: Floats
    high: Floats


def find_lids(pieces: Pieces, taken: set[int]) -> list[Lid]:
    """The lid of a thing; none where several things look like one, as burners do."""
    low, high = face_on(pieces, TOP)
    size = high - low
    across = size[:, :2].max(axis=1)
    fits = (across >= LEAST) & (size[:, :2].min(axis=1) >= across / 1.2) & (size[:, 2] <= THICK * across)
    fits &= pieces.area <= MOST_AREA * float(pieces.area.sum())
    bare = pieces.seen[:, TOP] / np.maximum(size[:, 0] * size[:, 1], 1e-12)
    fits &= bare >= BARE_UNDER_BAIL
    fits[sorted(taken)] = False
    discs = [i for i in np.flatnonzero(fits).tolist() if is_round(pieces, TOP, [i], size[i, :2])]
    if len(discs) != 1:
        return []
    disc = discs[0]
    knob = _knob(low, high, disc, across)
    host = _host(low, high, disc)
    if host is None or not (knob or (bare[disc] >= BARE and _is_vessel(pieces, host))):
        return []
    fragments = [disc, *knob]
    return [Lid(fragments, knob, *pieces.box(fragments))]


def _is_vessel(pieces: Pieces, host: int) -> bool:
    """Whether a piece is open at the top and closed all round."""
    size = pieces.high[host] - pieces.low[host]
    closed = all(pieces.seen[host, s] >= 0.6 * size[a] * size[2] for s, a in ((FRONT, 0), (LEFT, 1)))
    return closed and from_above(pieces, [host]).lid <= MOUTH


def _knob(low: Floats, high: Floats, disc: int, across: Floats) -> list[int]:
    """Small pieces in the middle of a disc that stand up from it."""
    off = np.linalg.norm((low + high)[:, :2] / 2 - (low + high)[disc, :2] / 2, axis=1)
    stands = (
        (low[:, 2] < low[disc, 2] - 0.01) & (high[:, 2] >= low[disc, 2] - GAP) & (high[:, 2] <= high[disc, 2] + GAP)
    )
    found = stands & (off <= MIDDLE * across[disc]) & (across <= KNOB * across[disc])
    found[disc] = False
    return [int(i) for i in np.flatnonzero(found)]


def _host(low: Floats, high: Floats, disc: int) -> int | None:
    """The largest piece that a disc lies on."""
    under = (low[:, 2] <= high[disc, 2] + GAP) & (high[:, 2] > high[disc, 2] + GAP)
    middle = (low[disc, :2] + high[disc, :2]) / 2
    under &= (low[:, :2] <= middle).all(axis=1) & (high[:, :2] >= middle).all(axis=1)
    under[disc] = False
    rows = np.flatnonzero(under)
    if not len(rows):
        return None
    foot = np.prod((high - low)[rows, :2], axis=1)
    return int(rows[int(np.argmax(foot))])
