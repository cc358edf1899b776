"""A mesh whose moving parts are known, as a folder of the articulation benchmark holds it, and its fused variant."""

from __future__ import annotations

import copy
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.solid.deviation import surface_samples
from casa_assets.mesh.surface import face_normals
from casa_assets.mesh.voxels import boundary, voxelise

# Axes of a file by their names.
AXES = {"+X": (1, 0, 0), "-X": (-1, 0, 0), "+Y": (0, 1, 0), "-Y": (0, -1, 0), "+Z": (0, 0, 1), "-Z": (0, 0, -1)}
# Cubes along the longest side; points on the surfaces of the parts, and of each part at least so many.
CELLS, SAMPLES, LEAST_SAMPLES = 112, 120_000, 300
# A face of the shell is of the part whose point lies farthest out among so many near ones, which are no farther away
# than the nearest and the mean distance between points: what is printed on a surface hides that surface.
NEAR = 12


@dataclass(frozen=True)
class LabelledMesh:
    """One variant of a case.

    Attributes:
        points: (P, 3) in the axes and units of the file. faces: (F, 3).
        part: (F,) identifier of the part of each face, 0 for what does not move.
        truth: gt.json of the case.
    """

    points: Floats
    faces: Ints
    part: Ints
    truth: dict[str, Any]

    @property
    def areas(self) -> Floats:
        """(F,) areas of the faces."""
        return face_normals(self.points, self.faces)[1]


def fused(mesh: LabelledMesh) -> tuple[LabelledMesh, LabelledMesh]:
    """The mesh with the share of each part that the shell shows in its truth, and the shell.

    The shell is one of cubes around all that is seen from outside, gaps closed.
    """
    compact = np.unique(mesh.faces, return_inverse=True)[1].reshape(-1, 3).astype(np.int64)
    outer, skin = boundary(voxelise(mesh.points[np.unique(mesh.faces)], compact, CELLS))
    areas, shown = mesh.areas, face_normals(outer, skin)[1]
    clouds, ids = [], []
    for number in np.unique(mesh.part).tolist():
        rows = mesh.part == number
        count = max(LEAST_SAMPLES, int(SAMPLES * float(areas[rows].sum() / areas.sum())))
        clouds.append(surface_samples(mesh.points, mesh.faces[rows], count))
        ids.append(np.full(count, number, dtype=np.int64))
    cloud, center = np.concatenate(clouds), outer[skin].mean(axis=1)
    apart, at = cKDTree(cloud).query(center, k=NEAR)
    out = np.einsum("nkd,nd->nk", cloud[at], face_normals(outer, skin)[0])
    near = apart <= apart[:, :1] + np.sqrt(areas.sum() / SAMPLES)
    best = np.where(near, out, -np.inf).argmax(axis=1)
    part = np.concatenate(ids)[at[np.arange(len(at)), best]]
    truth = copy.deepcopy(mesh.truth)
    for row in truth["parts"]:
        area = float(areas[mesh.part == row["id"]].sum())
        row["visible"] = min(1.0, float(shown[part == row["id"]].sum() / max(area, 1e-12)))
    return replace(mesh, truth=truth), LabelledMesh(outer, skin, part, truth)


def write_case(folder: Path, mesh: LabelledMesh, shell: LabelledMesh) -> None:
    """Write a case: `input.obj`, `fused.obj`, and gt.json, whose runs of faces fit both."""
    folder.mkdir(parents=True, exist_ok=True)
    truth = copy.deepcopy(mesh.truth)
    truth["name"] = folder.name
    corners = mesh.points[mesh.faces].reshape(-1, 3)
    areas = mesh.areas
    truth["mesh"] = {
        "file": "input.obj",
        "vertices": len(mesh.points),
        "faces": len(mesh.faces),
        "bbox": [corners.min(axis=0).tolist(), corners.max(axis=0).tolist()],
        "diagonal": float(np.linalg.norm(np.ptp(corners, axis=0))),
        "area": float(areas.sum()),
    }
    for row in truth["parts"]:
        mine = np.flatnonzero(mesh.part == row["id"])
        row["faces"], row["area"] = runs_of(mine), float(areas[mine].sum())
        if len(mine):
            cloud = mesh.points[mesh.faces[mine]].reshape(-1, 3)
            row["bbox"] = [cloud.min(axis=0).tolist(), cloud.max(axis=0).tolist()]
    ids = [p["id"] for p in truth["parts"]]
    truth["welded"] = {}
    truth["fused"] = {"parts": {str(i): runs_of(np.flatnonzero(shell.part == i)) for i in ids}}
    write_obj(folder / "input.obj", mesh.points, mesh.faces)
    write_obj(folder / "fused.obj", shell.points, shell.faces)
    (folder / "gt.json").write_text(json.dumps(truth), encoding="utf-8")


def read_obj(path: Path) -> tuple[Floats, Ints]:
    """Vertices and triangles of an OBJ file; polygons become fans in file order, as score.py reads them."""
    points: list[list[str]] = []
    faces: list[list[int]] = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        if line.startswith("v "):
            points.append(line.split()[1:4])
        elif line.startswith("f "):
            corners = [int(word.split("/")[0]) for word in line.split()[1:]]
            corners = [c - 1 if c > 0 else len(points) + c for c in corners]
            faces += [[corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1)]
    return np.array(points, dtype=np.float64).reshape(-1, 3), np.array(faces, dtype=np.int64).reshape(-1, 3)


def write_obj(path: Path, points: Floats, faces: Ints) -> None:
    """Write triangles without the vertices that none of them uses."""
    used, at = np.unique(faces, return_inverse=True)
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in points[used].tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (at.reshape(-1, 3) + 1).tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def runs_of(rows: Ints) -> list[list[int]]:
    """Ascending indices as (start, count)."""
    if not len(rows):
        return []
    starts = np.flatnonzero(np.diff(rows, prepend=rows[0] - 2) != 1)
    counts = np.diff(np.append(starts, len(rows)))
    return [[int(rows[s]), int(c)] for s, c in zip(starts, counts, strict=True)]
