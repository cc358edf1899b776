"""The fused variant of a case: one shell of cubes around all that is seen from outside, gaps closed."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.articulate.cases.labelled import LabelledMesh
from casa_assets.mesh.solid.deviation import surface_samples
from casa_assets.mesh.surface import face_normals
from casa_assets.mesh.voxels import boundary, voxelise

# Cubes along the longest side; points on the surfaces of the parts, and of each part at least so many.
CELLS, SAMPLES, LEAST_SAMPLES = 112, 120_000, 300
# A face of the shell is of the part whose point lies farthest out among so many near ones, which are no farther away
# than the nearest and the mean distance between points: what is printed on a surface hides that surface.
NEAR = 12


def fused(mesh: LabelledMesh) -> tuple[LabelledMesh, LabelledMesh]:
    """The mesh with the share of each part that the shell shows in its truth, and the shell."""
    outer, skin = boundary(voxelise(mesh.points[np.unique(mesh.faces)], _compact(mesh), CELLS))
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
    return replace(mesh, truth=truth), LabelledMesh(outer, skin, part, np.zeros(len(skin), dtype=bool), truth)


def _compact(mesh: LabelledMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """Faces over the vertices that they use."""
    return np.unique(mesh.faces, return_inverse=True)[1].reshape(-1, 3).astype(np.int64)
