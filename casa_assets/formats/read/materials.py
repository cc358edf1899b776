"""Pictures of any common format, and looks that a file states -> Texture and Material.

A Texture is a PNG of 8 bits, the same bytes every time.
"""

from __future__ import annotations

import io
import math
import struct
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image, UnidentifiedImageError

from casa_assets.core import numeric
from casa_assets.formats.read.formats import PACKED_FAULTS
from casa_assets.formats.read.text import Notes, UniqueNames, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.material import ColorSpace, Material, Texture

# Longer sides are scaled down: no simulator gains from more, and files grow with the square.
LARGEST_PX = 4096
# Ref: KTX 2.0, 2: the identifier, then (from byte 20 on) width and height as 32-bit numbers.
KTX2 = b"\xabKTX 20\xbb\r\n\x1a\n"
FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "TGA", "TIFF", "GIF")

Pixels = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class ImageUse:
    """Colour space and treatment of alpha in which the pixels of an image are kept.

    Attributes:
        space: sRGB or raw.
        alpha: `keep`, `drop`, or a cut in 0..1 (alpha at or above it becomes opaque, below it invisible).
    """

    space: ColorSpace = ColorSpace.SRGB
    alpha: str | float = "keep"


class Images:
    """Decodes each image once; a picture that cannot be read is left out with a note, and the model stays."""

    def __init__(self, limits: Mapping[str, float], notes: Notes) -> None:
        self._limits, self._notes = limits, notes
        self._pixels: dict[str, Pixels | None] = {}
        self._textures: dict[tuple[str, ImageUse], Texture] = {}
        self._names = UniqueNames()

    def pixels(self, key: str, data: bytes) -> Pixels | None:
        """(H, W, 3 or 4) uint8 rows from the top, or None (noted) where it is refused or unreadable."""
        if key not in self._pixels:
            self._pixels[key] = self._decode(key, data)
        return self._pixels[key]

    def texture(self, key: str, data: bytes, name: str, use: ImageUse) -> Texture | None:
        """Texture named after `name`, or None (noted) where the image is refused or unreadable."""
        if (key, use) not in self._textures:
            pixels = self.pixels(key, data)
            if pixels is None:
                return None
            if pixels.shape[2] == 4 and not isinstance(use.alpha, str):
                pixels = pixels.copy()
                pixels[:, :, 3] = np.where(pixels[:, :, 3] >= use.alpha * 255.0, 255, 0)
            if (
                pixels.shape[2] == 4
                and use.alpha != "keep"
                and (use.alpha == "drop" or int(pixels[:, :, 3].min()) == 255)
            ):
                pixels = np.ascontiguousarray(pixels[:, :, :3])
            self._textures[key, use] = self.encode(pixels, name, use.space)
        return self._textures[key, use]

    def encode(self, pixels: Pixels, name: str, space: ColorSpace) -> Texture:
        """Texture of (H, W, 3 or 4) uint8 pixels, under a name not yet taken."""
        stream = io.BytesIO()
        Image.fromarray(pixels).save(stream, "PNG", compress_level=6)
        height, width = pixels.shape[:2]
        return Texture(
            name=self._names.unique(name, "texture"),
            png=stream.getvalue(),
            width_px=width,
            height_px=height,
            color_space=space,
        )

    def _decode(self, key: str, data: bytes) -> Pixels | None:
        where = "embedded image" if key.startswith("data:") else printable(key)
        if data.startswith(KTX2):
            return self._decode_ktx2(where, data)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                image = Image.open(io.BytesIO(data), formats=FORMATS)
                if not self._is_small_enough(image.size, where):
                    return None
                return _eight_bit(self._shrunk(image, where))
        except Image.DecompressionBombError:
            self._notes.add(codes.IMAGE_REFUSED, where, "the image is far too large to decode; texture left out")
        except UnidentifiedImageError:
            message = f"not a {', '.join(FORMATS)} image (it starts with {data[:8]!r}); texture left out"
            self._notes.add(codes.IMAGE_UNREADABLE, where, message)
        except (*PACKED_FAULTS, SyntaxError, TypeError) as error:
            message = f"the image cannot be decoded ({type(error).__name__}: {error}); texture left out"
            self._notes.add(codes.IMAGE_UNREADABLE, where, message)
        return None

    def _decode_ktx2(self, where: str, data: bytes) -> Pixels | None:
        """Pixels of the largest level; only what is packed by Basis Universal can be unpacked."""
        import opengl_basisu  # here, since it takes long to load and few meshes need it

        try:
            if not self._is_small_enough(struct.unpack_from("<II", data, 20), where):
                return None
            unpacked = opengl_basisu.open(data).transcode("rgba8").data
            return _eight_bit(self._shrunk(Image.fromarray(unpacked), where))
        except (ValueError, IndexError, RuntimeError, struct.error) as error:
            message = f"the KTX2 image cannot be decoded ({printable(str(error), 80)}); texture left out"
            self._notes.add(codes.IMAGE_UNREADABLE, where, message)
        return None

    def _is_small_enough(self, size: tuple[int, ...], where: str) -> bool:
        width, height = size
        max_side, max_pixels = self._limits["input_texture_px"], self._limits["input_texture_pixels"]
        if max(size) <= max_side and width * height <= max_pixels:
            return True
        message = f"{width} x {height} pixels, over {max_side:.0f} a side or {max_pixels:.0f} in all; left out"
        self._notes.add(codes.IMAGE_REFUSED, where, message)
        return False

    def _shrunk(self, image: Image.Image, where: str) -> Image.Image:
        longest = max(image.size)
        if longest <= LARGEST_PX:
            return image
        size = (max(1, image.width * LARGEST_PX // longest), max(1, image.height * LARGEST_PX // longest))
        message = f"{image.width} x {image.height} scaled to {size[0]} x {size[1]}"
        self._notes.add(codes.IMAGE_DOWNSCALED, where, message)
        if image.mode in ("P", "1"):
            image = image.convert("RGBA")
        return image.resize(size, Image.Resampling.BOX)


def _eight_bit(image: Image.Image) -> Pixels:
    """(H, W, 3 or 4) uint8; four channels only where some alpha is below 255."""
    if image.mode.startswith("I;16") or image.mode in ("I", "F"):
        values = np.asarray(image).astype(np.float64)
        top = 65535.0 if image.mode != "F" else max(1.0, float(np.nanmax(values)))
        grey = np.clip(np.rint(np.nan_to_num(values) * (255.0 / top)), 0, 255).astype(np.uint8)
        return np.repeat(grey[:, :, None], 3, axis=2)
    has_alpha = "A" in image.getbands() or "a" in image.getbands() or "transparency" in image.info
    pixels = np.asarray(image.convert("RGBA" if has_alpha else "RGB"), dtype=np.uint8)
    if has_alpha and int(pixels[:, :, 3].min()) == 255:
        pixels = np.ascontiguousarray(pixels[:, :, :3])
    return pixels


def linear_from_srgb(value: float) -> float:
    """One channel, display value, brought into 0..1 -> linear light in 0..1."""
    return numeric.linear_from_srgb(min(1.0, max(0.0, value)))


def srgb_bytes_from_linear(values: npt.NDArray[np.float64]) -> Pixels:
    """Linear light in 0..1, any shape -> sRGB bytes."""
    clipped = np.clip(np.nan_to_num(values, nan=1.0), 0.0, 1.0)
    return np.rint(numeric.srgb_from_linear_array(clipped) * 255.0).astype(np.uint8)


def rgba_of_linear(values: npt.NDArray[np.float64]) -> Pixels:
    """(N, 4) sRGB bytes of (N, 3) or (N, 4) linear light and opacity in 0..1; opaque where they have no alpha."""
    out = np.full((len(values), 4), 255, dtype=np.uint8)
    out[:, :3] = srgb_bytes_from_linear(values[:, :3])
    if values.shape[1] == 4:
        out[:, 3] = np.rint(np.clip(values[:, 3], 0.0, 1.0) * 255.0).astype(np.uint8)
    return out


@dataclass(frozen=True)
class Look:
    """Look of a surface, as a file says it.

    Attributes:
        color: linear RGB, 0..1; if there is a picture, its tint. opacity, metallic, roughness: 0..1.
        picture: key and bytes of the colour picture.
    """

    name: str
    color: tuple[float, float, float] = (0.8, 0.8, 0.8)
    opacity: float = 1.0
    metallic: float = 0.0
    roughness: float = 0.6
    picture: tuple[str, bytes] | None = None


class Materials:
    """Makes a Material of each look once."""

    def __init__(self, limits: Mapping[str, float], notes: Notes) -> None:
        self._images, self._notes = Images(limits, notes), notes
        self._names = UniqueNames()
        self._made: dict[object, Material] = {}

    def material(self, key: object, look: Callable[[], Look]) -> Material:
        """The material of a look, which is read once; `key` identifies it within one file."""
        if key not in self._made:
            self._made[key] = self._make(look())
        return self._made[key]

    def _make(self, look: Look) -> Material:
        opacity = _unit(look.opacity, 1.0)
        if opacity <= 0.0:
            self._notes.add(codes.FULLY_TRANSPARENT, look.name, "alpha 0 would hide it; made opaque")
            opacity = 1.0
        texture = None
        if look.picture is not None:
            use = ImageUse(ColorSpace.SRGB, "keep" if opacity < 1.0 else 0.5)
            texture = self._images.texture(*look.picture, f"{look.name}_color", use)
        r, g, b = (_unit(c, 0.8) for c in look.color)
        return Material(
            id=self._names.unique(look.name, "material"),
            base_color=(r, g, b, opacity),
            metallic=_unit(look.metallic, 0.0),
            roughness=_unit(look.roughness, 0.6),
            base_color_texture=texture,
        )


def _unit(value: float, default: float) -> float:
    """A number clamped to 0..1; the default if it is not finite."""
    return min(1.0, max(0.0, value)) if math.isfinite(value) else default


def roughness_of_shininess(shininess: float | None, specular: float | None = None) -> float:
    """0..1 from Ns in 0..1000, None: matt. A thing without a highlight (`specular` near 0) is matt too.

    Ref: Blender's wavefront_obj exporter, Ns = 1000 (1 - roughness)^2.
    """
    if shininess is None:
        return 0.6
    guess = 1.0 - math.sqrt(min(1000.0, max(0.0, shininess)) / 1000.0)
    floor = 0.6 if specular is not None and specular < 0.01 else 0.05
    return max(floor, guess)
