"""How a batch form looks: pictures on boxes at their true size, the boxes themselves unchanged."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
import pytest

from casa_assets.addons.batch.merged_form import BatchForms
from casa_assets.asset.lightweight import light_scene
from casa_assets.formats.mjcf import batch
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import BatchScene
from casa_assets.model.record import Vec3
from tests.support.kitchen.rooms import at, block, room
from tests.support.mesh.meshes import texture

# A board that stands, 1.2 m wide and 0.6 m high: its picture is 0.3 m wide and 0.2 m high.
BOARD: Vec3 = (1.2, 0.02, 0.6)
TILE = (0.3, 0.2)


def grain(width: int = 600, height: int = 400) -> Texture:
    pixels = np.zeros((height, width, 3), dtype=np.uint8)
    pixels[: height // 2] = 200
    return texture("grain", pixels)


def board(picture: Texture, tile: tuple[float, float] | None = TILE) -> Asset:
    """With a picture that `box_mesh` draws once on each side, wherever `tile` says it repeats."""
    plain = block("board", BOARD)
    oak = Material(id="paint", base_color_texture=picture, tile_m=tile)
    return plain.replace(materials=(oak,))


def form(picture: Texture, tile: tuple[float, float] | None = TILE) -> BatchScene:
    return BatchForms(light_scene(room((board(picture, tile), at(0.0, 0.0, 0.0))))).form()


def compiled(files: Files) -> mujoco.MjModel:
    entries = {path.replace("assets/", "../assets/"): data for path, data in files.entries.items()}
    return mujoco.MjModel.from_xml_string(entries.pop(batch.FILE).decode(), assets=entries)


def corners(model: mujoco.MjModel, geom: int) -> set[tuple[float, ...]]:
    """Of a box, in its body, mm."""
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    signs = np.array(list(itertools.product((-1, 1), repeat=3)))
    points = (signs * model.geom_size[geom]) @ turn.reshape(3, 3).T + model.geom_pos[geom]
    return {tuple(point) for point in (points * 1000).round(3) + 0.0}


def test_a_picture_repeats_by_its_true_size() -> None:
    model = compiled(batch.write(form(grain())))
    geom = model.geom("thing_0__shape_0").id
    material = int(model.geom_matid[geom])
    assert model.mat_texuniform[material]
    # MuJoCo multiplies by half of the length.
    times = model.mat_texrepeat[material] * model.geom_size[geom][:2]
    assert times == pytest.approx([1.2 / 0.3, 0.6 / 0.2])
    assert model.geom_size[geom][2] == pytest.approx(0.01), "the side with the picture is the top of the box"


def test_the_box_is_where_it_was() -> None:
    shown = compiled(batch.write(form(grain())))
    plain = compiled(batch.write(form(grain(), tile=None)))
    assert plain.nmat == 0
    name = "thing_0__shape_0"
    assert not np.allclose(shown.geom(name).size, plain.geom(name).size)
    assert corners(shown, shown.geom(name).id) == corners(plain, plain.geom(name).id)
