"""Pictures of raw models: wherever there are triangles there is a picture."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from casa_assets.errors import CasaError
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.mesh import Mesh
from casa_assets.model.ingest.source import RawModel, RawPart, Up
from casa_assets.preview import tonemap
from casa_assets.preview.camera import View
from casa_assets.preview.raw import point_splatting, raw_model
from tests.meshes import box_mesh, texture

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
            assert colored(raw_model.render_mesh([part(SHAPES[name])], Up.Z, QUICK)) > 0.10


def test_so_does_drawing_by_hand(subtests: pytest.Subtests) -> None:
    for name in sorted(SHAPES):
        with subtests.test(name=name):
            stood = raw_model._stand_up([part(SHAPES[name])], Up.Z)
            assert colored(tonemap.png(point_splatting.draw(stood, QUICK))) > 0.10


def test_a_line_without_area_is_no_reason_to_fail() -> None:
    line = Mesh(vertices=np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]]), faces=np.array([[0, 1, 2]]))
    assert raw_model.render_mesh([part(line)], Up.Z, QUICK).startswith(b"\x89PNG")
    point = Mesh(vertices=np.zeros((3, 3)), faces=np.array([[0, 1, 2]]))
    assert raw_model.render_mesh([part(point)], Up.Z, QUICK).startswith(b"\x89PNG")


def test_no_triangle_is_an_error() -> None:
    empty = Mesh(vertices=np.zeros((3, 3)), faces=np.zeros((0, 3), dtype=np.int32))
    with pytest.raises(CasaError, match="no triangle"):
        raw_model.render_mesh([part(empty)], Up.Z, QUICK)


def test_up_axis_of_the_file_is_respected_and_the_bytes_repeat() -> None:
    # Red above blue along y, as glTF stands things up.
    parts = (part(box_mesh((1, 1, 1), (0, 1, 0))), part(box_mesh((1, 1, 1), (0, 0, 0)), BLUE))
    model = RawModel(parts=parts, up=Up.Y, format="glb")
    png = raw_model.render_model(model, QUICK)
    assert raw_model.render_model(model, QUICK) == png
    with Image.open(io.BytesIO(png)) as opened:
        red, _, blue = np.asarray(opened.convert("RGB"), dtype=float).transpose(2, 0, 1)
    rows = [np.flatnonzero((a - b > 40.0).any(axis=1)).mean() for a, b in ((red, blue), (blue, red))]
    assert rows[0] < rows[1]


@pytest.mark.parametrize("by_hand", [False, True])
def test_an_image_has_its_first_row_at_the_top(by_hand: bool) -> None:
    image = np.zeros((8, 8, 3), dtype=np.uint8)
    image[:4, :, 0], image[4:, :, 2] = 220, 220
    material = Material(id="image", base_color=(1, 1, 1, 1), base_color_texture=texture("image", image))
    mesh = Mesh(vertices=FLAT.vertices, faces=FLAT.faces, uv=np.array([[0, 0], [1, 0], [1, 1], [0, 1]]))
    stood = raw_model._stand_up([part(mesh, material)], Up.Z)
    png = tonemap.png(point_splatting.draw(stood, QUICK)) if by_hand else raw_model.render_mesh(stood, Up.Z, QUICK)
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
    assert colored(raw_model.render_mesh([part(mesh, white)], Up.Z, QUICK)) > 0.10
