"""Find meshes that are too dark, of one plain grey, or with tiny or blurred pictures (FLT)."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from PIL import Image

from casa_assets.checks.check import Measurement, not_applicable, required_limit
from casa_assets.checks.filters.welded_surface import welded_surface, why_no_surface
from casa_assets.core.color import linear_from_srgb_array, srgb_from_linear_array
from casa_assets.core.typing import Floats, Ints
from casa_assets.model.asset.asset import Asset, Visual
from casa_assets.model.asset.material import Material, Texture

# Weights of red, green and blue in what the eye takes for bright. Ref: ITU-R BT.709.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# From so metallic on a surface shows what is around it, and a grey of its own is no lack of colour.
METALLIC = 0.5
METAL = "it has bare metal on it, whose colour is that of what is around"
# What is seen of a picture shows something from this contrast on, as displayed, 0..1.
DETAIL = 0.05
# Fewer pixels than this along the longest side are a palette of plain colours, and no picture.
PALETTE = 1
# Of so many points it is looked at what colour they have, spread evenly over what is seen.
POINTS = 8000
# The share of what is seen that has to lie on a picture for its sharpness to matter.
PICTURED = 0.2
# Pictures are looked at no larger than this along a side, pixels.
LARGEST = 1024
# What takes this part of a picture to change is a gradient, and meant to be soft.
GRADIENT = 0.3
# Painted here from vertex colours, as sharp as those were.
PAINTED = "painted"


@dataclass(frozen=True)
class ColorSamples:
    """Colours of points spread over what is seen.

    Attributes:
        linear: (N, 3) linear RGB.
        texels: (N,) pixels of the picture to a metre there, 0 where there is none; of those painted here too.
        sharp: (N,) the same over the width in pixels of the sharpest edges of that picture.
    """

    linear: Floats
    texels: Floats
    sharp: Floats


def is_not_too_dark(asset: Asset, limit: float | None) -> Measurement:
    """FLT010: mean luminance of what is seen in white light, 0..1; coal has 0.04."""
    look = _look(asset)
    if look is None or _is_metal(asset):
        return why_no_surface(asset) if look is None else not_applicable(METAL)
    bright = float((look.linear @ LUMINANCE).mean())
    message = f"is black, it gives back {bright:.2%} of the light; set the colours of its materials"
    return Measurement(bright, (("materials", message),) if bright < required_limit(limit) else ())


def is_not_plain_grey(asset: Asset, limit: float | None) -> Measurement:
    """FLT011: largest distance of what is seen from one plain grey, as displayed, 0..1."""
    look = _look(asset)
    if look is None or _is_metal(asset):
        return why_no_surface(asset) if look is None else not_applicable(METAL)
    shown = srgb_from_linear_array(look.linear)
    off = float(np.percentile(np.abs(shown - shown.mean()).max(axis=1), 99))
    message = "has one plain grey all over; bring its materials, or a picture"
    return Measurement(off, (("materials", message),) if off < required_limit(limit) else ())


def textures_are_sharp(asset: Asset, limit: float | None) -> Measurement:
    """FLT012: points of the pictures that can be told apart along the longest side; the median."""
    look, found = _look(asset), welded_surface(asset)
    if look is None or found is None:
        return why_no_surface(asset)
    shows = (look.sharp > 0) & (look.texels * found.longest >= PALETTE)
    if shows.mean() < PICTURED:
        return not_applicable(f"less than {PICTURED:.0%} of what is seen shows a picture with sharp edges in it")
    if float(np.ptp(np.percentile(srgb_from_linear_array(look.linear[shows]) @ LUMINANCE, (2, 98)))) < DETAIL:
        return not_applicable("its pictures are one plain colour where they are seen")
    points = float(np.median(look.sharp[shows])) * found.longest
    texels = float(np.median(look.texels[shows])) * found.longest
    kind = "is blurred" if texels > 2 * points else "is small"
    message = f"its picture {kind}: {points:.0f} points along the longest side can be told apart; bring a sharper one"
    return Measurement(points, (("materials", message),) if points < required_limit(limit) else ())


def _is_metal(asset: Asset) -> bool:
    """True if one of its looks is that of bare metal."""
    return any(m.metallic >= METALLIC for m in asset.materials)


def _look(asset: Asset) -> ColorSamples | None:
    found = welded_surface(asset)
    return None if found is None else _looked_at(asset.root.visuals, asset.materials)


@lru_cache(maxsize=2)
def _looked_at(visuals: tuple[Visual, ...], materials: tuple[Material, ...]) -> ColorSamples:
    """Colours at points spread evenly over the area of the visuals."""
    of = {m.id: m for m in materials}
    total = sum(_areas(v).sum() for v in visuals)
    parts = [_part(v, of[v.material], max(1, round(POINTS * float(_areas(v).sum() / total)))) for v in visuals]
    linear, texels, sharp = (np.concatenate([p[i] for p in parts]) for i in range(3))
    return ColorSamples(linear, texels, sharp)


def _part(visual: Visual, look: Material, count: int) -> tuple[Floats, Floats, Floats]:
    """Linear colours, pixels of the picture to a metre, and those over the width of its edges."""
    base, image, uv = np.array(look.base_color[:3]), look.base_color_texture, visual.mesh.uv
    if image is None or uv is None:
        return np.tile(base, (count, 1)), np.zeros(count), np.zeros(count)
    picture, edge = _pixels(image), _edge_width(image)
    face, weights = _spots(_areas(visual), count)
    shown = _sampled(picture, np.einsum("nk,nkd->nd", weights, uv[visual.mesh.faces[face]]))
    texels = _texels(visual, image)[face]
    # What was painted here has one patch to a triangle, however sharp the vertex colours were.
    soft = edge > GRADIENT * max(image.width_px, image.height_px)
    own = texels if image.name != PAINTED and not soft else np.zeros(count)
    return base * linear_from_srgb_array(shown), texels, own / edge


def _areas(visual: Visual) -> Floats:
    corners = visual.mesh.vertices[visual.mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas: Floats = np.linalg.norm(cross, axis=1) / 2
    return areas


def _spots(areas: Floats, count: int) -> tuple[Ints, Floats]:
    """(N,) faces and (N, 3) weights of their corners, evenly over the area. Ref: the R2 sequence, Roberts 2018."""
    ends = np.cumsum(areas)
    face = np.minimum(np.searchsorted(ends, (np.arange(count) + 0.5) / count * ends[-1]), len(areas) - 1)
    u, v = ((np.arange(1, count + 1)[:, None] * np.array([0.7548776662466927, 0.5698402909980532])) % 1.0).T
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return face.astype(np.int64), np.stack([1 - u - v, u, v], axis=1)


def _texels(visual: Visual, image: Texture) -> Floats:
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
    picture.thumbnail((LARGEST, LARGEST), Image.Resampling.BOX, reducing_gap=None)
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


def _sampled(pixels: Floats, uv: Floats) -> Floats:
    """(N, 3) nearest pixels; pictures repeat, and v goes up."""
    high, wide = pixels.shape[:2]
    column = np.minimum((uv[:, 0] % 1.0 * wide).astype(np.int64), wide - 1)
    row = np.minimum(((1 - uv[:, 1] % 1.0) * high).astype(np.int64), high - 1)
    picked: Floats = pixels[np.maximum(row, 0), column]
    return picked
