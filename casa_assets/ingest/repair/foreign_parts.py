"""Find pieces that are no part of the thing: ground planes, backdrops, stands, skies, floating specks."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.mesh.measure import face_normals, signed_volume
from casa_assets.geometry.mesh.topology import is_closed
from casa_assets.geometry.solid.coverage import surface_samples
from casa_assets.geometry.solid.hull import hull_volume
from casa_assets.ingest.draft import warning
from casa_assets.ingest.repair.components import Pieces, box_gaps
from casa_assets.model.issue import Issue
from casa_assets.model.registry.category import Category

# With more pieces than these it is a heap, of which nothing is taken away.
MOST_PIECES = 5000
# A speck is smaller than this part of the largest piece. It floats where it is farther from everything than that part
# of the largest piece, and than so many times its own size: crumbs and sprinkles lie near.
SPECK_SIZE = 0.05
SPECK_GAP = 0.03
SPECK_GAPS = 3.0
# Specks nearer to each other than this part of their size hang together, as the links of a chain do.
LINK_GAP_SHARE = 0.25
MOST_LINKED = 1500
SURFACE_SAMPLES = 40_000
# A ground plane is this many times wider than what stands on it, and this flat.
GROUND_WIDTH = 1.5
GROUND_FLAT = 1e-3
# A sky around the thing is this many times larger than all that is in it.
SKY_WIDTH = 5.0
SKY_CONVEX = 0.9
# Cosine off which faces are level, or at right angles.
LEVEL_OFF = 0.02
# Several flat sheets are a room where they are so many times wider.
ROOM_WIDTH = 2.5
# A backdrop is an open sheet bent along one line: how far its normals leave the plane across that line, the least
# second moment of them in it (.5 for a right angle of equal sides), the length of their mean, and the share of the
# sheet that has the thing before it.
BENT_OFF = 0.03
BENT_BY = 0.1
BENT_LEAN = 0.5
BENT_BEFORE = 0.9
# A stand is a slab this flat and convex, so many times wider than what is on it, whose foot is so near to its top.
STAND_FLAT = 0.15
STAND_FULL = 0.9
STAND_WIDTH = 1.2
STAND_GAP = 0.05
# The category of what nobody could name, which has no proportions.
UNKNOWN = "object"
# What is left without it has to be so much nearer to the usual proportions of the category, and that near: logarithms.
MIN_IMPROVEMENT = 0.2
MAX_PROPORTION_ERROR = 0.7
# Pieces this large and this far apart, as parts of the largest one's size, are objects of their own.
APART_SIZE = 0.3
APART_GAP = 0.1
MOST_APART = 64


def foreign_parts(found: Pieces, category: Category | None) -> tuple[Mask, list[Issue]]:
    """(N,) True for pieces that are no part of the thing, and notes on them.

    Args:
        category: whose usual proportions tell a stand from a foot; without one no stand is taken away.
    """
    out = np.zeros(found.count, dtype=bool)
    if found.count == 1 or found.count > MOST_PIECES:
        return out, []
    notes: list[Issue] = []
    for kind, message, taken in (
        ("ground", "a wide flat sheet under or behind the object was taken away", _sheets(found)),
        ("backdrop", "a bent sheet behind the object was taken away", _backdrop(found)),
    ):
        if (taken & ~out).any():
            out |= taken
            notes.append(warning("MSH012", kind, message))
    sky = _sky(found, out)
    if sky is not None:
        out[sky] = True
        notes.append(warning("MSH012", "sky", "a shell far around the object was taken away"))
    stand = None if category is None or category.id == UNKNOWN else _stand(found, out, category)
    if stand is not None:
        out[stand] = True
        notes.append(warning("MSH012", "stand", "a slab that the object stands on was taken away"))
    specks = _specks(found, out)
    if specks.any():
        message = f"{int(specks.sum())} stray pieces that touch nothing were taken away"
        notes.append(warning("MSH013", "floaters", message))
    return out | specks, notes


def separate_objects(found: Pieces, out: Mask) -> list[Issue]:
    """A note where large pieces stand apart from each other."""
    if out.all():
        return []
    main = float(found.size[~out].max())
    large = np.flatnonzero(~out & (found.size > APART_SIZE * main))
    if not 1 < len(large) <= MOST_APART:
        return []
    near = box_gaps(found.low[large], found.high[large]) <= APART_GAP * main
    groups = int(connected_components(near, directed=False)[0])
    message = f"{groups} groups of pieces stand apart from each other; give each object a file of its own"
    return [warning("MSH024", "pieces", message)] if groups > 1 else []


def _sheets(found: Pieces) -> Mask:
    """Flat sheets that are much wider than all that is not flat; of several, which might be boards, still wider."""
    flat = (found.high - found.low).min(axis=1) <= GROUND_FLAT * found.size
    width = float(found.spread(~flat).max())
    wide: Mask = flat & (found.size > GROUND_WIDTH * width) & (width > 0)
    return wide if wide.sum() == 1 else wide & (found.size > ROOM_WIDTH * width)


def _backdrop(found: Pieces) -> Mask:
    """The largest piece where it is an open sheet, bent along one line, and much wider than the rest before it."""
    out = np.zeros(found.count, dtype=bool)
    piece = int(np.argmax(found.size))
    rest = np.arange(found.count) != piece
    faces = found.faces(piece)
    if found.size[piece] <= GROUND_WIDTH * found.spread(rest).max() or is_closed(faces):
        return out
    normals, areas = face_normals(found.points, faces)
    share = areas / areas.sum()
    spread, axes = np.linalg.eigh(np.einsum("n,ni,nj->ij", share, normals, normals))
    bent = spread[1] > BENT_BY and float(share @ np.abs(normals @ axes[:, 0])) < BENT_OFF
    corner = found.size[piece] > ROOM_WIDTH * found.spread(rest).max() and _is_corner(normals, share)
    # The normals of a tube cancel out.
    lean = float(np.linalg.norm(share @ normals))
    middle = (found.low[rest].min(axis=0) + found.high[rest].max(axis=0)) / 2
    level = np.einsum("ij,ij->i", middle - found.points[faces].mean(axis=1), normals)
    ahead = float(share[level > 0].sum())
    out[piece] = (bent or corner) and lean > BENT_LEAN and max(ahead, 1 - ahead) > BENT_BEFORE
    return out


def _is_corner(normals: Floats, share: Floats) -> bool:
    """Nearly all of it lies in three planes at right angles: the floor and two walls."""
    first = normals[int(np.argmax(share))]
    across = np.abs(normals @ first) < LEVEL_OFF
    if not across.any():
        return False
    second = normals[int(np.argmax(np.where(across, share, -1)))]
    three = np.stack([first, second, np.cross(first, second)], axis=1)
    same = np.abs(normals @ three) > 1 - LEVEL_OFF
    return float(share @ same.any(axis=1)) > BENT_BEFORE and bool((share @ same > BENT_BY).all())


def _sky(found: Pieces, out: Mask) -> int | None:
    """The piece that is a shell far around all others: convex and seen from within."""
    for piece in np.argsort(-found.size, kind="stable")[:3]:
        rest = ~out & (np.arange(found.count) != piece)
        if out[piece] or not rest.any():
            continue
        around = (found.low[piece] < found.low[rest]).all() and (found.high[rest] < found.high[piece]).all()
        if around and found.spread(rest).max() * SKY_WIDTH < found.size[piece]:
            points, faces = _own(found, int(piece))
            # A vessel with a crumb in it is hollow, and a fruit with seeds faces outwards.
            if -signed_volume(points, faces) > SKY_CONVEX * hull_volume(points) > 0:
                return int(piece)
    return None


def _stand(found: Pieces, out: Mask, category: Category) -> int | None:
    """The slab below all others, without which the thing has the proportions of its category."""
    usual = np.sort(np.array(category.shape))
    for piece in np.flatnonzero(~out):
        rest = ~out & (np.arange(found.count) != piece)
        if not rest.any() or not _is_under(found, int(piece), rest):
            continue
        whole, left = (_unlike(found.spread(some), usual) for some in (~out, rest))
        if left <= MAX_PROPORTION_ERROR and left <= whole - MIN_IMPROVEMENT and _is_slab(found, int(piece)):
            return int(piece)
    return None


def _is_under(found: Pieces, piece: int, rest: Mask) -> bool:
    """Flat, wider than all others, and all on one side of it."""
    low, high = found.low[piece], found.high[piece]
    across = int(np.argmin(high - low))
    beside = [k for k in range(3) if k != across]
    sides, others = high - low, found.spread(rest)
    if sides[across] > STAND_FLAT * sides[beside].min() or (sides[beside] < STAND_WIDTH * others[beside]).any():
        return False
    gap = STAND_GAP * float(others.max())
    above = found.low[rest][:, across].min() - high[across]
    below = low[across] - found.high[rest][:, across].max()
    return bool(abs(above) <= gap or abs(below) <= gap)


def _is_slab(found: Pieces, piece: int) -> bool:
    points, faces = _own(found, piece)
    return abs(signed_volume(points, faces)) >= STAND_FULL * hull_volume(points) > 0


def _own(found: Pieces, piece: int) -> tuple[Floats, Ints]:
    """(P, 3) points and (F, 3) faces of one piece alone."""
    used, local = np.unique(found.faces(piece), return_inverse=True)
    return found.points[used], local.reshape(-1, 3)


def _unlike(sides: Floats, usual: Floats) -> float:
    """Largest logarithm by which proportions differ, whichever way the thing is turned."""
    mine = np.sort(sides) / max(float(sides.max()), 1e-300)
    return float(np.abs(np.log(np.maximum(mine, 1e-9) / usual)).max())


def _specks(found: Pieces, out: Mask) -> Mask:
    """Small pieces that touch nothing, nor hang on others that do."""
    none = np.zeros(found.count, dtype=bool)
    if out.all():
        return none
    main = float(found.size[~out].max())
    small = ~out & (found.size < SPECK_SIZE * main)
    large = ~out & ~small
    if not small.any():
        return none
    faces = found.ids[large[found.label]]
    used, local = np.unique(faces, return_inverse=True)
    strewn = surface_samples(found.points[used], local.reshape(-1, 3), SURFACE_SAMPLES)
    index, mine = np.flatnonzero(small), small[found.label]
    away = cKDTree(np.concatenate([found.points[used], strewn])).query(found.points[found.ids[mine]].reshape(-1, 3))[0]
    gap = np.full(found.count, np.inf)
    np.minimum.at(gap, found.label[mine], away.reshape(-1, 3).min(axis=1))
    floating = gap[index] > np.maximum(SPECK_GAP * main, SPECK_GAPS * found.size[index])
    if len(index) <= MOST_LINKED and not floating.all() and floating.any():
        sizes = np.minimum(found.size[index][:, None], found.size[index][None])
        chain = connected_components(
            box_gaps(found.low[index], found.high[index]) <= LINK_GAP_SHARE * sizes, directed=False
        )[1]
        held = np.zeros(int(chain.max()) + 1, dtype=bool)
        held[chain[~floating]] = True
        floating &= ~held[chain]
    none[index[floating]] = True
    return none
