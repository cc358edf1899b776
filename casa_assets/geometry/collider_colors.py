"""One plain colour for each collider of an asset: the mean colour of the visuals that the collider covers."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from PIL import Image, ImageStat

from casa_assets.core.color import linear_from_srgb_array, srgb_from_linear
from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.bounds import shape_bounds
from casa_assets.model.asset.asset import Asset, Collider, Link
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.mesh import Mesh
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
        for collider in link.colliders:
            found[collider.name] = (
                _mean_within(collider, visuals)
                or _best_overlap(collider, visuals)
                or _largest_visual(asset, link, colors)
            )
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
    """Colour of the visual whose bounds overlap most with those of a collider."""
    own = _padded(shape_bounds(collider.shape, collider.pose))
    overlaps = [_overlap(own, _padded(v.bounds)) for v in visuals]
    best = max(range(len(visuals)), key=lambda i: overlaps[i], default=None)
    return None if best is None or overlaps[best] <= 0 else visuals[best].color


def _largest_visual(asset: Asset, link: Link, colors: dict[str, Vec4]) -> Vec4:
    """Colour of the largest visual of the link, of the asset where the link has none."""
    visuals = link.visuals or tuple(v for k in asset.links for v in k.visuals)
    largest = max(visuals, key=lambda v: float(np.ptp(v.mesh.bounds, axis=0).sum()), default=None)
    return NO_COLOR if largest is None else colors[largest.material]


def _padded(bounds: Floats) -> Floats:
    return np.array([bounds[0] - PADDING_M, bounds[1] + PADDING_M])


def _overlap(first: Floats, second: Floats) -> float:
    """Intersection over union of two boxes, 0..1."""
    common = np.clip(np.minimum(first[1], second[1]) - np.maximum(first[0], second[0]), 0.0, None).prod()
    total = np.ptp(first, axis=0).prod() + np.ptp(second, axis=0).prod() - common
    return float(common / total)
