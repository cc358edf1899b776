"""Propose rectangles of a side that may be fronts, score each, and choose the set that explains the side best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.fronts.relief import (
    MIN_BAR_PROTRUSION,
    FrontRectangle,
    LineTable,
    find_front_rectangles,
    find_lines,
    is_bar,
    line_table,
    measure_rectangle,
    merge_stairs,
    seam_maps,
)
from casa_assets.articulate.segment.fragments import WeldedMesh
from casa_assets.articulate.segment.orthographic import BACKGROUND_DEPTH, SIDES, Protrusion, SideRelief
from casa_assets.core.numeric import Floats, Forest, Ints, Mask

# Least side of a front, diagonals, and least share of its rectangle that is surface.
MIN_SIDE, MIN_COVERAGE = 0.035, 0.6
# Each side of a rectangle is at least so well supported, unless the rectangle is given.
MIN_SUPPORT = 0.15
# Most rectangles that are kept of a side, those with the best supported sides first.
MAX_RECTANGLES = 4000
# A normal faces the viewer from this cosine on.
FACING_COS = 0.819
# A rectangle of more than this share of the outline both ways is the whole side.
WHOLE_SHARE = 0.92
# Rectangles that agree to this share of their area are one hypothesis; those that overlap less than the second share
# of the smaller do not exclude each other.
SAME_OVERLAP, FREE_OVERLAP = 0.7, 0.08
# Widths or heights within this share are equal, and neighbours lie within this many diagonals of each other.
EQUAL_SIZE, NEIGHBOUR_GAP = 0.08, 0.035
# Strong hypotheses that are looked at as neighbours, and the share of one that lies within another.
MAX_NEIGHBOURS, INSIDE_SHARE = 400, 0.85
# Most hypotheses among which the best set is looked for.
MAX_CHOICE = 60
# A rectangle is a front from these log odds on.
MIN_SCORE = -0.5
# What is less likely by itself is a front, too, from these log odds on, where it is in line with fronts beside it, and
# flush (but for what is sunk in their frames), within this many diagonals, and its pull has the size of theirs but for
# this share.
COMPLETING_SCORE, IN_LINE_SLACK, FLUSH_SLACK, ALIKE_PULLS = -1.6, 0.008, 0.02, 0.25
# Score of a neighbour that is not there, log odds; and the bound of probabilities.
NO_NEIGHBOUR, LEAST_PROBABILITY = -4.0, 0.002
FEATURES = (
    *("constant", "support_least", "support_second", "support_mean", "outline_mean", "outline_count", "edge_mean"),
    *("edge_least", "groove_mean", "bend_mean", "proud_mean", "proud_least", "inset_mean", "inset_least"),
    *("visible_least", "cross_level", "cross_upright", "coverage", "facing", "roughness", "depth", "width"),
    *("height", "area", "tall", "wide", "whole", "one_bar", "more_bars", "one_small", "two_small", "more_small"),
    *("bar_and_small", "straddles", "given", "one_bar_support", "bare_support", "no_bars_at_all"),
    *("bare_among_bars", "pull_fit"),
)
CONTEXT = ("mirrored", "stacked", "beside", "inside_better", "around_better")


@dataclass(frozen=True)
class FrontHypotheses:
    """Rectangles of a side, each with features.

    Attributes:
        rows, columns: (N, 2) half-open pixel ranges. features: (N, K) in the order of FEATURES.
        turn: sum of two columns that mirror each other in the middle of the outline. pixel: edge of one, diagonals.
    """

    rows: Ints
    columns: Ints
    features: Floats
    turn: float
    pixel: float


def find_fronts(
    mesh: WeldedMesh, relief: SideRelief, side: int, forests: tuple[Forest, Forest]
) -> list[tuple[FrontRectangle, float]]:
    """Return the rectangles of a side that are fronts, each with its probability, top down and left to right.

    Args:
        forests: the one that sees each hypothesis alone, with FEATURES, and the one that sees CONTEXT, too.
    """
    found = propose_fronts(mesh, relief, side, merge_stairs(relief, find_front_rectangles(relief)))
    if not len(found.rows):
        return []
    alone = log_odds(forests[0].probabilities(found.features)[:, 1])
    features = np.concatenate([found.features, context_features(found, alone)], axis=1)
    chances = forests[1].probabilities(features)[:, 1]
    kept = choose_fronts(found, log_odds(chances), MIN_SCORE)
    more = [k for k in choose_fronts(found, log_odds(chances), COMPLETING_SCORE) if _completes(found, relief, k, kept)]
    out = [(_measured(found, relief, k), max(float(chances[k]), 0.5)) for k in (*kept, *more)]
    return sorted(out, key=lambda m: (m[0].rows, m[0].columns))


def _measured(found: FrontHypotheses, relief: SideRelief, k: int) -> FrontRectangle:
    """Return a hypothesis as a rectangle with its depth and its protrusions."""
    (a, b), (c, d) = found.rows[k].tolist(), found.columns[k].tolist()
    return measure_rectangle(relief, FrontRectangle((a, b), (c, d)))


def _completes(found: FrontHypotheses, relief: SideRelief, k: int, kept: Sequence[int]) -> bool:
    """Return whether a rectangle is in line and flush with the fronts next to it, and has one pull like theirs."""
    if k in kept or not kept or any(_conflict(found, k, o) for o in kept):
        return False
    own = _measured(found, relief, k)
    if len(own.blobs) != 1:
        return False
    pull, slack = relief.blobs[own.blobs[0]], max(3.0, IN_LINE_SLACK / found.pixel)
    for across, along in ((found.columns, found.rows), (found.rows, found.columns)):
        touching = (o for o in kept if min(abs(along[k, 0] - along[o, 1]), abs(along[o, 0] - along[k, 1])) <= slack)
        beside = [o for o in touching if min(across[k, 1], across[o, 1]) > max(across[k, 0], across[o, 0])]
        if not beside:
            continue
        ends = across[beside, 0].min(), across[beside, 1].max()
        others = [_measured(found, relief, o) for o in beside]
        pulls = [relief.blobs[b] for m in others for b in m.blobs]
        if (
            float(np.abs(across[k] - ends).max()) <= slack
            and all(abs(m.plane - own.plane) <= FLUSH_SLACK for m in others)
            and any(_are_alike(pull, other, found.pixel) for other in pulls)
        ):
            return True
    return False


def _are_alike(pull: Protrusion, other: Protrusion, pixel: float) -> bool:
    """Return whether two pulls have one size, whichever way they lie."""
    a, b = np.sort(pull.upper - pull.lower), np.sort(other.upper - other.lower)
    return bool((np.abs(a - b) <= ALIKE_PULLS * np.maximum(a, b) + 2 * pixel).all())


def propose_fronts(mesh: WeldedMesh, relief: SideRelief, side: int, given: Sequence[FrontRectangle]) -> FrontHypotheses:
    """Return the rectangles of a side between lines that something speaks for, and those given."""
    pixel = relief.image.pixel
    seen = np.flatnonzero((relief.depth < BACKGROUND_DEPTH / 2).any(axis=0))
    middle = int(seen[0] + seen[-1] + 1) // 2 if len(seen) else 0
    rows, columns = sorted({r for m in given for r in m.rows}), sorted({c for m in given for c in m.columns})
    level_maps, upright_maps = (seam_maps(mesh, relief, side, upright) for upright in (False, True))
    level_at = find_lines(level_maps, pixel, rows)
    central = [] if any(abs(middle - c) <= 2 for c in columns) else [middle]
    upright_at = find_lines(upright_maps, pixel, sorted([*columns, *central]))
    level = line_table(level_maps, level_at, upright_at, pixel)
    upright = line_table(upright_maps, upright_at, level_at, pixel)
    top, bottom, left, right = _pairs(level_at, upright_at, max(4, round(MIN_SIDE / pixel)))
    wanted = {(*m.rows, *m.columns): m.fit for m in given}
    ends = np.stack([level_at[top], level_at[bottom], upright_at[left], upright_at[right]], axis=1)
    is_given = np.array([tuple(e) in wanted for e in ends.tolist()], dtype=bool)
    fit = np.array([wanted.get(tuple(e), 0.0) for e in ends.tolist()])
    support = _support(level, upright, (top, bottom, left, right))
    kept = is_given | (support.max(axis=2).min(axis=1) >= MIN_SUPPORT)
    pick = np.flatnonzero(kept & (_coverage(relief, ends) >= MIN_COVERAGE))
    if len(pick) > MAX_RECTANGLES:
        rank = np.where(is_given[pick], 2.0, np.sort(support[pick].max(axis=2), axis=1)[:, :2].sum(axis=1) / 2)
        pick = pick[np.argsort(-rank, kind="stable")[:MAX_RECTANGLES]]
    ends, is_given, fit = ends[pick], is_given[pick], fit[pick]
    index = top[pick], bottom[pick], left[pick], right[pick]
    features = _features(mesh, relief, side, ends, (is_given, fit), level, upright, index)
    turn = float(seen[0] + seen[-1] + 1) if len(seen) else 0.0
    return FrontHypotheses(ends[:, :2], ends[:, 2:], features, turn, pixel)


def _pairs(level: Ints, upright: Ints, least: int) -> tuple[Ints, Ints, Ints, Ints]:
    """Return indices of every two level and two upright lines that are far enough apart."""
    a, b = np.triu_indices(len(level), 1)
    far = level[b] - level[a] >= least
    a, b = a[far], b[far]
    c, d = np.triu_indices(len(upright), 1)
    far = upright[d] - upright[c] >= least
    c, d = c[far], d[far]
    return np.repeat(a, len(c)), np.repeat(b, len(c)), np.tile(c, len(a)), np.tile(d, len(a))


def _support(level: LineTable, upright: LineTable, index: tuple[Ints, Ints, Ints, Ints]) -> Floats:
    """Return (N, 4, 4): of each side (top, bottom, left, right) its edge, groove, bend and outline."""
    top, bottom, left, right = index
    out = []
    for table, at, first, last, outline in (
        (level, top, left, right, 3),
        (level, bottom, left, right, 4),
        (upright, left, top, bottom, 3),
        (upright, right, top, bottom, 4),
    ):
        values = table.values[at, first, last]
        out.append(np.stack([values[:, 0], values[:, 1], values[:, 2], values[:, outline]], axis=1))
    return np.stack(out, axis=1)


def _integral(values: Floats) -> Floats:
    """Return the (H + 1, W + 1) sums of an image up to each corner."""
    return np.pad(np.cumsum(np.cumsum(values, axis=0), axis=1), ((1, 0), (1, 0)))


def _sums(integral: Floats, ends: Ints) -> Floats:
    """Return the (N,) sums over rectangles (first row, last row, first column, last column; half-open)."""
    a, b, c, d = ends.T
    return np.asarray(integral[b, d] - integral[a, d] - integral[b, c] + integral[a, c])


def _coverage(relief: SideRelief, ends: Ints) -> Floats:
    """Return the (N,) share of each rectangle that is surface."""
    seen = _integral((relief.depth < BACKGROUND_DEPTH / 2).astype(np.float64))
    return _sums(seen, ends) / np.maximum((ends[:, 1] - ends[:, 0]) * (ends[:, 3] - ends[:, 2]), 1)


def _features(
    mesh: WeldedMesh,
    relief: SideRelief,
    side: int,
    ends: Ints,
    given: tuple[Mask, Floats],
    level: LineTable,
    upright: LineTable,
    index: tuple[Ints, Ints, Ints, Ints],
) -> Floats:
    """Return the (N, K) features of rectangles.

    Args:
        given: (N,) whether each was given, and how well its pull is placed on it.
    """
    top, bottom, left, right = index
    support = _support(level, upright, index)
    best = np.sort(support.max(axis=2), axis=1)
    above, below = level.values[top, left, right], level.values[bottom, left, right]
    before, after = upright.values[left, top, bottom], upright.values[right, top, bottom]
    steps = np.stack([above[:, 5], -below[:, 5], before[:, 5], -after[:, 5]], axis=1)
    visible = np.stack([above[:, 6], below[:, 6], before[:, 6], after[:, 6]], axis=1)
    proud, inset = np.maximum(steps, 0.0), np.maximum(-steps, 0.0)
    pixel = relief.image.pixel
    seen = relief.depth < BACKGROUND_DEPTH / 2
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    high = float(np.ptp(rows) + 1) if len(rows) else 1.0
    wide = float(np.ptp(columns) + 1) if len(columns) else 1.0
    height, width = (ends[:, 1] - ends[:, 0]) / high, (ends[:, 3] - ends[:, 2]) / wide
    tall = np.log(np.maximum(ends[:, 1] - ends[:, 0], 1) / np.maximum(ends[:, 3] - ends[:, 2], 1))
    named = {
        "constant": np.ones(len(ends)),
        "given": given[0].astype(np.float64),
        "pull_fit": given[1],
        "support_least": best[:, 0],
        "support_second": best[:, 1],
        "support_mean": best.mean(axis=1),
        "outline_mean": support[:, :, 3].mean(axis=1),
        "outline_count": (support[:, :, 3] > 0.8).sum(axis=1) / 4,
        "edge_mean": support[:, :, 0].mean(axis=1),
        "edge_least": support[:, :, [0, 3]].max(axis=2).min(axis=1),
        "groove_mean": support[:, :, 1].mean(axis=1),
        "bend_mean": support[:, :, 2].mean(axis=1),
        "proud_mean": proud.mean(axis=1),
        "proud_least": proud.min(axis=1),
        "inset_mean": inset.mean(axis=1),
        "inset_least": inset.min(axis=1),
        "visible_least": visible.min(axis=1),
        "cross_level": _crossing(level, top, bottom, left, right, pixel),
        "cross_upright": _crossing(upright, left, right, top, bottom, pixel),
        **_surface_features(mesh, relief, side, ends),
        "width": width,
        "height": height,
        "area": width * height,
        "tall": np.maximum(tall, 0.0),
        "wide": np.maximum(-tall, 0.0),
        "whole": ((width > WHOLE_SHARE) & (height > WHOLE_SHARE)).astype(np.float64),
    }
    named |= _thing_features(relief, ends, named["support_least"])
    return np.stack([named[name] for name in FEATURES], axis=1)


def _surface_features(mesh: WeldedMesh, relief: SideRelief, side: int, ends: Ints) -> dict[str, Floats]:
    """Return how much of rectangles is surface, how it faces, and how deep and rough it is."""
    seen = relief.depth < BACKGROUND_DEPTH / 2
    ground = seen & (relief.blob < 0)
    depth = np.where(ground, relief.depth, 0.0)
    count = np.maximum(_sums(_integral(ground.astype(np.float64)), ends), 1.0)
    mean = _sums(_integral(depth), ends) / count
    spread = np.sqrt(np.maximum(_sums(_integral(depth**2), ends) / count - mean**2, 0.0))
    faces = np.abs(mesh.normals[np.maximum(relief.image.face, 0)] @ SIDES[side][2]) > FACING_COS
    return {
        "coverage": _coverage(relief, ends),
        "facing": _sums(_integral((faces & ground).astype(np.float64)), ends) / count,
        "roughness": np.minimum(spread / 0.02, 2.0),
        "depth": np.minimum((mean - float(relief.depth[seen].min(initial=0.0))) / 0.1, 3.0),
    }


def _thing_features(relief: SideRelief, ends: Ints, support_least: Floats) -> dict[str, Floats]:
    """Return which handles and other small things rectangles hold."""
    bars, small, straddles = _count_blobs(relief, ends)
    any_bar = any(is_bar(b) for b in relief.blobs)
    bare = (bars == 0) & (small == 0)
    return {
        "one_bar": (bars == 1).astype(np.float64),
        "more_bars": np.minimum(np.maximum(bars - 1, 0), 3) / 3,
        "one_small": ((bars == 0) & (small == 1)).astype(np.float64),
        "two_small": ((bars == 0) & (small == 2)).astype(np.float64),
        "more_small": np.minimum(np.maximum(small - 2, 0), 4) / 4,
        "bar_and_small": ((bars > 0) & (small > 0)).astype(np.float64),
        "straddles": np.minimum(straddles, 2) / 2,
        "one_bar_support": (bars == 1) * support_least,
        "bare_support": bare * support_least,
        "no_bars_at_all": np.full(len(ends), float(not any_bar)),
        "bare_among_bars": (bare & any_bar).astype(np.float64),
    }


def _count_blobs(relief: SideRelief, ends: Ints) -> tuple[Ints, Ints, Ints]:
    """Return (N,) how many bars, and how many other things, have their middle in each rectangle; how many cross it."""
    bars, small, straddles = (np.zeros(len(ends), dtype=np.int64) for _ in range(3))
    for blob in relief.blobs:
        row, column = sum(blob.rows) / 2, sum(blob.columns) / 2
        inside = (ends[:, 0] <= row) & (row < ends[:, 1]) & (ends[:, 2] <= column) & (column < ends[:, 3])
        if is_bar(blob):
            bars += inside
        elif blob.protrusion >= 0.3 * MIN_BAR_PROTRUSION:
            small += inside
        (a, b), (c, d) = blob.rows, blob.columns
        high = np.minimum(ends[:, 1], b) - np.maximum(ends[:, 0], a)
        wide = np.minimum(ends[:, 3], d) - np.maximum(ends[:, 2], c)
        share = np.maximum(high, 0) * np.maximum(wide, 0) / ((b - a) * (d - c))
        straddles += (share > 0.1) & (share < 0.9)
    return bars, small, straddles


def _crossing(table: LineTable, first: Ints, last: Ints, start: Ints, stop: Ints, pixel: float) -> Floats:
    """Return (N,) the best support of any line that crosses a rectangle from side to side, away from its ends."""
    support = table.values[..., :3].max(axis=3)
    count = len(table.at)
    margin = MIN_SIDE / pixel
    best = np.zeros((count, count, *support.shape[1:]))
    for i in range(count):
        for j in range(i + 2, count):
            inner = np.flatnonzero((table.at - table.at[i] >= margin) & (table.at[j] - table.at >= margin))
            if len(inner):
                best[i, j] = support[inner].max(axis=0)
    return best[first, last, start, stop]


def context_features(hypotheses: FrontHypotheses, score: Floats) -> Floats:
    """Return (N, 5) features of CONTEXT: the best score of a mirrored, stacked, neighbouring or overlapping rectangle.

    Args:
        score: (N,) log odds of each by itself.
    """
    out = np.full((len(score), len(CONTEXT)), NO_NEIGHBOUR)
    strong = np.flatnonzero(score > NO_NEIGHBOUR)
    for k in strong[np.argsort(-score[strong], kind="stable")[:MAX_NEIGHBOURS]].tolist():
        for column, mask in enumerate(_relations(hypotheses, k)):
            mask[k] = False
            out[mask, column] = np.maximum(out[mask, column], score[k])
    return out


def _relations(hypotheses: FrontHypotheses, k: int) -> tuple[Mask, Mask, Mask, Mask, Mask]:
    """Return (N,) masks of the rectangles that one mirrors, is on or under, is next to, lies within, and contains."""
    rows, columns = hypotheses.rows, hypotheses.columns
    gap, turn = NEIGHBOUR_GAP / hypotheses.pixel, hypotheses.turn
    height, width = rows[:, 1] - rows[:, 0], columns[:, 1] - columns[:, 0]
    area = height * width
    slack = EQUAL_SIZE * min(height[k], width[k]) + 2.0
    same_rows = (np.abs(rows - rows[k]) <= slack).all(axis=1)
    same_columns = (np.abs(columns - columns[k]) <= slack).all(axis=1)
    mirrored = (np.abs(columns - (turn - columns[k][::-1])) <= slack).all(axis=1)
    apart = np.abs(columns.sum(axis=1) - turn) >= width - slack
    stacked, beside = _touch(rows, k, slack, gap), _touch(columns, k, slack, gap)
    over = np.minimum(rows[:, 1], rows[k, 1]) - np.maximum(rows[:, 0], rows[k, 0])
    across = np.minimum(columns[:, 1], columns[k, 1]) - np.maximum(columns[:, 0], columns[k, 0])
    common = np.maximum(over, 0) * np.maximum(across, 0)
    other = common / (area + area[k] - common) < SAME_OVERLAP
    within, around = other & (common > INSIDE_SHARE * area[k]), other & (common > INSIDE_SHARE * area)
    return same_rows & mirrored & apart, same_columns & stacked, same_rows & beside, within, around


def _touch(spans: Ints, k: int, slack: float, gap: float) -> Mask:
    """Mark the (N,) spans that begin where one ends, or end where it begins."""
    after, before = spans[:, 0] - spans[k, 1], spans[k, 0] - spans[:, 1]
    return np.asarray(((after >= -slack) & (after <= gap)) | ((before >= -slack) & (before <= gap)))


def log_odds(probability: Floats) -> Floats:
    """Return the log odds of probabilities, bounded."""
    bounded = np.clip(probability, LEAST_PROBABILITY, 1 - LEAST_PROBABILITY)
    return np.log(bounded / (1 - bounded))


def choose_fronts(hypotheses: FrontHypotheses, score: Floats, least: float) -> list[int]:
    """Return the rectangles that do not overlap and whose scores above a least one have the greatest sum."""
    order = np.flatnonzero(score > least)
    order = order[np.argsort(-score[order], kind="stable")]
    kept: list[int] = []
    for k in order.tolist():
        if len(kept) < MAX_CHOICE and not any(_agreement(hypotheses, k, o) > SAME_OVERLAP for o in kept):
            kept.append(k)
    gain = {k: float(score[k] - least) for k in kept}
    against = {k: {o for o in kept if o != k and _conflict(hypotheses, k, o)} for k in kept}
    return sorted(_best_set(kept, gain, against))


def _overlap(hypotheses: FrontHypotheses, a: int, b: int) -> float:
    spans = ((hypotheses.rows[a], hypotheses.rows[b]), (hypotheses.columns[a], hypotheses.columns[b]))
    over = [float(min(p[1], q[1]) - max(p[0], q[0])) for p, q in spans]
    return max(over[0], 0.0) * max(over[1], 0.0)


def _area(hypotheses: FrontHypotheses, a: int) -> float:
    return float(np.ptp(hypotheses.rows[a]) * np.ptp(hypotheses.columns[a]))


def _agreement(hypotheses: FrontHypotheses, a: int, b: int) -> float:
    """Return the intersection of two rectangles over their union."""
    common = _overlap(hypotheses, a, b)
    return common / (_area(hypotheses, a) + _area(hypotheses, b) - common)


def _conflict(hypotheses: FrontHypotheses, a: int, b: int) -> bool:
    """Return whether two rectangles cannot both be fronts."""
    return _overlap(hypotheses, a, b) > FREE_OVERLAP * min(_area(hypotheses, a), _area(hypotheses, b))


def _best_set(order: list[int], gain: Mapping[int, float], against: Mapping[int, set[int]]) -> list[int]:
    """Return the members without conflict of the greatest sum, by exchanging one at a time from a greedy start."""
    chosen: set[int] = set()
    for k in order:
        if not against[k] & chosen:
            chosen.add(k)
    changed = True
    while changed:
        changed = False
        for k in order:
            if k in chosen:
                continue
            lost = against[k] & chosen
            rest = chosen - lost | {k}
            for o in order:
                if o not in rest and not against[o] & rest:
                    rest.add(o)
            if sum(gain[m] for m in rest) > sum(gain[m] for m in chosen) + 1e-9:
                chosen, changed = rest, True
    return list(chosen)
