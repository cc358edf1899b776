"""The articulation benchmark: what `casa_assets.articulate` finds, scored by the benchmark's own score.py.

    CASA_SHARED=/path/to/shared python benchmarks/articulate.py [--variant input welded fused] [--suite core]
        [--every 4] [--only regex] [--perturb SEED] [--true-frame] [--families] [--travel] [--keep FOLDER]

Prints the table of score.py for each variant and per type, of all cases and of those of its core suite, seconds of the
processor per mesh, and how often the frame was right. `--keep` stores what each case gave and takes what is stored
there: a run can be stopped and taken up, and several may share a folder (one for each version of the tool).
`--families` scores 40 appliances of this project's own families instead (CASA_SHARED is needed for score.py alone);
`--travel` also builds each case and prints the share of joints that reach their declared range in MuJoCo under 20 N
without a contact of over 1 mm beyond the rest one; and of each case its kind, and whether it holds its contract.
`--predict OUT.json` runs the whole command on any folder of cases, also without ground truth, and writes predictions
in the format of score.py (see benchmarks/articulate_predict.py).
`--true-frame` gives the tool the up and front that the ground truth has: what the frame guess costs is the difference.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
import json
import os
import sys
import tarfile
import tempfile
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from articulate_cases.pose import AXES, turned
from articulate_predict import predict

from casa_assets.articulate.choose_plan import choose_plan
from casa_assets.articulate.frame.axes import given_frame, guess_frame
from casa_assets.articulate.plan import Articulation, Frame
from casa_assets.articulate.segment.welded_mesh import weld_triangles
from casa_assets.checks.motion.joint_travel import joint_travels
from casa_assets.errors import Rejected
from casa_assets.export import mjcf
from casa_assets.pipeline.articulate.build import ArticulateRequest, build
from casa_assets.pipeline.articulate.limit_ranges import limit_ranges
from casa_assets.pipeline.articulate.models import load_models
from casa_assets.pipeline.articulate.run import with_contract


def shared() -> Path:
    """The benchmark's folder."""
    return Path(os.environ["CASA_SHARED"]) / "articulate_bench"


def load_score(cases: Path) -> ModuleType:
    """score.py as a module that reads `cases`."""
    os.environ["ARTBENCH_CASES"] = str(cases)
    spec = importlib.util.spec_from_file_location("score", shared() / "score.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def unpacked(folder: Path) -> Path:
    """The cases below `folder`, unpacked where they are not there."""
    if not (folder / "cases" / "index.json").exists():
        with tarfile.open(shared() / "cases.tar.xz") as tar:
            tar.extractall(folder, filter="data")
    return folder / "cases"


def truth(case: Any) -> tuple[Any, Any]:
    """Up and front of a case as vectors, None where it has no front."""
    up, front = case.J["up"], case.J.get("front")
    return AXES.get(up, up) if isinstance(up, str) else up, AXES.get(front, front) if isinstance(front, str) else front


def frame_is_right(frame: Frame, case: Any) -> bool:
    """Whether the guess has the up axis of the ground truth, and its front where it has one."""
    up, front = truth(case)
    good = float(np.dot(frame.rotation[2], up)) > 0.99
    return good and (front is None or float(np.dot(frame.rotation[1], front)) < -0.99)


def prediction(found: Articulation) -> dict[str, Any]:
    """What score.py reads: parts by face index, joints in the frame and units of the file."""
    parts = []
    for part in found.parts:
        joint = part.joint
        slides = joint.kind.value == "slide"
        span = [r / found.frame.scale if slides else r for r in joint.range]
        kind = "prismatic" if slides else "continuous" if joint.endless else "revolute"
        axis = found.frame.direction_to_file(joint.axis)
        origin = found.frame.to_file(np.array([joint.anchor]))[0].tolist()
        row = {"type": kind, "axis": list(axis), "origin": origin, "range": span}
        parts.append(
            {"name": part.name, "type": part.kind.value, "parent": part.parent or "base", "joint": row}
            | {"faces": part.faces.tolist()}
        )
    return {"parts": parts}


def one(case: Any, true_frame: bool) -> tuple[Articulation, float]:
    """What the tool makes of a case, and the seconds of the processor that it takes."""
    begin = time.process_time()
    mesh = weld_triangles(case.V, case.F)
    up, front = truth(case)
    frame = given_frame(mesh, up, front or (0, -1, 0)) if true_frame else guess_frame(mesh)
    plan = choose_plan(mesh.in_frame(frame), frame, models=load_models())
    return plan.articulation, time.process_time() - begin


def options(message: str) -> argparse.ArgumentParser:
    """The options that say which cases are looked at, and how they lie."""
    parser = argparse.ArgumentParser(description=message, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--variant", nargs="+", default=["input", "welded", "fused"])
    parser.add_argument("--suite", default="all")
    parser.add_argument("--only", help="Regular expression of the names.")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--perturb", type=int, help="Seed: another up axis, yaw, unit and place for each.")
    parser.add_argument("--cases", type=Path, help="Folder in which the cases are unpacked, or to unpack them in.")
    parser.add_argument("--families", action="store_true", help="40 appliances of our own families instead.")
    parser.add_argument("--verbose", action="store_true")
    return parser


@contextlib.contextmanager
def scored(args: argparse.Namespace) -> Iterator[ModuleType]:
    """score.py on the cases that the options ask for."""
    with contextlib.ExitStack() as stack:
        folder = args.cases or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        if not args.families:
            yield load_score(unpacked(folder))
            return
        sys.path.insert(0, str(Path(__file__).parent))
        from articulate_families import write_cases

        yield load_score(folder / "cases" if (folder / "cases").exists() else write_cases(folder))


def main() -> None:
    """Run and print."""
    parser = options(__doc__ or "")
    parser.add_argument("--true-frame", action="store_true")
    parser.add_argument("--travel", action="store_true", help="Also build each and print how far its joints go.")
    parser.add_argument("--keep", type=Path, help="Folder for what each case gave, of this version of the tool.")
    parser.add_argument("--out", type=Path, help="Folder for the predictions.")
    parser.add_argument("--predict", type=Path, metavar="OUT.json", help="Run the whole command; write what it finds.")
    parser.add_argument("--jobs", type=int, default=2, help="Processes of --predict.")
    parser.add_argument("--anonymous", action="store_true", help="With --predict: hide the names of files and folders.")
    args = parser.parse_args()
    if args.predict is not None:
        if args.cases is None:
            parser.error("--predict needs --cases")
        for variant in args.variant:
            several = len(args.variant) > 1
            out = args.predict.with_stem(f"{args.predict.stem}_{variant}") if several else args.predict
            predict(args.cases, variant, out, args.jobs, args.anonymous)
        return
    with scored(args) as score:
        for variant in args.variant:
            run(score, args, variant)


def run(score: ModuleType, args: argparse.Namespace, variant: str) -> None:
    """One variant."""
    names = score.case_names(args.suite, args.only)[:: args.every]
    done = []
    for name in names:
        stored = stored_at(args, variant, name)
        if stored is not None and stored.exists():
            done.append(json.loads(stored.read_text()))
        else:
            done.append(looked_at(score, args, variant, name))
            if stored is not None:
                stored.parent.mkdir(parents=True, exist_ok=True)
                stored.write_text(json.dumps(done[-1], default=float))
        if args.verbose:
            tell(done[-1]["row"], done[-1]["right"], done[-1]["took"])
    seconds = [d["took"] for d in done]
    print(f"\n== {variant}: {len(names)} cases; frame right {sum(d['right'] for d in done)}; seconds", end=" ")
    print(f"median {np.median(seconds):.2f} p95 {np.percentile(seconds, 95):.2f}")
    tables(score, [d["row"] for d in done])
    went: dict[str, list[bool]] = {}
    for kind, whole in (pair for d in done for pair in d["went"]):
        for each in ("ALL", kind):
            went.setdefault(each, []).append(whole)
    for kind, all_ in sorted(went.items()):
        share = sum(all_) / len(all_)
        message = "reach their range under 20 N, touching nothing"
        print(f"travel {kind}: {sum(all_)} of {len(all_)} joints ({share:.1%}) {message}")
    for d in done if args.travel else []:
        print(f"contract {d['row']['name']}: {d['holds']}")
    sys.stdout.flush()


def stored_at(args: argparse.Namespace, variant: str, name: str) -> Path | None:
    """The file that keeps what a case gave, or None where nothing is kept."""
    marks = [variant, *(["true"] if args.true_frame else []), *(["travel"] if args.travel else [])]
    marks += [] if args.perturb is None else [f"perturb{args.perturb}"]
    return None if args.keep is None else Path(args.keep) / "_".join(marks) / f"{name}.json"


def looked_at(score: ModuleType, args: argparse.Namespace, variant: str, name: str) -> dict[str, Any]:
    """The row of score.py for a case, whether its frame was right, the seconds that it took, and how its joints go."""
    case = score.Case(f"{score.CASES}/{name}", variant)
    if args.perturb is not None:
        turned(case, np.random.default_rng([args.perturb, zlib.crc32(name.encode())]))
    found, took = one(case, args.true_frame)
    decisions = prediction(found)
    if args.out:
        args.out.mkdir(parents=True, exist_ok=True)
        (args.out / f"{name}.json").write_text(json.dumps(decisions))
    mesh = Path(f"{score.CASES}/{name}/{variant}.obj")
    went, holds = travel(mesh) if args.travel else ([], "")
    row = score.score_case(case, decisions)
    return {"row": row, "right": frame_is_right(found.frame, case), "took": took, "went": went, "holds": holds}


def tables(score: ModuleType, rows: list[dict[str, Any]]) -> None:
    """All cases, those of the core suite where they are not all, and each category; then each type."""
    core = set(score.case_names("core"))
    inner = [r for r in rows if r["name"] in core]
    some = 0 < len(inner) < len(rows)
    groups = [score.summarise(rows, "ALL"), *([score.summarise(inner, "core")] if some else [])]
    kinds = sorted({r["category"] for r in rows})
    groups += [score.summarise([r for r in rows if r["category"] == k], k) for k in kinds]
    print(f"{score.table(groups)}\n\n{score.by_type(rows)}")
    if some:
        print(f"\ncore alone\n{score.by_type(inner)}")


def travel(mesh: Path) -> tuple[list[tuple[str, bool]], str]:
    """Build a mesh: of each joint the type of its part, and whether it goes all its way, touching nothing.

    Returns with it the kind that it was taken for, and the contract that it holds or the first thing that it lacks.
    """
    with tempfile.TemporaryDirectory() as folder:
        try:
            built = limit_ranges(build(ArticulateRequest(mesh, Path(folder)))).with_runtime_names()
            built = with_contract(built, Path(folder))
        except Rejected:
            return [], "nothing moves"
    holds = (
        f"holds {built.asset.contract}"
        if built.asset.contract
        else ": ".join(built.unmet_checks[:2]) or "none aimed at"
    )
    found = {t.joint: t for t in joint_travels(built.asset, mjcf.write(built.asset))}
    whole = [(p.kind.value, found[built.joints[p.name]].is_full) for p in built.articulation.parts]
    return whole, f"{built.category.id} ({built.confidence[0]:.0%}): {holds}"


def tell(row: dict[str, Any], good: bool, took: float) -> None:
    """What is wrong with one case, on one line each."""
    misses = [f"{p['name']}({p['type']}) {p['iou']:.2f}" for p in row["parts"] if p["iou"] < 0.5]
    wrong = [
        f"{p['name']}({p['type']}->{p.get('ptype')}): "
        + " ".join(k for k in ("type_ok", "joint_ok", "dir_ok") if p.get(k) is False)
        + f" ax {p.get('axis_deg')} o {p.get('origin_part')}"
        for p in row["parts"]
        if p["iou"] >= 0.5
        and (
            not p.get("joint_ok")
            or p.get("dir_ok") is False
            or p.get("axis_deg", 0) > 5
            or p.get("origin_part", 0) > 0.1
        )
    ]
    mark = "" if good else " FRAME"
    counts = f"{took:.1f}s gt {row['n_gt']} pred {row['n_pred']}"
    print(f"{row['name']}{mark} {counts} miss {misses} extra {row['extra']} wrong {wrong}")


if __name__ == "__main__":
    main()
