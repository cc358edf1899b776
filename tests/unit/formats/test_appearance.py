"""How a batch form looks: pictures on boxes at their true size, the boxes themselves unchanged."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
import pytest

from casa_assets.addons.batch.merged_form import batch_form
from casa_assets.asset.lightweight import light_scene
from casa_assets.formats.mjcf import batch
from casa_assets.model.asset.material import Material
from casa_assets.model.record import Vec3
from tests.support.kitchen.rooms import at, block, room
from tests.support.mesh.meshes import texture

# A board that stands, 1.2 m wide and 0.6 m high: its picture is 0.3 m wide and 0.2 m high.
BOARD: Vec3 = (1.2, 0.02, 0.6)
TILE = (0.3, 0.2)


def compiled(tile: tuple[float, float] | None) -> mujoco.MjModel:
    """A board with a picture that `box_mesh` draws once on each side, wherever `tile` says it repeats."""
    pixels = np.zeros((400, 600, 3), dtype=np.uint8)
    pixels[:200] = 200
    oak = Material(id="paint", base_color_texture=texture("grain", pixels), tile_m=tile)
    board = block("board", BOARD).replace(materials=(oak,))
    files = batch.write(batch_form(light_scene(room((board, at(0.0, 0.0, 0.0))))))
    entries = {path.replace("assets/", "../assets/"): data for path, data in files.entries.items()}
    return mujoco.MjModel.from_xml_string(entries.pop(batch.FILE).decode(), assets=entries)


def corners(model: mujoco.MjModel, geom: int) -> set[tuple[float, ...]]:
    """Of a box, in its body, mm."""
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    signs = np.array(list(itertools.product((-1, 1), repeat=3)))
    points = (signs * model.geom_size[geom]) @ turn.reshape(3, 3).T + model.geom_pos[geom]
    return {tuple(point) for point in (points * 1000).round(3) + 0.0}


def test_a_picture_repeats_by_its_true_size_and_the_box_is_where_it_was() -> None:
    model, plain, name = compiled(TILE), compiled(None), "thing_0__shape_0"
    geom = model.geom(name).id
    material = int(model.geom_matid[geom])
    assert model.mat_texuniform[material]
    # MuJoCo multiplies by half of the length.
    times = model.mat_texrepeat[material] * model.geom_size[geom][:2]
    assert times == pytest.approx([1.2 / 0.3, 0.6 / 0.2])
    assert model.geom_size[geom][2] == pytest.approx(0.01), "the side with the picture is the top of the box"
    assert plain.nmat == 0
    assert not np.allclose(model.geom(name).size, plain.geom(name).size)
    assert corners(model, geom) == corners(plain, plain.geom(name).id)
