"""Convert materials of raw models to display colours (sRGB) and images of bounded size."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image

from casa_assets.core.color import srgb_from_linear_array
from casa_assets.core.typing import Floats
from casa_assets.model.asset.material import Material, Texture
from casa_assets.preview.tonemap import Pixels

_LARGEST_PX = 1024


def opened(texture: Texture) -> Pixels:
    """(H, W, 3) pixels, first row at the top, at most 1024 on a side."""
    with Image.open(io.BytesIO(texture.png)) as source:
        picture = source.convert("RGB")
    picture.thumbnail((_LARGEST_PX, _LARGEST_PX), Image.Resampling.BOX)
    return np.asarray(picture)


def srgb(material: Material) -> Floats:
    """(4,) base colour as a screen shows it, 0..1; alpha no lower than what can be seen."""
    rgb = np.array(material.base_color[:3])
    curve = srgb_from_linear_array(rgb)
    return np.array([*curve, max(material.base_color[3], 0.15)])
