"""Cut out the few faces at edges where more than two meet, and close the holes that this leaves."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Ints
from casa_assets.geometry.mesh.topology import edge_counts, weld
from casa_assets.ingest.draft import warning
from casa_assets.ingest.repair.holes import close_holes
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.ingest.source import RawPart
from casa_assets.model.issue import Issue

# More tangled edges than this share are the way it was built, and so many at most are looked at.
MAX_NONMANIFOLD_SHARE = 0.005
MOST_EDGES = 400
# Cutting out may bare another tangle so many times.
ROUNDS = 3


def cut_nonmanifold_faces(parts: tuple[RawPart, ...]) -> tuple[tuple[RawPart, ...], list[Issue]]:
    """Cut out nonmanifold faces and close the holes; unchanged where that leaves more unsound edges than before.

    Returns:
        The parts, and notes of tangles that were cut out and of holes that were closed.
    """
    plain, plain_notes = close_holes(parts)
    ids = _ids(plain)
    before = _unsound(ids)
    if not _is_rare(ids):
        return plain, plain_notes
    tried, cut = parts, []
    for _ in range(ROUNDS):
        bad = _touching(_ids(tried))
        if not bad.any():
            break
        cut.append(_corners(tried)[bad].reshape(-1, 3))
        tried = _without(tried, bad)
        if not tried:
            return plain, plain_notes
    mended, _ = close_holes(tried, np.concatenate(cut))
    after = _unsound(_ids(mended))
    if after * 2 > before:
        return plain, plain_notes
    message = f"{before} unsound edges became {after}: the faces around tangled ones were cut out and closed anew"
    return mended, [warning("MSH045", "edges", message)]


def _ids(parts: tuple[RawPart, ...]) -> Ints:
    starts = np.cumsum([0] + [len(p.mesh.vertices) for p in parts[:-1]])
    faces = np.concatenate([p.mesh.faces.astype(np.int64) + s for p, s in zip(parts, starts, strict=True)])
    found: Ints = weld(np.concatenate([p.mesh.vertices for p in parts]))[1][faces]
    return found


def _unsound(ids: Ints) -> int:
    return int((edge_counts(ids)[1] != 2).sum())


def _is_rare(ids: Ints) -> bool:
    _, uses, _ = edge_counts(ids)
    tangled = int((uses > 2).sum())
    return 0 < tangled <= min(MOST_EDGES, MAX_NONMANIFOLD_SHARE * len(uses))


def _touching(ids: Ints) -> npt.NDArray[np.bool_]:
    """(F,) faces at the ends of edges of more than two, and where rims meet, so that what is left has a plain rim."""
    edges, uses, _ = edge_counts(ids)
    count = int(ids.max()) + 1
    ends: npt.NDArray[np.bool_] = np.bincount(edges[uses == 1].ravel(), minlength=count) > 2
    ends[edges[uses > 2].ravel()] = True
    found: npt.NDArray[np.bool_] = np.any(ends[ids], axis=1)
    return found


def _corners(parts: tuple[RawPart, ...]) -> npt.NDArray[np.float64]:
    """(F, 3, 3) corners of all faces."""
    return np.concatenate([p.mesh.vertices[p.mesh.faces] for p in parts])


def _without(parts: tuple[RawPart, ...], bad: npt.NDArray[np.bool_]) -> tuple[RawPart, ...]:
    out, start = [], 0
    for part in parts:
        rows = bad[start : start + len(part.mesh.faces)]
        start += len(part.mesh.faces)
        if not rows.all():
            out.append(part.replace(mesh=_fewer(part.mesh, ~rows)) if rows.any() else part)
    return tuple(out)


def _fewer(mesh: Mesh, keep: npt.NDArray[np.bool_]) -> Mesh:
    used, faces = np.unique(mesh.faces[keep], return_inverse=True)
    return Mesh(
        vertices=mesh.vertices[used],
        faces=faces.reshape(-1, 3),
        uv=None if mesh.uv is None else mesh.uv[used],
        normals=None if mesh.normals is None else mesh.normals[used],
        colors=None if mesh.colors is None else mesh.colors[used],
    )
