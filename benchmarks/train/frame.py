"""Weights of the frame guess, learned from members of the own families, each merged into one mesh.

    ./dev bench train_frame [--members 3] [--keep FOLDER]

First a conditional logit over what the six sides look like, then one over what the likeliest candidates let find when
they are tried out, on the scores that families got while they were left out of the first. Prints the tables WEIGHTS
and SCORE_WEIGHTS and the number APPEARANCE_WEIGHT of casa_assets/articulate/frame/; how many looks are right
when their family is left out of both, and how many of the guesses above a confidence are. `--keep` stores what was
measured, and takes what is stored there.
"""

from __future__ import annotations

import argparse
import pickle
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from benchmarks.train.frame_members import Bools, Floats, Ints, Mesh, changed, merged, panel, seen, table
from casa_assets.articulate.frame import MAX_SCORED, PRIOR_UP, SCORE_NAMES, score_candidate
from casa_assets.articulate.segment.fragments import MeasuredFragments
from casa_assets.articulate.segment.orthographic import FRONT, SIDES, TOP
from casa_assets.articulate.side_views import FEATURES, frame_features, hidden_area, measure_side, side_facing
from casa_assets.families.build import FamilyRequest, build_asset, params_of
from casa_assets.registry.families import family

Limit = tuple[float | None, float | None]
Wanted = list[tuple[float, float, Limit]]

FAMILIES = (
    *("base_cabinet", "wall_cabinet", "tall_cabinet", "drawer_stack", "sink_base", "island_base", "housing_microwave"),
    *("housing_oven", "housing_fridge", "range", "wall_oven", "microwave", "toaster_oven", "dishwasher", "hob"),
    *("fridge_top_freezer", "fridge_bottom_freezer", "fridge_side_by_side", "fridge_french_door"),
    *("coffee_machine", "toaster", "door", "window"),
)
# Of these any side may be the front: they teach the top alone.
ROUND = ("corner_cabinet_blind", "corner_cabinet_diagonal", "hood", "kettle", "stand_mixer", "blender", "sink")
# Plain things that are no family, by name.
PLAIN: Mapping[str, Callable[[np.random.Generator], Mesh]] = {
    "table": table,
    "panel_front": lambda rng: panel(rng, False),
    "panel_top": lambda rng: panel(rng, True),
}
ANY_FRONT = (*ROUND, "panel_top")
# Weight of the families in ROUND, of those that stand in a wall, and of the plain ones, against 1 of the others.
LESS, IN_WALLS = 0.4, ("door", "window")
PAIRS = [(f, t) for f in range(len(SIDES)) for t in range(len(SIDES)) if f // 2 != t // 2]
# Members are the first of a seed, mixed with presets; each is looked at as it is, and changed so often.
SEED, CHANGED = 5, 2
# Families that are left out together; the turns of a file that a fit looks at, every so manyth.
FOLDS, EVERY = 6, 3
# Strength of the priors of the weights: of looks that they are small, of trials that they are near what is expected;
# numbers are in units of their spread.
RIDGE, RIDGE_TRIAL = 0.01, 0.05
# What a feature may say: for a candidate, against it; the others are left out. A weight that the families would turn
# round is an accident of how we build.
FOR = (
    *("front_detail", "front_juts", "front_knobs", "front_bars", "front_panels", "front_stands", "top_juts"),
    *("top_knobs", "symmetry", "front_level", "support", "shape", "bars_high", "knobs_high", "top_rings", "top_slots"),
    *("knobs_near", "back_plain", "bottom_legs"),
)
AGAINST = (
    *("back_detail", "sides_detail", "back_juts", "bottom_juts", "sides_juts", "back_knobs", "sides_knobs"),
    *("top_bars", "back_bars", "bottom_bars", "sides_bars", "back_panels", "back_stands", "sides_stands"),
    *("inside_upright", "mass_height", "top_legs"),
)
# What a trial is expected to say, log odds; it may say more or less, but not the opposite. Of the others the members
# decide alone. Set by what kitchens are like, and nothing else.
EXPECTED = {
    "front_coverage": 1.5,
    "doors": 0.0,
    "drawers": 0.0,
    "drawers_with_box": 0.7,
    "drawers_without_box": -0.3,
    "knobs": 0.3,
    "buttons": 0.1,
    "levers": 0.5,
    "lids": 1.0,
    "racks": 1.5,
    "turntables": 1.5,
    "front_confidence": 2.0,
    "joint_confidence": 1.0,
    "with_handle": 1.0,
    "hinged_above": -1.5,
    "no_parts": -0.7,
}
# Score of what is not tried; weights below the second are left out; confidences that are reported.
NEVER, LEAST = -1e3, 1e-3
SURE = (0.5, 0.8, 0.9)


@dataclass(frozen=True)
class Looks:
    """All looks at members.

    Attributes:
        rows: (N, 24, len(FEATURES)) what the sides of each look like, for each pair of front and top.
        true: (N, 24) right pairs. fold: (N,) which of the families left out together. weight: (N,).
        trials: (N, 24, len(SCORE_NAMES)) of the pairs that were tried. has: (N, 24) which these are.
    """

    rows: Floats
    true: Bools
    fold: Ints
    weight: Floats
    trials: Floats
    has: Bools


def features(pieces: MeasuredFragments) -> Floats:
    """(24, len(FEATURES)) evidence for each pair of front and top."""
    sides = [measure_side(pieces, i) for i in range(len(SIDES))]
    inside = hidden_area(pieces)
    return np.array([frame_features(pieces, sides, f, t, inside) for f, t in PAIRS])


def likeliest(rows: Floats, weights: Floats) -> Bools:
    """(24,) pairs that are among the likeliest of a look, in a file that is turned some way, and the right one."""
    best = np.max([rows @ weights + prior(turn) for turn in turns()], axis=0)
    found: Bools = np.zeros(len(PAIRS), dtype=bool)
    found[np.lexsort((np.arange(len(PAIRS)), -np.round(best, 9)))[: MAX_SCORED - 1]] = True
    found[PAIRS.index((FRONT, TOP))] = True
    return found


def fitted(numbers: Floats, base: Floats, true: Bools, weight: Floats, wanted: Wanted) -> Floats:
    """Weights that make the true pairs likely in files with z up and with y up, turned to each side.

    Args:
        numbers: (N, 24, K). base: (N, 24) score that is given. true: (N, 24). weight: (N,).
        wanted: strength of the prior of each weight, the weight that it is near, and its limits.
    """
    spread = numbers[base > NEVER / 2].std(axis=0) + 1e-3
    scaled, ridge = numbers / spread, np.array([r for r, _, _ in wanted])
    mean, limits = np.array([m for _, m, _ in wanted]) * spread, [k for _, _, k in wanted]
    priors = [prior(turn) for turn in turns()[::EVERY]]
    part_of = weight / weight.sum()

    def loss(b: Floats) -> tuple[float, Floats]:
        value, slope = float(ridge @ (b - mean) ** 2), 2 * ridge * (b - mean)
        for known in priors:
            share = shares(base + scaled @ b + known)
            right = share * true
            part = right.sum(axis=1, keepdims=True)
            value -= float(part_of @ np.log(part[:, 0] + 1e-30)) / len(priors)
            off = (right / (part + 1e-30) - share) * part_of[:, None]
            slope = slope - np.einsum("np,npk->k", off, scaled) / len(priors)
        return value, slope

    found: Floats = minimize(loss, mean, jac=True, bounds=limits, method="L-BFGS-B").x / spread
    return found


def by_looks(looks: Looks, rows: Bools) -> Floats:
    """(len(FEATURES),) weights that some looks teach."""
    wanted = [(RIDGE, 0.0, _sign(1 if n in FOR else -1 if n in AGAINST else 0)) for n in FEATURES]
    none = np.zeros(looks.true[rows].shape)
    return fitted(looks.rows[rows], none, looks.true[rows], looks.weight[rows], wanted)


def _sign(sign: int) -> Limit:
    return (0.0, None) if sign > 0 else (None, 0.0) if sign < 0 else (0.0, 0.0)


def by_trials(looks: Looks, scores: Floats, rows: Bools) -> Floats:
    """(1 + len(SCORE_NAMES),) weight of the scores of the looks and of each trial, of pairs that were tried."""
    numbers = np.concatenate([scores[:, :, None], looks.trials], axis=2)[rows]
    base = np.where(looks.has[rows], 0.0, NEVER)
    wanted: Wanted = [(0.0, 1.0, _sign(1))]
    for name in SCORE_NAMES:
        mean = EXPECTED.get(name)
        limit = (None, None) if mean is None else _sign(1 if mean >= 0 else -1)
        wanted.append((RIDGE_TRIAL, mean or 0.0, limit))
    return fitted(numbers, base, looks.true[rows], looks.weight[rows], wanted)


def shares(scores: Floats) -> Floats:
    """Odds that sum to 1 over the last axis, of logarithms."""
    odds = np.exp(scores - scores.max(axis=-1, keepdims=True))
    found: Floats = odds / odds.sum(axis=-1, keepdims=True)
    return found


def turns() -> list[Floats]:
    """The rotations from an upright thing to the axes of its file: z up and y up, each in quarter turns."""
    quarters = [np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    lying = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    return [*quarters, *(lying @ q for q in quarters)]


def prior(turn: Floats) -> Floats:
    """(24,) log prior of each pair in a file that is turned so."""
    return np.log([PRIOR_UP[side_facing(-turn @ SIDES[t][2])] for _, t in PAIRS])


def members(name: str, count: int, keep: Path | None, cache: Path) -> Iterator[list[MeasuredFragments]]:
    """The first members of a family, each as it is and as others might have left it."""
    names = (*FAMILIES, *ROUND, *PLAIN)
    for index in range(count):
        stored = None if keep is None else keep / f"{name}.{index}.pickle"
        if stored is not None and stored.exists():
            yield pickle.loads(stored.read_bytes())
            continue
        rng = np.random.default_rng([SEED, names.index(name), index])
        if name in PLAIN:
            mesh = PLAIN[name](rng)
        else:
            mesh = merged(build_asset(family(name), params_of(_wish(name, index)), cache))
        found = [seen(mesh), *(changed(mesh, rng) for _ in range(CHANGED))]
        if stored is not None:
            stored.parent.mkdir(parents=True, exist_ok=True)
            stored.write_bytes(pickle.dumps(found))
        yield found


def _wish(name: str, index: int) -> FamilyRequest:
    """Every third member is a preset, as long as there are some."""
    presets = list(family(name).presets)
    if index % 3 == 1 and index // 3 < len(presets):
        return FamilyRequest(name, preset=presets[index // 3])
    return FamilyRequest(name, seed=SEED, index=index)


def learned(looks: Looks, names: Sequence[str]) -> tuple[Floats, Floats]:
    """Weights of looks and of trials; prints how they do on families that neither has seen."""
    every = np.ones(len(looks.rows), dtype=bool)
    first, second = np.zeros(looks.true.shape), np.zeros(looks.true.shape)
    for k in range(FOLDS):
        out = looks.fold == k
        first[out] = looks.rows[out] @ by_looks(looks, ~out)
    for k in range(FOLDS):
        out = looks.fold == k
        sharpness, *trial = by_trials(looks, first, ~out).tolist()
        second[out] = sharpness * first[out] + looks.trials[out] @ np.array(trial)
    for message, scores in (("by looks", first), ("and tried", np.where(looks.has, second, NEVER))):
        told = np.stack([shares(scores + prior(turn)) for turn in turns()])
        hit = np.stack([looks.true[np.arange(len(scores)), t.argmax(axis=1)] for t in told])
        confidence = told.max(axis=2)
        above = [
            f"above {s:.0%} sure {hit[confidence >= s].mean():.1%} of {(confidence >= s).mean():.0%}" for s in SURE
        ]
        print(f"# {len(scores)} {message}: {hit.mean():.1%} right where their family is left out; {', '.join(above)}")
        rates = {n: hit[:, [m == n for m in names]].mean() for n in dict.fromkeys(names)}
        print("#   less often:", ", ".join(f"{n} {r:.0%}" for n, r in rates.items() if r < 0.9))
    return by_looks(looks, every), by_trials(looks, first, every)


def gathered(count: int, keep: Path | None) -> tuple[Looks, list[str]]:
    """Looks at the first members of each family, and their families."""
    rows, views, names = [], [], []
    with tempfile.TemporaryDirectory() as cache:
        for name in (*FAMILIES, *ROUND, *PLAIN):
            for some in members(name, count, keep, Path(cache)):
                rows += [features(pieces) for pieces in some]
                views += some
                names += len(some) * [name]
    every = sorted(set(names))
    true = np.array([[t == TOP and (f == FRONT or n in ANY_FRONT) for f, t in PAIRS] for n in names])
    weight = np.array([LESS if n in (*ROUND, *IN_WALLS, *PLAIN) else 1.0 for n in names])
    fold = np.array([every.index(n) % FOLDS for n in names])
    trials, has = np.zeros((len(rows), len(PAIRS), len(SCORE_NAMES))), np.zeros((len(rows), len(PAIRS)), dtype=bool)
    looks = Looks(np.array(rows), true, fold, weight, trials, has)
    weights = by_looks(looks, np.ones(len(rows), dtype=bool))
    for i, pieces in enumerate(views):
        has[i] = likeliest(looks.rows[i], weights)
        for k in np.flatnonzero(has[i]).tolist():
            trials[i, k] = score_candidate(pieces, *PAIRS[k])
    return looks, names


def main() -> None:
    """Build, measure, fit, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--members", type=int, default=3)
    parser.add_argument("--keep", type=Path)
    args = parser.parse_args()
    looks, names = gathered(args.members, args.keep)
    weights, (sharpness, *trial) = learned(looks, names)
    for title, table_ in (
        ("WEIGHTS", zip(FEATURES, weights, strict=True)),
        ("SCORE_WEIGHTS", zip(SCORE_NAMES, trial, strict=True)),
    ):
        print(title)
        print("\n".join(f'    "{n}": {float(f"{v:.4g}")},' for n, v in table_ if abs(v) > LEAST))
    print(f"APPEARANCE_WEIGHT = {sharpness:.3f}")


if __name__ == "__main__":
    main()
