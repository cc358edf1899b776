"""Find pieces sealed up in others, which nobody sees or touches: the inner structures of generated meshes."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.grid.voxel import Grid, voxelise
from casa_assets.geometry.mesh.measure import signed_volume
from casa_assets.geometry.mesh.topology import is_closed
from casa_assets.geometry.solid.coverage import surface_samples
from casa_assets.ingest.draft import warning
from casa_assets.ingest.repair.components import Pieces
from casa_assets.model.ingest.source import RawPart
from casa_assets.model.issue import Issue

# Cubes along the longest side: what gets out through a smaller hole is sealed in.
CELLS = 96
# Points on a piece of which all have to lie in cubes that are enclosed, or in the skin; so many in the former.
SAMPLES = 256
WELL_WITHIN = 0.8
# Most pieces that are looked at; a heap of more is left alone.
MOST_PIECES = 2000
# Alpha below which one sees through, of 255; colour types of PNG that carry alpha.
OPAQUE = 250
WITH_ALPHA = (4, 6)


def enclosed_parts(found: Pieces, clear: Mask) -> tuple[Mask, list[Issue]]:
    """(N,) True for pieces sealed up in others that cannot be seen through, and notes where there are some.

    The inner wall of a room stays, with a note: it says how thick the outer one is. So does all that is glass.

    Args:
        clear: (F,) faces that can be seen through.
    """
    out = np.zeros(found.count, dtype=bool)
    glass = np.zeros(found.count, dtype=bool)
    glass[found.label[clear]] = True
    if found.count == 1 or found.count > MOST_PIECES:
        return out, []
    within = _within_another(found) & ~glass
    rooms = [int(k) for k in np.flatnonzero(within) if _is_room(found, int(k))]
    message = f"{len(rooms)} closed walls inside look inwards: sealed rooms, which collision shapes fill"
    notes = [warning("MSH043", "rooms", message)] if rooms else []
    candidates = [int(k) for k in np.flatnonzero(within) if int(k) not in rooms]
    around = ~glass
    around[candidates] = False
    walls = found.ids[around[found.label]]
    if not candidates or not len(walls):
        return out, notes
    used, local = np.unique(walls, return_inverse=True)
    grid = voxelise(found.points[used], local.reshape(-1, 3), CELLS)
    for piece in candidates:
        out[piece] = _is_sealed(found.points, found.faces(piece), grid)
    if out.any():
        message = f"{int(out.sum())} pieces that are sealed up in others were taken away: nobody sees or touches them"
        notes.append(warning("MSH042", "pieces", message))
    return out, notes


def clear_parts(parts: tuple[RawPart, ...]) -> list[bool]:
    """For each part, True where it can be seen through somewhere."""
    return [_is_clear(part) for part in parts]


def _is_clear(part: RawPart) -> bool:
    picture = part.material.base_color_texture
    # Ref: PNG specification, 11.2.1: the colour type is the tenth byte of the header's data.
    painted = picture is not None and picture.png[25] in WITH_ALPHA
    colors = part.mesh.colors
    tinted = colors is not None and len(colors) > 0 and int(colors[:, 3].min()) < OPAQUE
    return painted or tinted or part.material.base_color[3] * 255 < OPAQUE


def _within_another(found: Pieces) -> Mask:
    """Pieces whose box lies within that of a larger one."""
    out = np.zeros(found.count, dtype=bool)
    for host in np.argsort(-found.size, kind="stable")[: min(found.count, 64)]:
        inner = (found.low[host] < found.low).all(axis=1) & (found.high < found.high[host]).all(axis=1)
        out |= inner
    return out


def _is_room(found: Pieces, piece: int) -> bool:
    """A closed wall that faces inwards."""
    faces = found.faces(piece)
    used, local = np.unique(faces, return_inverse=True)
    return is_closed(faces) and signed_volume(found.points[used], local.reshape(-1, 3)) < 0


def _is_sealed(points: Floats, faces: Ints, grid: Grid) -> bool:
    """All of the piece lies in what the grid encloses, and most of it off its skin."""
    used, local = np.unique(faces, return_inverse=True)
    places = np.concatenate([points[used], surface_samples(points[used], local.reshape(-1, 3), SAMPLES)])
    at = np.round((places - grid.origin) / grid.cell).astype(int)
    if (at < 0).any() or (at >= grid.solid.shape).any():
        return False
    where = tuple(at.T)
    return bool(grid.solid[where].all() and (grid.solid & ~grid.skin)[where].mean() >= WELL_WITHIN)
