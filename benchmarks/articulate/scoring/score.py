"""Read the cases of the articulation benchmark, articulate them, and score what is found by its own score.py."""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
import json
import os
import tarfile
import tempfile
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from benchmarks.articulate.cases.families import write_cases
from benchmarks.articulate.cases.pose import AXES, turned
from benchmarks.articulate.scoring.prediction import part_row
from casa_assets.articulate.frame import given_frame, guess_frame
from casa_assets.articulate.infer import choose_plan
from casa_assets.articulate.plan import Articulation, Frame, Models
from casa_assets.articulate.run.build import ArticulateRequest, build, load_models
from casa_assets.articulate.run.repairs import limit_ranges
from casa_assets.articulate.run.run import with_contract
from casa_assets.articulate.segment.welded_mesh import weld_triangles
from casa_assets.checks.motion.joints import joint_travels
from casa_assets.errors import Rejected
from casa_assets.formats import mjcf


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
    return {"parts": [part_row(part, part.joint, found.frame, part.faces) for part in found.parts]}


def one(case: Any, true_frame: bool, models: Models | None = None) -> tuple[Articulation, float]:
    """What the tool makes of a case, and the seconds of the processor that it takes.

    Args:
        models: instead of those of the registry.
    """
    begin = time.process_time()
    mesh = weld_triangles(case.V, case.F)
    up, front = truth(case)
    frame = given_frame(mesh, up, front or (0, -1, 0)) if true_frame else guess_frame(mesh)
    plan = choose_plan(mesh.in_frame(frame), frame, models=models or load_models())
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
        yield load_score(folder / "cases" if (folder / "cases").exists() else write_cases(folder))


def looked_at(
    score: ModuleType, args: argparse.Namespace, variant: str, name: str, models: Models | None = None
) -> dict[str, Any]:
    """The row of score.py for a case, whether its frame was right, the seconds that it took, and how its joints go.

    Args:
        models: instead of those of the registry.
    """
    case = score.Case(f"{score.CASES}/{name}", variant)
    if args.perturb is not None:
        turned(case, np.random.default_rng([args.perturb, zlib.crc32(name.encode())]))
    found, took = one(case, args.true_frame, models)
    decisions = prediction(found)
    if args.out:
        args.out.mkdir(parents=True, exist_ok=True)
        (args.out / f"{name}.json").write_text(json.dumps(decisions))
    mesh = Path(f"{score.CASES}/{name}/{variant}.obj")
    went, holds = travel(mesh) if args.travel else ([], "")
    row = score.score_case(case, decisions)
    return {"row": row, "right": frame_is_right(found.frame, case), "took": took, "went": went, "holds": holds}


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
