"""Compare the ways of splitting a mesh into fragments, and write how sure the tool is of what it finds.

    CASA_SHARED=/path/to/shared ./dev bench articulate_ways --cases FOLDER [FOLDER ...] [--variant input fused]
        [--keep FOLDER] [--every 4] [--jobs 2] [--margins] [--rows ROWS.json]

Each FOLDER is as `./dev bench articulate --cases` takes it: labelled cases, with an index whose rows may name a
source. Each way of splitting a case is followed to a plan, which score.py grades. Printed are F1 and MAO with the
welded fragments alone, with each other way where a case has it, with the plan that the tool chooses, and with the best
plan of each case, which no choice can beat; with `--margins` what other constants of the choice would give. `--rows`
writes what benchmarks/articulate/confidence.py fits on.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import zlib
from pathlib import Path
from typing import Any

from benchmarks.articulate.confidence import confidence_row
from benchmarks.articulate.score import frame_is_right, load_score, prediction
from casa_assets.articulate.frame import guess_frame
from casa_assets.articulate.infer import best_score, candidate_plans, needed_advantage, plan_score
from casa_assets.articulate.run.build import load_models
from casa_assets.articulate.segment.fragments import weld_triangles
from casa_assets.articulate.segment.segmentations import Segmentation

Case = dict[str, Any]
# Constants of the choice that --margins tries.
LEAST, ADVANTAGES = (0.0, 0.1, 0.2, 0.3, 0.4), (0.0, 0.15, 0.3, 0.5, 0.8)


def case_plans(job: tuple[Path, str, str, Path | None]) -> Case:
    """The plans of one case: of each the way, the score, the row of score.py, and how sure the tool is of its parts."""
    root, name, variant, keep = job
    stored = None if keep is None else keep / f"{zlib.crc32(str(root).encode()):08x}" / variant / f"{name}.json"
    if stored is not None and stored.exists():
        return dict(json.loads(stored.read_text()))
    score = load_score(root)
    case = score.Case(f"{root}/{name}", variant)
    mesh = weld_triangles(case.V, case.F)
    frame = guess_frame(mesh)
    plans = []
    for plan in candidate_plans(mesh.in_frame(frame), frame, "", load_models()):
        row = score.score_case(case, prediction(plan.articulation))
        sure = confidence_row(row, plan.articulation)
        plans.append({"way": plan.way.value, "score": plan.score, "row": row, "sure": sure})
    found = {"name": name, "root": str(root), "variant": variant, "plans": plans}
    found["frame"] = [frame.confidence, frame_is_right(frame, case)]
    if stored is not None:
        stored.parent.mkdir(parents=True, exist_ok=True)
        stored.write_text(json.dumps(found, default=float))
    return found


def chosen(case: Case) -> dict[str, Any]:
    """The plan that the tool takes."""
    advantage = needed_advantage(len(case["plans"][0]["sure"]["parts"]))
    return dict(case["plans"][best_score([p["score"] for p in case["plans"]], advantage)])


def chosen_with(case: Case, least: float, advantage: float) -> dict[str, Any]:
    """The plan that the tool would take with other constants of infer.py."""
    scores = [plan_score([part[0] for part in p["sure"]["parts"]], least) for p in case["plans"]]
    return dict(case["plans"][best_score(scores, advantage)])


def best(case: Case) -> dict[str, Any]:
    """The plan with the most right parts for its number of parts."""
    return dict(max(case["plans"], key=lambda p: _f1(p["row"])))


def split_by(case: Case, way: Segmentation) -> dict[str, Any]:
    """The plan of a way of splitting; that of the welded fragments where the case has no such way."""
    return dict(next((p for p in case["plans"] if p["way"] == way.value), case["plans"][0]))


def _f1(row: dict[str, Any]) -> float:
    total = row["n_gt"] + row["n_pred"]
    return 2 * sum(p["iou"] >= 0.5 for p in row["parts"]) / total if total else 1.0


def main() -> None:
    """Follow all cases to plans, print, and write the rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=Path, nargs="+", required=True)
    parser.add_argument("--variant", nargs="+", default=["input"])
    parser.add_argument("--keep", type=Path, help="Folder for the plans of each case, of this version of the tool.")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--rows", type=Path, help="Write what benchmarks/articulate/confidence.py fits on.")
    parser.add_argument("--margins", action="store_true", help="Also print what other constants of the choice give.")
    args = parser.parse_args()
    found, sources = _gathered(args)
    score = load_score(Path(found[0]["root"]))
    names = [*(way.value for way in Segmentation), "chosen", "best"]
    print(f"{'set':44s} cases  " + "  ".join(f"{n[:11]:>11s}" for n in names) + "   F1/MAO")
    for root, variant in [*sorted({(f["root"], f["variant"]) for f in found}), ("", "")]:
        rows = [f for f in found if not root or (f["root"], f["variant"]) == (root, variant)]
        plans = [[split_by(f, way) for f in rows] for way in Segmentation]
        plans += [[chosen(f) for f in rows], [best(f) for f in rows]]
        cells = [_cell(score, [p["row"] for p in column]) for column in plans]
        print(f"{(root[-36:] + ' ' + variant) if root else 'all':44s} {len(rows):5d}  " + "  ".join(cells))
    if args.margins:
        print("\nleast confidence x advantage over the first plan   " + "  ".join(f"{a:11.2f}" for a in ADVANTAGES))
        for least in LEAST:
            cells = [_cell(score, [chosen_with(f, least, a)["row"] for f in found]) for a in ADVANTAGES]
            print(f"{least:50.2f} " + "  ".join(cells))
    if args.rows is not None:
        rows_ = {
            f"{f['root']}/{f['variant']}/{f['name']}": {"group": s, "frame": f["frame"], **chosen(f)["sure"]}
            for f, s in zip(found, sources, strict=True)
        }
        args.rows.write_text(json.dumps(rows_), encoding="utf-8")


def _gathered(args: argparse.Namespace) -> tuple[list[Case], list[str]]:
    """The plans of all cases, and the source of each case."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    jobs, sources = [], []
    for folder in args.cases:
        root = folder / "cases" if (folder / "cases").is_dir() else folder
        index = json.loads((root / "index.json").read_text(encoding="utf-8"))["cases"]
        for row in index[:: args.every]:
            for variant in args.variant:
                if (root / row["name"] / f"{variant}.obj").exists():
                    jobs.append((root, row["name"], variant, args.keep))
                    source = row.get("source")
                    sources.append(str(source["repo"] if isinstance(source, dict) else source or root.parent.name))
    with multiprocessing.get_context("spawn").Pool(args.jobs, maxtasksperchild=40) as pool:
        found = list(pool.imap(case_plans, jobs, chunksize=4))
    return found, sources


def _cell(score: Any, rows: list[dict[str, Any]]) -> str:
    summary = score.summarise(rows)
    return f"{summary['F1@0.5']:5.3f}/{summary['MAO']:5.3f}"


if __name__ == "__main__":
    main()
