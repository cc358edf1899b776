"""Encode painted layers as a Finish (PNG files with the size of the tile), and render a swatch of it at true size."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from casa_assets.core.numeric import linear_from_srgb_array, srgb_from_linear_array
from casa_assets.model.asset.material import ColorSpace, Material, Substance, Texture
from casa_assets.model.record import Vec2
from casa_assets.model.registry.rows import Finish
from casa_assets.textures.canvas import Layers, Map
from casa_assets.textures.check import Pictures

Pixels = npt.NDArray[np.uint8]
# Takes 0.4 of the time of Pillow's default, 6, for files that are 7 % larger.
PNG_LEVEL = 4
# A larger picture is compressed with the default instead, so that finishes stay below the limit of check TEX011.
LARGE_PNG, LARGE_PNG_LEVEL = 1_900_000, 6
# Normals and roughness are written at half the size: they hold no finer detail that is seen beside the colour.
DETAIL_SCALE = 2


def finish(name: str, tile_m: Vec2, layers: Layers, substance: Substance) -> Finish:
    """The finish of a picture; tile_m: its width and height, metres."""
    color = np.rint(np.clip(layers.albedo, 0, 1) * 255).astype(np.uint8)
    rough = np.rint(np.clip(halved(layers.roughness), 0, 1) * 255).astype(np.uint8)
    gloss = np.stack([np.full_like(rough, 255), rough, np.full_like(rough, round(255 * layers.metallic))], axis=2)
    textures = (
        encode_texture(f"{name}_color", color, ColorSpace.SRGB),
        encode_texture(f"{name}_normal", normals(halved(layers.height_m), tile_m), ColorSpace.RAW),
        encode_texture(f"{name}_metallic_roughness", gloss, ColorSpace.RAW),
    )
    return textured(name, tile_m, textures, substance)


def textured(name: str, tile_m: Vec2, textures: Sequence[Texture], substance: Substance) -> Finish:
    """The finish of its colour, normals, and metal share and roughness, which are multiplied with 1."""
    base, normal, gloss = textures
    material = Material(
        id=name,
        base_color=(1.0, 1.0, 1.0, 1.0),
        metallic=1.0,
        roughness=1.0,
        base_color_texture=base,
        metallic_roughness_texture=gloss,
        normal_texture=normal,
        tile_m=tile_m,
        substance=substance.id,
    )
    return Finish(id=name, material=material, substance=substance)


def normals(height_m: Map, tile_m: Vec2) -> Pixels:
    """(H, W, 3) tangent-space normals, y up, of a (H, W) relief that repeats; tile_m: width and height, metres."""
    rows, columns = height_m.shape
    dx, dy = tile_m[0] / columns, tile_m[1] / rows
    slope_x = (np.roll(height_m, -1, axis=1) - np.roll(height_m, 1, axis=1)) / (2 * dx)
    slope_y = (np.roll(height_m, 1, axis=0) - np.roll(height_m, -1, axis=0)) / (2 * dy)  # row 0 is above
    vectors = np.stack([-slope_x, -slope_y, np.ones_like(slope_x)], axis=2)
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    return np.rint((vectors * 0.5 + 0.5) * 255).astype(np.uint8)


def halved(image: Map) -> Map:
    """Mean of each block of two by two."""
    h, w = (n - n % DETAIL_SCALE for n in image.shape)
    blocks = image[:h, :w].reshape(h // DETAIL_SCALE, DETAIL_SCALE, w // DETAIL_SCALE, DETAIL_SCALE)
    return np.asarray(blocks.mean(axis=(1, 3)), dtype=np.float32)


def encode_texture(name: str, pixels: Pixels, space: ColorSpace) -> Texture:
    """A (H, W, 3) picture as PNG, the same bytes every time."""
    png = _encoded(pixels, PNG_LEVEL)
    if len(png) > LARGE_PNG:
        png = _encoded(pixels, LARGE_PNG_LEVEL)
    height, width = pixels.shape[:2]
    return Texture(name=name, png=png, width_px=width, height_px=height, color_space=space)


def _encoded(pixels: Pixels, level: int) -> bytes:
    out = io.BytesIO()
    Image.fromarray(pixels, "RGB").save(out, "PNG", compress_level=level)
    return out.getvalue()


Array = npt.NDArray[np.floating[Any]]
_LIGHT = np.array([-0.42, 0.52, 0.74]) / np.linalg.norm([-0.42, 0.52, 0.74])
_AMBIENT = 0.42
_F0 = 0.04  # reflectance of what is no metal, seen head on. Ref: glTF 2.0, appendix B


def swatch(pictures: Pictures, metallic: float, side_m: float, side_px: int) -> Pixels:
    """(side_px, side_px, 3) sRGB picture of the upper left square of a finish, `side_m` wide, repeated if smaller."""
    lit = _lit(pictures, metallic)
    height, width = lit.shape[:2]
    need_x, need_y = round(side_m / pictures.tile_m[0] * width), round(side_m / pictures.tile_m[1] * height)
    tiled = np.tile(lit, (-(-need_y // height), -(-need_x // width), 1))[:need_y, :need_x]
    return np.asarray(Image.fromarray(tiled, "RGB").resize((side_px, side_px), Image.Resampling.LANCZOS))


def _lit(p: Pictures, metallic: float) -> Pixels:
    height, width = p.base.shape[:2]
    normal = _scaled(p.normal, width, height).astype(np.float32) / 127.5 - 1.0
    rough = np.clip(_scaled(p.rough, width, height).astype(np.float32) / 255, 0.08, 1.0)
    linear = linear_from_srgb_array(p.base.astype(np.float32) / 255)
    facing = np.clip(normal @ _LIGHT.astype(np.float32), 0.0, 1.0) / np.float32(_LIGHT[2])
    # The eye moves over the swatch a little, so that a gloss shows as a gleam in one part of it.
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    view = np.stack([0.35 - x / width, y / height - 0.35, np.full_like(x, 1.5)], axis=2)
    view /= np.linalg.norm(view, axis=2, keepdims=True)
    middle = view + _LIGHT.astype(np.float32)
    middle /= np.linalg.norm(middle, axis=2, keepdims=True)
    # GGX lobe. Ref: B. Walter et al., Microfacet Models for Refraction, EGSR 2007.
    alpha = rough**2
    along = np.clip((normal * middle).sum(axis=2), 0.0, 1.0)
    lobe = np.minimum(alpha**2 / (np.pi * (along**2 * (alpha**2 - 1.0) + 1.0) ** 2), 12.0)
    tint = _F0 * (1.0 - metallic) + linear * metallic
    diffuse = linear * (1.0 - 0.75 * metallic) * (_AMBIENT + (1.0 - _AMBIENT) * facing)[..., None]
    color = np.clip(diffuse + 0.55 * tint * lobe[..., None] + 0.15 * metallic * linear, 0.0, 1.0)
    return np.asarray(np.rint(srgb_from_linear_array(color) * 255).astype(np.uint8))


def _scaled(image: Pixels, width: int, height: int) -> Pixels:
    mode = "RGB" if image.ndim == 3 else "L"
    picture = Image.fromarray(np.ascontiguousarray(image), mode)
    return np.asarray(picture.resize((width, height), Image.Resampling.BILINEAR))
