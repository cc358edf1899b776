"""Triangle mesh as arrays."""

from __future__ import annotations

from typing import Self

import numpy as np
import numpy.typing as npt
from pydantic import model_validator

from casa_assets.model.record import Colors, Faces, Points, Record, Uvs


class Mesh(Record):
    """Triangles over shared vertices; counter-clockwise seen from outside.

    Attributes:
        vertices: (V, 3) float64, metres once scaled, frame of the owner.
        faces: (F, 3) int32 indices into `vertices`.
        uv: (V, 2) float64, origin at the lower left of the image (the OBJ and USD convention), or None.
        normals: (V, 3) float64 unit normals, or None.
        colors: (V, 4) uint8 sRGB vertex colours, or None; only raw meshes carry them.
    """

    vertices: Points
    faces: Faces
    uv: Uvs | None = None
    normals: Points | None = None
    colors: Colors | None = None

    @model_validator(mode="after")
    def _agree(self) -> Self:
        count = len(self.vertices)
        for name in ("uv", "normals", "colors"):
            values = getattr(self, name)
            if values is not None and len(values) != count:
                raise ValueError(f"{name} has {len(values)} rows for {count} vertices")
        if len(self.faces) and not 0 <= int(self.faces.min()) <= int(self.faces.max()) < count:
            raise ValueError("a face names a vertex that does not exist")
        return self

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3) lower and upper corner of all vertices."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def with_vertices(self, vertices: npt.NDArray[np.float64], normals: npt.NDArray[np.float64] | None = None) -> Mesh:
        """Copy with moved vertices; normals are replaced, or dropped if None."""
        return Mesh(vertices=vertices, faces=self.faces, uv=self.uv, normals=normals, colors=self.colors)
