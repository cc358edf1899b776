"""Learn to tell knobs, keys and neither apart, on drawn scenes and on cases whose sources are left out in turn.

    CASA_SHARED=/path/to/shared ./dev bench train_controls [--scenes 1500] [--cases FOLDER ...]
        [--keep FOLDER] [--write]

Prints, for each source of the articulation benchmark while it is left out (of scenes and of own families a fifth), how
many controls the rule that looks at each alone, and the forest, tell right; and how many of those told at a confidence
are right. `--cases` adds folders of cases of our own families. `--keep` stores what was measured and takes what is
stored there. `--write` writes registry/learned/controls.json. Needs scikit-learn (`pip install scikit-learn`), which
nothing else here does.
"""

from __future__ import annotations

import argparse
import json
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from sklearn.ensemble import ExtraTreesClassifier

from benchmarks.articulate.cases.plain.draw import KINDS
from benchmarks.articulate.scoring.score import load_score, unpacked
from benchmarks.train.control_cases.samples import (
    SKIP,
    Samples,
    cached,
    case_samples,
    drawn_samples,
    fused_scene_samples,
    scene_samples,
)
from benchmarks.train.control_cases.scenes import KEY, KNOB, NEITHER
from benchmarks.train.forest_file import write_forest
from casa_assets.articulate.controls.classify import CONTROL_CLASSES, CONTROL_FEATURES, decided, pooled
from casa_assets.articulate.controls.controls import classify_control
from casa_assets.articulate.plan import PartKind

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

SEED, FOLDS = 4, 5
# So many of the scenes and drawings are also learned from as shells, which take far longer to measure.
SHARE_OF_SHELLS = 0.27
# The sources of the benchmark weigh so much together by what scenes and own families do: with more, what one source
# does alone is learned (with .5, knobs and keys of shells of a source left out are confused a fifth less often than
# with 1). A source of few controls weighs less. Of a large group, so many members are learned from.
SHARE_OF_BENCHMARK, FULL_SOURCE, MOST_OF_GROUP = 0.5, 40, 4
TREES, LEAVES, FEWEST_AT_LEAF = 60, 400, 10
# What has no joint in its file and, by a forest that has not seen it, is neither with at most this probability.
MAX_CHANCE_OF_NEITHER = 0.3
# Of so many alike, as the keys of a keyboard, that some forest tells from the others at all is enough.
MIN_KEYBOARD = 12
OWN = ("scenes", "drawn", "own")
KIND_NUMBER = {None: NEITHER, PartKind.KNOB: KNOB, PartKind.BUTTON: KEY}


class Table:
    """All controls: what is known of each, in rows."""

    def __init__(self, samples: Sequence[Samples]) -> None:
        self.features = np.concatenate([s.features for s in samples])
        self.types = np.concatenate([s.types for s in samples])
        self.group = np.unique(
            np.concatenate([s.groups + (k << 16) for k, s in enumerate(samples)]), return_inverse=True
        )[1]
        self.rule = np.concatenate([_by_rule(s) for s in samples])
        self.source = np.concatenate([np.full(len(s.types), s.source) for s in samples])
        self.fold = np.concatenate([np.full(len(s.types), _fold(s)) for s in samples])
        self.fused = np.concatenate([np.full(len(s.types), ".fused." in s.name) for s in samples])
        self.on_top = self.features[:, CONTROL_FEATURES.index("on_top")] > 0
        rng = np.random.default_rng(SEED)
        order = rng.permutation(len(self.types))
        place = np.zeros(len(order), dtype=np.int64)
        seen: dict[int, int] = {}
        for i in order:
            place[i] = seen[int(self.group[i])] = seen.get(int(self.group[i]), -1) + 1
        self.learnable: Bools = (self.types != SKIP) & (place < MOST_OF_GROUP)
        self.weight = self._weights()

    def leave_out_doubtful(self, chances: Floats) -> None:
        """Learn nothing of what has no joint in its file, but surely looks like a knob or a key: many files omit it."""
        unlabelled = (self.types == NEITHER) & ~np.isin(self.source, OWN)
        in_grid = self.features[:, CONTROL_FEATURES.index("group_count")] >= MIN_KEYBOARD
        is_key = decided(chances, self.on_top) != NEITHER
        doubtful = np.where(in_grid, is_key, chances[:, NEITHER] <= MAX_CHANCE_OF_NEITHER)
        self.learnable &= ~(unlabelled & doubtful)

    def _weights(self) -> Floats:
        weight = np.ones(len(self.types))
        own = np.isin(self.source, OWN)
        others = np.unique(self.source[~own])
        for name in others:
            rows = (self.source == name) & self.learnable
            share = SHARE_OF_BENCHMARK * min(1.0, rows.sum() / FULL_SOURCE) / len(others)
            weight[rows] = share * (own & self.learnable).sum() / max(rows.sum(), 1)
        return weight

    def learn(self, rows: Bools) -> ExtraTreesClassifier:
        """A forest that these rows teach."""
        rows = rows & self.learnable
        forest = ExtraTreesClassifier(
            TREES, max_leaf_nodes=LEAVES, min_samples_leaf=FEWEST_AT_LEAF, random_state=SEED, n_jobs=1
        )
        return forest.fit(self.features[rows], self.types[rows], sample_weight=self.weight[rows])

    def told(self) -> Floats:
        """(N, 3) probabilities, of each fold by a forest that has not seen it, those of a group together."""
        chances = np.zeros((len(self.types), len(CONTROL_CLASSES)))
        for fold in np.unique(self.fold):
            out = self.fold == fold
            chances[out] = self.learn(~out).predict_proba(self.features[out])
        order = np.argsort(self.group, kind="stable")
        for rows in np.split(order, np.cumsum(np.bincount(self.group))[:-1]):
            chances[rows] = pooled(chances[rows])
        return chances


def _by_rule(samples: Samples) -> Ints:
    return np.array([KIND_NUMBER[classify_control(c, samples.controls)[0]] for c in samples.controls])


def _fold(samples: Samples) -> str:
    if samples.source not in OWN:
        return samples.source
    return f"{samples.source} {zlib.crc32(samples.name.split('.')[0].encode()) % FOLDS}"


def tell(table: Table, chances: Floats) -> None:
    """Print how many are right, by the rule and by the forest."""
    best = decided(chances, table.on_top)
    print(f"{'source':28s} side   controls   rule: right swapped extra lost   forest: right swapped extra lost")
    shown = [*np.unique(table.source), "all of the benchmark"]
    for name in shown:
        of = ~np.isin(table.source, OWN) if name == shown[-1] else table.source == name
        for fused in (False, True):
            for top in (False, True):
                rows = of & (table.types != SKIP) & (table.fused == fused) & (table.on_top == top)
                if rows.any():
                    counts = " ".join(_counts(table.types[rows], found[rows]) for found in (table.rule, best))
                    title = f"{name}{' fused' if fused else ''}"
                    print(f"{title:28s} {'top' if top else 'front':6s} {rows.sum():8d} {counts}")
    own = np.isin(table.source, OWN)
    for name, of in (("benchmark", ~own), ("scenes and own", own)):
        print(f"told to be a knob or a key, {name}: confidence, how many, share that is")
        told, sure = of & (best != NEITHER) & (table.types != SKIP), chances.max(axis=1)
        for low, high in ((0.0, 0.5), (0.5, 0.6), (0.6, 0.7), (0.7, 0.8), (0.8, 0.9), (0.9, 1.01)):
            rows = told & (sure >= low) & (sure < high)
            if rows.any():
                right = (best == table.types)[rows].mean()
                print(
                    f"  {low:.1f} to {min(high, 1.0):.1f}: {rows.sum():5d} {right:.2f} (mean {sure[rows].mean():.2f})"
                )


def _counts(true: Ints, found: Ints) -> str:
    swapped = ((true != NEITHER) & (found != NEITHER) & (true != found)).sum()
    extra, lost = ((true == NEITHER) & (found != NEITHER)).sum(), ((true != NEITHER) & (found == NEITHER)).sum()
    return f"{(true == found).mean():12.3f} {swapped:7d} {extra:5d} {lost:4d}       "


def gathered(keep: Path, bench: Path, own: Sequence[Path], scenes: int, drawings: int) -> list[Samples]:
    """All samples: of scenes, of the benchmark, and of own families.

    Args:
        keep: folder that stores them. bench, own: folders with an index.json. drawings: of each kind.
    """

    def drawn_scenes() -> list[Samples]:
        return [s for i in range(scenes) for s in scene_samples(SEED, i)]

    def cases(folder: Path, variant: str, own: bool) -> list[Samples]:
        score = load_score(folder)
        rows = json.loads((folder / "index.json").read_text(encoding="utf-8"))["cases"]
        return [s for r in rows for s in case_samples(score, r["name"], "own" if own else r["origin"], variant)]

    found = list(cached(keep / f"scenes_{scenes}.pickle", drawn_scenes))
    plain = [(kind, i) for kind in KINDS for i in range(drawings)]
    found += cached(
        keep / f"drawn_{drawings}.pickle", lambda: [s for kind, i in plain for s in drawn_samples(kind, SEED, i)]
    )
    found += shells(keep, round(SHARE_OF_SHELLS * scenes), round(SHARE_OF_SHELLS * drawings))
    for variant in ("input", "fused"):
        found += cached(keep / f"bench_{variant}.pickle", lambda v=variant: cases(bench, v, False))
    for folder in own:
        for variant in ("input", "fused"):
            stored = keep / f"own_{'_'.join(folder.parts[-3:])}_{variant}.pickle"
            found += cached(stored, lambda f=folder, v=variant: cases(f, v, True))
    return found


def shells(keep: Path, scenes: int, drawings: int) -> list[Samples]:
    """The samples of scenes and of plain drawings as one shell of cubes each.

    Args:
        keep: folder that stores them. drawings: of each kind.
    """
    plain = [(kind, i) for kind in KINDS for i in range(drawings)]
    found: list[Samples] = cached(
        keep / f"fused_scenes_{scenes}.pickle", lambda: [s for i in range(scenes) for s in fused_scene_samples(SEED, i)]
    )
    return found + cached(
        keep / f"fused_drawn_{drawings}.pickle",
        lambda: [s for kind, i in plain for s in drawn_samples(kind, SEED, i, as_shell=True)],
    )


def fitted(samples: Sequence[Samples], verbose: bool = False) -> ExtraTreesClassifier:
    """The forest that samples teach, without those whose labels are doubtful; it may print how it does out of fold."""
    table = Table(samples)
    chances = table.told()
    if verbose:
        tell(table, chances)
    table.leave_out_doubtful(chances)
    return table.learn(np.ones(len(table.types), dtype=bool))


def main() -> None:
    """Gather, judge, learn, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=1500)
    parser.add_argument("--drawings", type=int, default=20, help="Plain drawings of each kind.")
    parser.add_argument("--bench", type=Path, help="Folder in which the benchmark is unpacked, or to unpack it in.")
    parser.add_argument("--cases", type=Path, nargs="*", default=[], help="Folders with an index.json.")
    parser.add_argument("--keep", type=Path, required=True)
    parser.add_argument("--write", action="store_true")
    args = parser.parse_args()
    bench = unpacked(args.bench or args.keep)
    forest = fitted(gathered(args.keep, bench, args.cases, args.scenes, args.drawings), verbose=True)
    if args.write:
        write_forest("controls", forest, CONTROL_FEATURES, CONTROL_CLASSES)


if __name__ == "__main__":
    main()
