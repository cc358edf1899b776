"""Meshes and pictures built in code, for the small assets of the tests."""

from __future__ import annotations

import io
import math
from typing import TypeVar

import numpy as np
import numpy.typing as npt
from PIL import Image

from casa_assets.model.asset.material import ColorSpace, Texture
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.record import Vec3

T = TypeVar("T")


def some(value: T | None) -> T:
    """What has to be there."""
    assert value is not None
    return value


def texture(name: str, pixels: npt.NDArray[np.uint8], space: ColorSpace = ColorSpace.SRGB) -> Texture:
    """A PNG texture of (H, W, 3) uint8 pixels."""
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "PNG")
    height, width, *_ = pixels.shape
    return Texture(name=name, png=out.getvalue(), width_px=width, height_px=height, color_space=space)


def box_mesh(size: Vec3, center: Vec3, shared: bool = False) -> Mesh:
    """A box of full `size`: 24 vertices with uv and normals (each side shows the whole picture), or 8 shared ones."""
    if shared:
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        faces = [f for a, b, c, d in quads for f in ((a, b, c), (a, c, d))]
        return Mesh(vertices=corners * size + center, faces=np.array(faces))
    sides = {(0, 0, 1): ((1, 0, 0), (0, 1, 0)), (0, 0, -1): ((1, 0, 0), (0, -1, 0))}
    for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        sides[(x, y, 0)] = ((-y, x, 0), (0, 0, 1))
    uv = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    points = [normal + (2 * uv - 1) @ np.array(axes) for normal, axes in sides.items()]
    faces = [f for a in range(0, 24, 4) for f in ((a, a + 1, a + 2), (a, a + 2, a + 3))]
    normals = np.repeat(list(sides), 4, axis=0)
    vertices = np.concatenate(points) / 2 * size + center
    return Mesh(vertices=vertices, faces=np.array(faces), uv=np.tile(uv, (6, 1)), normals=normals)


def wall(i: int, steps: int) -> Mesh:
    """One piece of the mug's wall: a prism of eight corners, (8, 3) metres."""
    corners = []
    for turn in (i, i + 1):
        angle = 2 * math.pi * turn / steps
        for r, z in ((0.035, 0.0), (0.04, 0.0), (0.04, 0.095), (0.035, 0.095)):
            corners.append((r * math.cos(angle), r * math.sin(angle), z))
    quads = [(0, 1, 2, 3), (7, 6, 5, 4), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]
    return Mesh(vertices=np.array(corners), faces=np.array([f for a, b, c, d in quads for f in ((a, b, c), (a, c, d))]))


def lathe(profile: list[tuple[float, float]], steps: int) -> Mesh:
    """Surface of revolution about z of (radius, height) points in metres, with uv."""
    angles = np.linspace(0.0, 2 * math.pi, steps + 1)
    vertices, uv, faces = [], [], []
    for i, (radius, height) in enumerate(profile):
        vertices += [(radius * math.cos(a), radius * math.sin(a), height) for a in angles]
        uv += [(j / steps, i / (len(profile) - 1)) for j in range(steps + 1)]
    for i in range(len(profile) - 1):
        for j in range(steps):
            a, b = i * (steps + 1) + j, (i + 1) * (steps + 1) + j
            if profile[i][0] > 0:
                faces.append((a, b, a + 1))
            if profile[i + 1][0] > 0:
                faces.append((a + 1, b, b + 1))
    return Mesh(vertices=np.array(vertices), faces=np.array(faces), uv=np.array(uv))
