"""Pictures of kitchens in one structure: each shows what it shows alone, and is plain where pictures are left out."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from casa_assets.addons.batch.shared_model import SharedModel, share
from casa_assets.addons.batch.structure import materials_of, plain_colors
from casa_assets.core.numeric import linear_from_srgb_array
from tests.unit.addons.batch.small_kitchens import painted


@pytest.fixture(scope="module")
def alone() -> list[mujoco.MjModel]:
    return [mujoco.MjModel.from_xml_string(text) for text in painted()]


@pytest.fixture(scope="module")
def shared() -> list[SharedModel]:
    return share([mujoco.MjSpec.from_string(text) for text in painted()], textures=True)


def material_of(model: mujoco.MjModel, geom: int) -> str | None:
    number = int(model.geom_matid[geom])
    return None if number < 0 else str(model.material(number).name)


@pytest.mark.parametrize("number", [0, 1])
def test_each_geom_shows_what_it_shows_alone(
    number: int, shared: list[SharedModel], alone: list[mujoco.MjModel]
) -> None:
    one, model = shared[number], alone[number]
    for name, geom in one.geoms.items():
        own = model.geom(name).id
        assert material_of(one.model, geom) == material_of(model, own), name
        if model.geom_matid[own] < 0:
            assert np.array_equal(one.model.geom_rgba[geom], model.geom_rgba[own])
    for name, material in materials_of(model).items():
        other = materials_of(one.model)[name]
        assert {k: np.asarray(v).tolist() for k, v in other.values.items()} == {
            k: np.asarray(v).tolist() for k, v in material.values.items()
        }
        assert (material.picture is None) == (other.picture is None)
        if material.picture and other.picture:
            assert np.array_equal(material.picture.pixels, other.picture.pixels)


def test_only_which_material_a_geom_has_differs(shared: list[SharedModel]) -> None:
    first, second = (one.model for one in shared)
    assert not np.array_equal(first.geom_matid, second.geom_matid)
    for name in ("mat_texid", "mat_rgba", "mat_texrepeat", "mat_texuniform", "tex_adr", "tex_data", "tex_width"):
        assert np.array_equal(getattr(first, name), getattr(second, name)), name


def test_without_pictures_geoms_have_their_mean_colour(alone: list[mujoco.MjModel]) -> None:
    made = share([mujoco.MjSpec.from_string(text) for text in painted()])[0]
    assert made.model.nmat == 0
    assert "<mujoco" in made.text
    floor, slab = (made.model.geom_rgba[made.geoms[name]] for name in ("floor__floor", "top__slab"))
    assert floor == pytest.approx([0.2, 0.4, 0.6, 1.0], abs=0.003)
    dark, light = linear_from_srgb_array(np.array([[1.0, 0.5, 0.2], [0.5, 0.2, 0.0]]))
    assert linear_from_srgb_array(slab[None, :3])[0] == pytest.approx((dark + light) / 2, abs=0.01)
    colors = plain_colors(alone[0])
    door = alone[0].geom("base__front").id
    assert np.array_equal(colors[door], alone[0].geom_rgba[door])
