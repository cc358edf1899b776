"""What the whole command makes of a folder of cases, as predictions that the bench's score.py reads.

Used by `./dev bench articulate --cases DIR --variant V --predict OUT.json`. Each case is a folder with VARIANT.obj;
no ground truth is needed. OUT.json holds {case: prediction}; the folder OUT beside it holds one file for each case,
which `score.py --pred OUT` reads. A prediction also says how the command ended and how sure it was of frame and parts.

Parts are given by the faces of the file, in the order of score.py's own reader, before shells are cut. Parts that the
command adds inside (racks, turntables, boxes of drawers) have no faces in the file and are left out.
"""

from __future__ import annotations

import json
import multiprocessing
import re
import resource
import sys
import tempfile
import time
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.articulate.labelled import read_obj
from benchmarks.articulate.score import part_row
from casa_assets.articulate.run.build import ArticulateRequest, ArticulateResult, build
from casa_assets.articulate.run.steps import publish_result
from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.model.source import RawModel


@dataclass(frozen=True)
class Job:
    """One case: its name, its mesh, and the file to write."""

    name: str
    mesh: Path
    out: Path
    anonymous: bool


def predict(
    cases: Path,
    variant: str,
    out: Path,
    jobs: int = 2,
    anonymous: bool = False,
    only: str = "",
    every: int = 1,
    shows_each: bool = True,
) -> None:
    """Write the predictions of every case below a folder that has the variant; those that are there are kept.

    Args:
        cases: folder with a folder for each case, itself or in `cases`.
        out: JSON file; the folder of the same name without suffix gets one file for each case.
        anonymous: each mesh is given to the command under a name that says nothing.
        only: a regular expression for the names of cases; empty for all. every: takes the first of so many.
        shows_each: print how each case ended.
    """
    root = cases / "cases" if (cases / "cases").is_dir() else cases
    folder = out.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    meshes = [m for m in sorted(root.glob(f"*/{variant}.obj")) if re.search(only, m.parent.name)][::every]
    if not meshes:
        raise SystemExit(f"{root}: no case with {variant}.obj; name a folder that holds a folder for each case")
    todo = [Job(m.parent.name, m, folder / f"{m.parent.name}.json", anonymous) for m in meshes]
    open_ = [job for job in todo if not job.out.exists()]
    with multiprocessing.get_context("spawn").Pool(jobs, maxtasksperchild=8) as pool:
        for number, (name, line) in enumerate(pool.imap_unordered(predict_one, open_), 1):
            told = f" {name}: {line}" if shows_each else ""
            print(f"[{number}/{len(open_)}]{told}", file=sys.stderr, flush=True)
    found = {job.name: json.loads(job.out.read_text(encoding="utf-8")) for job in todo}
    out.write_text(json.dumps(found), encoding="utf-8")
    seconds = [p["seconds"] for p in found.values()]
    outcomes = sorted({p["outcome"] for p in found.values()})
    counts = ", ".join(f"{sum(p['outcome'] == o for p in found.values())} {o}" for o in outcomes)
    print(f"{len(found)} cases: {counts}; seconds of the processor median {np.median(seconds):.2f}", end=" ")
    print(f"p95 {np.percentile(seconds, 95):.2f}; wrote {out} and {folder}/")


def predict_one(job: Job) -> tuple[str, str]:
    """Run the command on one case and write its prediction; return its name and a line that tells how it ended."""
    begin = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    started = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        mesh = job.mesh
        if job.anonymous:
            mesh = Path(folder) / "in" / "mesh.obj"
            mesh.parent.mkdir()
            mesh.write_bytes(job.mesh.read_bytes())
        found = found_by_command(ArticulateRequest(mesh, Path(folder) / "out"), job.mesh)
    found["seconds"] = resource.getrusage(resource.RUSAGE_SELF).ru_utime - begin
    found["seconds_of_the_clock"] = time.monotonic() - started
    partial = job.out.with_suffix(".partial")
    partial.write_text(json.dumps(found), encoding="utf-8")
    partial.replace(job.out)
    return job.name, f"{found['outcome']} {found['code']} {len(found['parts'])} parts"


def found_by_command(request: ArticulateRequest, file: Path) -> dict[str, Any]:
    none = {"parts": [], "code": "", "message": "", "frame_confidence": None, "category": ""}
    try:
        result = build(request)
    except Rejected as error:
        moves = error.code != "ART001"
        return {**none, "outcome": "rejected" if moves else "nothing moves", "code": error.code, "message": str(error)}
    except Exception:  # noqa: BLE001  reported with the case; the other cases go on
        return {**none, "outcome": "traceback", "code": "RUN004", "message": traceback.format_exc()}
    parts = prediction_parts(result, file)
    about = {"frame_confidence": result.articulation.frame.confidence, "category": result.category.id}
    about |= {"category_confidence": result.confidence[0]}
    try:
        outcome = publish_result(request, result)
    except Exception:  # noqa: BLE001  reported with the case; the other cases go on
        return {**none, **about, "parts": parts, "outcome": "traceback", "message": traceback.format_exc()}
    about |= {"outcome": outcome.decision.value, "to_decide": list(outcome.to_decide)}
    return {**none, **about, "parts": parts, "code": outcome.code, "message": outcome.message}


def prediction_parts(result: ArticulateResult, file: Path) -> list[dict[str, Any]]:
    """The parts of a built asset as score.py reads them, over the faces of an OBJ file."""
    place = _faces_in_file(result, file)
    final = {p.name: p.joint for p in result.articulation.parts}
    frame = result.articulation.frame
    return [
        part_row(part, final.get(part.name, part.joint), frame, np.sort(place[part.faces]))
        | {"confidence": part.confidence}
        for part in result.planned.parts
    ]


def _faces_in_file(result: ArticulateResult, file: Path) -> Ints:
    """(F,) index in the file of each face of the mesh as read: the same corners, else the nearest middle."""
    read = read_model(result.read)
    vertices, faces = read_obj(file)
    there = vertices[faces]
    return matching_faces(read, there)


def read_model(model: RawModel) -> Floats:
    """(F, 3, 3) corners of all triangles of a model, part by part."""
    return np.concatenate([p.mesh.vertices[p.mesh.faces] for p in model.parts])


def matching_faces(corners: Floats, others: Floats) -> Ints:
    """(F,) index in `others` (G, 3, 3) of each of `corners` (F, 3, 3); equal ones are taken in their order."""
    if corners.shape == others.shape and np.array_equal(corners, others):
        return np.arange(len(corners))
    rows = np.concatenate([others, corners]).reshape(-1, 9)
    _, group = np.unique(rows, axis=0, return_inverse=True)
    group = group.reshape(-1)
    waiting: dict[int, list[int]] = {}
    for index, key in enumerate(group[: len(others)].tolist()):
        waiting.setdefault(key, []).append(index)
    place = np.full(len(corners), -1, dtype=np.int64)
    for index, key in enumerate(group[len(others) :].tolist()):
        if waiting.get(key):
            place[index] = waiting[key].pop(0)
    lost = np.flatnonzero(place < 0)
    if len(lost):
        place[lost] = cKDTree(others.mean(axis=1)).query(corners[lost].mean(axis=1))[1]
    return place
