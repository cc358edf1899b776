"""Pictures of surfaces for tests of texture packs, made from seeds."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from casa_assets.core.sampling import rng_for
from casa_assets.textures import noise

Pixels = npt.NDArray[np.uint8]


def pixels(seed: int = 1, width: int = 520, height: int = 520, color: tuple[int, int, int] = (150, 120, 90)) -> Pixels:
    """A stone-like picture that does not tile: a cut from a larger one. (H, W, 3)."""
    return _colored(_tone(seed, width + 100, height + 100)[:height, :width], color)


def tiling(seed: int = 1, size_px: int = 512, color: tuple[int, int, int] = (150, 120, 90)) -> Pixels:
    """A stone-like picture that tiles. (H, W, 3)."""
    return _colored(_tone(seed, size_px, size_px), color)


def relief(seed: int = 1, size_px: int = 512) -> npt.NDArray[np.float32]:
    """(H, W) heights of mean 0 that tile."""
    return _tone(seed, size_px, size_px).astype(np.float32)


def encoded(image: npt.NDArray[np.generic], kind: str = "PNG") -> bytes:
    """The bytes of a file with the picture."""
    out = io.BytesIO()
    Image.fromarray(image).save(out, kind)
    return out.getvalue()


def write_pictures(folder: Path, count: int, name: str = "stone") -> Path:
    """Pictures that tile, each in another colour: `<name> 00.png` and so on."""
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(count):
        color = tuple(int(v) for v in rng_for(number, name).uniform(70, 200, 3))
        (folder / f"{name} {number:02d}.png").write_bytes(encoded(tiling(number, color=(color[0], color[1], color[2]))))
    return folder


def _tone(seed: int, width: int, height: int) -> npt.NDArray[np.floating]:
    return np.asarray(noise.fbm((height, width), (9, 9), rng_for(seed, "stone"), 5))


def _colored(tone: npt.NDArray[np.floating], color: tuple[int, int, int]) -> Pixels:
    return np.asarray(np.clip(np.array(color) * (1.0 + 0.5 * tone[..., None]), 0, 255), dtype=np.uint8)
