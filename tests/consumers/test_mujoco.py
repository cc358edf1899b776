"""MuJoCo's own reader of USD, which is there up to Python 3.13, and its own renderer."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import mujoco
import pytest

from casa_assets.checks.readers.usd_facts import imported
from casa_assets.formats.mjcf import write
from tests.support.asset.articulated_assets import grill
from tests.support.asset.assets import textured_box, write_to
from tests.support.asset.packages import written
from tests.support.kitchen.rooms import at, in_all_forms, room
from tests.support.library.libraries import ran

pytestmark = pytest.mark.consumers


def test_the_tree_is_that_of_the_mjcf(tmp_path: Path) -> None:
    """Read by MuJoCo from USD, the bodies have the parents that model.xml gives them."""
    package = written(grill(), tmp_path)
    model = imported(package.usd_files[1]).model
    assert model is not None
    truth = mujoco.MjModel.from_xml_path(str(package.mjcf))
    links = [link.name for link in package.asset.links[1:]]
    ours = {name: truth.body(int(truth.body(name).parentid[0])).name for name in links}
    names = {i: model.body(i).name.rsplit("/", 1)[-1] for i in range(model.nbody)}
    found = {names[i]: names[model.body_parentid[i]] for i in range(1, model.nbody)}
    assert {name: found[name] for name in links} == ours


def test_a_picture_that_many_materials_name_is_read_once(tmp_path: Path) -> None:
    """MuJoCo's reader of USD has a texture for each; a carton of 16 x 16 px is there twice."""
    print_and_twin = textured_box().replace(id="carton_9876543210")
    scene = room((textured_box(), at(0.0, 0.0, 0.0)), (print_and_twin, at(0.5, 0.0, 0.0)))
    loaded = in_all_forms(scene, tmp_path).imported
    model = loaded.model
    assert model is not None, loaded.error
    assert loaded.warnings == ()
    shown = {int(i) for i in model.mat_texid[:, mujoco.mjtTextureRole.mjTEXROLE_RGB] if i >= 0}
    pictured = [m for m in range(model.nmat) if model.mat_texid[m, mujoco.mjtTextureRole.mjTEXROLE_RGB] >= 0]
    assert len(pictured) == 2
    (one,) = shown
    assert (model.tex_width[one], model.tex_height[one]) == (16, 16)
    assert model.ntex > 2
    assert sorted(model.tex_width[model.tex_width > 1].tolist()) == [8, 16]


# In a process of its own: which OpenGL is used is settled when mujoco is imported.
SCRIPT = """
import json, sys
import mujoco

model = mujoco.MjModel.from_xml_path("scene.xml")
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
camera = mujoco.MjvCamera()
camera.lookat[:] = [0, 0, 0.06]
camera.distance, camera.azimuth, camera.elevation = 0.35, 90, 0
with mujoco.Renderer(model, 240, 320) as renderer:
    renderer.update_scene(data, camera)
    picture = renderer.render()
spots = {"top_left": (80, 110), "top_right": (80, 210), "bottom_left": (160, 110), "bottom_right": (160, 210)}
print(json.dumps({name: picture[spot].tolist() for name, spot in spots.items()}))
"""


def test_a_picture_is_drawn_upright_and_hides_what_collides(tmp_path: Path) -> None:
    folder = write_to(write(textured_box()), tmp_path)
    environment = {**os.environ, "MUJOCO_GL": os.environ.get("MUJOCO_GL", "egl")}
    told = json.loads(ran(sys.executable, "-c", SCRIPT, cwd=folder, env=environment).stdout)
    strongest = {name: max(range(3), key=pixel.__getitem__) for name, pixel in told.items()}
    assert strongest == {"top_left": 0, "top_right": 0, "bottom_left": 1, "bottom_right": 2}
