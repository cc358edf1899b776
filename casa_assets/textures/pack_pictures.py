"""Decode pictures of a pack, make them tile, and derive the maps that they lack from their brightness."""

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
from pydantic import Field
from scipy import ndimage

from casa_assets.errors import Rejected
from casa_assets.model.asset.material import ColorSpace, Substance
from casa_assets.model.record import Record, Vec2
from casa_assets.model.registry.rows import Finish, Surface
from casa_assets.textures.canvas import Layers
from casa_assets.textures.check import jump, repair, seam
from casa_assets.textures.finish import encode_texture, finish, halved
from casa_assets.textures.pack_entry import MAX_ASPECT, MAX_SIDE_PX, MIN_SIDE_PX, MapRole, PictureRejection

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
    """A picture."""

    pixels: Floats  # (H, W, 3) sRGB 0..1, upright
    prompt: str  # from the file, or empty
    notes: tuple[str, ...]  # conversions that were made


def decode(data: bytes) -> DecodedPicture:
    """The picture in these bytes; Rejected if there is none, or it is broken, transparent, of wrong size or blank."""
    found = _decoded(data)
    if float(np.abs(found.pixels - found.pixels.mean(axis=(0, 1))).mean()) * 255.0 < _BLANK / 2.0:
        raise Rejected(PictureRejection.BLANK, "shows one colour")
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
        raise Rejected(fault, "is far too large" if large else _unknown(data)) from None
    except (*_FAULTS, zlib.error) as error:
        message = f"cannot be decoded: {type(error).__name__}: {str(error)[:120]}"
        raise Rejected(PictureRejection.BROKEN, message) from None
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
        raise Rejected(PictureRejection.TOO_LARGE, f"has tiles of over {MAX_SIDE_PX} pixels a side")
    if image.mode == "I":  # 32 bits, or numbers below 0
        raise Rejected(PictureRejection.NOT_A_PICTURE, "is a TIFF file of integers that are not of 8 or 16 bits")


def _check_size(width: int, height: int) -> None:
    size = f"{width} x {height} pixels"
    if max(width, height) > MAX_SIDE_PX:
        raise Rejected(PictureRejection.TOO_LARGE, f"{size}, over {MAX_SIDE_PX} a side")
    if min(width, height) < MIN_SIDE_PX:
        raise Rejected(PictureRejection.TOO_SMALL, f"{size}, under {MIN_SIDE_PX} a side")
    if max(width, height) > MAX_ASPECT * min(width, height):
        raise Rejected(PictureRejection.TOO_LONG, f"{size}, longer than {MAX_ASPECT:g} times its width")


def _rgb(image: Image.Image, kind: str) -> tuple[Floats, tuple[str, ...]]:
    """Pixels of a picture that Pillow has loaded, and what was converted. `kind`: format of the file."""
    mode = image.mode
    if mode in ("RGBA", "LA", "PA") or "transparency" in image.info:
        alpha = np.asarray(image.convert("RGBA"))[..., 3]
        if float(alpha.min()) < _OPAQUE:
            message = f"{np.mean(alpha < _OPAQUE):.1%} of it can be seen through"
            raise Rejected(PictureRejection.TRANSPARENT, message)
    if mode.startswith("I") or mode == "F":
        raw = np.asarray(image, dtype=np.float32)
        if not np.isfinite(raw).all():
            raise Rejected(PictureRejection.BROKEN, "holds values that are no numbers")
        grey = raw if mode == "F" else raw / np.float32(65535.0)  # a grey PNG of 16 bits has mode I;16 or I
        words = "floats" if mode == "F" else "16 bits"
        return np.repeat(grey[..., None], 3, axis=2), (f"grey of {words} in a {kind} file was read as such",)
    notes = (f"was converted from {mode} to RGB",) if mode != "RGB" else ()
    return np.asarray(image.convert("RGB"), dtype=np.float32) / np.float32(255.0), notes


def _prompt(image: Image.Image) -> str:
    """Prompt that image generators write into a text chunk of a PNG."""
    for key in ("parameters", "prompt", "Description"):
        if isinstance(text := image.info.get(key), str):
            return " ".join(text.split())[:2000]
    return ""


SIZE_PX = 1024
# A border whose steps are this many times those inside is seen in a wall of copies. A repaired one has less.
VISIBLE_SEAM = 1.5
_REPAIR_SEAM, _REPAIR_JUMP = 1.0, 1.5
MAX_SEAM = 2.5
# Dark is taken to lie deeper: true of joints, pores and cracks, not of what is painted on. So the relief is kept low.
_RELIEF_M = 0.0006
_GLOSS = {Surface.WALL: 0.75, Surface.FLOOR: 0.45, Surface.COUNTER: 0.25, Surface.CABINET: 0.45}
_UNEVEN = 0.15  # roughness between the palest and the darkest detail
HEIGHT = "height"  # the map that is kept with 16 bits
_FLATTEST = 0.1  # least z of a normal: steeper ones have no slope that could be averaged


class TiledPicture(Record):
    """A picture made to tile, as it is stored."""

    base: bytes = Field(description="PNG of the colour")
    maps: dict[str, bytes] = Field(description="name of a map -> its PNG, of the same size")
    width_px: int
    height_px: int
    kept: Vec2 = Field(description="share of the width and height of the source that it shows")
    seam_before: float = Field(description="worst border score")
    seam_after: float
    repaired: bool = Field(description="whether the border was repaired")
    prompt: str = Field("", description="from its file")
    notes: tuple[str, ...] = Field((), description="conversions that were made, maps that were left out")


def tile(pixels: Floats, size_px: int = SIZE_PX, given: Mapping[str, Floats] | None = None) -> TiledPicture:
    """Scale down, repair the border where it is seen; the maps are cut as the colour is.

    Pictures that come with maps are of a library that makes them to repeat: a joint on their border is no fault.
    `pixels`: (H, W, 3) sRGB 0..1. `size_px`: longer side of the result; nothing is scaled up but a map that is smaller
    than the colour. `given`: name -> map of the same surface, (H, W, 3) normals, y up, or (H, W, 1), 0..1, of any size.
    Raises Rejected: the border is still plain to see.
    """
    maps = given or {}
    small = scaled(pixels, size_px)
    before = seam(small).worst
    is_seen = before > VISIBLE_SEAM if maps else before > _REPAIR_SEAM or jump(small).worst > _REPAIR_JUMP
    planes = np.concatenate([small, *(_fitted(plane, *small.shape[:2]) for plane in maps.values())], axis=2)
    whole = repair(planes, shown=3) if is_seen else planes
    after = seam(whole[..., :3]).worst
    if after > MAX_SEAM:
        message = f"its border is {after:.1f} times as strong as the pattern, after its repair"
        raise Rejected(PictureRejection.SEAM, message)
    height, width = whole.shape[:2]
    stored, at = {}, 3
    for name, plane in maps.items():
        stored[name] = png(whole[..., at : at + plane.shape[2]], is_deep=name == HEIGHT)
        at += plane.shape[2]
    return TiledPicture(
        base=png(whole[..., :3]),
        maps=stored,
        width_px=width,
        height_px=height,
        kept=(width / small.shape[1], height / small.shape[0]),
        seam_before=round(before, 3),
        seam_after=round(after, 3),
        repaired=is_seen,
    )


def layers(base: Floats, surface: Surface, roughness: float | None) -> Layers:
    """Colour (H, W, 3) that tiles with a derived relief and gloss; `roughness`: mean, or None: that of the surface."""
    detail = _detail(base @ np.array([0.2126, 0.7152, 0.0722], dtype=np.float32))
    mean = _GLOSS[surface] if roughness is None else roughness
    return Layers.of(base, _RELIEF_M * detail, mean - _UNEVEN * detail)


def finish_of_tile(
    name: str, made: TiledPicture, tile_m: Vec2, look: tuple[Surface, float | None], substance: Substance, size_px: int
) -> Finish:
    """The finish of a picture: with its own maps, and with derived ones where it has none.

    Normals come from their map, else from that of heights, else from the brightness. `name`: id. `tile_m`: width and
    height of what it shows. `look`: surface and mean roughness. `size_px`: longer side; nothing is scaled up.
    """
    base = scaled(pixels_of(made.base), size_px)
    maps = {key: scaled(pixels_of(data), size_px) for key, data in made.maps.items()}
    painted = layers(base, *look)
    height = _RELIEF_M * _detail(maps[HEIGHT][..., 0]) if HEIGHT in maps else painted.height_m
    rough = maps["roughness"][..., 0] if "roughness" in maps else painted.roughness
    whole = finish(name, tile_m, Layers.of(painted.albedo, height, rough), substance)
    material = whole.material
    if "normal" in maps:
        # Unit normals of a map at half its size, upright on the mean: what repeats has no slope on the whole.
        vectors = np.stack([halved(maps["normal"][..., axis]) for axis in range(3)], axis=2) * 2.0 - 1.0
        slopes = vectors[..., :2] / np.maximum(vectors[..., 2:], _FLATTEST)
        slopes -= slopes.mean(axis=(0, 1))
        upright = np.concatenate([slopes, np.ones_like(slopes[..., :1])], axis=2)
        unit = np.asarray(upright / np.linalg.norm(upright, axis=2, keepdims=True), dtype=np.float32)
        pixels = np.rint((unit * 0.5 + 0.5) * 255).astype(np.uint8)
        material = material.replace(normal_texture=encode_texture(f"{name}_normal", pixels, ColorSpace.RAW))
    if "metalness" in maps:
        gloss = halved(np.clip(rough, 0.04, 1.0)), halved(maps["metalness"][..., 0])
        planes = np.stack([np.ones_like(gloss[0]), *gloss], axis=2)
        pixels = np.rint(np.clip(planes, 0, 1) * 255).astype(np.uint8)
        texture = encode_texture(f"{name}_metallic_roughness", pixels, ColorSpace.RAW)
        material = material.replace(metallic_roughness_texture=texture)
    return whole.replace(material=material)


def _detail(light: Floats) -> Floats:
    """Detail of a (H, W) picture as heights from -1 to 1."""
    # Broad light and shade is light and shade; only detail can be relief.
    detail = light - ndimage.gaussian_filter(light, min(light.shape) / 24.0, mode="wrap")
    detail = ndimage.gaussian_filter(detail, 0.8, mode="wrap")
    return np.asarray(np.clip(detail / max(float(np.abs(detail).max()), 0.08), -1.0, 1.0), dtype=np.float32)


def scaled(pixels: Floats, size_px: int) -> Floats:
    """(H, W, C) scaled down, never up, around the border, so that it tiles as before; `size_px`: its longer side."""
    height, width = pixels.shape[:2]
    scale = size_px / max(height, width)
    if scale >= 1.0:
        return pixels
    return _fitted(pixels, max(1, round(height * scale)), max(1, round(width * scale)))


def png(image: Floats, is_deep: bool = False) -> bytes:
    """(H, W, 1 or 3) 0..1 as PNG, always the same bytes; `is_deep`: 16 bits, since heights in 255 steps are stairs."""
    whole = np.clip(image, 0.0, 1.0)
    pixels = np.rint(whole * 65535.0).astype(np.uint16) if is_deep else np.rint(whole * 255.0).astype(np.uint8)
    out = io.BytesIO()
    Image.fromarray(pixels[..., 0] if pixels.shape[2] == 1 else pixels).save(out, "PNG", compress_level=6)
    return out.getvalue()


def pixels_of(data: bytes) -> Floats:
    """(H, W, 3) float32 0..1 of a PNG that this package wrote."""
    with Image.open(io.BytesIO(data)) as image:
        if image.mode.startswith("I"):  # with 16 bits
            return np.repeat((np.asarray(image, dtype=np.float32) / np.float32(65535.0))[..., None], 3, axis=2)
        return np.asarray(image.convert("RGB"), dtype=np.float32) / np.float32(255.0)


def _fitted(pixels: Floats, height: int, width: int) -> Floats:
    """(H, W, C) in another size, around the border."""
    old = pixels.shape[:2]
    if old == (height, width):
        return pixels
    rim = int(np.ceil(4.0 * max(1.0, old[0] / height, old[1] / width)))
    padded = np.pad(pixels, ((rim, rim), (rim, rim), (0, 0)), mode="wrap")
    box = (rim, rim, rim + old[1], rim + old[0])
    planes = [
        np.asarray(Image.fromarray(padded[..., c]).resize((width, height), Image.Resampling.LANCZOS, box=box))
        for c in range(pixels.shape[2])
    ]
    return np.asarray(np.clip(np.stack(planes, axis=-1), 0.0, 1.0), dtype=np.float32)
