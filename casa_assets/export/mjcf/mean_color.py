"""Asset -> one plain colour for each collider: the mean colour of the visual that it stands for."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from PIL import Image, ImageStat

from casa_assets.core.color import linear_from_srgb_array
from casa_assets.core.typing import Floats
from casa_assets.export.mjcf import number
from casa_assets.export.mjcf.material import linear_to_srgb
from casa_assets.geometry.solid.bounds import shape_bounds
from casa_assets.model.asset.asset import Asset, Collider, Link
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.record import Vec4

# What is seen lies this near to what collides for it, metres.
NEAR = 0.003
# Thickness that a bound has at least, metres, so that the overlap of flat things is not zero.
THIN = 1e-4
# Pictures whose mean is remembered: those of a kitchen.
KEPT = 256
PLAIN: Vec4 = (0.6, 0.6, 0.6, 1.0)


def collider_colors(asset: Asset) -> dict[str, str]:
    """Collider name -> `rgba`, three digits: mean colour of what is seen of its link within its bounds."""
    colors = {item.id: mean_color(item) for item in asset.materials}
    found = {}
    for link in asset.links:
        seen = [_Seen.of(v.mesh, colors[v.material]) for v in link.visuals]
        for item in link.colliders:
            color = _within(item, seen) or _alike(item, seen) or _any(asset, link, colors)
            found[item.name] = number.numbers(round(c, 3) for c in color)
    return found


def mean_color(item: Material) -> Vec4:
    """Display colour and alpha of a material: its colour times the mean of its picture."""
    red, green, blue, alpha = item.base_color
    if item.base_color_texture is not None:
        r, g, b, a = _mean(item.base_color_texture.png)
        red, green, blue, alpha = red * r, green * g, blue * b, alpha * a
    return linear_to_srgb(red), linear_to_srgb(green), linear_to_srgb(blue), alpha


@lru_cache(maxsize=KEPT)
def _mean(png: bytes) -> Vec4:
    """Linear mean of a picture."""
    with Image.open(io.BytesIO(png)) as image:
        # Of a small copy: a mean of display values would be too dark where a picture is rich in contrast.
        small = image.convert("RGBA").resize((32, 32), Image.Resampling.BOX)
    values = np.asarray(small, dtype=np.float64).reshape(-1, 4) / 255
    color = linear_from_srgb_array(values)[:, :3].mean(axis=0)
    red, green, blue = (float(c) for c in color)
    return red, green, blue, float(ImageStat.Stat(small.getchannel("A")).mean[0]) / 255


@dataclass(frozen=True)
class _Seen:
    """A visual: its bounds, and (F, 3) middles and (F,) areas of its triangles."""

    bounds: Floats
    middles: Floats
    areas: Floats
    color: Vec4

    @classmethod
    def of(cls, mesh: Mesh, color: Vec4) -> _Seen:
        corners = mesh.vertices[mesh.faces]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return cls(mesh.bounds, corners.mean(axis=1), np.linalg.norm(cross, axis=1) / 2, color)


def _within(item: Collider, seen: list[_Seen]) -> Vec4 | None:
    """Mean colour of the triangles whose middles lie within the bounds of a collider."""
    lower, upper = shape_bounds(item.shape, item.pose)
    inside = [((s.middles >= lower - NEAR) & (s.middles <= upper + NEAR)).all(axis=1) for s in seen]
    areas = np.array([s.areas[m].sum() for s, m in zip(seen, inside, strict=True)])
    if not seen or areas.sum() <= 0:
        return None
    red, green, blue, alpha = (float(c) for c in areas @ np.array([s.color for s in seen]) / areas.sum())
    return red, green, blue, alpha


def _alike(item: Collider, seen: list[_Seen]) -> Vec4 | None:
    """Colour of the visual whose bounds share most with those of a collider."""
    own = _thick(shape_bounds(item.shape, item.pose))
    shares = [_overlap(own, _thick(s.bounds)) for s in seen]
    best = max(range(len(seen)), key=lambda i: shares[i], default=None)
    return None if best is None or shares[best] <= 0 else seen[best].color


def _any(asset: Asset, link: Link, colors: dict[str, Vec4]) -> Vec4:
    """Colour of the largest visual of the link, of the asset where it has none."""
    visuals = link.visuals or tuple(v for k in asset.links for v in k.visuals)
    best = max(visuals, key=lambda v: float(np.ptp(v.mesh.bounds, axis=0).sum()), default=None)
    return PLAIN if best is None else colors[best.material]


def _thick(bounds: Floats) -> Floats:
    return np.array([bounds[0] - THIN, bounds[1] + THIN])


def _overlap(first: Floats, second: Floats) -> float:
    """Volume that two boxes share over the volume that they fill together, 0..1."""
    common = np.clip(np.minimum(first[1], second[1]) - np.maximum(first[0], second[0]), 0.0, None).prod()
    total = np.ptp(first, axis=0).prod() + np.ptp(second, axis=0).prod() - common
    return float(common / total)
