"""Weights of the frame guess: a conditional logit over members of the own families, each merged into one mesh.

    python benchmarks/train_frame.py [--samples 6] [--presets 3]

Prints the table WEIGHTS of casa_assets/articulate/frame.py and how many of the training members it gets right.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize

from casa_assets.articulate.evidence import FEATURES, evidence, facing, hidden_area
from casa_assets.articulate.fragments import fragment_labels
from casa_assets.articulate.frame import PIXELS, PRIOR_UP, given_frame
from casa_assets.articulate.pieces import FRONT, SIDES, TOP, Pieces, measure
from casa_assets.articulate.sides import look
from casa_assets.articulate.soup import soup_of
from casa_assets.families.catalog import family
from casa_assets.model.asset import Asset
from casa_assets.pipeline.families import Wish, build_asset, params_of

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

FAMILIES = (
    *("base_cabinet", "wall_cabinet", "tall_cabinet", "drawer_stack", "sink_base", "island_base", "housing_microwave"),
    *("housing_oven", "housing_fridge", "range", "wall_oven", "microwave", "toaster_oven", "dishwasher", "hob"),
    *("fridge_top_freezer", "fridge_bottom_freezer", "fridge_side_by_side", "fridge_french_door"),
    *("coffee_machine", "toaster", "door", "window"),
)
# Of these any side may be the front: they teach the top alone.
ROUND = ("corner_cabinet_blind", "corner_cabinet_diagonal", "hood", "kettle", "stand_mixer", "blender", "sink")
# Weight of the families in ROUND and of those that stand in a wall, against 1 of the others.
LESS, IN_WALLS = 0.4, ("door", "window")
PAIRS = [(f, t) for f in range(len(SIDES)) for t in range(len(SIDES)) if f // 2 != t // 2]
# Strength of the prior that weights are small; features are in units of their spread.
RIDGE = 0.01
# Every second look at a member is at one that was stretched along its axes by so much (a spread of logarithms), and of
# these some have lost what is inside, some the borders of their pieces: files of others are not like ours.
STRETCH, WITHOUT_INSIDE, IN_ONE = 0.13, 0.3, 0.25
# What a feature may say: for a candidate, against it; the others are left out. A weight that the families would turn
# round is an accident of how we build.
FOR = (
    *("front_detail", "front_juts", "front_knobs", "front_bars", "front_panels", "front_stands", "top_juts"),
    *("top_knobs", "symmetry", "front_level", "support", "shape", "bars_high", "knobs_high", "top_rings", "top_slots"),
    *("knobs_near", "back_plain"),
)
AGAINST = (
    *("back_detail", "sides_detail", "back_juts", "bottom_juts", "sides_juts", "back_knobs", "sides_knobs"),
    *("top_bars", "back_bars", "bottom_bars", "sides_bars", "back_panels", "back_stands", "sides_stands"),
    *("inside_upright", "low_mass"),
)


def merged(asset: Asset) -> tuple[Floats, Ints]:
    """All that is seen of an asset as one mesh: vertices and faces."""
    points, faces, start = [], [], 0
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        for visual in link.visuals:
            points.append(pose.apply(visual.mesh.vertices))
            faces.append(visual.mesh.faces.astype(np.int64) + start)
            start += len(visual.mesh.vertices)
    return np.concatenate(points), np.concatenate(faces)


def seen(points: Floats, faces: Ints, one: bool = False) -> Pieces:
    """The pieces of a mesh that stands upright; `one` takes it all for one piece."""
    soup = soup_of(points, faces)
    frame = given_frame(soup, (0, 0, 1), (0, -1, 0))
    placed = soup.placed(frame.rotation, np.array(frame.origin), frame.scale)
    label = fragment_labels(placed)
    return measure(placed, np.minimum(label, 0) if one else label, PIXELS)


def features(pieces: Pieces) -> Floats:
    """(24, len(FEATURES)) evidence for each pair of front and top."""
    sides = [look(pieces, i) for i in range(len(SIDES))]
    inside = hidden_area(pieces)
    return np.array([evidence(pieces, sides, f, t, inside) for f, t in PAIRS])


def changed(asset: Asset, rng: np.random.Generator) -> Pieces:
    """The pieces of an asset as another modeller might have left it."""
    points, faces = merged(asset)
    points = points * np.exp(rng.normal(0.0, STRETCH, 3))
    pieces = seen(points, faces)
    if rng.random() < WITHOUT_INSIDE:
        faces = faces[np.unique(np.concatenate([p.face[p.face >= 0] for p in pieces.pictures]))]
    return seen(points, faces, one=bool(rng.random() < IN_ONE))


def fitted(rows: Floats, true: Bools, weight: Floats) -> Floats:
    """(len(FEATURES),) weights that make the true pairs likely in files with z up and with y up, turned to each side.

    Args:
        rows: (N, 24, len(FEATURES)). true: (N, 24). weight: (N,) of each member, summing to 1.
    """
    spread = rows.reshape(-1, rows.shape[2]).std(axis=0) + 1e-9
    scaled = rows / spread
    priors = [prior(turn) for turn in turns()]

    def loss(b: Floats) -> tuple[float, Floats]:
        value, slope = RIDGE * float(b @ b), 2 * RIDGE * b
        for known in priors:
            score = scaled @ b + known
            odds = np.exp(score - score.max(axis=1, keepdims=True))
            share = odds / odds.sum(axis=1, keepdims=True)
            right = share * true
            part = right.sum(axis=1, keepdims=True)
            value -= float(weight @ np.log(part[:, 0] + 1e-30)) / len(priors)
            slope = slope - weight @ ((right / part - share)[:, :, None] * scaled).sum(axis=1) / len(priors)
        return value, slope

    bounds = [(0, None) if n in FOR else (None, 0) if n in AGAINST else (0, 0) for n in FEATURES]
    found: Floats = minimize(loss, np.zeros(rows.shape[2]), jac=True, bounds=bounds, method="L-BFGS-B").x / spread
    return found


def turns() -> list[Floats]:
    """The rotations from an upright thing to the axes of its file: z up and y up, each in quarter turns."""
    quarters = [np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    lying = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    return [*quarters, *(lying @ q for q in quarters)]


def prior(turn: Floats) -> Floats:
    """(24,) log prior of each pair in a file that is turned so."""
    return np.log([PRIOR_UP[facing(-turn @ SIDES[t][2])] for _, t in PAIRS])


def main() -> None:
    """Build, measure, fit, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=6)
    parser.add_argument("--presets", type=int, default=3)
    args = parser.parse_args()
    rows, true, weight = [], [], []
    rng = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as cache:
        for name in (*FAMILIES, *ROUND):
            members = [Wish(name, preset=p) for p in list(family(name).presets)[: args.presets]]
            members += [Wish(name, seed=5, index=i) for i in range(args.samples)]
            for wish in members:
                asset = build_asset(family(name), params_of(wish), Path(cache))
                rows += [features(seen(*merged(asset))), features(changed(asset, rng))]
                true += 2 * [[t == TOP and (f == FRONT or name in ROUND) for f, t in PAIRS]]
                weight += 2 * [(LESS if name in (*ROUND, *IN_WALLS) else 1.0) / len(members)]
    table, answers = np.array(rows), np.array(true)
    found = fitted(table, answers, np.array(weight) / sum(weight))
    right = float(answers[np.arange(len(table)), (table @ found).argmax(axis=1)].mean())
    for name, value in zip(FEATURES, found, strict=True):
        if value:
            print(f'    "{name}": {float(f"{value:.4g}")},')
    count = len(FAMILIES) + len(ROUND)
    print(f"{len(rows)} looks at members of {count} families, {right:.0%} right, no prior of the axes")


if __name__ == "__main__":
    main()
