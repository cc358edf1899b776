"""Cut pieces out of slab textures: each piece shows another part of the slab."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from casa_assets.textures.canvas import Canvas, Layers, Map
from casa_assets.textures.laying.pieces import Array, PieceMap


@dataclass(frozen=True)
class Slab:
    """A picture that repeats, and its true width and height in metres."""

    face: Layers
    tile_m: tuple[float, float]


def slab_canvas(canvas: Canvas, tile_m: tuple[float, float]) -> Canvas:
    """A canvas for a slab with pixels as large as those of the surface it is cut for."""
    width, height = (max(8, round(side / canvas.pixel_m)) for side in tile_m)
    return Canvas((height, width), tile_m)


def inlay(
    pieces: PieceMap,
    slabs: tuple[Slab, ...],
    pick: npt.NDArray[np.int64],
    middle_u: Array,
    middle_v: Array,
    mirrored: Array,
) -> Layers:
    """(H, W) face in which every piece shows its own cut.

    Args:
        pieces: the laid surface.
        slabs: what is cut; all of one gloss.
        pick: (N,) number of the slab of each piece.
        middle_u, middle_v: (N,) metres on the slab under the middle of the piece.
        mirrored: (N,) 1 or -1, whether it is turned end for end.
    """
    shape = pieces.owner.shape
    albedo = np.zeros((*shape, 3), dtype=np.float32)
    height, roughness = np.zeros(shape, dtype=np.float32), np.zeros(shape, dtype=np.float32)
    sign = mirrored.astype(np.float32)[pieces.owner]
    u = pieces.u_m * sign + middle_u.astype(np.float32)[pieces.owner]
    v = pieces.v_m * sign + middle_v.astype(np.float32)[pieces.owner]
    chosen = pick[pieces.owner]
    for number, slab in enumerate(slabs):
        here = np.nonzero(chosen == number)
        rows, columns = slab.face.height_m.shape
        at = [v[here] * (rows / slab.tile_m[1]) - 0.5, u[here] * (columns / slab.tile_m[0]) - 0.5]
        for channel in range(3):
            albedo[..., channel][here] = _read(slab.face.albedo[..., channel], at)
        height[here] = _read(slab.face.height_m, at)
        roughness[here] = _read(slab.face.roughness, at)
    return Layers(albedo=albedo, height_m=height, roughness=roughness, metallic=slabs[0].face.metallic)


def _read(image: Map, at: list[Map]) -> Map:
    return np.asarray(ndimage.map_coordinates(image, at, order=1, mode="grid-wrap"), dtype=np.float32)
