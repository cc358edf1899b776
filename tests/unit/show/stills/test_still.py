"""Pictures of assets and raw models: something is seen, in the middle, from the front, always the same; sheets."""

from __future__ import annotations

import io
import itertools
import multiprocessing
from collections.abc import Callable
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image, ImageSequence

from casa_assets.errors import CasaError
from casa_assets.formats import mjcf
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import RawModel, RawPart, Up
from casa_assets.show.stills import opengl, still
from casa_assets.show.stills.pictures import SheetCell, contact_sheet
from casa_assets.show.stills.studio import View
from tests.support.asset.assets import ball, drawer_unit, rigid_mug, textured_box, write_to
from tests.support.mesh.meshes import box_mesh, texture

QUICK = View(size_px=160, passes=8)


def pixels(png: bytes) -> npt.NDArray[np.float64]:
    """(H, W, 3) pixels, 0..255."""
    with Image.open(io.BytesIO(png)) as opened:
        return np.asarray(opened.convert("RGB"), dtype=np.float64)


def outline(png: bytes) -> npt.NDArray[np.bool_]:
    """Where something coloured is; the floor and its shadows are grey."""
    seen = pixels(png)
    return np.asarray(np.ptp(seen, axis=2) > 30.0)


@pytest.fixture
def box(tmp_path: Path) -> Path:
    return write_to(mjcf.write(textured_box()), tmp_path / "box") / "model.xml"


@pytest.mark.parametrize("make", [rigid_mug, ball, textured_box, drawer_unit])
def test_something_is_seen_in_the_middle_and_fills_the_frame(make: Callable[[], Asset], tmp_path: Path) -> None:
    red = tuple(Material(id=m.id, base_color=(0.8, 0.1, 0.1, 1.0)) for m in make().materials)
    asset = make().replace(materials=red)
    seen = outline(still.render(write_to(mjcf.write(asset), tmp_path) / "model.xml", QUICK))
    # First and last row and column, as fractions of the frame.
    spans = np.array([np.flatnonzero(seen.any(axis=axis))[[0, -1]] + (0, 1) for axis in (0, 1)]) / QUICK.size_px
    assert 0.72 <= np.ptp(spans, axis=1).max() <= 0.88
    assert spans.sum(axis=1) == pytest.approx([1.0, 1.0], abs=0.04)


def test_only_one_picture_of_a_strip_has_the_colours_of_its_parts(tmp_path: Path) -> None:
    """The asset is grey, so that nothing but the paint of its parts has a colour."""
    grey = tuple(Material(id=m.id, base_color=(0.5, 0.5, 0.5, 1.0)) for m in drawer_unit().materials)
    asset = drawer_unit().replace(materials=grey)
    moving = [still.MovingJoint(joint.name, joint.name, "") for joint in asset.joints[:1]]
    strip = still.joint_strip(write_to(mjcf.write(asset), tmp_path) / "model.xml", moving, "drawers")
    seen = outline(strip)
    colored = {
        name: int(seen[y : y + still.CELL_PX, x : x + still.CELL_PX].sum())
        for name, (x, y) in still.strip_corners(moving).items()
    }
    assert [name for name, count in colored.items() if count > 200] == ["parts"], colored


def test_the_front_is_seen_which_faces_minus_y(tmp_path: Path) -> None:
    # A board, red where it faces -y and blue behind: mostly red is seen.
    model = tmp_path / "model.xml"
    plates = "".join(
        f'<geom type="box" group="1" size="0.05 0.004 0.05" pos="0 {y} 0.05" rgba="{rgba}"/>'
        for y, rgba in ((-0.004, "1 0 0 1"), (0.004, "0 0 1 1"))
    )
    model.write_text(f"<mujoco><worldbody><body><body name='object'>{plates}</body></body></worldbody></mujoco>")
    red, _, blue = pixels(still.render(model, QUICK)).transpose(2, 0, 1)
    assert np.count_nonzero(red - blue > 60.0) > 5 * np.count_nonzero(blue - red > 60.0) > 0
    # Its right side (+x) is nearer, so the front recedes to the left: the blue edge looks out on the right.
    columns = [np.flatnonzero((a - b > 60.0).any(axis=0)).mean() for a, b in ((red, blue), (blue, red))]
    assert columns[0] < columns[1]


def test_the_same_bytes_twice_and_in_another_process(box: Path) -> None:
    once = still.render(box, QUICK)
    assert still.render(box, QUICK) == once
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["mujoco"])
    with context.Pool(1) as pool:
        assert pool.apply(still.render, (box, QUICK)) == once


def test_a_child_of_a_process_that_has_drawn_is_refused_and_does_not_hang(box: Path) -> None:
    still.render(box, QUICK)
    with multiprocessing.get_context("fork").Pool(1) as pool, pytest.raises(opengl.NoRenderer, match="forkserver"):
        pool.apply_async(still.render, (box, QUICK)).get(timeout=60)


def test_colliders_are_seen_in_colours_of_their_own(tmp_path: Path) -> None:
    model = write_to(mjcf.write(rigid_mug()), tmp_path) / "model.xml"
    plain, colliders = still.render(model, QUICK), still.render(model, QUICK, collision=True)
    hues = [len(np.unique((pixels(png)[outline(png)] // 48).astype(int), axis=0)) for png in (plain, colliders)]
    assert hues[0] < hues[1]


def test_a_broken_model_is_named(tmp_path: Path) -> None:
    model = tmp_path / "model.xml"
    model.write_text("<mujoco><worldbody/></mujoco>")
    with pytest.raises(still.CannotDraw, match=r"model\.xml: it has no geom"):
        still.render(model, QUICK)
    model.write_text("<mujoco>")
    with pytest.raises(still.CannotDraw):
        still.render(model, QUICK)


def test_the_turntable_turns_once(box: Path) -> None:
    animation = still.render_turntable(box, View(size_px=64, passes=4), frames=4)
    with Image.open(io.BytesIO(animation)) as opened:
        assert opened.format == "WEBP"
        frames = [np.asarray(frame.convert("RGB"), dtype=float) for frame in ImageSequence.Iterator(opened)]
    assert len(frames) == 4
    assert all(np.abs(a - b).mean() > 1.0 for a, b in itertools.pairwise(frames))


def test_without_opengl_the_error_says_what_to_install(box: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As if this process had not drawn, and could not."""
    monkeypatch.setattr(opengl, "_open", Mock(side_effect=OSError("cannot open shared object file")))
    monkeypatch.setattr(opengl, "_opened", [])
    monkeypatch.setattr(opengl, "context", opengl.context.__wrapped__)
    for name in ("MUJOCO_GL", "CASA_ASSETS_GL"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(CasaError, match=r"egl: OSError.*osmesa: OSError.*apt-get install -y libegl1"):
        still.render(box, QUICK)
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    with pytest.raises(CasaError, match=r"apt-get install -y libosmesa6.*leave MUJOCO_GL=osmesa out") as error:
        still.render(box, QUICK)
    assert "egl: " not in str(error.value)


SMALL = View(size_px=128, passes=6)
RED = Material(id="red", base_color=(0.7, 0.05, 0.05, 1.0))
BLUE = Material(id="blue", base_color=(0.05, 0.05, 0.7, 1.0))


def part(mesh: Mesh, material: Material = RED) -> RawPart:
    return RawPart(name="part", mesh=mesh, material=material)


def raw(*parts: RawPart) -> bytes:
    return still.render_model(RawModel(parts=parts, up=Up.Z, format="obj"), SMALL)


CORNERS = [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)]
FLAT = Mesh(vertices=np.array(CORNERS, dtype=np.float64), faces=np.array([[0, 1, 2], [0, 2, 3]]))
SHAPES = {
    "box": box_mesh((1.0, 2.0, 3.0), (100.0, 0.0, 0.0)),
    "huge": box_mesh((1e6, 1e6, 1e6), (0.0, 0.0, 0.0)),
    "tiny": box_mesh((1e-6, 1e-6, 2e-6), (0.0, 0.0, 0.0)),
    "flat": FLAT,
    "one triangle": Mesh(vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1.0]]), faces=np.array([[0, 1, 2]])),
    "inside out": Mesh(vertices=FLAT.vertices, faces=FLAT.faces[:, ::-1]),
    "with empty faces": Mesh(vertices=FLAT.vertices, faces=np.vstack([FLAT.faces, [[0, 0, 1], [2, 2, 2]]])),
}


def test_any_mesh_gives_a_picture() -> None:
    for name, shape in SHAPES.items():
        assert outline(raw(part(shape))).mean() > 0.10, name
    empty = Mesh(vertices=np.zeros((3, 3)), faces=np.zeros((0, 3), dtype=np.int32))
    with pytest.raises(CasaError, match="no triangle"):
        raw(part(empty))


def red_over_blue(png: bytes, apart: float) -> bool:
    red, _, blue = pixels(png).transpose(2, 0, 1)
    rows = [np.flatnonzero((a - b > apart).any(axis=1)).mean() for a, b in ((red, blue), (blue, red))]
    return bool(rows[0] < rows[1])


def test_up_axis_of_the_file_is_respected_and_the_bytes_repeat() -> None:
    # Red above blue along y, as glTF has it.
    parts = (part(box_mesh((1, 1, 1), (0, 1, 0))), part(box_mesh((1, 1, 1), (0, 0, 0)), BLUE))
    model = RawModel(parts=parts, up=Up.Y, format="glb")
    png = still.render_model(model, SMALL)
    assert still.render_model(model, SMALL) == png
    assert red_over_blue(png, 40.0)


def test_an_image_has_its_first_row_at_the_top() -> None:
    image = np.zeros((8, 8, 3), dtype=np.uint8)
    image[:4, :, 0], image[4:, :, 2] = 220, 220
    material = Material(id="image", base_color=(1, 1, 1, 1), base_color_texture=texture("image", image))
    mesh = Mesh(vertices=FLAT.vertices, faces=FLAT.faces, uv=np.array([[0, 0], [1, 0], [1, 1], [0, 1]]))
    assert red_over_blue(raw(part(mesh, material)), 60.0)


def test_the_many_faces_of_a_mesh_are_drawn_as_a_coarse_one_would_be(monkeypatch: pytest.MonkeyPatch) -> None:
    x, z = np.meshgrid(np.linspace(0, 1, 64), np.linspace(0, 1, 64))
    at = np.arange(64 * 64).reshape(64, 64)
    a, b, c, d = (at[corners].ravel() for corners in itertools.product((slice(-1), slice(1, None)), repeat=2))
    faces = np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])
    vertices = np.stack([x, 0.1 * np.sin(6 * x), z], axis=2).reshape(-1, 3)
    shades = np.stack([255 * x, 200 * z, 0 * x, 0 * x + 255], axis=2).reshape(-1, 4).astype(np.uint8)
    fine = part(Mesh(vertices=vertices, faces=faces, colors=shades), Material(id="white", base_color=(1, 1, 1, 1)))
    monkeypatch.setattr(still, "_GRID_STEPS", 24)
    whole = pixels(raw(fine))
    monkeypatch.setattr(still, "_MANY_FACES", 1000)
    assert 0.0 < np.abs(pixels(raw(fine)) - whole).mean() < 4.0


def shot(color: tuple[int, int, int], title: str = "mug_0123456789", side_px: int = 32) -> SheetCell:
    """A cell with a picture of light paper, in the middle of which is a colour."""
    picture, out = Image.new("RGB", (32, side_px), (244, 244, 244)), io.BytesIO()
    picture.paste(color, (0, side_px // 2 - 16, 32, side_px // 2 + 16))
    picture.save(out, "PNG")
    return SheetCell(title, "8 x 8 x 10 cm", out.getvalue())


def test_a_sheet_has_every_picture_whole_and_captions_cut_to_the_cell() -> None:
    colors = [(200, 40, 40), (40, 200, 40), (40, 40, 200)]
    shots = [shot(color, "W" * 5000 + "\n\u202e\x00\U0001f600") for color in colors]
    png = contact_sheet(shots, "Three", columns=2, cell_px=64)
    assert contact_sheet(shots, "Three", columns=2, cell_px=64) == png
    seen = pixels(png)
    assert [np.count_nonzero((seen == color).all(axis=2)) for color in colors] == [64 * 64] * 3
    plain = pixels(contact_sheet([shot(color) for color in colors], "Three", columns=2, cell_px=64))
    assert plain.shape == seen.shape
    assert (seen[60:, 12 + 2 * 64 + 8 + 1 :] == 255).all()
    # One of another shape fills its cell, and loses paper.
    red = (pixels(contact_sheet([shot((200, 40, 40), side_px=48)], "One", cell_px=64)) == (200, 40, 40)).all(axis=2)
    assert np.ptp(np.flatnonzero(red.any(axis=0))) > 0.85 * 64
