"""A mesh whose moving parts are known, as a folder of the articulation benchmark holds it."""

from __future__ import annotations

import copy
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.articulate.cases.pose import AXES
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.surface import face_normals
from casa_assets.mesh.topology import weld

# Types of parts that close an opening, and of those that are pressed or turned on a surface.
FRONTS, CONTROLS = ("door", "drawer", "lid"), ("button", "knob")


@dataclass(frozen=True)
class LabelledMesh:
    """One variant of a case.

    Attributes:
        points: (P, 3) in the axes and units of the file. faces: (F, 3).
        part: (F,) identifier of the part of each face, 0 for what does not move.
        handle: (F,) whether the face belongs to a handle of its part, as far as the case says so.
        truth: gt.json of the case; its runs of faces are those of the file that it was read from.
    """

    points: Floats
    faces: Ints
    part: Ints
    handle: Mask
    truth: dict[str, Any]

    @property
    def parts(self) -> list[dict[str, Any]]:
        """The parts of the ground truth."""
        found: list[dict[str, Any]] = self.truth["parts"]
        return found

    @property
    def diagonal(self) -> float:
        """Diagonal of the box around the vertices that faces use."""
        return float(np.linalg.norm(np.ptp(self.points[self.faces].reshape(-1, 3), axis=0)))

    @property
    def areas(self) -> Floats:
        """(F,) areas of the faces."""
        return face_normals(self.points, self.faces)[1]

    def with_faces(self, rows: Ints | Mask) -> LabelledMesh:
        """Only these faces, in this order."""
        return replace(self, faces=self.faces[rows], part=self.part[rows], handle=self.handle[rows])

    def with_points(self, points: Floats) -> LabelledMesh:
        """The same faces with their vertices elsewhere."""
        return replace(self, points=points)

    def added(self, points: Floats, faces: Ints, part: int | Ints) -> LabelledMesh:
        """The mesh and more faces after its own, with vertices of their own."""
        return LabelledMesh(
            np.concatenate([self.points, points]),
            np.concatenate([self.faces, faces + len(self.points)]),
            np.concatenate([self.part, np.broadcast_to(np.asarray(part, dtype=np.int64), len(faces))]),
            np.concatenate([self.handle, np.zeros(len(faces), dtype=bool)]),
            self.truth,
        )

    def direction(self, key: str) -> Floats | None:
        """`up` or `front` of the ground truth as a unit vector, None where the case has none."""
        value = self.truth.get(key)
        if value is None:
            return None
        return np.array(AXES[value] if isinstance(value, str) else value, dtype=np.float64)


def read_case(folder: Path, variant: str = "input") -> LabelledMesh:
    """Read one variant of a case: `input` or `fused`."""
    truth = json.loads((folder / "gt.json").read_text(encoding="utf-8"))
    points, faces = read_obj(folder / f"{variant}.obj")
    part, handle = np.zeros(len(faces), dtype=np.int64), np.zeros(len(faces), dtype=bool)
    for row in truth["parts"]:
        runs = truth["fused"]["parts"][str(row["id"])] if variant == "fused" else row["faces"]
        part[unruns(runs)] = row["id"]
        if variant == "input":
            handle[unruns(row.get("subparts", {}).get("handle", []))] = True
    return LabelledMesh(points, faces, part, handle, truth)


def write_case(
    folder: Path, mesh: LabelledMesh, fused: LabelledMesh | None = None, *, welded: float | None = None
) -> None:
    """Write a case: `input.obj`, where it is given `fused.obj`, and gt.json, whose runs of faces fit both.

    Args:
        welded: also write `welded.obj`, in which vertices within this share of the diagonal are one.
    """
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
        "diagonal": mesh.diagonal,
        "area": float(areas.sum()),
    }
    for row in truth["parts"]:
        mine = np.flatnonzero(mesh.part == row["id"])
        row["faces"], row["area"] = runs_of(mine), float(areas[mine].sum())
        row.pop("components", None)
        row.pop("subparts", None)
        grips = mine[mesh.handle[mine]]
        if len(grips):
            row["subparts"] = {"handle": runs_of(grips)}
        if len(mine):
            cloud = mesh.points[mesh.faces[mine]].reshape(-1, 3)
            row["bbox"] = [cloud.min(axis=0).tolist(), cloud.max(axis=0).tolist()]
    truth["welded"], truth["fused"] = {}, {}
    write_obj(folder / "input.obj", mesh.points, mesh.faces)
    if welded is not None:
        points, place = weld(mesh.points, welded * mesh.diagonal / float(np.ptp(mesh.points, axis=0).max()))
        write_obj(folder / "welded.obj", points, place[mesh.faces])
    if fused is not None:
        ids = [p["id"] for p in truth["parts"]]
        truth["fused"] = {"parts": {str(i): runs_of(np.flatnonzero(fused.part == i)) for i in ids}}
        write_obj(folder / "fused.obj", fused.points, fused.faces)
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


def unruns(runs: list[list[int]]) -> Ints:
    """Indices of (start, count) runs."""
    return np.concatenate([np.arange(a, a + n) for a, n in runs]) if runs else np.zeros(0, dtype=np.int64)
