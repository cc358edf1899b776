"""A map of pieces: outlines become pixels, with joints and edges between them, cut out of slabs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from pydantic import Field
from scipy import ndimage

from casa_assets.model.record import Record
from casa_assets.model.registry.rows import HexColor
from casa_assets.textures.canvas import Canvas, Layers, Map, Share, blend, rgb

Array = npt.NDArray[np.floating[Any]]
# (u, v) in metres from the middle of the piece -> metres to its nearest edge, positive inside.
Outline = Callable[[Array, Array], Array]
_MARGIN_M = 0.004  # joints are looked up a little beyond the outline


@dataclass(frozen=True)
class PlacedOutline:
    """One piece."""

    x: float  # of its middle from the upper left corner, m
    y: float  # m, down
    turn: float  # from the picture's axes to its own, rad, clockwise as seen; v runs along the piece, u across
    half_u: float  # half of its box, m
    half_v: float
    outline: Outline
    sort: int = 0  # of its shape or orientation, for colours that depend on it


@dataclass(frozen=True)
class PieceMap:
    """The laid surface."""

    owner: npt.NDArray[np.int32]  # (H, W) int32, number of the piece
    inside_m: Map  # (H, W) float32, to the nearest edge of the piece; below 0 between pieces
    u_m: Map  # (H, W) float32, from the middle of the piece across it
    v_m: Map  # (H, W) float32, along it
    turn: Array  # (N,) of each piece
    sort: npt.NDArray[np.int64]  # (N,)
    half_m: Array  # (N, 2) half of its box across and along

    @property
    def count(self) -> int:
        """Number of pieces."""
        return len(self.turn)

    def read(self, values: npt.NDArray[Any]) -> Map:
        """(H, W) float32: at each pixel the value of its piece, of (N,)."""
        return values.astype(np.float32)[self.owner]


def raster(places: Sequence[PlacedOutline], canvas: Canvas) -> PieceMap:
    """Draw all places; where two overlap, a pixel goes to the piece in which it lies deeper."""
    owner = np.zeros(canvas.size_px, dtype=np.int32)
    best = np.full(canvas.size_px, -1.0, dtype=np.float32)
    us, vs = np.zeros_like(best), np.zeros_like(best)
    for number, place in enumerate(places):
        rows, columns, dx, dy = window(place, canvas)
        cos, sin = np.float32(np.cos(place.turn)), np.float32(np.sin(place.turn))
        u, v = cos * dx + sin * dy, cos * dy - sin * dx
        inside = place.outline(u, v)
        at = np.ix_(rows, columns)
        deeper = inside > best[at]
        for target, fresh in ((best, inside), (us, u), (vs, v)):
            target[at] = np.where(deeper, fresh, target[at])
        owner[at] = np.where(deeper, number, owner[at])
    return PieceMap(
        owner=owner,
        inside_m=best,
        u_m=us,
        v_m=vs,
        turn=np.array([p.turn for p in places]),
        sort=np.array([p.sort for p in places], dtype=np.int64),
        half_m=np.array([(p.half_u, p.half_v) for p in places]),
    )


def window(place: PlacedOutline, canvas: Canvas) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], Map, Map]:
    """Rows and columns (wrapped) around a piece, and their distances from its middle: (1, w) and (h, 1)."""
    cos, sin = abs(np.cos(place.turn)), abs(np.sin(place.turn))
    reach_x = place.half_u * cos + place.half_v * sin + _MARGIN_M
    reach_y = place.half_u * sin + place.half_v * cos + _MARGIN_M
    (height, width), (wide, tall) = canvas.size_px, canvas.tile_m

    def span(middle: float, reach: float, size: int, length: float) -> tuple[npt.NDArray[np.int64], Map]:
        pixel = length / size
        first = int(np.floor((middle - reach) / pixel - 0.5))
        last = int(np.ceil((middle + reach) / pixel - 0.5))
        if last - first >= size:  # a piece as long as the picture: once around, with its ends on the border
            first, last = int(np.ceil(middle / pixel - size / 2 - 0.5)), int(np.ceil(middle / pixel + size / 2 - 1.5))
        numbers = np.arange(first, last + 1)
        return numbers % size, ((numbers + 0.5) * pixel - middle).astype(np.float32)

    columns, dx = span(place.x, reach_x, width, wide)
    rows, dy = span(place.y, reach_y, height, tall)
    return rows, columns, dx[None, :], dy[:, None]


def box(half_u: float, half_v: float) -> Outline:
    """A rectangle."""
    return lambda u, v: np.minimum(np.float32(half_u) - np.abs(u), np.float32(half_v) - np.abs(v))


def disc(radius: float) -> Outline:
    """A circle."""
    return lambda u, v: np.float32(radius) - np.hypot(u, v)


def polygon(corners: Sequence[tuple[float, float]]) -> Outline:
    """A convex polygon of (u, v) corners in metres, in either order."""
    points = np.array(corners, dtype=np.float64)
    ahead = np.roll(points, -1, axis=0) - points
    normal = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) / np.linalg.norm(ahead, axis=1)[:, None]
    normal = normal * np.sign(((points.mean(axis=0) - points) * normal).sum(axis=1))[:, None]
    offset = (normal * points).sum(axis=1)

    def inside(u: Array, v: Array) -> Array:
        gap = np.float32(normal[0, 0]) * u + np.float32(normal[0, 1]) * v - np.float32(offset[0])
        for (a, b), c in zip(normal[1:], offset[1:], strict=True):
            gap = np.minimum(gap, np.float32(a) * u + np.float32(b) * v - np.float32(c))
        return gap

    return inside


def whole(length_m: float, module_m: float, even: bool = False) -> tuple[int, float]:
    """Number of whole modules in a length, and their true size in metres.

    Raises ValueError: the length is not a whole number of modules, so that pieces would be stretched by over 2 %.
    """
    step = 2 if even else 1
    count = max(step, step * round(length_m / module_m / step))
    true = length_m / count
    if abs(true / module_m - 1.0) > 0.02:
        fits = f"{count * module_m:.4f}"
        raise ValueError(f"{length_m:g} m holds no whole number of modules of {module_m:.4f} m; {fits} m would")
    return count, true


# Rim of a piece: SQUARE, broken by half a millimetre; BEVEL a straight slope; PILLOW a dome that falls off to it.
TileEdge = StrEnum("TileEdge", "SQUARE BEVEL PILLOW")


class Joint(Record):
    """Joint between pieces."""

    color: HexColor = Field("#b8b2a6", description="of the grout or mortar")
    width_m: float = Field(0.003, ge=0, le=0.03, description="0 where pieces touch")
    depth_m: float = Field(0.001, ge=0, le=0.02, description="how far it lies below the rim of the pieces")
    roughness: Annotated[float, Field(ge=0.1, le=1)] = 0.88
    edge: TileEdge = Field(TileEdge.SQUARE, description="profile of the pieces")
    edge_width_m: float = Field(0.001, ge=0.0002, le=0.05, description="of the profile")
    rim_drop_m: float = Field(0.0004, ge=0, le=0.01, description="how deep the profile falls")
    rim_noise_m: float = Field(0.0, ge=0, le=0.02, description="how far the rim of a piece strays from its outline")
    coarseness: Share = Field(0.3, description="how coarse the filling is")


def rim(joint: Joint, pieces: PieceMap, canvas: Canvas, rng: np.random.Generator) -> Map:
    """(H, W) metres from the rim of the piece, positive on it, with the strayings of hand-made pieces."""
    inside = pieces.inside_m - np.float32(joint.width_m / 2)
    if joint.rim_noise_m > 0:
        stray = 0.7 * canvas.noise(0.03, 0.03, rng, 2) + 0.5 * canvas.noise(0.008, 0.008, rng, 2)
        inside = inside - np.float32(0.5 * joint.rim_noise_m) * np.maximum(stray, -0.6)
    return np.asarray(inside, dtype=np.float32)


def gap(joint: Joint, rim_m: Map, canvas: Canvas) -> Map:
    """(H, W) 0..1, share of a pixel that the joint covers; thin joints of coarse pictures fade, they do not widen."""
    pixel, half = np.float32(canvas.pixel_m), np.float32(joint.width_m / 2)
    to_middle = np.maximum(rim_m + half, 0.0)
    covered = np.clip((half - to_middle) / pixel + 0.5, 0, 1) - np.clip((-half - to_middle) / pixel + 0.5, 0, 1)
    return np.asarray(np.where(rim_m + half < -0.5 * pixel, 1.0, covered), dtype=np.float32)


def profile(joint: Joint, rim_m: Map) -> Map:
    """(H, W) metres, 0 in the middle of a piece and -drop_m at its rim."""
    t = np.clip(rim_m / np.float32(joint.edge_width_m), 0.0, None)
    if joint.edge is TileEdge.BEVEL:
        rise = np.minimum(t, 1.0)
    elif joint.edge is TileEdge.PILLOW:
        rise = 1.0 - np.exp(-2.5 * t)
    else:
        rise = np.sqrt(np.clip(1.0 - (1.0 - np.minimum(t, 1.0)) ** 2, 0.0, 1.0))
    return np.asarray((rise - 1.0) * joint.rim_drop_m, dtype=np.float32)


def fill(face: Layers, joint: Joint, rim_m: Map, canvas: Canvas, rng: np.random.Generator) -> Layers:
    """The pieces with rims worked and joints filled; `face`: how the pieces look everywhere; `rim_m`: of `rim`."""
    share = gap(joint, rim_m, canvas)
    sand = canvas.resolved(0.003, 0.003) * canvas.noise(0.003, 0.003, rng) + 0.5 * canvas.noise(0.012, 0.012, rng, 3)
    shade = 1.0 + joint.coarseness * 0.06 * sand + 0.03 * canvas.noise(0.3, 0.3, rng, 3)
    mortar = rgb(joint.color) * shade[..., None]
    height = face.height_m + profile(joint, rim_m)
    return Layers.of(
        blend(face.albedo, mortar, share),
        height + ((-joint.rim_drop_m - joint.depth_m + 0.0004 * joint.coarseness * sand) - height) * share,
        face.roughness + (joint.roughness - face.roughness) * share,
        face.metallic,
    )


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

    `slabs`: what is cut. `pick`: (N,) of them. `middle_u`, `middle_v`: (N,) m on a slab. `mirrored`: (N,) 1 or -1.
    """
    shape = pieces.owner.shape
    albedo = np.zeros((*shape, 3), dtype=np.float32)
    height, roughness = np.zeros((2, *shape), dtype=np.float32)
    sign = pieces.read(mirrored)
    u = pieces.u_m * sign + pieces.read(middle_u)
    v = pieces.v_m * sign + pieces.read(middle_v)
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
