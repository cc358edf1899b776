"""Render a swatch of a finish at true size, lit from the upper left so that relief and gloss are seen."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from casa_assets.core.color import linear_from_srgb_array, srgb_from_linear_array
from casa_assets.textures.check import Pictures, Pixels

Array = npt.NDArray[np.floating[Any]]
_LIGHT = np.array([-0.42, 0.52, 0.74]) / np.linalg.norm([-0.42, 0.52, 0.74])
_AMBIENT = 0.42
_F0 = 0.04  # reflectance of what is no metal, seen head on. Ref: glTF 2.0, appendix B


def swatch(pictures: Pictures, metallic: float, side_m: float = 1.0, side_px: int = 192) -> Pixels:
    """(side_px, side_px, 3) uint8 sRGB picture of the upper left square of a finish, repeated where it is smaller.

    Args:
        pictures: of the finish. metallic: 0..1.
        side_m: of the cut in metres. side_px: of the result.
    """
    lit = _lit(pictures, metallic)
    height, width = lit.shape[:2]
    need_x, need_y = round(side_m / pictures.tile_m[0] * width), round(side_m / pictures.tile_m[1] * height)
    tiled = np.tile(lit, (-(-need_y // height), -(-need_x // width), 1))[:need_y, :need_x]
    small = Image.fromarray(tiled, "RGB").resize((side_px, side_px), Image.Resampling.LANCZOS)
    return np.asarray(small)


def _lit(p: Pictures, metallic: float) -> Pixels:
    height, width = p.base.shape[:2]
    normal = _scaled(p.normal, width, height).astype(np.float32) / 127.5 - 1.0
    rough = np.clip(_scaled(p.rough, width, height).astype(np.float32) / 255, 0.08, 1.0)
    base = p.base.astype(np.float32) / 255
    linear = linear_from_srgb_array(base)
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
    shown = srgb_from_linear_array(color)
    pixels: Pixels = np.rint(shown * 255).astype(np.uint8)
    return pixels


def _scaled(image: Pixels, width: int, height: int) -> Pixels:
    mode = "RGB" if image.ndim == 3 else "L"
    return np.asarray(
        Image.fromarray(np.ascontiguousarray(image), mode).resize((width, height), Image.Resampling.BILINEAR)
    )
