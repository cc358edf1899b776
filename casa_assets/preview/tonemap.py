"""Tone-map exposures (fractions of white) to 8-bit pictures, and encode them as PNG."""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt
from PIL import Image
from scipy.ndimage import gaussian_filter

from casa_assets.core.typing import Floats, Mask

Pixels = npt.NDArray[np.uint8]

# Brightness of paper without shadow, how much darker the corners are, and the blur of the paper as a part of the width.
_WHITE = 0.965
_VIGNETTE = 0.045
_BLUR = 0.010


def blur_background(exposure: Floats, paper: Mask) -> Floats:
    """Blur the background within its own outline, which hides the steps between single shadows.

    Args:
        exposure: (H, W, 3) fractions of white.
        paper: (H, W) where nothing but floor is seen.
    """
    sigma_px = _BLUR * exposure.shape[0]
    weight = gaussian_filter(paper.astype(np.float32), sigma_px)
    soft = gaussian_filter((exposure.mean(axis=2) * paper).astype(np.float32), sigma_px) / np.maximum(weight, 1e-6)
    return np.where(paper[..., None], soft[..., None], exposure)


def tone_map(exposure: Floats, paper: Mask) -> Pixels:
    """(H, W, 3) fractions of white to 8 bit: unshadowed background near white, corners a little darker."""
    lit = float(np.percentile(exposure[paper], 98)) if paper.any() else 1.0
    tone = np.clip(exposure * (_WHITE / max(lit, 0.05)), 0.0, 1.0)
    # Black keeps some form: it starts a little above zero.
    tone = 0.02 + 0.98 * tone**0.92
    height, width = tone.shape[:2]
    y, x = np.mgrid[-1.0 : 1.0 : height * 1j, -1.0 : 1.0 : width * 1j]
    tone *= (1.0 - _VIGNETTE * np.clip((x**2 + (y - 0.1) ** 2) / 2.0, 0.0, 1.0) ** 1.5)[..., None]
    return np.asarray(np.clip(np.rint(tone * 255.0), 0, 255), dtype=np.uint8)


def png(pixels: Pixels) -> bytes:
    """(H, W, 3) pixels as PNG, always with the same options."""
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, format="PNG", compress_level=6)
    return out.getvalue()
