"""Tone-map exposures (fractions of white) to 8-bit pictures, and encode them as PNG."""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt
from PIL import Image

from casa_assets.core.typing import Floats, Mask

Pixels = npt.NDArray[np.uint8]

# Brightness of the background where no shadow falls, how much darker the corners are, and the standard deviation of
# the background's blur as a part of the width. Chosen by eye.
_BACKGROUND_WHITE = 0.965
_VIGNETTE = 0.045
_BLUR_SHARE = 0.010


def blur_background(exposure: Floats, background: Mask) -> Floats:
    """Blur the background within its own outline, which hides the steps between single shadows.

    Args:
        exposure: (H, W, 3) fractions of white.
        background: (H, W) where nothing but floor is seen.
    """
    from scipy.ndimage import gaussian_filter  # here, since SciPy loads slowly and contact sheets need only `png`

    sigma_px = _BLUR_SHARE * exposure.shape[0]
    weight = gaussian_filter(background.astype(np.float32), sigma_px)
    soft = gaussian_filter((exposure.mean(axis=2) * background).astype(np.float32), sigma_px) / np.maximum(weight, 1e-6)
    return np.where(background[..., None], soft[..., None], exposure)


def tone_map(exposure: Floats, background: Mask) -> Pixels:
    """(H, W, 3) fractions of white to 8 bit: unshadowed background near white, corners a little darker."""
    lit = float(np.percentile(exposure[background], 98)) if background.any() else 1.0
    tone = np.clip(exposure * (_BACKGROUND_WHITE / max(lit, 0.05)), 0.0, 1.0)
    # Black keeps some form: it starts a little above zero.
    tone = 0.02 + 0.98 * tone**0.92
    height, width = tone.shape[:2]
    y, x = np.mgrid[-1.0 : 1.0 : height * 1j, -1.0 : 1.0 : width * 1j]
    tone *= (1.0 - _VIGNETTE * np.clip((x**2 + (y - 0.1) ** 2) / 2.0, 0.0, 1.0) ** 1.5)[..., None]
    return to_uint8(tone)


def to_uint8(values: Floats) -> Pixels:
    """Values in 0..1, any shape, as 8-bit numbers; what lies outside is clipped."""
    return np.asarray(np.clip(np.rint(values * 255.0), 0, 255), dtype=np.uint8)


def png(pixels: Pixels) -> bytes:
    """(H, W, 3) pixels as PNG, always with the same options."""
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, format="PNG", compress_level=6)
    return out.getvalue()
