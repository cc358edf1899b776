"""Polygons of any number of corners, and what is said of each corner -> ReadParts of triangles."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.notes import Notes
from casa_assets.ingest.load.raw_parts import Bytes, ReadPart, check_face_count, merged_corners
from casa_assets.ingest.load.triangulate import triangulate
from casa_assets.model.asset.material import Material


def cut_polygons(
    points: Floats, corners: Ints, counts: Ints, limits: Mapping[str, float], notes: Notes, name: str
) -> tuple[Ints, Ints]:
    """Triangles of polygons; those with fewer than three corners or with points that do not exist are dropped.

    Args:
        points: (P, 3), any unit.
        corners: (C,) point of each corner, polygon after polygon.
        counts: (N,) corners of each polygon; where they claim more corners than there are, the last ones are dropped.
    Returns:
        (T, 3) places in `corners`, and (T,) polygon of each triangle, ascending.
    Raises:
        Rejected: TOO_LARGE.
    """
    counts = np.clip(counts, 0, len(corners) + 1)
    starts = np.concatenate(([0], np.cumsum(counts)))[:-1]
    is_whole = (counts >= 3) & (starts + counts <= len(corners))
    check_face_count(int((counts[is_whole] - 2).sum()), limits, name)
    is_bad = np.concatenate(([0], np.cumsum((corners < 0) | (corners >= len(points)))))
    is_whole[is_whole] = is_bad[(starts + counts)[is_whole]] == is_bad[starts[is_whole]]
    dropped = int((~is_whole).sum())
    if dropped:
        message = f"{dropped} faces with fewer than three corners or missing vertices were dropped"
        notes.add(codes.FACE_DROPPED, name, message)
    places: list[Ints] = [np.zeros((0, 3), dtype=np.int64)]
    owners: list[Ints] = [np.zeros(0, dtype=np.int64)]
    fanned = 0
    for size in np.unique(counts[is_whole]):
        chosen = np.flatnonzero(is_whole & (counts == size))
        at = starts[chosen][:, None] + np.arange(size)
        local, polygon, fans = triangulate(points[corners[at]])
        fanned += fans
        places.append(at[polygon[:, None], local])
        owners.append(chosen[polygon])
    if fanned:
        notes.add(
            codes.POLYGON_FAN, name, f"{fanned} concave or crossed faces were cut as fans; triangulate them first"
        )
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(places)[order], owner[order]


def part_of_corners(
    name: str,
    points: Floats,
    corners: Ints,
    triangles: Ints,
    material: Material,
    uv: Floats | None = None,
    normals: Floats | None = None,
    colors: Bytes | None = None,
) -> ReadPart:
    """ReadPart of triangles whose corners have texture coordinates, normals and colours of their own.

    Args:
        points: (P, 3). corners: (C,) point of each corner. triangles: (T, 3) places in `corners`.
        uv, normals, colors: (C, 2), (C, 3), (C, 4) uint8, or None.
    """
    picked = triangles.reshape(-1)
    extra = [values[picked] for values in (uv, normals, colors) if values is not None]
    if not len(picked) or not extra:
        return ReadPart(name, points, corners[triangles], material)
    columns = [corners[picked], *(_row_numbers(values) for values in extra)]
    first, faces = merged_corners(columns)
    chosen = picked[first]
    return ReadPart(
        name=name,
        vertices=points[corners[chosen]],
        faces=faces,
        material=material,
        uv=None if uv is None else uv[chosen],
        normals=None if normals is None else normals[chosen],
        colors=None if colors is None else colors[chosen],
    )


def _row_numbers(values: np.ndarray[tuple[int, int], np.dtype[np.generic]]) -> Ints:
    """(N,) the same number for equal rows, by their bits, so that NaN equals itself."""
    rows = np.ascontiguousarray(values)
    whole = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).reshape(-1)
    return np.unique(whole, return_inverse=True)[1].reshape(-1).astype(np.int64)
