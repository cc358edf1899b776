"""Make a picture tile with the maps that it comes with, and derive those that it lacks from its brightness."""

from __future__ import annotations

import io
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt
from PIL import Image
from scipy import ndimage

from casa_assets.model.asset.material import ColorSpace, Substance
from casa_assets.model.record import Record, Vec2
from casa_assets.model.registry.finish import Finish, Surface
from casa_assets.textures.canvas import Layers
from casa_assets.textures.finish import encode_texture, finish, halved
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
HEIGHT = "height"  # the map that is kept with 16 bits
_FLATTEST = 0.1  # least z of a normal: steeper ones have no slope that could be averaged

Floats = npt.NDArray[np.float32]


@dataclass(frozen=True)
class GivenMaps:
    """Maps that come with a picture, float32 0..1; missing ones are None.

    Attributes:
        normal: (H, W, 3), y up. roughness, metalness, height: (H, W, 1).
    """

    normal: Floats | None = None
    roughness: Floats | None = None
    metalness: Floats | None = None
    height: Floats | None = None

    def named(self) -> dict[str, Floats]:
        """Those that there are, by their names."""
        found = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: planes for name, planes in found.items() if planes is not None}


class TiledPicture(Record):
    """A picture made to tile, as it is stored.

    Attributes:
        base: PNG of the colour, (height_px, width_px).
        maps: name of a map of GivenMaps -> its PNG, of the same size.
        kept: share of the width and height of the source that it shows.
        seam_before, seam_after: worst border score.
        repaired: whether the border was repaired.
    """

    base: bytes
    maps: dict[str, bytes]
    width_px: int
    height_px: int
    kept: Vec2
    seam_before: float
    seam_after: float
    repaired: bool


def tile(pixels: Floats, size_px: int = SIZE_PX, given: GivenMaps | None = None) -> TiledPicture:
    """Scale down, repair the border where it is seen; the maps are cut as the colour is.

    Pictures that come with maps are of a library that makes them to repeat: a joint on their border is no fault.

    Args:
        pixels: (H, W, 3) sRGB 0..1.
        size_px: longer side of the result; nothing is scaled up but a map that is smaller than the colour.
        given: maps of the same surface, of any size.
    Raises:
        Rejected: the border is still plain to see.
    """
    maps = (given or GivenMaps()).named()
    small = scaled(pixels, size_px)
    before = seam(small).worst
    is_seen = before > VISIBLE_SEAM if maps else before > _REPAIR_SEAM or jump(small).worst > _REPAIR_JUMP
    planes = np.concatenate([small, *(_fitted(plane, *small.shape[:2]) for plane in maps.values())], axis=2)
    whole = repair(planes, shown=3) if is_seen else planes
    after = seam(whole[..., :3]).worst
    if after > MAX_SEAM:
        raise rejection_error(
            PictureRejection.SEAM, f"its border is {after:.1f} times as strong as the pattern, after its repair"
        )
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
    """Colour with a derived relief and gloss.

    Args:
        base: (H, W, 3) sRGB 0..1 that tiles.
        surface: decides the mean roughness if `roughness` is None.
        roughness: mean, 0..1, or None.
    """
    detail = _detail(base @ np.array([0.2126, 0.7152, 0.0722], dtype=np.float32))
    mean = _GLOSS[surface] if roughness is None else roughness
    return Layers.of(base, _RELIEF_M * detail, mean - _UNEVEN * detail)


def finish_of_tile(
    name: str, made: TiledPicture, tile_m: Vec2, look: tuple[Surface, float | None], substance: Substance, size_px: int
) -> Finish:
    """The finish of a picture: with its own maps, and with derived ones where it has none.

    Normals come from the map of normals, else from that of heights, else from the brightness.

    Args:
        name: id. made: the picture. tile_m: width and height of what it shows.
        look: surface and mean roughness, as `layers` takes them.
        size_px: longer side of the result; nothing is scaled up.
    """
    base = scaled(pixels_of(made.base), size_px)
    maps = {key: scaled(pixels_of(data), size_px) for key, data in made.maps.items()}
    painted = layers(base, *look)
    height = _RELIEF_M * _detail(maps[HEIGHT][..., 0]) if HEIGHT in maps else painted.height_m
    rough = maps["roughness"][..., 0] if "roughness" in maps else painted.roughness
    whole = finish(name, tile_m, Layers.of(painted.albedo, height, rough), substance)
    material = whole.material
    if "normal" in maps:
        pixels = np.rint((_upright(maps["normal"]) * 0.5 + 0.5) * 255).astype(np.uint8)
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


def _upright(normal: Floats) -> Floats:
    """Unit normals of a map at half its size, upright on the mean: what repeats has no slope on the whole.

    Args:
        normal: (H, W, 3) 0..1.
    """
    vectors = np.stack([halved(normal[..., axis]) for axis in range(3)], axis=2) * 2.0 - 1.0
    slopes = vectors[..., :2] / np.maximum(vectors[..., 2:], _FLATTEST)
    slopes -= slopes.mean(axis=(0, 1))
    upright = np.concatenate([slopes, np.ones_like(slopes[..., :1])], axis=2)
    return np.asarray(upright / np.linalg.norm(upright, axis=2, keepdims=True), dtype=np.float32)


def scaled(pixels: Floats, size_px: int) -> Floats:
    """(H, W, C) scaled down around the border, so that what tiled before does so after; nothing is scaled up.

    Args:
        size_px: longer side of the result.
    """
    height, width = pixels.shape[:2]
    scale = size_px / max(height, width)
    if scale >= 1.0:
        return pixels
    return _fitted(pixels, max(1, round(height * scale)), max(1, round(width * scale)))


def png(image: Floats, is_deep: bool = False) -> bytes:
    """(H, W, 3) or (H, W, 1) 0..1 as PNG, the same bytes every time.

    Args:
        is_deep: with 16 bits, of (H, W, 1): slopes of heights in 255 steps are stairs.
    """
    whole = np.clip(image, 0.0, 1.0)
    pixels = np.rint(whole * 65535.0).astype(np.uint16) if is_deep else np.rint(whole * 255.0).astype(np.uint8)
    out = io.BytesIO()
    Image.fromarray(pixels[..., 0] if pixels.shape[2] == 1 else pixels).save(out, "PNG", compress_level=6)
    return out.getvalue()


def pixels_of(data: bytes) -> Floats:
    """(H, W, 3) float32 0..1 of a PNG that this package wrote."""
    with Image.open(io.BytesIO(data)) as image:
        if image.mode.startswith("I"):  # with 16 bits
            grey = np.asarray(image, dtype=np.float32) / np.float32(65535.0)
            return np.repeat(grey[..., None], 3, axis=2)
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
