"""Pictures of surfaces for tests of textures, made from seeds, and what is measured of pictures."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from casa_assets.core.numeric import rng_for
from casa_assets.kitchenware.textures.kinds import KINDS
from casa_assets.textures.canvas import Canvas, Layers, fbm

Pixels = npt.NDArray[np.uint8]
CANVAS = Canvas((240, 240), (0.6, 0.6))


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
    out = io.BytesIO()
    Image.fromarray(image).save(out, kind)
    return out.getvalue()


def deep_png(image: npt.NDArray[np.uint16]) -> bytes:
    """The bytes of a PNG of 16 bits. image: (H, W) or (H, W, 3)."""
    height, width = image.shape[:2]
    rows = image.astype(">u2").reshape(height, -1)
    packed = zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows), 1)
    head = struct.pack(">IIBBBBB", width, height, 16, 0 if image.ndim == 2 else 2, 0, 0, 0)
    parts = ((b"IHDR", head), (b"IDAT", packed), (b"IEND", b""))
    chunks = (struct.pack(">I", len(d)) + n + d + struct.pack(">I", zlib.crc32(n + d)) for n, d in parts)
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def tiff(image: npt.NDArray[np.generic], **tile: int) -> bytes:
    """The bytes of a TIFF that is not packed, with numbers of any kind.

    Args:
        image: (H, W) or (H, W, 3). tile: width and height of tiles, which the header claims and the file has not.
    """
    (height, width), samples = image.shape[:2], 1 if image.ndim == 2 else 3
    data, kind = image.tobytes(), {"u": 1, "i": 2, "f": 3}[image.dtype.kind]
    short, long, bits = (3, "<H"), (4, "<I"), image.dtype.itemsize * 8
    tags = [(256, long, [width]), (257, long, [height]), (258, short, [bits] * samples), (259, short, [1])]
    tags += [(262, short, [1 if samples == 1 else 2]), (273, long, [8]), (277, short, [samples])]
    tags += [(278, long, [height]), (279, long, [len(data)])]
    tags += [(code, long, [tile[side]]) for code, side in ((322, "width"), (323, "height")) if side in tile]
    tags += [(339, short, [kind] * samples)]
    start = 8 + len(data)
    rows, behind = b"", b""
    for number, (code, form), values in tags:
        packed = b"".join(struct.pack(form, value) for value in values)
        if len(packed) > 4:
            at = start + 2 + 12 * len(tags) + 4 + len(behind)
            packed, behind = struct.pack("<I", at), behind + packed
        rows += struct.pack("<HHI", number, code, len(values)) + packed.ljust(4, b"\0")
    return b"II*\0" + struct.pack("<I", start) + data + struct.pack("<H", len(tags)) + rows + bytes(4) + behind


def write_pictures(folder: Path, count: int, name: str = "stone") -> Path:
    """Pictures that tile, each in another colour: `<name> 00.png` and so on."""
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(count):
        color = tuple(int(v) for v in rng_for(number, name).uniform(70, 200, 3))
        (folder / f"{name} {number:02d}.png").write_bytes(encoded(tiling(number, color=(color[0], color[1], color[2]))))
    return folder


def painted(params: Any, lane: str, canvas: Canvas = CANVAS, seed: int = 1) -> Layers:
    paint = next(kind.paint for kind in KINDS.values() if kind.params is type(params))
    return paint(params, canvas, rng_for(seed, lane))


def runs(row: npt.NDArray[np.floating]) -> int:
    """How often a row that repeats rises over its middle."""
    middle = (row.max() + row.min()) / 2
    return int(np.sum((row < middle) & (np.roll(row, -1) >= middle)))


def steps(image: npt.NDArray[np.floating]) -> tuple[float, float]:
    """Mean step of a picture across and along its height."""
    return float(np.abs(np.diff(image, axis=1)).mean()), float(np.abs(np.diff(image, axis=0)).mean())


def _tone(seed: int, width: int, height: int) -> npt.NDArray[np.floating]:
    return np.asarray(fbm((height, width), (9, 9), rng_for(seed, "stone"), 5))


def _colored(tone: npt.NDArray[np.floating], color: tuple[int, int, int]) -> Pixels:
    return np.asarray(np.clip(np.array(color) * (1.0 + 0.5 * tone[..., None]), 0, 255), dtype=np.uint8)
