"""What is promised of collision shapes, beside what was measured: passed, or missed and by how far."""

from __future__ import annotations

import statistics
from collections.abc import Sequence

import numpy as np

from benchmarks.ingest.judging.collision_report import COACD, MOST_SHAPES, OURS, VHACD, Row
from benchmarks.ingest.judging.stepping import Pace

MEDIAN_S, P95_S, MEMORY_MB, CLOSE, VERTICES, KEPT, MUG_IOU = 4.0, 20.0, 1024, 0.9, 64, 0.8, 0.8
PACE, STEPS = 5.0, 3.0
# Categories that have to be one shape, and of which kind; empty: any.
ONE_SHAPE = {"apple": "", "can": "cylinder", "boxed_food": "box"}
AS_GOOD = 0.005  # IoU that is equal but for sampling


def targets(rows: Sequence[Row], pace: Sequence[Pace]) -> list[str]:
    """Lines of a table, one for each target that the rows can say something about."""
    mine = [r for r in rows if r.tool == OURS]
    lines = ["| target | measured | of | verdict |", "|---|---|---|---|"]
    for name, measured, of, short in [*_cost(mine), *_closeness(mine), *_kinds(mine), *_peers(rows, pace)]:
        lines.append(f"| {name} | {measured} | {of} | {'pass' if not short else f'MISS: {short}'} |")
    return lines


Line = tuple[str, str, str, str]


def _most(name: str, value: float, limit: float, unit: str, of: str) -> Line:
    short = "" if value <= limit else f"{value - limit:.1f} {unit} over"
    return f"{name} <= {limit:g} {unit}".strip(), f"{value:.1f} {unit}".strip(), of, short


def _least(name: str, value: float, limit: float, of: str, percent: bool = False) -> Line:
    show = (lambda v: f"{v:.0%}") if percent else (lambda v: f"{v:.2f}")
    short = "" if value >= limit else f"{show(limit - value)} short"
    return f"{name} >= {show(limit)}", show(value), of, short


def _cost(mine: Sequence[Row]) -> list[Line]:
    seconds = [r.seconds for r in mine]
    of, failed = f"{len(mine)} inputs", sum(r.shapes is None for r in mine)
    return [
        _most("CPU seconds per asset, median", statistics.median(seconds), MEDIAN_S, "s", of),
        _most("CPU seconds per asset, p95", float(np.percentile(seconds, 95)), P95_S, "s", of),
        _most("memory of the worst", max(r.memory_mb for r in mine), MEMORY_MB, "MB", of),
        _most("aborts", failed, 0, "", of),
    ]


def _closeness(mine: Sequence[Row]) -> list[Line]:
    of = f"{len(mine)} inputs"
    close = sum(r.is_close for r in mine) / len(mine)
    open_ = [r.kept for r in mine if r.kept is not None]
    lines = [
        _least("within max(2 mm, 1.5 %) for 95 % both ways, 5 % at worst", close, CLOSE, of, percent=True),
        _most("shapes", max(r.shapes or 0 for r in mine), MOST_SHAPES, "", of),
        _most("vertices of a hull", max(r.hull_vertices or 0 for r in mine), VERTICES, "", of),
    ]
    if open_:
        kept = f"{sum(k >= KEPT for k in open_)} of {len(open_)} containers, least {min(open_):.0%}"
        short = "" if min(open_) >= KEPT else f"{KEPT - min(open_):.0%} short"
        lines.append((f"interior kept by each open container >= {KEPT:.0%}", kept, "containers", short))
    return lines


def _kinds(mine: Sequence[Row]) -> list[Line]:
    lines = []
    for category, kind in ONE_SHAPE.items():
        rows = [r for r in mine if r.category == category]
        good = [r for r in rows if r.shapes == 1 and kind in r.kinds]
        if rows:
            short = "" if len(good) == len(rows) else f"{len(rows) - len(good)} of {len(rows)} not"
            lines.append((f"{category}: one {kind or 'shape'}", f"{len(good)} of {len(rows)}", category, short))
    mugs = [r.iou for r in mine if r.category == "mug" and r.iou is not None]
    if mugs:
        words = f"{sum(v >= MUG_IOU for v in mugs)} of {len(mugs)}, median {statistics.median(mugs):.2f}"
        short = "" if min(mugs) >= MUG_IOU else f"least {min(mugs):.2f}, {MUG_IOU - min(mugs):.2f} short"
        lines.append((f"IoU of each closed mug >= {MUG_IOU:.2f}", words, "mugs", short))
    return lines


def _peers(rows: Sequence[Row], pace: Sequence[Pace]) -> list[Line]:
    mine = {r.path: r for r in rows if r.tool == OURS and r.shapes}
    pairs = [(mine[r.path], r) for r in rows if r.tool == COACD and r.path in mine]
    lines = []
    if pairs:
        # One that was stopped took at least as long as it was given.
        faster = statistics.median(b.seconds / max(a.seconds, 0.01) for a, b in pairs)
        stopped = sum(b.shapes is None for _, b in pairs)
        of = f"{len(pairs)} inputs, of which CoACD was stopped or failed on {stopped}"
        lines.append(_least("times faster than CoACD as obj2mjcf calls it, median", faster, PACE, of))
        both = [(a.iou, b.iou) for a, b in pairs if a.iou is not None and b.iou is not None]
        if both:
            share = sum(a >= b - AS_GOOD for a, b in both) / len(both)
            lines.append(
                _least("of these, IoU equal or better", share, 1.0, f"{len(both)} closed meshes", percent=True)
            )
    steps = {p.tool: p for p in pace}
    if OURS in steps and VHACD in steps:
        ratio = steps[OURS].steps / steps[VHACD].steps
        of = f"{steps[OURS].things} things, {steps[OURS].shapes} and {steps[VHACD].shapes} shapes"
        lines.append(_least("MuJoCo steps per second over those of 32 V-HACD hulls each", ratio, STEPS, of))
    return lines
