"""Appearance of primitives that stand for visuals: a plain colour, or the material that they show most."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageStat

from casa_assets.core.numeric import Floats, Ints, Mask, linear_from_srgb_array, srgb_from_linear
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.model.asset.asset import Asset, Collider
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Box, Mesh, Shape, Visual
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec4

MAX_GAP_M = 0.003  # a triangle belongs to a collider if its centroid is at most this far outside of its bounds
PADDING_M = 1e-4  # added to bounds on all sides, so that the overlap of flat things is not zero
CACHED_PICTURES = 256  # mean colours to keep: as many as a kitchen has pictures
NO_COLOR: Vec4 = (0.6, 0.6, 0.6, 1.0)  # of an asset without visuals


def collider_colors(asset: Asset) -> dict[str, Vec4]:
    """Collider name -> sRGB colour and alpha, 0..1: of the visuals of its link within its bounds."""
    colors = {material.id: mean_color(material) for material in asset.materials}
    found = {}
    for link in asset.links:
        visuals = [_ColoredVisual.of(v.mesh, colors[v.material]) for v in link.visuals]
        # Where nothing overlaps: the largest visual of the link, or of the asset where the link has none.
        others = link.visuals or tuple(v for k in asset.links for v in k.visuals)
        largest = max(others, key=lambda v: float(np.ptp(v.mesh.bounds, axis=0).sum()), default=None)
        spare = NO_COLOR if largest is None else colors[largest.material]
        for collider in link.colliders:
            found[collider.name] = _mean_within(collider, visuals) or _best_overlap(collider, visuals) or spare
    return found


def mean_color(material: Material) -> Vec4:
    """SRGB colour and alpha of a material: its colour times the mean of its picture."""
    red, green, blue, alpha = material.base_color
    if material.base_color_texture is not None:
        r, g, b, a = _picture_mean(material.base_color_texture.png)
        red, green, blue, alpha = red * r, green * g, blue * b, alpha * a
    return srgb_from_linear(red), srgb_from_linear(green), srgb_from_linear(blue), alpha


@lru_cache(maxsize=CACHED_PICTURES)
def _picture_mean(png: bytes) -> Vec4:
    """Linear mean colour and alpha of a picture."""
    with Image.open(io.BytesIO(png)) as image:
        small = image.convert("RGBA").resize((32, 32), Image.Resampling.BOX)
    # Averaged as linear light: a mean of display values would be too dark where contrast is high.
    values = np.asarray(small, dtype=np.float64).reshape(-1, 4) / 255
    red, green, blue = (float(c) for c in linear_from_srgb_array(values)[:, :3].mean(axis=0))
    return red, green, blue, float(ImageStat.Stat(small.getchannel("A")).mean[0]) / 255


@dataclass(frozen=True)
class _ColoredVisual:
    """A visual: its bounds, (F, 3) centroids and (F,) areas of its triangles, and its colour."""

    bounds: Floats
    centroids: Floats
    areas: Floats
    color: Vec4

    @classmethod
    def of(cls, mesh: Mesh, color: Vec4) -> _ColoredVisual:
        """Take a mesh in the frame of its link, one color for all of it."""
        corners = mesh.vertices[mesh.faces]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return cls(mesh.bounds, corners.mean(axis=1), np.linalg.norm(cross, axis=1) / 2, color)


def _mean_within(collider: Collider, visuals: list[_ColoredVisual]) -> Vec4 | None:
    """Mean colour, by area, of the triangles whose centroids lie within the bounds of a collider."""
    lower, upper = shape_bounds(collider.shape, collider.pose)
    inside = [((v.centroids >= lower - MAX_GAP_M) & (v.centroids <= upper + MAX_GAP_M)).all(axis=1) for v in visuals]
    areas = np.array([v.areas[mask].sum() for v, mask in zip(visuals, inside, strict=True)])
    if not visuals or areas.sum() <= 0:
        return None
    red, green, blue, alpha = (float(c) for c in areas @ np.array([v.color for v in visuals]) / areas.sum())
    return red, green, blue, alpha


def _best_overlap(collider: Collider, visuals: list[_ColoredVisual]) -> Vec4 | None:
    """Colour of the visual whose bounds overlap most with those of a collider: intersection over union."""
    padding = np.array([[-PADDING_M], [PADDING_M]])
    own = shape_bounds(collider.shape, collider.pose) + padding
    overlaps = []
    for visual in visuals:
        bounds = visual.bounds + padding
        common = np.clip(np.minimum(own[1], bounds[1]) - np.maximum(own[0], bounds[0]), 0.0, None).prod()
        overlaps.append(float(common / (np.ptp(own, axis=0).prod() + np.ptp(bounds, axis=0).prod() - common)))
    best = max(range(len(visuals)), key=lambda i: overlaps[i], default=None)
    return None if best is None or overlaps[best] <= 0 else visuals[best].color


# A visual is shown where it is at most so far, m, outside of a primitive or below a face: boxes fill gaps of 12 mm.
OUTSIDE_M, INSIDE_M = 0.012, 0.025
# The normals of what a face shows are within 25 degrees of its own.
FACING = 0.9
# Where visuals cover less than this share of its largest face, a primitive shows none of them.
LEAST_SHARE = 0.1
# How much surfaces count: those outside of a thing (in a room, inside of it), the other ones, those behind other
# primitives, and those behind the outermost layer, since panels are drawn as several.
OUTER, INNER, HIDDEN, LOWER = 1.0, 0.3, 0.02, 0.1
# The outermost layer begins where this share of a side is covered, and is as thick as this, metres.
LAYER_SHARE, LAYER_M = 0.2, 0.001
# Where so much of what is shown can be seen through, no one material stands for it.
CLEAR_SHARE = 0.2
# A side of a box is open where at most half of nine points so far in front of it lie in other primitives, metres.
AHEAD_M = 0.02


class Shown(NamedTuple):
    """The material that the outside of a primitive shows.

    material: that covers most of it. turn: (3, 3) of a box with a picture that repeats: columns are the width and the
    height of the picture and the normal of the side that shows most of it, in the axes of the box. None for all else.
    """

    material: Material
    turn: Floats | None


@dataclass(frozen=True)
class ShownMaterials:
    """Triangles of visuals in one frame.

    materials: of all of them. number: (F,) index into `materials`. corners: (F, 3, 3) metres. centroids, normals: (F,
    3). areas: (F,) m^2. weights: (F,) how much each counts, OUTER or INNER. uv: (F, 3, 2) texture coordinates of the
    corners, not a number where a mesh has none.
    """

    materials: tuple[Material, ...]
    number: Ints
    corners: Floats
    centroids: Floats
    normals: Floats
    areas: Floats
    weights: Floats
    uv: Floats

    @classmethod
    def of(
        cls, visuals: Iterable[tuple[Visual, Pose]], materials: Iterable[Material], middle: Floats, is_room: bool
    ) -> ShownMaterials:
        """Those of some visuals, each with the pose that takes its mesh into the common frame.

        `middle`: (3,) of the thing that they belong to, or of the room. `is_room`: they are seen from there.
        """
        known = {material.id: material for material in materials}
        order = {name: number for number, name in enumerate(known)}
        numbers, corners, uv = [np.empty(0, dtype=np.int64)], [np.empty((0, 3, 3))], [np.empty((0, 3, 2))]
        for visual, pose in visuals:
            mesh = visual.mesh
            numbers.append(np.full(len(mesh.faces), order[visual.material]))
            corners.append(pose.apply(mesh.vertices)[mesh.faces])
            uv.append(np.full((len(mesh.faces), 3, 2), np.nan) if mesh.uv is None else mesh.uv[mesh.faces])
        points = np.concatenate(corners)
        cross = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
        double = np.linalg.norm(cross, axis=1)
        normals, centroids = cross / np.maximum(double, 1e-12)[:, None], points.mean(axis=1)
        weights = np.where(((normals * (centroids - middle)).sum(axis=1) > 0) != is_room, OUTER, INNER)
        number = np.concatenate(numbers)
        return cls(tuple(known.values()), number, points, centroids, normals, double / 2, weights, np.concatenate(uv))

    def on(self, shape: Shape, pose: Pose, open_sides: Mask) -> Shown | None:
        """Return the material that a primitive, posed in the frame of the triangles, shows.

        None if visuals cover next to nothing of it, or if they are a frame with panes of glass. `open_sides`: (6,) of a
        box, below and above along each axis: True if nothing is right in front of them.
        """
        lower, upper = shape_bounds(shape, pose)
        near = ((self.centroids >= lower - OUTSIDE_M) & (self.centroids <= upper + OUTSIDE_M)).all(axis=1)
        near &= self.areas > 0
        if not near.any():
            return None
        corner = shape_bounds(shape, Pose())
        half = (corner[1] - corner[0]) / 2
        local = (self.centroids[near] - np.array(pose.position)) @ pose.rotation
        normals = self.normals[near] @ pose.rotation
        if isinstance(shape, Box):
            sides = _sides(local, normals, self.areas[near], half)
        else:
            sides = ((normals * local).sum(axis=1) > 0)[:, None].astype(np.float64)
        areas, number = self.areas[near], self.number[near]
        faces = np.array([half[1] * half[2], half[0] * half[2], half[0] * half[1]]) * 4
        seen = areas * (sides > 0).any(axis=1)
        if seen.sum() < LEAST_SHARE * faces.max():
            return None
        is_clear = np.array([material.base_color[3] < 1 for material in self.materials])[number]
        if CLEAR_SHARE < seen[is_clear].sum() / seen.sum() < 1:
            return None
        if isinstance(shape, Box):
            sides = sides * np.where(open_sides, 1.0, HIDDEN)
        areas = areas * self.weights[near]
        # Rounded: of two that are equal the last bit must not decide, which differs between processors.
        covered = np.array([np.bincount(number, areas * side, len(self.materials)) for side in sides.T]).round(9)
        best = int(covered.sum(axis=0).argmax())
        material = self.materials[best]
        if not isinstance(shape, Box) or material.base_color_texture is None or material.tile_m is None:
            return Shown(material, None)
        # Of two sides that show as much, the upper one is seen more often.
        side = 5 - int(covered[::-1, best].argmax())
        return Shown(material, self._turn(np.flatnonzero(near)[(sides[:, side] > 0) & (number == best)], pose, side))

    def _turn(self, triangles: Ints, pose: Pose, side: int) -> Floats | None:
        """How a picture lies on a side of a box, by the texture coordinates of what it shows; None without any."""
        triangles = triangles[np.isfinite(self.uv[triangles]).all(axis=(1, 2))]
        if not len(triangles):
            return None
        corners, uv = self.corners[triangles] @ pose.rotation, self.uv[triangles]
        axis = side // 2
        plane = [other for other in range(3) if other != axis]
        edges = (corners[:, 1:] - corners[:, :1])[:, :, plane]
        flat = np.abs(np.linalg.det(edges)) > 1e-12
        if not flat.any():
            return None
        # Change of both coordinates along both directions of the side, the mean by area.
        slopes = np.linalg.solve(edges[flat], (uv[:, 1:] - uv[:, :1])[flat])
        slope = np.average(slopes, axis=0, weights=self.areas[triangles][flat])
        along = int(np.abs(slope[:, 0]).argmax())
        turn = np.zeros((3, 3))
        turn[plane[along], 0] = 1.0 if slope[along, 0] >= 0 else -1.0
        turn[plane[1 - along], 1] = 1.0 if slope[1 - along, 1] >= 0 else -1.0
        turn[:, 2] = np.cross(turn[:, 0], turn[:, 1])
        return turn


def _sides(local: Floats, normals: Floats, areas: Floats, half: Floats) -> Floats:
    """(N, 6) how much of each triangle each side of a box shows: those of each axis below, then above."""
    found = np.zeros((len(local), 6))
    for side in range(6):
        axis, sign = side // 2, 1.0 if side % 2 else -1.0
        depth = half[axis] - local[:, axis] * sign
        on_side = np.flatnonzero((normals[:, axis] * sign > FACING) & (depth < min(INSIDE_M, half[axis])))
        order = on_side[np.argsort(depth[on_side])]
        begin = int(np.searchsorted(areas[order].cumsum(), LAYER_SHARE * (4 * float(np.prod(half)) / half[axis])))
        if begin < len(order):
            found[order, side] = np.where(depth[order] <= depth[order[begin]] + LAYER_M, 1.0, LOWER)
        else:
            found[order, side] = 1.0
    return found


def open_sides(primitives: Sequence[tuple[Shape, Pose]]) -> Mask:
    """(N, 6) True for sides of primitives, below and above along each own axis, without another primitive in front."""
    corners = np.array([shape_bounds(shape, Pose()) for shape, _ in primitives])
    half = (corners[:, 1] - corners[:, 0]) / 2
    rotation = np.array([pose.rotation for _, pose in primitives])
    position = np.array([pose.position for _, pose in primitives])
    found = np.empty((len(primitives), 6), dtype=bool)
    grid = np.stack(np.meshgrid(*[(-0.7, 0.0, 0.7)] * 2), axis=-1).reshape(-1, 2)
    for side in range(6):
        axis, sign = side // 2, 1.0 if side % 2 else -1.0
        points = np.empty((len(primitives), len(grid), 3))
        points[:, :, axis] = sign * (half[:, axis] + AHEAD_M)[:, None]
        for place, other in enumerate(number for number in range(3) if number != axis):
            points[:, :, other] = half[:, other, None] * grid[:, place]
        points = points @ rotation.transpose(0, 2, 1) + position[:, None]
        covered = np.zeros(points.shape[:2], dtype=bool)
        for center, turn, size in zip(position, rotation, half, strict=True):
            covered |= (np.abs((points - center) @ turn) <= size).all(axis=2)
        found[:, side] = covered.mean(axis=1) <= 0.5
    return found
