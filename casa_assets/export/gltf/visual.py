"""Visuals of a link -> meshes: one primitive for each material, so that a link is drawn in few calls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.export.gltf.binary import Binary
from casa_assets.export.gltf.material import Materials
from casa_assets.geometry.mesh import measure
from casa_assets.model.asset.asset import Visual
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.mesh import Mesh


@dataclass
class Meshes:
    """Meshes as glTF lists them; equal ones are written once, however many nodes show them."""

    binary: Binary
    materials: Materials
    rows: list[dict[str, Any]] = field(default_factory=list)
    _index: dict[str, int] = field(default_factory=dict)

    def of_visuals(self, visuals: Sequence[Visual], looks: dict[str, Material]) -> int | None:
        """Index of the mesh of some visuals of one link, or None if they have no faces."""
        primitives = []
        for material in dict.fromkeys(visual.material for visual in visuals):
            joined = _joined([visual.mesh for visual in visuals if visual.material == material])
            if joined is not None:
                primitives.append(self._primitive(*joined, self.materials.index(looks[material])))
        return self._add({"primitives": primitives}) if primitives else None

    def bare(self, points: Floats, faces: Ints, material: int) -> int:
        """Index of a mesh of one material without normals, which viewers draw faceted."""
        return self._add({"primitives": [self._primitive(points, None, None, faces, material)]})

    def _primitive(
        self, points: Floats, normals: Floats | None, uv: Floats | None, faces: Ints, material: int
    ) -> dict[str, Any]:
        attributes = {"POSITION": self.binary.vectors(points, with_bounds=True)}
        if normals is not None:
            attributes["NORMAL"] = self.binary.vectors(normals)
        if uv is not None:
            attributes["TEXCOORD_0"] = self.binary.vectors(uv)
        return {"attributes": attributes, "indices": self.binary.indices(faces), "material": material}

    def _add(self, row: dict[str, Any]) -> int:
        key = repr(row)
        if key not in self._index:
            self.rows.append(row)
            self._index[key] = len(self.rows) - 1
        return self._index[key]


def _joined(meshes: Sequence[Mesh]) -> tuple[Floats, Floats, Floats | None, Ints] | None:
    """Join meshes into points, unit normals, texture coordinates and faces, or None if there are no faces.

    Texture coordinates have v down, as in glTF, and are None if no mesh has any.
    """
    filled = [_with_normals(mesh) for mesh in meshes if len(mesh.faces)]
    if not filled:
        return None
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh, _ in filled)])
    faces = np.concatenate([m.faces.astype(np.int64) + start for (m, _), start in zip(filled, starts, strict=False)])
    uv = None
    if any(mesh.uv is not None for mesh, _ in filled):
        rows = [np.zeros((len(m.vertices), 2)) if m.uv is None else m.uv for m, _ in filled]
        uv = np.concatenate(rows) * (1.0, -1.0) + (0.0, 1.0)
    points = np.concatenate([mesh.vertices for mesh, _ in filled])
    return points, np.concatenate([normals for _, normals in filled]), uv, faces


def _with_normals(mesh: Mesh) -> tuple[Mesh, Floats]:
    """Return the mesh and (V, 3) unit normals; a mesh without normals gets separate vertices for each face."""
    if mesh.normals is None:
        normals, areas = measure.face_normals(mesh.vertices, mesh.faces.astype(np.int64))
        normals[areas == 0] = (0.0, 0.0, 1.0)
        rows = mesh.faces.reshape(-1)
        faces = np.arange(len(rows), dtype=np.int32).reshape(-1, 3)
        mesh = Mesh(vertices=mesh.vertices[rows], faces=faces, uv=None if mesh.uv is None else mesh.uv[rows])
        return mesh, np.repeat(normals, 3, axis=0)
    lengths = np.linalg.norm(mesh.normals, axis=1, keepdims=True)
    upright = np.where(lengths > 0.0, mesh.normals, (0.0, 0.0, 1.0))
    return mesh, upright / np.where(lengths > 0.0, lengths, 1.0)
