"""Find meshes that are too dark, of one plain grey, or with tiny or blurred pictures (FLT)."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from PIL import Image

from casa_assets.checks.check import Measurement, at_least, not_applicable
from casa_assets.checks.filters.surface import welded_surface
from casa_assets.core.numeric import Floats, Ints, linear_from_srgb_array, srgb_from_linear_array
from casa_assets.model.asset.asset import Asset, Visual
from casa_assets.model.asset.material import Material, Texture

# Weights of linear red, green and blue in luminance. Ref: ITU-R BT.709.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# From this metalness on a surface shows what is around it, and a grey of its own is no lack of colour.
MIN_METALNESS = 0.5
IS_METAL = "it has bare metal on it, whose colour is that of what is around"
# Contrast from which on what is seen of a picture counts as a picture, as displayed, 0..1.
MIN_CONTRAST = 0.05
# Fewer pixels than this along the longest side are a palette of plain colours, and no picture.
MIN_PIXELS = 1
# Points at which colours are sampled, spread evenly over the area.
POINTS = 8000
# The share of the points that has to lie on a picture for its sharpness to matter.
MIN_TEXTURED_SHARE = 0.2
# Pictures are reduced to this many pixels along a side before they are looked at.
MAX_PIXELS = 1024
# An edge that takes this part of a picture is a gradient, and meant to be soft.
GRADIENT_SHARE = 0.3
# Name of textures that were painted by `ingest` from vertex colours, and are as sharp as those were.
PAINTED = "painted"


@dataclass(frozen=True)
class ColorSamples:
    """Colours of points spread over the visible surface.

    Attributes:
        linear: (N, 3) linear RGB.
        texels_per_m: (N,) pixels of the picture to a metre there, 0 if there is no picture.
        edges_per_m: (N,) sharpest edges of that picture that fit side by side into a metre; 0 if it has none.
    """

    linear: Floats
    texels_per_m: Floats
    edges_per_m: Floats


def is_not_too_dark(asset: Asset, limit: float) -> Measurement:
    """FLT010: mean luminance of what is seen in white light, 0..1; coal has 0.04."""
    colors = _own_colors(asset)
    if isinstance(colors, Measurement):
        return colors
    luminance = float((colors.linear @ LUMINANCE).mean())
    message = f"is black, it gives back {luminance:.2%} of the light; set the colours of its materials"
    return at_least(luminance, limit, "materials", message)


def is_not_plain_grey(asset: Asset, limit: float) -> Measurement:
    """FLT011: largest distance of what is seen from one plain grey, as displayed, 0..1."""
    colors = _own_colors(asset)
    if isinstance(colors, Measurement):
        return colors
    displayed = srgb_from_linear_array(colors.linear)
    distance = float(np.percentile(np.abs(displayed - displayed.mean()).max(axis=1), 99))
    return at_least(distance, limit, "materials", "has one plain grey all over; bring its materials, or a picture")


def textures_are_sharp(asset: Asset, limit: float) -> Measurement:
    """FLT012: points of the pictures that can be resolved along the longest side; the median."""
    colors, surface = _color_samples(asset), welded_surface(asset)
    if isinstance(colors, Measurement):
        return colors
    assert not isinstance(surface, Measurement), "colours are sampled from the surface"
    textured = (colors.edges_per_m > 0) & (colors.texels_per_m * surface.longest >= MIN_PIXELS)
    if textured.mean() < MIN_TEXTURED_SHARE:
        share = f"less than {MIN_TEXTURED_SHARE:.0%}"
        return not_applicable(f"{share} of what is seen shows a picture with sharp edges in it")
    luminance = srgb_from_linear_array(colors.linear[textured]) @ LUMINANCE
    if float(np.ptp(np.percentile(luminance, (2, 98)))) < MIN_CONTRAST:
        return not_applicable("its pictures are one plain colour where they are seen")
    points = float(np.median(colors.edges_per_m[textured])) * surface.longest
    texels = float(np.median(colors.texels_per_m[textured])) * surface.longest
    fault = "is blurred" if texels > 2 * points else "is small"
    message = f"its picture {fault}: {points:.0f} points along the longest side can be told apart; bring a sharper one"
    return at_least(points, limit, "materials", message)


def _own_colors(asset: Asset) -> ColorSamples | Measurement:
    """As `_color_samples`, if none of the materials is bare metal."""
    colors = _color_samples(asset)
    if not isinstance(colors, Measurement) and any(m.metallic >= MIN_METALNESS for m in asset.materials):
        return not_applicable(IS_METAL)
    return colors


def _color_samples(asset: Asset) -> ColorSamples | Measurement:
    """Colours of a loose mesh, or the result of a filter that has none to look at."""
    surface = welded_surface(asset)
    return surface if isinstance(surface, Measurement) else _sample_colors(asset.root.visuals, asset.materials)


@lru_cache(maxsize=2)
def _sample_colors(visuals: tuple[Visual, ...], materials: tuple[Material, ...]) -> ColorSamples:
    """Colours at points spread evenly over the area of the visuals."""
    by_id = {m.id: m for m in materials}
    areas = [float(_areas(v).sum()) for v in visuals]
    counts = [max(1, round(POINTS * area / sum(areas))) for area in areas]
    parts = [_sample_visual(v, by_id[v.material], n) for v, n in zip(visuals, counts, strict=True)]
    return ColorSamples(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _sample_visual(visual: Visual, material: Material, count: int) -> tuple[Floats, Floats, Floats]:
    """Columns of `ColorSamples` at points of one visual."""
    base, image, uv = np.array(material.base_color[:3]), material.base_color_texture, visual.mesh.uv
    if image is None or uv is None:
        return np.tile(base, (count, 1)), np.zeros(count), np.zeros(count)
    pixels, edge_px = _pixels(image), _edge_width(image)
    face, weights = _points_on_faces(_areas(visual), count)
    at = np.einsum("nk,nkd->nd", weights, uv[visual.mesh.faces[face]])
    # The nearest pixels: pictures repeat, and v goes up.
    high, wide = pixels.shape[:2]
    column = np.minimum((at[:, 0] % 1.0 * wide).astype(np.int64), wide - 1)
    row = np.minimum(((1 - at[:, 1] % 1.0) * high).astype(np.int64), high - 1)
    displayed = pixels[np.maximum(row, 0), column]
    texels_per_m = _texels_per_m(visual, image)[face]
    is_gradient = edge_px > GRADIENT_SHARE * max(image.width_px, image.height_px)
    # What was painted by `ingest` has one patch to a triangle, however sharp the vertex colours were.
    edges_per_m = np.zeros(count) if image.name == PAINTED or is_gradient else texels_per_m / edge_px
    return base * linear_from_srgb_array(displayed), texels_per_m, edges_per_m


def _areas(visual: Visual) -> Floats:
    corners = visual.mesh.vertices[visual.mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas: Floats = np.linalg.norm(cross, axis=1) / 2
    return areas


def _points_on_faces(areas: Floats, count: int) -> tuple[Ints, Floats]:
    """(N,) faces and (N, 3) barycentric weights of points spread evenly. Ref: the R2 sequence, Roberts 2018."""
    ends = np.cumsum(areas)
    face = np.minimum(np.searchsorted(ends, (np.arange(count) + 0.5) / count * ends[-1]), len(areas) - 1)
    u, v = ((np.arange(1, count + 1)[:, None] * np.array([0.7548776662466927, 0.5698402909980532])) % 1.0).T
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return face.astype(np.int64), np.stack([1 - u - v, u, v], axis=1)


def _texels_per_m(visual: Visual, image: Texture) -> Floats:
    """(F,) pixels of the picture to a metre on each face."""
    assert visual.mesh.uv is not None
    corners = visual.mesh.uv[visual.mesh.faces]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2 * image.width_px * image.height_px
    texels: Floats = np.sqrt(across / np.maximum(_areas(visual), 1e-300))
    return texels


@lru_cache(maxsize=8)
def _pixels(image: Texture) -> Floats:
    """(H, W, 3) as displayed, 0..1, no larger than is worth looking at."""
    with Image.open(io.BytesIO(image.png)) as opened:
        picture = opened.convert("RGB")
    picture.thumbnail((MAX_PIXELS, MAX_PIXELS), Image.Resampling.BOX, reducing_gap=None)
    pixels: Floats = np.asarray(picture, dtype=np.float64) / 255
    return pixels


@lru_cache(maxsize=8)
def _edge_width(image: Texture) -> float:
    """Pixels of the file that the sharpest edges of a picture take, its contrast over its steepest slope; 1 or more."""
    grey = _pixels(image) @ LUMINANCE
    if min(grey.shape) < 2:
        return 1.0
    slope = np.concatenate([np.abs(np.diff(grey, axis=0)).ravel(), np.abs(np.diff(grey, axis=1)).ravel()])
    contrast, steep = float(np.ptp(np.percentile(grey, (1, 99)))), float(np.percentile(slope, 99.8))
    file_px = max(image.width_px, image.height_px) / max(grey.shape)
    return max(1.0, contrast / steep * file_px) if contrast > 0 and steep > 0 else 1.0
