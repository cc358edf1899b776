"""Weights of the hinge edge of a door, and of a front being a drawer, learned from labelled cases.

    ./dev bench train_hinges CASES... [--variant input fused]

CASES are folders of cases in the form of the articulation benchmark (with `index.json`): its open cases, those of
`benchmarks/articulate/draw.py` (each set is a folder). Each front that the tool finds in the true frame
and that is a door or drawer of the ground truth (surfaces overlap by half) teaches a conditional logit over four edges,
and a logistic regression; what the kind of the thing makes likely is given, once with the kind
stated and once guessed by form. Prints the weights of EDGE_TABLE and DRAWER_TABLE of casa_assets/articulate/
front_features.py, and how many are right: fitted, and with the source of each case (`origin` or `source`) left out.
"""

from __future__ import annotations

import argparse
import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize

from benchmarks.articulate.score import load_score, truth
from casa_assets.articulate.frame import given_frame
from casa_assets.articulate.fronts.joints import (
    DRAWER_FEATURES,
    EDGE_FEATURES,
    EDGES,
    drawer_features,
    drawer_share,
    edge_features,
    edge_shares,
    kind_log_odds,
    view_fronts,
)
from casa_assets.articulate.fronts.opening_panels import select_opening_panels
from casa_assets.articulate.infer import PartCollector, look_at_front, traits_of_views
from casa_assets.articulate.kinds import kind_named, kinds_known
from casa_assets.articulate.plan import HingeEdge
from casa_assets.articulate.run.build import load_models
from casa_assets.articulate.segment.fragments import measure_fragments, render_sides, weld_triangles
from casa_assets.articulate.segment.segmentations import segmentations
from casa_assets.articulate.segment.shell_segments import fragment_mesh
from casa_assets.core.numeric import Floats, Mask

# Strength of the pull of the weights to zero, per front of the training set. Ref: of 0.001, 0.0003, 0.0001, 0.00003 and
# 0.00001 it has the least loss on fronts whose source is left out, of edges (0.135) and of drawers (0.088).
RIDGE = 0.0001
# What a feature may say of an edge: for it, or against it; the others are free.
FOR_EDGE = frozenset(
    {"handle_away", "handle_along", "handle_long", "far_and_along", "wide", "front_beyond", "controls_beyond"}
    | {"panel_beyond", "others_away", "knobs_away"}
)
AGAINST_EDGE = frozenset(
    {"front_at", "controls_at", "panel_at", "handle_off_middle", "front_over_or_under"} | {"handles_face"}
)
FOR_DRAWER = frozenset(
    {"handle_centred", "deep", "box", "wide", "handle_level", "stacked", "many_stacked", "alike", "under_larger"}
    | {"level_and_centred", "centred_beside_aside"}
)
AGAINST_DRAWER = frozenset(
    {"shelf_behind", "covers_front", "handle_aside", "handle_upright", "handle_low", "height_share"}
    | {"others_have_boxes"}
)
# A piece that is deep and seen from its front alone is a drawer whatever its kind; so is, mostly, what is as wide as
# two doors above it or low beside a larger front, where a door would be a flap: least weights, log odds. With a shelf
# right behind it a front has no room for a box: greatest weight. Nobody puts a handle in the middle of a door both
# ways: of 257 fronts with a level one there 253 are drawers. Choices: few cases have such fronts.
LEAST = {"deep": 4.0, "under_pair": 2.0, "low_beside_larger": 1.5, "handle_centred": 2.0}
MOST = {"shelf_behind": -2.0}
# Least overlap of the surfaces of a front and of a part of the ground truth.
MIN_OVERLAP = 0.5


@dataclass(frozen=True)
class Front:
    """A front that teaches.

    Attributes:
        case, source: it is of. kinds: probabilities of the kinds, once as stated, once by form.
        edges: (4, K). drawer: (K,). is_drawer: truth. edge: true edge of a door, None of a drawer.
    """

    case: str
    source: str
    kinds: tuple[Mapping[str, float], ...]
    edges: Floats
    drawer: Floats
    is_drawer: bool
    edge: HingeEdge | None


def true_edge(part: Mapping[str, Any], rotation: Floats) -> HingeEdge:
    """Return the edge that a hinge of the ground truth runs along, in the frame whose axes are the rows."""
    axis = rotation @ np.array(part["joint"]["axis"], dtype=np.float64)
    origin = rotation @ np.array(part["joint"]["origin"], dtype=np.float64)
    middle = rotation @ np.mean(part["bbox"], axis=0)
    if abs(axis[2]) > abs(axis[0]):
        return HingeEdge.LEFT if origin[0] < middle[0] else HingeEdge.RIGHT
    return HingeEdge.BOTTOM if origin[2] < middle[2] else HingeEdge.TOP


def fronts_of(case: Any, row: Mapping[str, Any]) -> list[Front]:
    """Return the fronts of a case that teach."""
    mesh = weld_triangles(case.V, case.F)
    up, front = truth(case)
    frame = given_frame(mesh, up, front or (0, -1, 0))
    placed = mesh.in_frame(frame)
    images = render_sides(placed)
    found: list[Front] = []
    for labels in segmentations(placed).values():
        split = fragment_mesh(placed, labels, load_models())
        collector = PartCollector(measure_fragments(placed, split.labels, images=images), split.fronts)
        measured = collector.measured
        seen = look_at_front(collector)
        panels = select_opening_panels(measured, seen.panels, seen.controls, collector.known)
        chosen = [p for p, _, _ in panels]
        views = view_fronts(measured, chosen, seen.panels, seen.controls)
        traits = traits_of_views(measured, views, seen)
        x, y, z = (float(v) for v in np.ptp(measured.mesh.points, axis=0))
        named = kind_named([row["category"].replace("_", " ")])
        fits = kind_log_odds(views)
        kinds = tuple(kinds_known((x, y, z), traits, fits, kind) for kind in (named.id if named else "", ""))
        for view in views:
            own = np.zeros(len(case.F), dtype=bool)
            own[measured.faces_of(view.panel.everything)] = True
            part = _matching(case, own)
            if part is None:
                continue
            slides = part["joint"]["type"] == "prismatic"
            if slides and part["type"] != "drawer":
                continue
            edge = None if slides else true_edge(part, frame.rotation)
            source = str(row.get("origin") or row["source"]["repo"])
            found.append(Front(row["name"], source, kinds, edge_features(view), drawer_features(view), slides, edge))
    return found


def _matching(case: Any, own: Mask) -> Mapping[str, Any] | None:
    """Return the door or drawer of the ground truth that some faces are, or None."""
    for part in case.parts:
        if part["type"] not in ("door", "drawer", "lid"):
            continue
        mask = case.lab == part["id"]
        if float(case.A[mask & own].sum()) >= MIN_OVERLAP * float(case.A[mask | own].sum()):
            found: Mapping[str, Any] = part
            return found
    return None


def fit_edges(fronts: Sequence[Front]) -> Floats:
    """Return the (len(EDGE_FEATURES),) weights that some doors teach."""
    rows = np.array([f.edges for f in fronts for _ in f.kinds])
    prior = np.log([edge_shares(k) for f in fronts for k in f.kinds])
    right = np.array([EDGES.index(f.edge) for f in fronts if f.edge is not None for _ in f.kinds])
    weight = _weights(fronts)

    def loss(b: Floats) -> tuple[float, Floats]:
        scores = prior + rows @ b
        share = np.exp(scores - scores.max(axis=1, keepdims=True))
        share /= share.sum(axis=1, keepdims=True)
        value = -float(weight @ np.log(share[np.arange(len(rows)), right] + 1e-30)) + RIDGE * float(b @ b)
        off = share.copy()
        off[np.arange(len(rows)), right] -= 1.0
        return value, np.einsum("n,ne,nek->k", weight, off, rows) + 2 * RIDGE * b

    return _fitted(loss, EDGE_FEATURES, FOR_EDGE, AGAINST_EDGE)


def fit_drawers(fronts: Sequence[Front]) -> Floats:
    """Return the (len(DRAWER_FEATURES),) weights that some fronts teach."""
    rows = np.array([f.drawer for f in fronts for _ in f.kinds])
    shares = np.array([drawer_share(k) for f in fronts for k in f.kinds])
    prior = np.log(shares / (1 - shares))
    right = np.array([1.0 if f.is_drawer else -1.0 for f in fronts for _ in f.kinds])
    weight = _weights(fronts)

    def loss(b: Floats) -> tuple[float, Floats]:
        odds = right * (prior + rows @ b)
        value = float(weight @ np.logaddexp(0.0, -odds)) + RIDGE * float(b @ b)
        slope = -weight * right / (1.0 + np.exp(np.clip(odds, -500, 500)))
        return value, rows.T @ slope + 2 * RIDGE * b

    return _fitted(loss, DRAWER_FEATURES, FOR_DRAWER, AGAINST_DRAWER)


def _weights(fronts: Sequence[Front]) -> Floats:
    """Return the weight of each row: each case counts once, its fronts share it."""
    count = Counter(f.case for f in fronts)
    weight = np.array([1.0 / count[f.case] / len(f.kinds) for f in fronts for _ in f.kinds])
    found: Floats = weight / weight.sum()
    return found


def _fitted(loss: Any, names: Sequence[str], plus: frozenset[str], minus: frozenset[str]) -> Floats:
    """Return the weights of least loss, with the signs that they may have."""
    start = np.array([LEAST.get(n, MOST.get(n, 0.0)) for n in names])
    bounds = [
        (LEAST.get(n, 0.0) if n in plus or n in LEAST else None, MOST.get(n, 0.0) if n in minus or n in MOST else None)
        for n in names
    ]
    found: Floats = minimize(loss, start, jac=True, bounds=bounds, method="L-BFGS-B").x
    return found


def edges_right(fronts: Sequence[Front], weights: Floats) -> list[tuple[bool, ...]]:
    """Return of each door whether its edge is right with the kind stated, and with it guessed."""
    return [
        tuple(EDGES[int(np.argmax(np.log(edge_shares(k)) + f.edges @ weights))] is f.edge for k in f.kinds)
        for f in fronts
    ]


def drawers_right(fronts: Sequence[Front], weights: Floats) -> list[tuple[bool, ...]]:
    """Return of each front whether its type is right with the kind stated, and with it guessed."""
    out = []
    for f in fronts:
        shares = [drawer_share(k) for k in f.kinds]
        out.append(tuple((float(f.drawer @ weights) + math.log(s / (1 - s)) > 0) == f.is_drawer for s in shares))
    return out


def report(title: str, fronts: Sequence[Front], fit: Any, right: Any) -> Floats:
    """Print how many fronts are right, fitted and with their source left out; return the weights of all."""
    weights: Floats = fit(fronts)
    told = np.array(right(fronts, weights))
    print(f"# {title}: {len(fronts)} fronts; right where the kind is stated, guessed by form:")
    print(f"#   fitted {told.mean(axis=0).round(3).tolist()}")
    held: list[tuple[bool, ...]] = []
    for source in sorted({f.source for f in fronts}):
        inside = [f for f in fronts if f.source == source]
        others = fit([f for f in fronts if f.source != source])
        found = right(inside, others)
        held += found
        wrong = [f.case for f, r in zip(inside, found, strict=True) if not all(r)]
        shares = np.array(found).mean(axis=0).round(3).tolist()
        print(f"#   without {source}: {len(inside)} fronts {shares}; wrong {' '.join(wrong)}")
    print(f"#   held out together {np.array(held).mean(axis=0).round(3).tolist()}")
    return weights


def gathered(folders: Sequence[Path], variants: Sequence[str]) -> list[Front]:
    """The fronts of folders of cases that teach."""
    fronts: list[Front] = []
    for folder in folders:
        score = load_score(folder)
        for row in json.loads((folder / "index.json").read_text())["cases"]:
            truth_ = json.loads((folder / row["name"] / "gt.json").read_text())
            row = {"category": truth_["category"]} | row
            for variant in variants:
                fronts += fronts_of(score.Case(str(folder / row["name"]), variant), row)
    return fronts


def main() -> None:
    """Look, fit, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="+", type=Path)
    parser.add_argument("--variant", nargs="+", default=["input", "fused"])
    args = parser.parse_args()
    fronts = gathered(args.cases, args.variant)
    edges = report("hinge edge", [f for f in fronts if f.edge is not None], fit_edges, edges_right)
    drawers = report("drawer or door", fronts, fit_drawers, drawers_right)
    for title, names, weights in (
        ("EDGE_TABLE", EDGE_FEATURES, edges),
        ("DRAWER_TABLE", DRAWER_FEATURES, drawers),
    ):
        print(title)
        shown = [(n, w) for n, w in zip(names, weights, strict=True) if abs(w) > 1e-3]
        print("\n".join(f'    "{n}": {float(f"{w:.3g}")},' for n, w in shown))


if __name__ == "__main__":
    main()
