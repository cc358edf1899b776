"""Size, pose and mass that ingest gives to meshes, against a table of what is true.

    ./dev bench ingest_pose folder_with_truth_csv [--copies] [--every 6] [--only mug bowl]

The folder holds meshes and truth.csv (file, category, true_longest_m, truth_source, plausible_min_m, plausible_max_m,
metres_per_unit_in_file, up_axis_in_file), which is for judging alone. Writes out/bench/ingest_pose.json and .md, and
prints the latter; `--copies` also hands every mesh in again upside down, on its side, on its other side and askew.
"""

from __future__ import annotations

import argparse
import csv
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.ingest.inputs import brief, publish
from casa_assets import registry
from casa_assets.core.numeric import Floats
from casa_assets.errors import CasaError
from casa_assets.formats.read import load
from casa_assets.ingest.clean import clean
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.mass import combine_estimates, estimate_masses
from casa_assets.ingest.run.inputs import find_category
from casa_assets.ingest.run.steps import MASS_AGREEMENT_RATIO, STAGES, BuildContext
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found
from casa_assets.ingest.up_axis import UP_ROTATIONS, outline_score, sample_surface
from casa_assets.mesh.solid.solids import closed_solid
from casa_assets.model.registry.category import Category, MatterFill, RestingPose

# Judge ----------------------------------------------------------------------------------------------------------------


SAME_DEG = 10.0  # two directions closer than this are one
SAME_SHAPE = 0.02  # of the longest side: surfaces closer than this for 95 % of their points look the same
FLAT = 1.3  # a thing lies where its height is no more than this times its least extent
LAY = 3.0  # nats by which the outline of a pose is more usual than another: the other one lies, say
YAWS = 12
POINTS = 900


class Grade(StrEnum):
    """How a pose compares with the true one."""

    EXACT = "exact"  # up is up
    SAME = "same shape"  # another way up, and nobody could tell from the shape
    ANY = "any pose"  # the category rests in any pose
    LIES = "lies"  # flat as its category does, on its other side
    STANDS = "stands"  # as its category does, where the file has it lying
    HEAD = "on its head"  # wrong: along the right axis, the other end up
    WRONG = "wrong"


# What is done to a mesh before it is given in again, in the axes of its file: the upside-down one, both that lie
# along the axes, and one that nobody modelled: let fall.
def about(axis: int, degrees: float) -> Floats:
    """(3, 3) rotation about a file axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
    return turn


COPIES: dict[str, Floats] = {
    "upside down": about(0, 180),
    "on its side": about(0, 90),
    "on its other side": about(2, 90) @ about(1, 90),
    "askew": about(0, 37) @ about(2, 52) @ about(1, 20),
}


def copy(draft: Draft, turn: Floats) -> Draft:
    """The same mesh, turned in its file."""
    parts = []
    for part in draft.parts:
        mesh = part.mesh
        normals = None if mesh.normals is None else mesh.normals @ turn.T
        parts.append(part.replace(mesh=mesh.with_vertices(mesh.vertices @ turn.T, normals)))
    return draft.replace(parts=tuple(parts))


def rotation(before: Draft, after: Draft) -> Floats:
    """(3, 3) rotation that took one to the other, by their vertices."""
    a, b = before.surface.vertices, after.surface.vertices
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    left, _, right = np.linalg.svd(b.T @ a)
    flip = np.diag([1, 1, np.sign(np.linalg.det(left @ right))])
    turn: Floats = left @ flip @ right
    return turn


def spread_points(draft: Draft) -> Floats:
    """(POINTS, 3) points over the surface, centred on the box around it, longest side 1."""
    samples = sample_surface(draft.surface.vertices, draft.surface.faces).samples
    picked = samples[:: max(1, len(samples) // POINTS)]
    low, high = samples.min(axis=0), samples.max(axis=0)
    out: Floats = (picked - (low + high) / 2) / float((high - low).max())
    return out


def same_shape(one: Floats, other: Floats, yaws: int = YAWS) -> bool:
    """Whether two surfaces, both z up, are the same for some turn about z."""
    tree = cKDTree(other)
    for k in range(yaws):
        turned = one @ about(2, 360 * k / yaws).T
        middle = (turned.min(axis=0) + turned.max(axis=0)) / 2
        if float(np.quantile(tree.query(turned - middle)[0], 0.95)) < SAME_SHAPE:
            return True
    return False


def grade(points: Floats, turn: Floats, up: str, category: Category) -> Grade:
    """Grade a pose.

    Args:
        points: of `spread_points`, in the axes of the file. turn: asset_from_file. up: true up axis of the file.
    """
    true = UP_ROTATIONS[up]
    if np.degrees(np.arccos(np.clip(turn[2] @ true[2], -1, 1))) < SAME_DEG:
        return Grade.EXACT
    if category.upright is RestingPose.ANY:
        return Grade.ANY
    if same_shape(points @ turn.T, points @ true.T):
        return Grade.SAME
    if category.upright is RestingPose.LIES and category.build is not MatterFill.VESSEL:
        _, axes = np.linalg.eigh(np.cov(points.T))
        least = min(*(float(np.ptp(points @ a)) for a in axes.T), *(float(np.ptp(points[:, k])) for k in range(3)))
        if float(np.ptp(points @ turn[2])) <= FLAT * least:
            return Grade.LIES
    if category.upright is RestingPose.STANDS and category.build is MatterFill.FILLED:
        ours, file = (outline_score(np.ptp(points @ t.T, axis=0), category) for t in (turn, true))
        if ours > file + LAY:
            return Grade.STANDS
    return Grade.HEAD if turn[2] @ true[2] < -np.cos(np.radians(SAME_DEG)) else Grade.WRONG


# Report ---------------------------------------------------------------------------------------------------------------

NEAR = 0.25  # of the true longest side
KEPT = 0.05  # a metric file may change by so much
SURE = 0.5  # below, a guess is for a person to look at
GOOD = ("exact", "same shape", "any pose", "lies", "stands")


def report(rows: Sequence[Row]) -> str:
    """Markdown."""
    done = [r for r in rows if not r.failed]
    lines = [f"{len(rows)} inputs, {len(rows) - len(done)} could not be worked on.", ""]
    lines += ["| what | target | measured | |", "|---|---|---|---|"]
    lines += [*_scale_lines(done), *_pose_lines(done), *_mass_lines(done), "", *_misses(done)]
    return "\n".join(lines) + "\n"


def _line(what: str, target: float, good: int, of: int, extra: str = "") -> str:
    if not of:
        return f"| {what} | {target:.0%} | no such rows | |"
    share = good / of
    verdict = "pass" if share >= target else f"miss by {100 * (target - share):.1f} points"
    return f"| {what} | {target:.0%} | {good} of {of} ({share:.1%}){extra} | {verdict} |"


def _error(row: Row) -> float:
    return abs(row.longest_m / row.true_m - 1)


def _scale_lines(rows: Sequence[Row]) -> list[str]:
    known = [r for r in rows if r.true_m is not None]
    odd, metric = [r for r in known if not r.metric], [r for r in known if r.metric]
    blind = [r for r in rows if r.true_m is None and r.high_m < 1e9]
    far = [r for r in known if _error(r) > NEAR]
    flagged = sum(r.scale_sure < SURE for r in far)
    verdict = "pass" if flagged == len(far) else "miss"
    return [
        _line(
            "within 25 % of the truth, files that are not metric", 0.9, sum(_error(r) <= NEAR for r in odd), len(odd)
        ),
        _line("changed by no more than 5 %, metric files", 1.0, sum(_error(r) <= KEPT for r in metric), len(metric)),
        _line("within the plausible range, no true size known", 0.9, _inside(blind), len(blind)),
        f"| wrong by more than 25 %, and for review | all | {flagged} of {len(far)} | {verdict} |",
        f"| sizes for review | | {sum(r.scale_sure < SURE for r in rows)} of {len(rows)} | |",
    ]


def _inside(rows: Sequence[Row]) -> int:
    return sum(r.low_m * 0.999 <= r.longest_m <= r.high_m * 1.001 for r in rows)


def _pose_lines(rows: Sequence[Row]) -> list[str]:
    judged = [r for r in rows if r.grade]
    lines = [
        _line("upright", 0.95, sum(r.grade in GOOD for r in judged), len(judged), _kinds([r.grade for r in judged]))
    ]
    for name in dict.fromkeys(n for r in judged for n in r.copies):
        of = [r for r in judged if name in r.copies]
        kinds = _kinds([r.copies[name] for r in of])
        asked = sum(r.copies[name] not in GOOD and r.copies_sure[name] < SURE for r in of)
        lines.append(_line(f"copies {name}, righted", 0.95, sum(r.copies[name] in GOOD for r in of), len(of), kinds))
        lines.append(
            f"| of those not righted, for review | | {asked} of {sum(r.copies[name] not in GOOD for r in of)} | |"
        )
    wrong = [r for r in judged if r.grade not in GOOD]
    lines.append(
        f"| poses for review | | {sum(r.up_sure < SURE for r in rows)} of {len(rows)}, "
        f"{sum(r.up_sure < SURE for r in wrong)} of the {len(wrong)} wrong ones | |"
    )
    return lines


def _kinds(grades: Sequence[str]) -> str:
    counts = Counter(grades)
    return ": " + ", ".join(f"{counts[name]} {name}" for name in (*GOOD, "on its head", "wrong") if counts[name])


def _mass_lines(rows: Sequence[Row]) -> list[str]:
    inside = sum(r.mass_span[0] * 0.999 <= r.mass_kg <= r.mass_span[1] * 1.001 for r in rows)
    lines = [_line("mass within the range of the category", 1.0, inside, len(rows))]
    for name, low, high in (("apple", 0.1, 0.3), ("mug", 0.25, 0.5)):
        of = [r.mass_kg for r in rows if r.category == name]
        message = f", {min(of):.3g} to {max(of):.3g} kg" if of else ""
        good = sum(low <= kg <= high for kg in of)
        lines.append(_line(f"{name}s of {low:g} to {high:g} kg", 1.0, good, len(of), message))
    lines.append(f"| masses for review | | {sum(r.mass_sure < SURE for r in rows)} of {len(rows)} | |")
    return lines


def _misses(rows: Sequence[Row]) -> list[str]:
    lines = ["| size missed | category | true (m) | ours (m) | sure | |", "|---|---|---|---|---|---|"]
    for r in rows:
        limit = None if r.true_m is None else KEPT if r.metric else NEAR
        if limit is not None and _error(r) > limit:
            lines.append(
                f"| {r.path} | {r.category} | {r.true_m:.3g} | {r.longest_m:.3g} | {r.scale_sure:.0%} | {r.scale} |"
            )
        elif limit is None and r.high_m < 1e9 and not _inside([r]):
            span = f"{r.low_m:g} to {r.high_m:g}"
            lines.append(f"| {r.path} | {r.category} | {span} | {r.longest_m:.3g} | {r.scale_sure:.0%} | {r.scale} |")
    lines += ["", "| pose missed | category | as it is | copies | sure |", "|---|---|---|---|---|"]
    for r in rows:
        copies = ", ".join(n for n, g in r.copies.items() if g not in GOOD)
        if (r.grade and r.grade not in GOOD) or copies:
            as_it_is = r.grade if r.grade not in GOOD else ""
            lines.append(f"| {r.path} | {r.category} | {as_it_is} | {copies} | {r.up_sure:.0%} |")
    return lines


# Measure --------------------------------------------------------------------------------------------------------------


@dataclass
class Row:
    """One input, and what was made of it."""

    path: str
    category: str
    metric: bool | None = None  # whether the file is in metres; None where no true size is known
    true_m: float | None = None
    low_m: float = 0.0
    high_m: float = 1e9
    longest_m: float = 0.0
    scale: str = ""
    scale_sure: float = 0.0
    up: str = ""
    up_sure: float = 0.0
    grade: str = ""
    front: str = ""
    front_sure: float = 0.0
    copies: dict[str, str] = field(default_factory=dict)
    copies_sure: dict[str, float] = field(default_factory=dict)
    mass_kg: float = 0.0
    mass_sure: float = 0.0
    mass_span: tuple[float, float] = (0.0, 0.0)
    mass_says: str = ""
    failed: str = ""


def inputs(folder: Path, every: int, only: list[str]) -> Iterator[tuple[Found, Category, Draft, BuildContext]]:
    """Every input that can be read, cleaned."""
    known = registry.load()
    for one in [f for f in discover([folder]) if isinstance(f, Found)][::every]:
        category = find_category(one, "")[0]
        if only and category.id not in only:
            continue
        try:
            bundle = collect(one, known.limits)
            yield one, category, clean(load(bundle, known.limits)), brief(one, bundle, category)
        except CasaError as error:
            print(f"{one.source.path}: {error}", flush=True)


def truths(folder: Path) -> dict[str, dict[str, str]]:
    """Rows of truth.csv by file; none where there is no such table."""
    table = folder / "truth.csv"
    if not table.is_file():
        return {}
    with table.open(encoding="utf-8", newline="") as handle:
        return {row["file"]: row for row in csv.DictReader(handle)}


def measured(
    path: str, category: Category, draft: Draft, told: BuildContext, truth: dict[str, str], copies: bool
) -> Row:
    """Run the stages on one input and judge what came out."""
    steps = {stage.name: stage.function for stage in STAGES}
    posed = steps["orient"](draft, told)
    done = steps["scale"](posed, told)
    by = {g.subject: g for g in done.guesses}
    surface = done.surface
    # Along the axes of the file, as the table has it: another pose makes another box.
    factor = float(
        np.linalg.norm(np.ptp(surface.vertices, axis=0)) / np.linalg.norm(np.ptp(posed.surface.vertices, axis=0))
    )
    known = registry.load()
    points, ids = surface.points, surface.welded_faces
    ways = estimate_masses(points, ids, closed_solid(points, ids), category, known.substances[category.substance])
    found = combine_estimates(ways, category, MASS_AGREEMENT_RATIO)
    row = Row(
        path=path,
        category=category.id,
        longest_m=factor * float(np.ptp(draft.surface.vertices, axis=0).max()),
        scale=by["scale"].value,
        scale_sure=by["scale"].confidence,
        up=by["up_axis"].value,
        up_sure=by["up_axis"].confidence,
        front=by["front"].value,
        front_sure=by["front"].confidence,
        mass_kg=found.kg,
        mass_sure=found.confidence,
        mass_span=(category.mass_kg.low, category.mass_kg.high),
        mass_says=found.message,
    )
    if truth:
        _judge(row, category, draft, posed, told, truth, copies)
    return row


def _judge(
    row: Row, category: Category, draft: Draft, posed: Draft, told: BuildContext, truth: dict[str, str], copies: bool
) -> None:
    if truth["true_longest_m"]:
        row.true_m = float(truth["true_longest_m"])
        row.metric = abs(float(truth["metres_per_unit_in_file"]) - 1) < 1e-9
    row.low_m, row.high_m = float(truth["plausible_min_m"]), float(truth["plausible_max_m"])
    points, up = spread_points(draft), truth["up_axis_in_file"]
    row.grade = grade(points, rotation(draft, posed), up, category).value
    orient = {stage.name: stage.function for stage in STAGES}["orient"]
    for name, turn in COPIES.items() if copies else ():
        other = copy(draft, turn)
        posed_copy = orient(other, told)
        back = rotation(other, posed_copy) @ turn
        row.copies[name] = grade(points, back, up, category).value
        row.copies_sure[name] = next(g.confidence for g in posed_copy.guesses if g.subject == "up_axis")


def main() -> None:
    """Parse, run, write, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("examples/meshes"), help="meshes")
    parser.add_argument("--copies", action="store_true", help="also upside-down and lying copies")
    parser.add_argument("--every", type=int, default=1, help="only every n-th input")
    parser.add_argument("--only", nargs="*", default=[], help="only inputs of these categories")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="where results go")
    given = parser.parse_args()
    table = truths(given.folder)
    rows: list[Row] = []
    for one, category, draft, told in inputs(given.folder, given.every, given.only):
        path = (one.root / one.main).resolve().relative_to(given.folder.resolve()).as_posix()
        try:
            row = measured(path, category, draft, told, table.get(path, {}), given.copies)
        except CasaError as error:
            rows.append(Row(path, category.id, failed=str(error)))
            continue
        rows.append(row)
        print(f"{path}: {row.longest_m:.3g} m (true {row.true_m}), {row.up} {row.grade} {row.copies}", flush=True)
    publish(given.out / "ingest_pose", [asdict(r) for r in rows], report(rows))


if __name__ == "__main__":
    main()
