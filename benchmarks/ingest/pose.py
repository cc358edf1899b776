"""Size, pose and mass that ingest gives to meshes, against a table of what is true.

    ./dev bench ingest_pose folder_with_truth_csv [--copies] [--sheet] [--every 6] [--only mug bowl] [--library out/lib]

The folder holds meshes and truth.csv (file, category, true_longest_m, truth_source, plausible_min_m, plausible_max_m,
metres_per_unit_in_file, up_axis_in_file), which is for judging alone. Writes out/bench/ingest_pose.json and .md, and
prints the latter; `--copies` also hands every mesh in again upside down, on its side, on its other side and askew;
`--sheet` draws all that came out; `--library` compares the masses of a library's MJCF and USD files.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.ingest.judging import pose
from benchmarks.ingest.judging.inputs import brief, dump
from benchmarks.ingest.judging.pose_report import parity, report
from benchmarks.ingest.judging.pose_sheet import draw
from casa_assets import registry
from casa_assets.errors import CasaError
from casa_assets.formats.read import load
from casa_assets.ingest.clean import clean
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.mass import combine_estimates, estimate_masses
from casa_assets.ingest.run.stages import MASS_AGREEMENT_RATIO, STAGES, BuildContext
from casa_assets.ingest.mass.estimates import combine_estimates, estimate_masses
from casa_assets.ingest.run.steps import MASS_AGREEMENT_RATIO, STAGES, BuildContext
from casa_assets.ingest.run.survey import find_category
from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found
from casa_assets.mesh.solid.solids import closed_solid
from casa_assets.model.registry.category import Category


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
) -> tuple[Row, Draft]:
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
    return row, done


def _judge(
    row: Row, category: Category, draft: Draft, posed: Draft, told: BuildContext, truth: dict[str, str], copies: bool
) -> None:
    if truth["true_longest_m"]:
        row.true_m = float(truth["true_longest_m"])
        row.metric = abs(float(truth["metres_per_unit_in_file"]) - 1) < 1e-9
    row.low_m, row.high_m = float(truth["plausible_min_m"]), float(truth["plausible_max_m"])
    points, up = pose.spread_points(draft), truth["up_axis_in_file"]
    row.grade = pose.grade(points, pose.rotation(draft, posed), up, category).value
    orient = {stage.name: stage.function for stage in STAGES}["orient"]
    for name, turn in pose.COPIES.items() if copies else ():
        other = pose.copy(draft, turn)
        posed_copy = orient(other, told)
        back = pose.rotation(other, posed_copy) @ turn
        row.copies[name] = pose.grade(points, back, up, category).value
        row.copies_sure[name] = next(g.confidence for g in posed_copy.guesses if g.subject == "up_axis")


def main() -> None:
    """Parse, run, write, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("examples/meshes"), help="meshes")
    parser.add_argument("--copies", action="store_true", help="also upside-down and lying copies")
    parser.add_argument("--sheet", action="store_true", help="draw what came out")
    parser.add_argument("--every", type=int, default=1, help="only every n-th input")
    parser.add_argument("--only", nargs="*", default=[], help="only inputs of these categories")
    parser.add_argument("--library", type=Path, help="compare masses of MJCF and USD in this library")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="where results go")
    given = parser.parse_args()
    table = truths(given.folder)
    rows, drawn = [], []
    for one, category, draft, told in inputs(given.folder, given.every, given.only):
        path = (one.root / one.main).resolve().relative_to(given.folder.resolve()).as_posix()
        try:
            row, done = measured(path, category, draft, told, table.get(path, {}), given.copies)
        except CasaError as error:
            rows.append(Row(path, category.id, failed=str(error)))
            continue
        rows.append(row)
        drawn.append((f"{category.id} {row.longest_m:.3g} m {row.mass_kg:.2g} kg", done))
        print(f"{path}: {row.longest_m:.3g} m (true {row.true_m}), {row.up} {row.grade} {row.copies}", flush=True)
    masses = parity(given.library) if given.library else []
    dump(given.out / "ingest_pose.json", {"rows": [asdict(r) for r in rows], "masses": masses})
    text = report(rows, masses)
    (given.out / "ingest_pose.md").write_text(text, encoding="utf-8")
    if given.sheet:
        draw(drawn, given.out / "ingest_pose.png")
    print(text)


if __name__ == "__main__":
    main()
