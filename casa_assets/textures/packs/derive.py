"""Make a picture tile and derive its relief and gloss, which are estimated from its brightness."""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt
from PIL import Image
from scipy import ndimage

from casa_assets.model.record import Record, Vec2
from casa_assets.model.registry.finish import Surface
from casa_assets.textures.canvas import Layers
from casa_assets.textures.packs.rejections import PictureRejection, rejection_error
from casa_assets.textures.seam import jump, repair, seam

SIZE_PX = 1024
# A border whose steps are this many times those inside is seen in a wall of copies. A repaired one has less.
VISIBLE_SEAM = 1.5
_REPAIR_SEAM, _REPAIR_JUMP = 1.0, 1.5
MAX_SEAM = 2.5
# Dark is taken to lie deeper: true of joints, pores and cracks, not of what is painted on. So the relief is kept low.
_RELIEF_M = 0.0006
_GLOSS = {Surface.WALL: 0.75, Surface.FLOOR: 0.45, Surface.COUNTER: 0.25, Surface.CABINET: 0.45}
_UNEVEN = 0.15  # roughness between the palest and the darkest detail

Floats = npt.NDArray[np.float32]


class TiledPicture(Record):
    """A picture made to tile, as it is stored.

    Attributes:
        base: PNG of the colour, (height_px, width_px).
        kept: share of the width and height of the source that it shows.
        seam_before, seam_after: worst border score.
        repaired: whether the border was repaired.
    """

    base: bytes
    width_px: int
    height_px: int
    kept: Vec2
    seam_before: float
    seam_after: float
    repaired: bool


def tile(pixels: Floats, size_px: int = SIZE_PX) -> TiledPicture:
    """Scale down, repair the border where it is seen.

    Args:
        pixels: (H, W, 3) sRGB 0..1.
        size_px: longer side of the result; nothing is scaled up.
    Raises:
        Rejected: the border is still plain to see.
    """
    small = scaled(pixels, size_px)
    before = seam(small).worst
    is_seen = before > _REPAIR_SEAM or jump(small).worst > _REPAIR_JUMP
    whole = repair(small) if is_seen else small
    after = seam(whole).worst
    if after > MAX_SEAM:
        raise rejection_error(
            PictureRejection.SEAM, f"its border is {after:.1f} times as strong as the pattern, after its repair"
        )
    height, width = whole.shape[:2]
    return TiledPicture(
        base=png(whole),
        width_px=width,
        height_px=height,
        kept=(width / small.shape[1], height / small.shape[0]),
        seam_before=round(before, 3),
        seam_after=round(after, 3),
        repaired=is_seen,
    )


def layers(base: Floats, surface: Surface, roughness: float | None) -> Layers:
    """Colour with a derived relief and gloss.

    Args:
        base: (H, W, 3) sRGB 0..1 that tiles.
        surface: sets the gloss where none is given.
        roughness: mean, 0..1, or None.
    """
    light = base @ np.array([0.2126, 0.7152, 0.0722], dtype=np.float32)
    # Broad light and shade is light and shade; only detail can be relief.
    detail = light - ndimage.gaussian_filter(light, min(light.shape) / 24.0, mode="wrap")
    detail = ndimage.gaussian_filter(detail, 0.8, mode="wrap")
    detail = np.clip(detail / max(float(np.abs(detail).max()), 0.08), -1.0, 1.0)
    mean = _GLOSS[surface] if roughness is None else roughness
    return Layers.of(base, _RELIEF_M * detail, mean - _UNEVEN * detail)


def scaled(pixels: Floats, size_px: int) -> Floats:
    """(H, W, 3) scaled down around the border, so that what tiled before does so after; nothing is scaled up.

    Args:
        size_px: longer side of the result.
    """
    height, width = pixels.shape[:2]
    scale = size_px / max(height, width)
    if scale >= 1.0:
        return pixels
    new = (max(1, round(height * scale)), max(1, round(width * scale)))
    rim = int(np.ceil(4.0 / scale))
    padded = np.pad(pixels, ((rim, rim), (rim, rim), (0, 0)), mode="wrap")
    box = (rim, rim, rim + width, rim + height)
    planes = [
        np.asarray(Image.fromarray(padded[..., c]).resize(new[::-1], Image.Resampling.LANCZOS, box=box))
        for c in range(3)
    ]
    return np.asarray(np.clip(np.stack(planes, axis=-1), 0.0, 1.0), dtype=np.float32)


def png(image: Floats) -> bytes:
    """(H, W, 3) 0..1 as PNG, the same bytes every time."""
    out = io.BytesIO()
    Image.fromarray(np.rint(np.clip(image, 0.0, 1.0) * 255.0).astype(np.uint8)).save(out, "PNG", compress_level=6)
    return out.getvalue()


def pixels_of(data: bytes) -> Floats:
    """(H, W, 3) float32 0..1 of a PNG that this package wrote."""
    with Image.open(io.BytesIO(data)) as image:
        return np.asarray(image.convert("RGB"), dtype=np.float32) / np.float32(255.0)
