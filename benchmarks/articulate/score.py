"""Read the cases of the articulation benchmark, articulate them, and score what is found by its own score.py."""

from __future__ import annotations

import importlib.util
import os
import tarfile
import time
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from benchmarks.articulate.labelled import AXES
from casa_assets.articulate.frame import likely_frames
from casa_assets.articulate.plan import Articulation, Frame, JointPlan, PartPlan
from casa_assets.articulate.run.build import load_models, load_plan_models
from casa_assets.articulate.search.choose import choose_plan
from casa_assets.articulate.segment.fragments import weld_triangles
from casa_assets.core.numeric import Ints


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


def part_row(part: PartPlan, joint: JointPlan, frame: Frame, faces: Ints) -> dict[str, Any]:
    """A part as score.py reads it, with its joint in the axes and units of the file.

    Args:
        joint: of the part, in the frame. faces: (F,) faces of the part in the order of the file.
    """
    slides = joint.kind.value == "slide"
    row = {
        "type": "prismatic" if slides else "continuous" if joint.endless else "revolute",
        "axis": list(frame.direction_to_file(joint.axis)),
        "origin": frame.to_file(np.array([joint.anchor]))[0].tolist(),
        "range": [r / frame.scale if slides else r for r in joint.range],
    }
    parent = part.parent or "base"
    return {"name": part.name, "type": part.kind.value, "parent": parent, "joint": row, "faces": faces.tolist()}


def prediction(found: Articulation) -> dict[str, Any]:
    """What score.py reads: parts by face index, joints in the frame and units of the file."""
    return {"parts": [part_row(part, part.joint, found.frame, part.faces) for part in found.parts]}


def looked_at(score: ModuleType, name: str, variant: str) -> dict[str, Any]:
    """The row of score.py for a case, whether its frame was right, and the seconds of the processor that it took."""
    case = score.Case(f"{score.CASES}/{name}", variant)
    begin = time.process_time()
    mesh = weld_triangles(case.V, case.F)
    found = choose_plan(mesh, likely_frames(mesh), "", load_models(), load_plan_models()).plan.articulation
    took = time.process_time() - begin
    return {"row": score.score_case(case, prediction(found)), "right": frame_is_right(found.frame, case), "took": took}
