"""Numbers -> PNG: painted textures, the same bytes on every machine."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Rgb = tuple[float, float, float]

LETTERS = {
    "O": ("01110", "10001", "10001", "10001", "10001", "10001", "01110"),
    "A": ("01110", "10001", "10001", "11111", "10001", "10001", "10001"),
    "T": ("11111", "00100", "00100", "00100", "00100", "00100", "00100"),
    "S": ("01111", "10000", "10000", "01110", "00001", "00001", "11110"),
    "V": ("10001", "10001", "10001", "10001", "10001", "01010", "00100"),
    "I": ("11111", "00100", "00100", "00100", "00100", "00100", "11111"),
    "N": ("10001", "11001", "10101", "10101", "10011", "10001", "10001"),
}


def canvas(width_px: int, height_px: int) -> tuple[Array, Array]:
    """u and v of every pixel centre, each (height_px, width_px); v is 1 at the top row."""
    u = (np.arange(width_px) + 0.5) / width_px
    v = 1.0 - (np.arange(height_px) + 0.5) / height_px
    return np.broadcast_to(u, (height_px, width_px)).copy(), np.broadcast_to(v[:, None], (height_px, width_px)).copy()


def noise(u: Array, v: Array, cells: tuple[int, int], seed: int) -> Array:
    """Smooth value noise in 0..1 that repeats over u; `cells` is how many lumps there are along u and v."""
    x, y = u * cells[0], v * cells[1]
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    s, t = x - i, y - j
    s, t = s * s * (3 - 2 * s), t * t * (3 - 2 * t)
    low = _hash(i % cells[0], j, seed) * (1 - s) + _hash((i + 1) % cells[0], j, seed) * s
    high = _hash(i % cells[0], j + 1, seed) * (1 - s) + _hash((i + 1) % cells[0], j + 1, seed) * s
    return low * (1 - t) + high * t


def ramp(t: Array, *colors: Rgb) -> Array:
    """Colours blended along t in 0..1: (..., 3)."""
    stops = np.linspace(0.0, 1.0, len(colors))
    table = np.array(colors)
    return np.stack([np.interp(t, stops, table[:, channel]) for channel in range(3)], axis=-1)


def over(picture: Array, mask: npt.NDArray[Any], color: Rgb | Array) -> Array:
    """The picture with a colour, or another picture, laid over it where the mask (0..1 or bool) says."""
    cover = mask[..., None].astype(np.float64)
    return picture * (1 - cover) + np.asarray(color) * cover


def word(u: Array, v: Array, text: str, box: tuple[float, float, float, float]) -> Array:
    """Mask of a word in blocky letters inside box (u0, v0, u1, v1)."""
    rows = ["0".join(LETTERS[letter][row] for letter in text) for row in range(7)]
    bits = np.array([[float(bit) for bit in row] for row in rows])
    u0, v0, u1, v1 = box
    column = np.floor((u - u0) / (u1 - u0) * bits.shape[1]).astype(np.int64)
    row = np.floor((v1 - v) / (v1 - v0) * 7).astype(np.int64)
    inside = (column >= 0) & (column < bits.shape[1]) & (row >= 0) & (row < 7)
    return np.where(inside, bits[row.clip(0, 6), column.clip(0, bits.shape[1] - 1)], 0.0)


def cereal_front() -> Array:
    """(H, W, 3) front of a cereal box: a word, a bowl and what falls into it."""
    u, v = canvas(208, 312)
    rays = np.floor(np.arctan2(v - 0.34, (u - 0.5) * 0.66) / np.pi * 12) % 2
    picture = over(ramp(v, (0.95, 0.55, 0.10), (0.98, 0.78, 0.22)), 0.35 * rays, (1.0, 0.93, 0.60))
    picture = over(picture, ((v > 0.66) & (v < 0.95)), (0.78, 0.10, 0.10))
    picture = over(picture, word(u, v, "OATS", (0.10, 0.70, 0.90, 0.91)), (1.0, 0.97, 0.90))
    x, y = (u - 0.5) * 0.66, v - 0.33
    picture = over(picture, ((x**2 + (y * 1.1) ** 2 < 0.064) & (y < 0)), (0.16, 0.36, 0.66))
    picture = over(picture, ((x / 0.253) ** 2 + (y / 0.055) ** 2 < 1), (0.97, 0.96, 0.92))
    for n in range(14):
        cx, cy = 0.19 * np.sin(2.4 * n), 0.02 * np.cos(3.1 * n) + (0.05 + 0.02 * n if n > 8 else 0.0)
        ring = np.hypot(x - cx * (0.5 if n > 8 else 1.0), y - cy)
        picture = over(picture, ((ring < 0.030) & (ring > 0.011)), (0.80, 0.56 + 0.01 * n, 0.24))
    return picture


def png(picture: Array) -> bytes:
    """A palette PNG of an (H, W, 3) picture, 0..1 sRGB.

    Nothing in it is compressed: compressors differ from machine to machine, and the samples are compared byte for byte.
    """
    for step in (1, 2, 4, 8, 16, 32):
        pixels = (np.round(picture.clip(0, 1) * 255 / step) * step).clip(0, 255).astype(np.uint8)
        colors, index = np.unique(pixels.reshape(-1, 3), axis=0, return_inverse=True)
        if len(colors) <= 256:
            break
    height, width = picture.shape[:2]
    rows = np.concatenate([np.zeros((height, 1)), index.reshape(height, width)], axis=1).astype(np.uint8)
    return (
        b"\x89PNG\r\n\x1a\n"
        + _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0))
        + _chunk(b"PLTE", colors.tobytes())
        + _chunk(b"IDAT", _stored(rows.tobytes()))
        + _chunk(b"IEND", b"")
    )


def _hash(i: npt.NDArray[np.int64], j: npt.NDArray[np.int64], seed: int) -> Array:
    # Ref: the finaliser of MurmurHash3, in 32 bits.
    h = (i * 73856093 ^ j * 19349663 ^ seed * 83492791) & 0xFFFFFFFF
    h = ((h ^ (h >> 16)) * 0x85EBCA6B) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 0xC2B2AE35) & 0xFFFFFFFF
    return ((h ^ (h >> 16)) & 0xFFFFFF) / float(0xFFFFFF)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _stored(data: bytes) -> bytes:
    blocks = [data[start : start + 65535] for start in range(0, len(data), 65535)]
    body = b"".join(
        struct.pack("<BHH", n == len(blocks) - 1, len(block), len(block) ^ 0xFFFF) + block
        for n, block in enumerate(blocks)
    )
    return b"\x78\x01" + body + struct.pack(">I", zlib.adler32(data))
