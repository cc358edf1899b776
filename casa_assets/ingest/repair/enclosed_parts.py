"""Find components sealed up in others, which nobody sees or touches: the inner structures of generated meshes."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.grid.voxel import Grid, voxelise
from casa_assets.geometry.mesh.measure import signed_volume
from casa_assets.geometry.mesh.topology import is_closed
from casa_assets.geometry.solid.coverage import surface_samples
from casa_assets.ingest.draft import warning
from casa_assets.ingest.repair.components import Components
from casa_assets.model.ingest.source import RawPart
from casa_assets.model.issue import Issue

# Voxels along the longest side; holes smaller than a voxel count as closed. A choice.
CELLS = 96
# Points sampled on a component. All have to lie in filled voxels for it to be sealed up, and this share of them in
# voxels that the surface does not pass through; choices.
SAMPLES = 256
MIN_INNER_SHARE = 0.8
# A mesh of more components is left as it is.
MAX_COMPONENTS = 2000
# Alpha, of 255, from which on a surface is opaque; a choice.
OPAQUE_ALPHA = 250
# Colour types with alpha. Ref: PNG specification, 11.2.1; the colour type is the tenth byte of the header's data.
PNG_TYPES_WITH_ALPHA = (4, 6)
PNG_TYPE_OFFSET = 25


def enclosed_parts(components: Components, see_through: Mask) -> tuple[Mask, list[Issue]]:
    """(N,) True for components sealed up in others that cannot be seen through, and notes where there are some.

    The inner wall of a sealed cavity stays, with a note, since it shows how thick the outer wall is.

    Args:
        see_through: (F,) faces that can be seen through.
    """
    is_sealed = np.zeros(components.count, dtype=bool)
    glass = np.zeros(components.count, dtype=bool)
    glass[components.label[see_through]] = True
    if components.count == 1 or components.count > MAX_COMPONENTS:
        return is_sealed, []
    within = _within_another(components) & ~glass
    cavities = [int(k) for k in np.flatnonzero(within) if _is_cavity_wall(components, int(k))]
    message = f"{len(cavities)} closed walls inside look inwards: sealed rooms, which collision shapes fill"
    notes = [warning("MSH043", "rooms", message)] if cavities else []
    candidates = [int(k) for k in np.flatnonzero(within) if int(k) not in cavities]
    is_wall = ~glass
    is_wall[candidates] = False
    wall_faces = components.faces[is_wall[components.label]]
    if not candidates or not len(wall_faces):
        return is_sealed, notes
    used, local = np.unique(wall_faces, return_inverse=True)
    grid = voxelise(components.points[used], local.reshape(-1, 3), CELLS)
    for component in candidates:
        is_sealed[component] = _is_sealed(*components.surface_of(component), grid)
    if is_sealed.any():
        message = (
            f"{int(is_sealed.sum())} pieces that are sealed up in others were taken away: nobody sees or touches them"
        )
        notes.append(warning("MSH042", "pieces", message))
    return is_sealed, notes


def transparent_parts(parts: tuple[RawPart, ...]) -> list[bool]:
    """For each part, True where it can be seen through somewhere."""
    return [_is_transparent(part) for part in parts]


def _is_transparent(part: RawPart) -> bool:
    picture = part.material.base_color_texture
    painted = picture is not None and picture.png[PNG_TYPE_OFFSET] in PNG_TYPES_WITH_ALPHA
    colors = part.mesh.colors
    tinted = colors is not None and len(colors) > 0 and int(colors[:, 3].min()) < OPAQUE_ALPHA
    return painted or tinted or part.material.base_color[3] * 255 < OPAQUE_ALPHA


def _within_another(components: Components) -> Mask:
    """(N,) components whose box lies within that of a larger one."""
    is_within = np.zeros(components.count, dtype=bool)
    for outer in np.argsort(-components.longest_side, kind="stable")[: min(components.count, 64)]:
        inner = (components.lower[outer] < components.lower).all(axis=1) & (
            components.upper < components.upper[outer]
        ).all(axis=1)
        is_within |= inner
    return is_within


def _is_cavity_wall(components: Components, component: int) -> bool:
    """True for a closed wall that faces inwards."""
    points, faces = components.surface_of(component)
    return is_closed(faces) and signed_volume(points, faces) < 0


def _is_sealed(points: Floats, faces: Ints, grid: Grid) -> bool:
    """True if all of a component lies in filled voxels, and most of it in inner ones."""
    samples = np.concatenate([points, surface_samples(points, faces, SAMPLES)])
    cell = np.round((samples - grid.origin) / grid.cell).astype(int)
    if (cell < 0).any() or (cell >= grid.solid.shape).any():
        return False
    index = tuple(cell.T)
    return bool(grid.solid[index].all() and (grid.solid & ~grid.skin)[index].mean() >= MIN_INNER_SHARE)
