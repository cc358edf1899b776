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
import pickle
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from sklearn.ensemble import ExtraTreesClassifier

from benchmarks.articulate.draw import KINDS, draw
from benchmarks.articulate.labelled import AXES, LabelledMesh, fused
from benchmarks.articulate.score import load_score, unpacked
from benchmarks.train.control_scenes import KEY, KNOB, NEITHER, draw_scene
from casa_assets.articulate.controls.classify import (
    CONTROL_CLASSES,
    CONTROL_FEATURES,
    control_features,
    decided,
    pooled,
)
from casa_assets.articulate.controls.controls import Control, classify_control, find_controls
from casa_assets.articulate.controls.levers_and_buttons import find_levers
from casa_assets.articulate.frame import given_frame
from casa_assets.articulate.fronts.panels import find_panels
from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.run.build import load_models
from casa_assets.articulate.segment.fragments import MeasuredFragments, measure_fragments, render_sides, weld_triangles
from casa_assets.articulate.segment.orthographic import FRONT, TOP
from casa_assets.articulate.segment.segmentations import segmentations
from casa_assets.articulate.segment.shell_segments import fragment_mesh
from casa_assets.core.numeric import Floats, Ints, Mask

# Samples --------------------------------------------------------------------------------------------------------------

# A control has a type where at least this share of its surface is of that type; of less nothing is learned.
MIN_SHARE = 0.6
# A part whose type is not scored teaches nothing, but for these, which are seen on the top and never turned or pressed.
# Least cosine between the axis of a control and the direction out of the side that it is on.
MIN_ALONG = 0.7
SKIP, NO_CONTROLS = -1, frozenset({"burner", "wheel"})


@dataclass
class Samples:
    """The controls of one side of one object.

    Attributes:
        features: (N, K). types: (N,) NEITHER, KNOB, KEY, or SKIP. groups: (N,) number of the group within the side.
        source: who made the object: nothing of a source is learned where it is judged.
    """

    name: str
    source: str
    features: Floats
    types: Ints
    groups: Ints
    controls: list[Control]


def samples_of(
    name: str, source: str, measured: MeasuredFragments, face_types: Mapping[int, Ints]
) -> Iterator[Samples]:
    """Look at the front and the top of an object.

    Args:
        face_types: by side, the (F,) types of faces: what is turned or pressed from there.
    """
    panels = find_panels(measured)
    rectangles = [(p.lower[:2], p.upper[:2]) for p in panels]
    front = find_controls(measured, FRONT, [f for p in panels for f in p.members])
    levers = find_levers(measured, front)
    taken = {id(lever.control) for lever in levers}
    front = [control for control in front if id(control) not in taken]
    gone = [f for v in levers for f in v.control.fragments]
    for side, controls, plates in ((FRONT, front, rectangles), (TOP, find_controls(measured, TOP, gone), [])):
        if not controls:
            continue
        features, groups = control_features(measured, side, controls, plates)
        number = np.zeros(len(controls), dtype=np.int64)
        for k, group in enumerate(groups):
            number[list(group.members)] = k
        types = np.array([_type(measured, c, face_types[side]) for c in controls])
        yield Samples(f"{name}.{side}", source, features, types, number, list(controls))


def _type(measured: MeasuredFragments, control: Control, face_types: Ints) -> int:
    faces = measured.faces_of(control.fragments)
    area = measured.mesh.areas[faces]
    for kind in (NEITHER, KNOB, KEY):
        if area[face_types[faces] == kind].sum() >= MIN_SHARE * area.sum():
            return kind
    return SKIP


def scene_samples(seed: int, index: int) -> list[Samples]:
    """The controls of a drawn scene."""
    kind, points, faces, labels = draw_scene(seed, index)
    mesh = weld_triangles(points, faces)
    mesh = mesh.in_frame(given_frame(mesh, (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)))
    right, wrong = (TOP, FRONT) if kind == "hob" else (FRONT, TOP)
    sides = {right: labels, wrong: np.full_like(labels, NEITHER)}
    return list(samples_of(f"{kind}_{index}", "scenes", measure_fragments(mesh, mesh.fragment_labels), sides))


def fused_scene_samples(seed: int, index: int) -> list[Samples]:
    """The controls of a drawn scene as one shell of cubes."""
    kind, points, faces, labels = draw_scene(seed, index)
    parts = [{"id": KNOB, "type": "knob", "scored": True}, {"id": KEY, "type": "button", "scored": True}]
    for part in parts:
        part["joint"] = {"axis": [0.0, 0.0, 1.0] if kind == "hob" else [0.0, 1.0, 0.0]}
    truth = {"name": f"{kind}_{index}.fused", "up": "+Z", "front": "-Y", "parts": parts}
    shell = fused(LabelledMesh(points, faces, labels, truth))[1]
    return _labelled("scenes", truth, shell.points, shell.faces, shell.part)


def drawn_samples(kind: str, seed: int, index: int, as_shell: bool = False) -> list[Samples]:
    """The controls of a plain drawing, whose bodies, doors and interiors are more like real ones.

    Args:
        as_shell: as one shell of cubes.
    """
    mesh = draw(kind, seed, index)
    if as_shell:
        mesh = fused(mesh)[1]
        mesh.truth["name"] = f"{mesh.truth['name']}.fused"
    return _labelled("drawn", mesh.truth, mesh.points, mesh.faces, mesh.part)


def case_samples(score: ModuleType, name: str, source: str, variant: str) -> list[Samples]:
    """The controls of a case of the benchmark, in its true frame."""
    case: Any = score.Case(f"{score.CASES}/{name}", variant)
    truth = {**case.J, "name": f"{name}.{variant}", "parts": case.parts}
    return _labelled(source, truth, case.V, case.F, case.lab)


def _labelled(source: str, truth: dict[str, Any], points: Floats, faces: Ints, part: Ints) -> list[Samples]:
    """The controls of a mesh in its true frame, split in each way.

    Args:
        truth: as in gt.json. part: (F,) identifier of the part of each face.
    """
    mesh = weld_triangles(points, faces)
    up, front = (AXES[axis] if isinstance(axis, str) else axis for axis in (truth["up"], truth.get("front") or "-Y"))
    frame = given_frame(mesh, up, front)
    placed = mesh.in_frame(frame)
    sides = {}
    for side, along in ((FRONT, 1), (TOP, 2)):
        table = {p["id"]: _part_type(p, frame.rotation[along]) for p in truth["parts"]}
        sides[side] = np.array([table.get(int(k), NEITHER) for k in part])
    images = render_sides(placed)
    found = []
    for way, split in segmentations(placed).items():
        pieces = fragment_mesh(placed, split, load_models())
        measured = measure_fragments(placed, pieces.labels, images=images)
        found += samples_of(f"{truth['name']}.{way}", source, measured, sides)
    return found


def _part_type(part: dict[str, Any], outward: Floats) -> int:
    """What a part is from a side: what is turned or pressed along another direction is no control of it."""
    kind = {"knob": KNOB, "button": KEY}.get(part["type"], NEITHER)
    if not part["scored"] and part["type"] not in NO_CONTROLS:
        return SKIP
    axis = np.array((part.get("joint") or {}).get("axis") or outward, dtype=np.float64)
    along = abs(float(axis @ outward)) / max(float(np.linalg.norm(axis)), 1e-9)
    return kind if along >= MIN_ALONG else NEITHER


# Files ----------------------------------------------------------------------------------------------------------------

LEARNED = Path(__file__).parents[2] / "registry" / "learned"


def cached(path: Path, make: Callable[[], list[Samples]]) -> list[Samples]:
    """What `make` gives, stored in a file."""
    if not path.exists():
        found = make()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(pickle.dumps(found))
        return found
    return list(pickle.loads(path.read_bytes()))


def write_forest(name: str, forest: ExtraTreesClassifier, features: Sequence[str], classes: Sequence[str]) -> None:
    """Write registry/learned/<name>.json, a tree on each line, as casa_assets.core.numeric reads it."""
    head = {"features": list(features), "classes": list(classes)}
    trees = ",\n".join(json.dumps(list(_nodes(e.tree_)), separators=(",", ":")) for e in forest.estimators_)
    path = LEARNED / f"{name}.json"
    path.write_text(f'{json.dumps(head, indent=1)[:-2]},\n "trees": [\n{trees}\n]}}\n', encoding="utf-8")
    print(f"{path.name}: {path.stat().st_size / 1024:.0f} KiB")


def _nodes(tree: Any) -> Iterator[list[Any]]:
    for k in range(tree.node_count):
        if tree.children_left[k] < 0:
            share = tree.value[k, 0] / tree.value[k, 0].sum()
            yield [[round(100 * float(p)) for p in share]]
        else:
            threshold = float(f"{tree.threshold[k]:.4g}")
            yield [int(tree.feature[k]), threshold, int(tree.children_left[k]), int(tree.children_right[k])]


# Learn ----------------------------------------------------------------------------------------------------------------

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
        self.learnable: Mask = (self.types != SKIP) & (place < MOST_OF_GROUP)
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

    def learn(self, rows: Mask) -> ExtraTreesClassifier:
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
        for as_shell in (False, True):
            for top in (False, True):
                rows = of & (table.types != SKIP) & (table.fused == as_shell) & (table.on_top == top)
                if rows.any():
                    counts = " ".join(_counts(table.types[rows], found[rows]) for found in (table.rule, best))
                    title = f"{name}{' fused' if as_shell else ''}"
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
    """All samples: of scenes and drawings, some of them as one shell of cubes too, of the benchmark, and of own cases.

    Args:
        keep: folder that stores them. bench, own: folders with an index.json. drawings: of each kind.
    """

    def cases(folder: Path, variant: str, is_own: bool) -> list[Samples]:
        score = load_score(folder)
        rows = json.loads((folder / "index.json").read_text(encoding="utf-8"))["cases"]
        return [s for r in rows for s in case_samples(score, r["name"], "own" if is_own else r["origin"], variant)]

    def drawn(count: int, as_shell: bool) -> list[Samples]:
        return [s for kind in KINDS for i in range(count) for s in drawn_samples(kind, SEED, i, as_shell)]

    shells, drawn_shells = (round(SHARE_OF_SHELLS * count) for count in (scenes, drawings))
    makers: dict[str, Callable[[], list[Samples]]] = {
        f"scenes_{scenes}": lambda: [s for i in range(scenes) for s in scene_samples(SEED, i)],
        f"drawn_{drawings}": lambda: drawn(drawings, False),
        f"fused_scenes_{shells}": lambda: [s for i in range(shells) for s in fused_scene_samples(SEED, i)],
        f"fused_drawn_{drawn_shells}": lambda: drawn(drawn_shells, True),
    }
    for variant in ("input", "fused"):
        makers[f"bench_{variant}"] = partial(cases, bench, variant, False)
    for folder in own:
        for variant in ("input", "fused"):
            makers[f"own_{'_'.join(folder.parts[-3:])}_{variant}"] = partial(cases, folder, variant, True)
    return [s for name, make in makers.items() for s in cached(keep / f"{name}.pickle", make)]


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
    table = Table(gathered(args.keep, bench, args.cases, args.scenes, args.drawings))
    chances = table.told()
    tell(table, chances)
    if args.write:
        table.leave_out_doubtful(chances)
        every = np.ones(len(table.types), dtype=bool)
        write_forest("controls", table.learn(every), CONTROL_FEATURES, CONTROL_CLASSES)


if __name__ == "__main__":
    main()
