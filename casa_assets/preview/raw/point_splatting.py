"""Render triangles without OpenGL: points are scattered over them, and the nearest wins each pixel.

Slower to look good than a rasteriser, but it draws anything: flat meshes, millions of faces, machines without Mesa.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

from casa_assets.core.typing import Floats
from casa_assets.model.ingest.source import RawPart
from casa_assets.preview.camera import View, fit
from casa_assets.preview.raw import raw_materials
from casa_assets.preview.tonemap import Pixels, to_uint8

# Pixels are drawn this many times finer and then averaged; points per fine pixel of the frame.
_FINER, _DENSITY = 2, 1.5
# Ref: M. Roberts, the R2 sequence.
_PLASTIC = 1.32471795724474602596
_LIGHT = np.array([-0.55, -0.65, 0.85]) / np.linalg.norm([-0.55, -0.65, 0.85])
_FLOOR, _SHADOW = 0.95, 0.35


def draw(parts: Sequence[RawPart], view: View) -> Pixels:
    """The picture of parts with z up.

    Args:
        parts: at least one triangle among them, any unit.
        view: direction and size; `passes` is not used.
    Returns:
        (size_px, size_px, 3) uint8.
    """
    corners = np.concatenate([p.mesh.vertices[p.mesh.faces] for p in parts])
    size = view.size_px * _FINER
    points, face, weights = _strew(corners, int(_DENSITY * size * size))
    camera = fit(corners.reshape(-1, 3), view)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    # Broken meshes face any way: a face is lit as if it faced the camera.
    normals *= np.where(normals @ camera.forward > 0.0, -1.0, 1.0)[:, None]
    shade = 0.66 + 0.42 * np.clip(normals @ _LIGHT, 0.0, 1.0)
    colors = _colors(parts, face, weights) * shade[face][:, None]
    x, y, depth = camera.project(points)
    ground = points * [1.0, 1.0, 0.0] + [0.0, 0.0, float(corners[..., 2].min())]
    paper = _ground(camera.project(ground)[:2], size)
    # Each point covers its pixel and two neighbours, or the floor would show between points.
    step = 2.0 / size
    pixel = np.concatenate([_pixel(x + dx * step, y + dy * step, size) for dx, dy in ((0, 0), (1, 0), (0, 1))])
    # Far to near, so that the nearest point of a pixel is written last.
    order = np.argsort(np.tile(-depth, 3), kind="stable")
    frame = paper.reshape(-1, 3)
    frame[pixel[order]] = colors[order % len(colors)]
    small = Image.fromarray(to_uint8(frame.reshape(size, size, 3))).resize(
        (view.size_px, view.size_px), Image.Resampling.BOX
    )
    return np.asarray(small)


def _strew(corners: Floats, count: int) -> tuple[Floats, np.ndarray, Floats]:
    """(N, 3) points, (N,) their faces and (N, 3) their weights of the corners: by area, evenly, the same every time."""
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    total = float(area.sum())
    share = area / total if total > 0.0 else np.full(len(area), 1.0 / len(area))
    ends = np.cumsum(share)
    face = np.minimum(np.searchsorted(ends, (np.arange(count) + 0.5) / count), len(corners) - 1)
    i = np.arange(count, dtype=np.float64)
    u, v = np.sqrt((i / _PLASTIC) % 1.0), (i / _PLASTIC**2) % 1.0
    weights = np.stack([1.0 - u, u * (1.0 - v), u * v], axis=1)
    return np.einsum("nk,nkd->nd", weights, corners[face]), face, weights


def _pixel(x: Floats, y: Floats, size: int) -> np.ndarray:
    """Index of the pixel of points in -1..1, rows from the top."""
    column = np.clip(((x + 1.0) * 0.5 * size).astype(np.int64), 0, size - 1)
    row = np.clip(((1.0 - y) * 0.5 * size).astype(np.int64), 0, size - 1)
    return np.asarray(row * size + column)


def _ground(shadow: tuple[Floats, Floats], size: int) -> Floats:
    """(size, size, 3) light floor with a soft shadow where the points stand above it."""
    count = np.bincount(_pixel(*shadow, size), minlength=size * size).reshape(size, size)
    soft = gaussian_filter(np.minimum(count, 1).astype(np.float32), size * 0.018)
    grey = _FLOOR * (1.0 - _SHADOW * soft.astype(np.float64))
    return np.repeat(grey[..., None], 3, axis=2)


def _colors(parts: Sequence[RawPart], face: np.ndarray, weights: Floats) -> Floats:
    """(N, 3) colours of points as a screen shows them, 0..1: base colour, times image, times vertex colours."""
    out = np.empty((len(face), 3))
    first = 0
    for part in parts:
        mine = (face >= first) & (face < first + len(part.mesh.faces))
        corner = part.mesh.faces[face[mine] - first]
        color = np.broadcast_to(raw_materials.srgb(part.material)[:3], (len(corner), 3)).copy()
        if part.mesh.colors is not None:
            color *= np.einsum("nk,nkd->nd", weights[mine], part.mesh.colors[corner][..., :3] / 255.0)
        if part.material.base_color_texture is not None and part.mesh.uv is not None:
            pixels = raw_materials.opened(part.material.base_color_texture)
            uv = np.einsum("nk,nkd->nd", weights[mine], part.mesh.uv[corner]) % 1.0
            height, width = pixels.shape[:2]
            row = np.minimum(((1.0 - uv[:, 1]) * height).astype(np.int64), height - 1)
            column = np.minimum((uv[:, 0] * width).astype(np.int64), width - 1)
            color *= pixels[row, column] / 255.0
        out[mine] = color
        first += len(part.mesh.faces)
    return out
