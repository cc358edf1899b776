"""Decode an image file to pixels, after its format and size were checked in the header."""

from __future__ import annotations

import io
import struct
import warnings
import zlib
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageOps, UnidentifiedImageError

from casa_assets.textures.packs.limits import MAX_ASPECT, MAX_SIDE_PX, MIN_SIDE_PX
from casa_assets.textures.packs.rejections import PictureRejection, rejection_error

FORMATS = ("PNG", "JPEG", "WEBP")
SUFFIXES = (".png", ".jpg", ".jpeg", ".webp")
_OPAQUE = 250  # of 255: some encoders write 254 for opaque
_BLANK = 1.5  # of 255: deviation of the noise that encoders add to one colour
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
        Rejected: it is none, is broken, has a wrong size, can be seen through, or shows one colour.
    """
    found = _decoded(data)
    if float(np.abs(found.pixels - found.pixels.mean(axis=(0, 1))).mean()) * 255.0 < _BLANK / 2.0:
        raise rejection_error(PictureRejection.BLANK, "shows one colour")
    return found


def decode_map(data: bytes) -> Floats:
    """(H, W, 3) 0..1 of a map of normals, roughness and so on; it may be one colour all over. Raises as `decode`."""
    return _decoded(data).pixels


def _decoded(data: bytes) -> DecodedPicture:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of metadata and of sizes, which are checked here
            image = Image.open(io.BytesIO(data), formats=FORMATS)
            _check_size(image.width, image.height)
            prompt = _prompt(image)
            image.load()
            upright = ImageOps.exif_transpose(image)
            pixels, notes = _rgb(upright if upright is not None else image)
    except (UnidentifiedImageError, Image.DecompressionBombError) as error:
        large = isinstance(error, Image.DecompressionBombError)
        fault = PictureRejection.TOO_LARGE if large else PictureRejection.NOT_A_PICTURE
        raise rejection_error(fault, "is far too large" if large else f"is no {', '.join(FORMATS)} file") from None
    except (*_FAULTS, zlib.error) as error:
        raise rejection_error(
            PictureRejection.BROKEN, f"cannot be decoded: {type(error).__name__}: {str(error)[:120]}"
        ) from None
    return DecodedPicture(pixels, prompt, notes)


def _check_size(width: int, height: int) -> None:
    size = f"{width} x {height} pixels"
    if max(width, height) > MAX_SIDE_PX:
        raise rejection_error(PictureRejection.TOO_LARGE, f"{size}, over {MAX_SIDE_PX} a side")
    if min(width, height) < MIN_SIDE_PX:
        raise rejection_error(PictureRejection.TOO_SMALL, f"{size}, under {MIN_SIDE_PX} a side")
    if max(width, height) > MAX_ASPECT * min(width, height):
        raise rejection_error(PictureRejection.TOO_LONG, f"{size}, longer than {MAX_ASPECT:g} times its width")


def _rgb(image: Image.Image) -> tuple[Floats, tuple[str, ...]]:
    notes = []
    mode = image.mode
    if mode in ("RGBA", "LA", "PA") or "transparency" in image.info:
        alpha = np.asarray(image.convert("RGBA"))[..., 3]
        if int(alpha.min()) < _OPAQUE:
            raise rejection_error(
                PictureRejection.TRANSPARENT, f"{np.mean(alpha < _OPAQUE):.1%} of it can be seen through"
            )
    if mode.startswith("I") or mode == "F":
        raw = np.asarray(image, dtype=np.float32)
        grey = raw / (65535.0 if raw.max() > 255 else 255.0)
        return np.repeat(grey[..., None], 3, axis=2), (f"grey of mode {mode} was read as 16 bit",)
    if mode != "RGB":
        notes.append(f"was converted from {mode} to RGB")
    return np.asarray(image.convert("RGB"), dtype=np.float32) / np.float32(255.0), tuple(notes)


def _prompt(image: Image.Image) -> str:
    """Prompt that image generators write into a text chunk of a PNG."""
    for key in ("parameters", "prompt", "Description"):
        if isinstance(said := image.info.get(key), str):
            return " ".join(said.split())[:2000]
    return ""
