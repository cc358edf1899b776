"""Find open niches: the place for a cup in a coffee machine, and the slots of a toaster."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from casa_assets.articulate.plan import round_mm, round_mm_vec3
from casa_assets.articulate.segment.fragments import FRONT, SIDES, TOP
from casa_assets.articulate.segment.orthographic import DepthImage, render_depth
from casa_assets.core.numeric import Floats, Mask
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.parts import Box
from casa_assets.model.pose import Pose

PIXELS = 192
# Height that a cup needs, and depth of its niche as a share of the machine.
MIN_CUP_HEIGHT_M, MIN_NICHE_DEPTH_SHARE = 0.055, 0.15
# Depth of a slot as a share of the height, its width, and its length to width.
MIN_SLOT_DEPTH_SHARE, SLOT_WIDTH_M, MIN_SLOT_RATIO = 0.2, (0.015, 0.06), 2.0


@dataclass(frozen=True)
class Niche:
    """A free box that is open to one side; metres, asset frame."""

    lower: tuple[float, float, float]
    upper: tuple[float, float, float]

    @property
    def middle(self) -> Floats:
        """Return its (3,) middle, metres."""
        return np.asarray((np.array(self.lower) + np.array(self.upper)) / 2)

    @property
    def size(self) -> Floats:
        """Return its (3,) size, metres."""
        return np.asarray(np.array(self.upper) - np.array(self.lower))


def find_cup_niche(asset: Asset) -> Niche | None:
    """Return the niche under the spout of a coffee machine, open to its front, or None; a cup goes on its floor.

    A machine without a drip tray pours onto the surface that it is placed on.
    """
    points, faces = _body(asset)
    image = render_depth(points, faces, SIDES[FRONT], PIXELS)
    deep = float(np.ptp(points[:, 1]))
    back = np.where(np.isfinite(image.depth), image.depth, deep)
    inner = back >= MIN_NICHE_DEPTH_SHARE * deep
    # What is open above is no place under something.
    under = inner & _above(~inner)
    floored = under & np.flip(_above(np.flip(~inner, 0)), 0)
    best = _largest(floored, image) or _largest(under, image)
    return None if best is None else _box(image, points, back, best)


def _largest(places: Mask, image: DepthImage) -> tuple[int, int, int, int] | None:
    """Return the rows and columns of the largest region that a cup fits into."""
    best: tuple[float, int, int, int, int] | None = None
    label, _ = ndimage.label(places)
    for number, place in enumerate(ndimage.find_objects(label), start=1):
        mask = label[place] == number
        a, b = place[0].start, place[0].stop
        c, d = place[1].start, place[1].stop
        tall, wide = (b - a) * image.pixel, (d - c) * image.pixel
        if tall < MIN_CUP_HEIGHT_M or wide < MIN_CUP_HEIGHT_M or mask.mean() < 0.6:
            continue
        size = float(mask.sum())
        if best is None or size > best[0]:
            best = (size, a, b, c, d)
    return None if best is None else best[1:]


def find_toaster_slots(asset: Asset) -> list[Niche]:
    """Return long narrow niches that are open above, sorted from the left, or from the front where they lie across."""
    points, faces = _body(asset)
    image = render_depth(points, faces, SIDES[TOP], PIXELS)
    lower, upper = points.min(axis=0), points.max(axis=0)
    tall = float(upper[2] - lower[2])
    deep = np.isfinite(image.depth) & (image.depth >= MIN_SLOT_DEPTH_SHARE * tall)
    label, _ = ndimage.label(deep)
    out = []
    for number, place in enumerate(ndimage.find_objects(label), start=1):
        mask = label[place] == number
        a, b = place[0].start, place[0].stop
        c, d = place[1].start, place[1].stop
        sides = sorted(((b - a) * image.pixel, (d - c) * image.pixel))
        edge = c == 0 or a == 0 or d == deep.shape[1] or b == deep.shape[0]
        if (
            edge
            or not SLOT_WIDTH_M[0] <= sides[0] <= SLOT_WIDTH_M[1]
            or sides[1] < MIN_SLOT_RATIO * sides[0]
            or mask.mean() < 0.8
        ):
            continue
        floor = float(upper[2]) - float(np.median(image.depth[place][mask]))
        # Row 0 is the far side.
        y1, y0 = (float(image.lower[1]) + (deep.shape[0] - r) * image.pixel for r in (a, b))
        x0, x1 = (float(image.lower[0]) + k * image.pixel for k in (c, d))
        px = image.pixel
        out.append(Niche(round_mm_vec3((x0 + px, y0 + px, floor)), round_mm_vec3((x1 - px, y1 - px, upper[2]))))
    along = bool(out) and float(out[0].size[1]) >= float(out[0].size[0])
    return sorted(out, key=lambda h: h.lower[0] if along else h.lower[1])


def niche_floor(niche: Niche, thick: float = 0.003) -> tuple[Box, Pose]:
    """Return a thin board whose top is the floor of a niche."""
    x, y, _ = (float(v) for v in niche.size)
    at = niche.middle
    return Box(size=(round_mm(x), round_mm(y), thick)), Pose(
        position=round_mm_vec3((at[0], at[1], niche.lower[2] - thick / 2))
    )


def _above(solid: Mask) -> Mask:
    """Mark pixels with something solid anywhere above in the same column."""
    return np.maximum.accumulate(solid, axis=0)


def _box(image: DepthImage, points: Floats, back: Floats, span: tuple[int, int, int, int]) -> Niche:
    """Return the niche at a range of pixels."""
    a, b, c, d = span
    rows = back.shape[0]
    front = float(points[:, 1].min())
    x0, x1 = (float(image.lower[0]) + k * image.pixel for k in (c, d))
    z1, z0 = (float(image.lower[1]) + (rows - r) * image.pixel for r in (a, b))
    far = front + float(np.median(back[a:b, c:d]))
    # It begins where what stands under it does.
    near = front + float(np.median(back[b + 1, c:d])) if b + 1 < rows else front
    return Niche(round_mm_vec3((x0, min(near, far - 0.02), z0)), round_mm_vec3((x1, far, z1)))


def _body(asset: Asset) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Return (P, 3) points and (F, 3) faces of the visible body, metres."""
    meshes = [v.mesh for v in asset.root.visuals]
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes[:-1])])
    faces = [np.asarray(m.faces, dtype=np.int64) + s for m, s in zip(meshes, starts, strict=True)]
    return np.concatenate([m.vertices for m in meshes]), np.concatenate(faces)
