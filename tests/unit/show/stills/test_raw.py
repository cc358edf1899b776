"""Pictures of raw models: wherever there are triangles there is a picture."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from casa_assets.errors import CasaError
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import RawModel, RawPart, Up
from casa_assets.show.stills import still
from casa_assets.show.stills.studio import View
from tests.support.mesh.meshes import box_mesh, texture

_SIDES = (slice(-1), slice(1, None))
QUICK = View(size_px=128, passes=6)
RED = Material(id="red", base_color=(0.7, 0.05, 0.05, 1.0))
BLUE = Material(id="blue", base_color=(0.05, 0.05, 0.7, 1.0))


def part(mesh: Mesh, material: Material = RED) -> RawPart:
    return RawPart(name="part", mesh=mesh, material=material)


def square(corners: list[tuple[float, float, float]]) -> Mesh:
    return Mesh(vertices=np.array(corners), faces=np.array([[0, 1, 2], [0, 2, 3]]))


def colored(png: bytes) -> float:
    """Fraction of the picture that is not grey."""
    with Image.open(io.BytesIO(png)) as opened:
        return float((np.ptp(np.asarray(opened.convert("RGB"), dtype=float), axis=2) > 30.0).mean())


FLAT = square([(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)])
SHAPES = {
    "box": box_mesh((1.0, 2.0, 3.0), (100.0, 0.0, 0.0)),
    "huge": box_mesh((1e6, 1e6, 1e6), (0.0, 0.0, 0.0)),
    "tiny": box_mesh((1e-6, 1e-6, 2e-6), (0.0, 0.0, 0.0)),
    "flat": FLAT,
    "one triangle": Mesh(vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1.0]]), faces=np.array([[0, 1, 2]])),
    "inside out": Mesh(vertices=FLAT.vertices, faces=FLAT.faces[:, ::-1]),
    "with empty faces": Mesh(vertices=FLAT.vertices, faces=np.vstack([FLAT.faces, [[0, 0, 1], [2, 2, 2]]])),
}


def test_any_mesh_gives_a_picture(subtests: pytest.Subtests) -> None:
    for name in sorted(SHAPES):
        with subtests.test(name=name):
            assert colored(still.render_mesh([part(SHAPES[name])], Up.Z, QUICK)) > 0.10


def test_no_triangle_is_an_error() -> None:
    empty = Mesh(vertices=np.zeros((3, 3)), faces=np.zeros((0, 3), dtype=np.int32))
    with pytest.raises(CasaError, match="no triangle"):
        still.render_mesh([part(empty)], Up.Z, QUICK)


def test_up_axis_of_the_file_is_respected_and_the_bytes_repeat() -> None:
    # Red above blue along y, as glTF stands things up.
    parts = (part(box_mesh((1, 1, 1), (0, 1, 0))), part(box_mesh((1, 1, 1), (0, 0, 0)), BLUE))
    model = RawModel(parts=parts, up=Up.Y, format="glb")
    png = still.render_model(model, QUICK)
    assert still.render_model(model, QUICK) == png
    with Image.open(io.BytesIO(png)) as opened:
        red, _, blue = np.asarray(opened.convert("RGB"), dtype=float).transpose(2, 0, 1)
    rows = [np.flatnonzero((a - b > 40.0).any(axis=1)).mean() for a, b in ((red, blue), (blue, red))]
    assert rows[0] < rows[1]


def test_an_image_has_its_first_row_at_the_top() -> None:
    image = np.zeros((8, 8, 3), dtype=np.uint8)
    image[:4, :, 0], image[4:, :, 2] = 220, 220
    material = Material(id="image", base_color=(1, 1, 1, 1), base_color_texture=texture("image", image))
    mesh = Mesh(vertices=FLAT.vertices, faces=FLAT.faces, uv=np.array([[0, 0], [1, 0], [1, 1], [0, 1]]))
    png = still.render_mesh([part(mesh, material)], Up.Z, QUICK)
    with Image.open(io.BytesIO(png)) as opened:
        red, _, blue = np.asarray(opened.convert("RGB"), dtype=float).transpose(2, 0, 1)
    assert (
        np.flatnonzero((red - blue > 60.0).any(axis=1)).mean() < np.flatnonzero((blue - red > 60.0).any(axis=1)).mean()
    )


def test_vertex_colours_are_seen() -> None:
    colors = np.full((4, 4), 255, dtype=np.uint8)
    colors[:, :3] = [10, 200, 10]
    mesh = Mesh(vertices=FLAT.vertices, faces=FLAT.faces, colors=colors)
    white = Material(id="white", base_color=(1, 1, 1, 1))
    assert colored(still.render_mesh([part(mesh, white)], Up.Z, QUICK)) > 0.10


def test_the_many_faces_of_a_mesh_are_drawn_as_a_coarse_one_would_be(monkeypatch: pytest.MonkeyPatch) -> None:
    x, z = np.meshgrid(np.linspace(0, 1, 64), np.linspace(0, 1, 64))
    at = np.arange(64 * 64).reshape(64, 64)
    a, b, c, d = (at[rows, columns].ravel() for rows in (slice(-1), slice(1, None)) for columns in _SIDES)
    faces = np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])
    vertices = np.stack([x, 0.1 * np.sin(6 * x), z], axis=2).reshape(-1, 3)
    shades = np.stack([255 * x, 200 * z, 0 * x, 0 * x + 255], axis=2).reshape(-1, 4).astype(np.uint8)
    fine = part(Mesh(vertices=vertices, faces=faces, colors=shades), Material(id="white", base_color=(1, 1, 1, 1)))
    monkeypatch.setattr(still, "_GRID_STEPS", 24)
    pictures = []
    for most in (150_000, 1000):
        monkeypatch.setattr(still, "_MANY_FACES", most)
        with Image.open(io.BytesIO(still.render_mesh([fine], Up.Z, QUICK))) as opened:
            pictures.append(np.asarray(opened.convert("RGB"), dtype=float))
    assert 0.0 < np.abs(pictures[0] - pictures[1]).mean() < 4.0
