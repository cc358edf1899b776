"""USD as MuJoCo's own reader has it, which is there up to Python 3.13."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest

from casa_assets.checks.readers.usd_facts import imported
from tests.support.asset.articulated_assets import grill
from tests.support.asset.assets import textured_box
from tests.support.asset.packages import written
from tests.support.kitchen.rooms import at, in_all_forms, room

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
