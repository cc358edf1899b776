"""Decode an image file to pixels, after its format and size were checked in the header."""

from __future__ import annotations

import io
import struct
import warnings
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageOps, UnidentifiedImageError

from casa_assets.textures.packs.limits import MAX_ASPECT, MAX_SIDE_PX, MIN_SIDE_PX
from casa_assets.textures.packs.maps import MapRole
from casa_assets.textures.packs.rejections import PictureRejection, rejection_error

FORMATS = ("PNG", "JPEG", "WEBP", "TIFF")
# In groups: of two files of one map that in the earlier group is read.
SUFFIX_GROUPS = ((".png", ".jpg", ".jpeg", ".webp"), (".tif", ".tiff"))
SUFFIXES = tuple(suffix for group in SUFFIX_GROUPS for suffix in group)
_OPAQUE = 250  # of 255: some encoders write 254 for opaque
_BLANK = 1.5  # of 255: deviation of the noise that encoders add to one colour
_SIGNED = -0.05  # a normal below this is a number from -1 to 1, not one from 0 to 1
_METRES = 0.1  # heights of floats that stay below this are metres, not shares of the relief
_TILE_SIDES = (322, 323)  # Ref: TIFF 6.0, tags TileWidth and TileLength
_FAULTS = (OSError, SyntaxError, ValueError, TypeError, IndexError, KeyError, OverflowError, EOFError, struct.error)

Floats = npt.NDArray[np.float32]


@dataclass(frozen=True)
class DecodedPicture:
    """A picture.

    Attributes:
        pixels: (H, W, 3) float32 sRGB 0..1, upright.
        prompt: what its generator wrote into the file, or nothing.
        notes: conversions that were made.
    """

    pixels: Floats
    prompt: str
    notes: tuple[str, ...]


def decode(data: bytes) -> DecodedPicture:
    """The picture in these bytes.

    Raises:
        Rejected: it is not a picture, is broken, has a wrong size, is transparent, or shows a single colour.
    """
    found = _decoded(data)
    if float(np.abs(found.pixels - found.pixels.mean(axis=(0, 1))).mean()) * 255.0 < _BLANK / 2.0:
        raise rejection_error(PictureRejection.BLANK, "shows one colour")
    return found


def decode_map(data: bytes, role: MapRole) -> Floats:
    """(H, W, 3) 0..1 of a map of normals, roughness and so on; it may be one colour all over. Raises as `decode`.

    Files of floats may hold normals from -1 to 1 and heights in metres: both are mapped to 0..1. The depth of a relief
    made from heights is set separately, so their unit does not matter.
    """
    pixels = _decoded(data).pixels
    low, high = float(pixels.min()), float(pixels.max())
    if role is MapRole.NORMAL and low < _SIGNED:
        pixels = pixels * 0.5 + 0.5
    elif role is MapRole.HEIGHT and (low < 0.0 or high > 1.0 or high < _METRES) and high > low:
        pixels = (pixels - low) / (high - low)
    return np.clip(pixels, 0.0, 1.0).astype(np.float32)


def _decoded(data: bytes) -> DecodedPicture:
    """The picture as its file has it, floats in any range. Raises Rejected."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of metadata and of sizes, which are checked here
            image = Image.open(io.BytesIO(data), formats=FORMATS)
            _check_size(image.width, image.height)
            _check_tiff(image)
            prompt = _prompt(image)
            image.load()
            upright = ImageOps.exif_transpose(image)
            pixels, notes = _rgb(upright if upright is not None else image, image.format or "")
    except (UnidentifiedImageError, Image.DecompressionBombError) as error:
        large = isinstance(error, Image.DecompressionBombError)
        fault = PictureRejection.TOO_LARGE if large else PictureRejection.NOT_A_PICTURE
        raise rejection_error(fault, "is far too large" if large else _unknown(data)) from None
    except (*_FAULTS, zlib.error) as error:
        raise rejection_error(
            PictureRejection.BROKEN, f"cannot be decoded: {type(error).__name__}: {str(error)[:120]}"
        ) from None
    return DecodedPicture(pixels, prompt, notes)


def _unknown(data: bytes) -> str:
    """Why Pillow does not know a file."""
    if data[:4] in (b"II*\0", b"MM\0*"):
        return "is a TIFF file of a kind that is not read, such as one with three floats a pixel"
    return f"is no {', '.join(FORMATS)} file"


def _check_tiff(image: Image.Image) -> None:
    """Raise Rejected for a TIFF whose numbers are not read, or whose tiles are larger than a picture may be."""
    if image.format != "TIFF":
        return
    tags: Mapping[int, Any] = getattr(image, "tag_v2", {})
    if max(int(tags.get(side, 0)) for side in _TILE_SIDES) > MAX_SIDE_PX:
        raise rejection_error(PictureRejection.TOO_LARGE, f"has tiles of over {MAX_SIDE_PX} pixels a side")
    if image.mode == "I":  # 32 bits, or numbers below 0
        raise rejection_error(PictureRejection.NOT_A_PICTURE, "is a TIFF file of integers that are not of 8 or 16 bits")


def _check_size(width: int, height: int) -> None:
    size = f"{width} x {height} pixels"
    if max(width, height) > MAX_SIDE_PX:
        raise rejection_error(PictureRejection.TOO_LARGE, f"{size}, over {MAX_SIDE_PX} a side")
    if min(width, height) < MIN_SIDE_PX:
        raise rejection_error(PictureRejection.TOO_SMALL, f"{size}, under {MIN_SIDE_PX} a side")
    if max(width, height) > MAX_ASPECT * min(width, height):
        raise rejection_error(PictureRejection.TOO_LONG, f"{size}, longer than {MAX_ASPECT:g} times its width")


def _check_opaque(alpha: npt.NDArray[Any]) -> None:
    """Raise Rejected where a picture can be seen through. alpha: 0..255."""
    if float(alpha.min()) < _OPAQUE:
        raise rejection_error(PictureRejection.TRANSPARENT, f"{np.mean(alpha < _OPAQUE):.1%} of it can be seen through")


def _rgb(image: Image.Image, kind: str) -> tuple[Floats, tuple[str, ...]]:
    """Pixels of a picture that Pillow has loaded, and what was converted.

    Args:
        kind: format of the file.
    """
    notes = []
    mode = image.mode
    if mode in ("RGBA", "LA", "PA") or "transparency" in image.info:
        _check_opaque(np.asarray(image.convert("RGBA"))[..., 3])
    if mode.startswith("I") or mode == "F":
        raw = np.asarray(image, dtype=np.float32)
        if not np.isfinite(raw).all():
            raise rejection_error(PictureRejection.BROKEN, "holds values that are no numbers")
        grey = raw if mode == "F" else raw / np.float32(65535.0)  # a grey PNG of 16 bits has mode I;16 or I
        words = "floats" if mode == "F" else "16 bits"
        return np.repeat(grey[..., None], 3, axis=2), (f"grey of {words} in a {kind} file was read as such",)
    if mode != "RGB":
        notes.append(f"was converted from {mode} to RGB")
    return np.asarray(image.convert("RGB"), dtype=np.float32) / np.float32(255.0), tuple(notes)


def _prompt(image: Image.Image) -> str:
    """Prompt that image generators write into a text chunk of a PNG."""
    for key in ("parameters", "prompt", "Description"):
        if isinstance(said := image.info.get(key), str):
            return " ".join(said.split())[:2000]
    return ""
