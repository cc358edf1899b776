"""Close the small holes of scans and generated meshes that keep them from bounding a volume."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.topology import directed_edges, edge_counts, is_closed

# Faces around tangled edges are taken out this many times, as each time may tear open some more.
ROUNDS = 3
# More torn edges than this share are no small damage.
MAX_TORN_SHARE = 0.02


def fill_holes(
    points: Floats, faces: Ints, widest: float, most_torn: float = MAX_TORN_SHARE
) -> tuple[Floats, Ints] | None:
    """Close the small holes of a surface, each by a fan about its middle; return None if any holes are left.

    Args:
        points: (P, 3) welded. faces: (F, 3), consistently wound.
        widest: of a hole that is closed, in units of the points: the longest side of the box around it.
        most_torn: maximum share of edges that are torn.
    """
    if not len(faces):
        return None
    kept = faces
    for _ in range(ROUNDS):
        _, uses, balance = edge_counts(kept)
        if ((uses != 2) | (balance != 0)).mean() > most_torn:
            return None
        tangled = _touching(kept, (uses > 2) | ((uses == 2) & (balance != 0)))
        if not tangled.any():
            break
        kept = kept[~tangled]
        if not len(kept):
            return None
    loops = _loops(kept)
    if loops is None or any(float(np.ptp(points[loop], axis=0).max()) > widest for loop in loops):
        return None
    middles = [points[loop].mean(axis=0) for loop in loops]
    fans = []
    for k, loop in enumerate(loops):
        if len(loop) == 3:
            fans.append(np.array([loop]))
        else:
            fans.append(np.stack([loop, np.roll(loop, -1), np.full(len(loop), len(points) + k)], axis=1))
    whole = np.concatenate([kept, *fans])
    return (np.concatenate([points, np.array(middles).reshape(-1, 3)]), whole) if is_closed(whole) else None


def _touching(faces: Ints, bad: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """(F,) faces with one of the edges that `edge_counts` lists and `bad` marks."""
    directed = directed_edges(faces)
    ends = np.sort(directed, axis=1)
    key = ends[:, 0] * (int(faces.max()) + 1) + ends[:, 1]
    _, inverse = np.unique(key, return_inverse=True)
    touching: npt.NDArray[np.bool_] = np.any(bad[inverse].reshape(3, -1), axis=0)
    return touching


def _loops(faces: Ints) -> list[Ints] | None:
    """Return the closed loops of boundary edges, which have one face, wound opposite to it; None if one does not close.

    If two holes meet in a point, each loop continues around the hole along which it arrived.
    """
    directed = directed_edges(faces)
    count = int(faces.max()) + 1
    forth, back = directed[:, 0] * count + directed[:, 1], directed[:, 1] * count + directed[:, 0]
    open_ = np.sort(back[~np.isin(back, forth)])
    out: dict[int, list[int]] = {}
    for start, end in zip((open_ // count).tolist(), (open_ % count).tolist(), strict=True):
        out.setdefault(start, []).append(end)
    if any(len(ends) > 2 for ends in out.values()):
        return None
    meet = any(len(ends) == 2 for ends in out.values())
    third = dict(zip(forth.tolist(), np.roll(faces, 1, axis=1).T.ravel().tolist(), strict=True)) if meet else {}
    ways = {}
    for start, ends in out.items():
        for end in ends:
            onwards = out.get(end, [])
            if len(onwards) == 2:  # the faces on this side of the point end at the other hole
                onwards = [spot for spot in onwards if spot != _around(third, start, end, count)]
            if len(onwards) != 1:
                return None
            ways[start, end] = (end, onwards[0])
    loops = []
    while ways:
        first = min(ways)
        way, at = [first[0]], ways.pop(first)
        while at != first:
            if at not in ways:
                return None
            way.append(at[0])
            at = ways.pop(at)
        loops.append(np.array(way, dtype=np.int64))
    return loops


def _around(third: dict[int, int], before: int, spot: int, count: int) -> int:
    """End of the fan of faces that an open way from `before` to `spot` runs along end, going around that point.

    Args:
        third: of each directed edge, first * count + second, the corner across from it. count: of the points.
    """
    for _ in range(len(third)):
        across = third[spot * count + before]
        if spot * count + across not in third:
            return across
        before = across
    return -1
