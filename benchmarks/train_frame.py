"""Weights of the frame guess: a conditional logit over members of the own families, each merged into one mesh.

    python benchmarks/train_frame.py [--samples 2] [--presets 4]

Prints the table WEIGHTS of casa_assets/articulate/frame.py and how many of the training members it gets right. Families
of which no side is the front (a kettle, a blender, a sink) teach only noise and are left out.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize

from casa_assets.articulate.fragments import fragment_labels
from casa_assets.articulate.frame import PIXELS, given_frame
from casa_assets.articulate.pieces import FRONT, SIDES, TOP, measure
from casa_assets.articulate.sides import FEATURES, evidence, look
from casa_assets.articulate.soup import soup_of
from casa_assets.families.catalog import family
from casa_assets.model.asset import Asset
from casa_assets.pipeline.families import Wish, build_asset, params_of

Floats = npt.NDArray[np.float64]

FAMILIES = (
    *("base_cabinet", "wall_cabinet", "tall_cabinet", "drawer_stack", "sink_base", "island_base", "housing_microwave"),
    *("range", "wall_oven", "microwave", "toaster_oven", "dishwasher", "coffee_machine", "toaster"),
    *("fridge_top_freezer", "fridge_bottom_freezer", "fridge_side_by_side", "fridge_french_door"),
)
PAIRS = [(f, t) for f in range(len(SIDES)) for t in range(len(SIDES)) if f // 2 != t // 2]
# Strength of the prior that weights are small; features are in units of their spread.
RIDGE = 0.02


def merged(asset: Asset) -> tuple[Floats, npt.NDArray[np.int64]]:
    """All that is seen of an asset as one mesh: vertices and faces."""
    points, faces, start = [], [], 0
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        for visual in link.visuals:
            points.append(pose.apply(visual.mesh.vertices))
            faces.append(visual.mesh.faces.astype(np.int64) + start)
            start += len(visual.mesh.vertices)
    return np.concatenate(points), np.concatenate(faces)


def features(asset: Asset) -> Floats:
    """(24, len(FEATURES)) evidence for each pair of front and top."""
    soup = soup_of(*merged(asset))
    frame = given_frame(soup, (0, 0, 1), (0, -1, 0))
    placed = soup.placed(frame.rotation, np.array(frame.origin), frame.scale)
    pieces = measure(placed, fragment_labels(placed), PIXELS)
    sides = [look(pieces, i) for i in range(len(SIDES))]
    return np.array([evidence(pieces, sides, f, t) for f, t in PAIRS])


def fitted(rows: Floats, weight: Floats) -> Floats:
    """(len(FEATURES),) weights that make the true pair likely.

    Args:
        rows: (N, 24, len(FEATURES)). weight: (N,) of each member, summing to 1.
    """
    spread = rows.reshape(-1, rows.shape[2]).std(axis=0) + 1e-9
    scaled = rows / spread
    true = PAIRS.index((FRONT, TOP))

    def loss(b: Floats) -> tuple[float, Floats]:
        score = scaled @ b
        odds = np.exp(score - score.max(axis=1, keepdims=True))
        share = odds / odds.sum(axis=1, keepdims=True)
        slope = (weight[:, None] * (scaled[:, true] - (share[:, :, None] * scaled).sum(axis=1))).sum(axis=0)
        return float(-(weight * np.log(share[:, true] + 1e-30)).sum() + RIDGE * b @ b), -slope + 2 * RIDGE * b

    found: Floats = minimize(loss, np.zeros(rows.shape[2]), jac=True).x / spread
    return found


def main() -> None:
    """Build, measure, fit, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=2)
    parser.add_argument("--presets", type=int, default=4)
    args = parser.parse_args()
    rows, weight = [], []
    with tempfile.TemporaryDirectory() as cache:
        for name in FAMILIES:
            members = [Wish(name, preset=p) for p in list(family(name).presets)[: args.presets]]
            members += [Wish(name, seed=5, index=i) for i in range(args.samples)]
            for wish in members:
                rows.append(features(build_asset(family(name), params_of(wish), Path(cache))))
                weight.append(1.0 / (len(members) * len(FAMILIES)))
    table = np.array(rows)
    found = fitted(table, np.array(weight))
    right = float(((table @ found).argmax(axis=1) == PAIRS.index((FRONT, TOP))).mean())
    for name, value in zip(FEATURES, found, strict=True):
        print(f'    "{name}": {float(f"{value:.4g}")},')
    print(f"{len(rows)} members of {len(FAMILIES)} families, {right:.0%} right, no prior of the axes")


if __name__ == "__main__":
    main()
