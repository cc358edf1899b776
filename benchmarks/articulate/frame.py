"""How often the guess of up and front is right on the articulation benchmark, and how honest its confidence is.

    CASA_SHARED=/path/to/shared ./dev bench articulate_frame [--variant input welded fused] [--suite core]
        [--every 4] [--only regex] [--perturb SEED] [--families] [--cases FOLDER] [--verbose]

Much faster than `./dev bench articulate`, whose options of cases these are: it guesses the frame and finds no parts.
"""

from __future__ import annotations

import argparse
import sys
import time
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from types import ModuleType

import numpy as np

from benchmarks.articulate.scoring.score import frame_is_right, options, scored, truth, turned
from casa_assets.articulate.frame.axes import guess_frame
from casa_assets.articulate.segment.welded_mesh import weld_triangles

BOUNDS = (0.0, 0.5, 0.8, 0.9, 1.01)


@dataclass(frozen=True)
class Guess:
    """One case: its category, whether the frame is right, whether up is, the confidence, and the seconds it took."""

    category: str
    right: bool
    upright: bool
    confidence: float
    took: float


def guessed(score: ModuleType, args: argparse.Namespace, variant: str) -> list[Guess]:
    """The guess of each case of a variant."""
    out = []
    for name in score.case_names(args.suite, args.only)[:: args.every]:
        case = score.Case(f"{score.CASES}/{name}", variant)
        if args.perturb is not None:
            turned(case, np.random.default_rng([args.perturb, zlib.crc32(name.encode())]))
        begin = time.perf_counter()
        frame = guess_frame(weld_triangles(case.V, case.F))
        took = time.perf_counter() - begin
        right = frame_is_right(frame, case)
        upright = float(np.dot(frame.rotation[2], truth(case)[0])) > 0.99
        out.append(Guess(case.J["category"], right, upright, frame.confidence, took))
        if args.verbose:
            message = "" if right else " WRONG" if upright else " NOT UPRIGHT"
            print(f"{name} {frame.confidence:.0%}{message}; next {frame.runner_up}", flush=True)
    return out


def tell(variant: str, guesses: Sequence[Guess]) -> None:
    """Shares, by category, and by confidence."""
    seconds = [g.took for g in guesses]
    right, upright = sum(g.right for g in guesses), sum(g.upright for g in guesses)
    print(f"\n== {variant}: {right} of {len(guesses)} frames right ({right / max(len(guesses), 1):.1%}),", end=" ")
    print(f"{upright} upright; seconds median {np.median(seconds):.2f} p95 {np.percentile(seconds, 95):.2f}")
    by_kind = {k: [g.right for g in guesses if g.category == k] for k in sorted({g.category for g in guesses})}
    print("  ".join(f"{k} {sum(r)}/{len(r)}" for k, r in by_kind.items()))
    for low, high in pairwise(BOUNDS):
        some = [g for g in guesses if low <= g.confidence < high]
        if some:
            mean = np.mean([g.confidence for g in some])
            print(f"sure {low:.0%} to {min(high, 1):.0%}: {len(some)} guesses, {mean:.0%} in the mean,", end=" ")
            print(f"{sum(g.right for g in some) / len(some):.0%} right")
    sys.stdout.flush()


def main() -> None:
    """Run and print."""
    args = options(__doc__ or "").parse_args()
    with scored(args) as score:
        for variant in args.variant:
            tell(variant, guessed(score, args, variant))


if __name__ == "__main__":
    main()
