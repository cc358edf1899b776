"""Kitchens in one structure: each is there whole, looks and moves as it does alone, and begins at rest."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np
import pytest

from casa_assets.addons.batch.shared_model import SharedModel, addresses, robot_of, share, slots_for
from casa_assets.addons.batch.start_positions import AWAKE, LOCKED, MOVED, start_positions
from casa_assets.addons.batch.structure import materials_of, plain_colors, structure_of
from casa_assets.checks.scene.light_forms import candidate_pairs
from casa_assets.core.numeric import linear_from_srgb_array
from casa_assets.errors import CasaError
from tests.unit.addons.batch.small_kitchens import DRIVING, FIRST, FLOATING, REST, SECOND, painted, specs, states

Models = list[mujoco.MjModel]


@pytest.fixture(scope="module")
def alone() -> Models:
    return [mujoco.MjModel.from_xml_string(text) for text in (FIRST, SECOND)]


@pytest.fixture(scope="module")
def shared() -> list[SharedModel]:
    return share(specs())


def names(pairs: np.ndarray, known: Mapping[int, str]) -> set[frozenset[str]]:
    """Pairs of geoms by name; those of geoms without one are left out."""
    return {frozenset((known[a], known[b])) for a, b in np.argwhere(pairs).tolist() if a in known and b in known}


def begun(model: mujoco.MjModel, qpos: np.ndarray) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    return data


def test_all_have_one_structure(shared: list[SharedModel]) -> None:
    first, second = (one.model for one in shared)
    for name in ("nbody", "njnt", "nv", "ngeom", "nsite", "ncam", "nlight", "nexclude", "nC"):
        assert getattr(first, name) == getattr(second, name)
    for name in ("geom_type", "geom_contype", "geom_conaffinity", "jnt_type", "body_parentid", "dof_length"):
        assert np.array_equal(getattr(first, name), getattr(second, name)), name
    assert first.njnt == 3 + 1 + 2 + 1, "three doors, a drawer, a thing with a lid and a thing without one"


@pytest.mark.parametrize("number", [0, 1])
class TestEachKitchen:
    def test_everything_is_there(self, number: int, shared: list[SharedModel], alone: Models) -> None:
        """And the same pairs can touch."""
        one, model = shared[number], alone[number]
        own = {geom: name for name, geom in one.geoms.items()}
        theirs = {i: model.geom(i).name for i in range(model.ngeom)}
        expected = names(candidate_pairs(model), theirs)
        assert expected
        assert names(candidate_pairs(one.model), own) == expected
        assert set(one.joints) == {model.joint(i).name for i in range(model.njnt)}
        assert set(one.geoms) == {model.geom(i).name for i in range(model.ngeom)}
        assert set(one.bodies) == {model.body(i).name for i in range(1, model.nbody)}
        for name, geom in one.geoms.items():
            for field in ("geom_size", "geom_rgba", "geom_friction", "geom_solref", "geom_group", "geom_condim"):
                assert np.allclose(getattr(one.model, field)[geom], getattr(model, field)[model.geom(name).id]), field
        for name, body in one.bodies.items():
            for field in ("body_mass", "body_inertia", "body_ipos"):
                expected_value = getattr(model, field)[model.body(name).id]
                assert np.allclose(getattr(one.model, field)[body], expected_value, atol=2e-6), field

    def test_it_moves_as_it_does_alone(self, number: int, shared: list[SharedModel], alone: Models) -> None:
        """Everything with a hinge or a slide is pulled, and loose things are pushed over the edge."""
        one, model = shared[number], alone[number]
        ours, theirs = begun(one.model, one.start), begun(model, model.key("start").qpos)
        for name, joint in one.joints.items():
            for data, of, its in ((ours, one.model, joint), (theirs, model, model.joint(name).id)):
                dof = int(of.jnt_dofadr[its])
                is_free = of.jnt_type[its] == mujoco.mjtJoint.mjJNT_FREE
                data.qvel[dof] = 0.8 if is_free else 0.0
                data.qfrc_applied[dof] = 0.0 if is_free else 3.0 * np.sign(sum(of.jnt_range[its]))
        for _ in range(300):
            mujoco.mj_step(one.model, ours)
            mujoco.mj_step(model, theirs)
        assert np.abs(theirs.qpos - model.key("start").qpos).max() > 0.1
        for name, body in one.bodies.items():
            assert np.allclose(ours.xpos[body], theirs.body(name).xpos, atol=1e-4), name
            assert np.allclose(ours.xmat[body], theirs.body(name).xmat, atol=1e-3), name

    def test_what_it_lacks_touches_nothing_and_stays(self, number: int, shared: list[SharedModel]) -> None:
        one = shared[number]
        data, known = begun(one.model, one.start), set(one.geoms.values())
        mujoco.mj_forward(one.model, data)
        placed = data.xpos.copy()
        for _ in range(300):
            mujoco.mj_step(one.model, data)
            assert {int(geom) for pair in data.contact.geom for geom in pair} <= known
        parked = [body for body in range(1, one.model.nbody) if body not in one.bodies.values()]
        assert parked
        assert np.abs(data.xpos[parked] - placed[parked]).max() < 1e-9
        assert data.xpos[parked][:, 2].max() < -4


def test_sites_lights_and_starts_are_those_of_each_kitchen(shared: list[SharedModel]) -> None:
    one, other = shared
    assert set(one.sites) == {"corner__place_site"}, "corners of bounds are left out"
    data = begun(one.model, one.start)
    mujoco.mj_kinematics(one.model, data)
    assert data.site_xpos[one.sites["corner__place_site"]] == pytest.approx([1.62, -0.52, 0.6])
    assert [list(each.model.light_active) for each in shared] == [[True, False], [True, True]]
    assert "at_sink" not in one.cameras
    assert other.model.cam_pos[other.cameras["at_sink"]] == pytest.approx([2, -2, 2])
    pair = {one.geoms["kettle__body"], one.geoms["kettle__lid_plate"]}
    assert not any({int(a), int(b)} == pair for a, b in np.argwhere(candidate_pairs(one.model)))
    assert one.start[addresses(one.model, one.joints["corner__slide"])] == pytest.approx([-0.1])
    assert one.start[addresses(one.model, one.joints["plate__free"])][:3] == pytest.approx([0.7, -0.3, 0.92])


def test_boxes_in_place_of_cylinders_are_as_high_and_as_large() -> None:
    one = share(specs(), cylinders=False)[0]
    assert mujoco.mjtGeom.mjGEOM_CYLINDER not in one.model.geom_type
    width, depth, half = one.model.geom_size[one.geoms["kettle__body"]]
    assert half == pytest.approx(0.1)
    assert 4 * width * depth == pytest.approx(np.pi * 0.08**2)


def test_what_has_all_that_the_others_have_has_nothing_parked(alone: Models) -> None:
    """So that nothing of it is without weight."""
    (one,) = share(specs()[:1])
    assert one.model.nbody == len(one.bodies) + 1
    assert one.model.ngeom == alone[0].ngeom
    whole, less = specs()[0], specs()[0]
    less.delete(less.body("plate"))
    less.keys[0].qpos = [0, -0.1, 1, -0.3, 0.92, 1, 0, 0, 0, 0]
    first, second = share([whole, less])
    assert (first.model.ngravcomp, second.model.ngravcomp) == (0, 1)
    assert "plate__free" not in second.joints


def doors(*geoms: str) -> mujoco.MjModel:
    """Doors side by side, each with a box for every b and a ball for every o of a word."""
    kinds = {"b": '<geom type="box" size=".1 .1 .1"/>', "o": '<geom size=".1"/>'}
    bodies = (f"<body><joint/>{''.join(kinds[kind] for kind in word)}</body>" for word in geoms)
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{''.join(bodies)}</worldbody></mujoco>")


def test_a_place_is_as_large_as_the_largest_that_takes_it() -> None:
    """Kitchens share the geoms that both need, and the third door goes to the place that grows least."""
    kitchens = doors("bbo", "bbb"), doors("bbo"), doors("bbbb")
    found = slots_for([structure_of(model) for model in kitchens])
    assert sorted(sum(slot.geoms[0].values()) for slot in found.moving) == [3, 4]


@pytest.mark.parametrize(("text", "mocaps"), [(DRIVING, 1), (FLOATING, 0)])
def test_a_robot_comes_after_all_that_is_the_kitchens(text: str, mocaps: int, shared: list[SharedModel]) -> None:
    robot = robot_of(mujoco.MjSpec.from_string(text))
    with_robot = share(specs(), robot=robot)
    for ours, bare in zip(with_robot, shared, strict=True):
        assert ours.model.nmocap == mocaps
        assert ours.model.nq == bare.model.nq + len(robot.qpos)
        assert ours.joints == bare.joints
        assert ours.geoms == bare.geoms
        assert ours.model.joint("robot_lift").id == ours.model.njnt - 1


def test_what_is_no_robot_and_no_batch_form_is_refused_by_name() -> None:
    with pytest.raises(CasaError, match=r"nowhere\.xml: MuJoCo cannot load this robot"):
        robot_of("nowhere.xml")
    text = FIRST.replace(
        "<contact>", '<tendon><fixed name="t"><joint joint="base__hinge" coef="1"/></fixed></tendon><contact>'
    )
    with pytest.raises(CasaError, match="first: the model has 1 of ntendon; a batch form has none"):
        share([mujoco.MjSpec.from_string(text)])


@pytest.fixture(scope="module")
def painted_alone() -> Models:
    return [mujoco.MjModel.from_xml_string(text) for text in painted()]


def material_of(model: mujoco.MjModel, geom: int) -> str | None:
    number = int(model.geom_matid[geom])
    return None if number < 0 else str(model.material(number).name)


def test_each_geom_shows_what_it_shows_alone_and_only_which_material_it_has_differs(painted_alone: Models) -> None:
    shared = share([mujoco.MjSpec.from_string(text) for text in painted()], textures=True)
    for one, model in zip(shared, painted_alone, strict=True):
        for name, geom in one.geoms.items():
            own = model.geom(name).id
            assert material_of(one.model, geom) == material_of(model, own), name
            if model.geom_matid[own] < 0:
                assert np.array_equal(one.model.geom_rgba[geom], model.geom_rgba[own])
        for name, material in materials_of(model).items():
            other = materials_of(one.model)[name]
            ours, theirs = ({k: np.asarray(v).tolist() for k, v in m.values.items()} for m in (other, material))
            assert ours == theirs
            assert (material.picture is None) == (other.picture is None)
            if material.picture and other.picture:
                assert np.array_equal(material.picture.pixels, other.picture.pixels)
    first, second = (one.model for one in shared)
    assert not np.array_equal(first.geom_matid, second.geom_matid)
    for name in ("mat_texid", "mat_rgba", "mat_texrepeat", "mat_texuniform", "tex_adr", "tex_data", "tex_width"):
        assert np.array_equal(getattr(first, name), getattr(second, name)), name


def test_without_pictures_geoms_have_their_mean_colour(painted_alone: Models) -> None:
    made = share([mujoco.MjSpec.from_string(text) for text in painted()])[0]
    assert made.model.nmat == 0
    assert "<mujoco" in made.text
    floor, slab = (made.model.geom_rgba[made.geoms[name]] for name in ("floor__floor", "top__slab"))
    assert floor == pytest.approx([0.2, 0.4, 0.6, 1.0], abs=0.003)
    dark, light = linear_from_srgb_array(np.array([[1.0, 0.5, 0.2], [0.5, 0.2, 0.0]]))
    assert linear_from_srgb_array(slab[None, :3])[0] == pytest.approx((dark + light) / 2, abs=0.01)
    colors = plain_colors(painted_alone[0])
    door = painted_alone[0].geom("base__front").id
    assert np.array_equal(colors[door], painted_alone[0].geom_rgba[door])


def changed(values: dict[int, float]) -> list[float]:
    return [values.get(place, number) for place, number in enumerate(REST)]


def test_joints_stand_where_the_state_says_at_rest_and_asleep(shared: list[SharedModel]) -> None:
    found = start_positions(shared[0], states((changed({0: -0.6, 2: 0.6}), ("base__hinge",)), (REST, ())), 16)
    assert found.qpos[0, addresses(shared[0].model, shared[0].joints["base__hinge"])] == pytest.approx([-0.6], abs=1e-3)
    plate = found.qpos[0, addresses(shared[0].model, shared[0].joints["plate__free"])]
    assert plate[:3] == pytest.approx([0.6, -0.3, 0.92], abs=1e-3)
    assert list(found.states) == [0, 1]
    assert found.base[0] == pytest.approx([0.0, 2.0, 0.5])
    assert (found.asleep >= 0).all()
    data = mujoco.MjData(shared[0].model)
    data.qpos[:] = found.qpos[1]
    mujoco.mj_step(shared[0].model, data, nstep=200)
    assert np.abs(data.qpos - found.qpos[1]).max() < 1e-4


def test_states_with_a_locked_joint_open_or_that_fall_are_left_out(shared: list[SharedModel]) -> None:
    opened, fallen = (changed({1: 0.2}), ("locked__slide",)), (changed({4: 1.3}), ())
    for row, reasons in ((opened, {LOCKED}), (fallen, {MOVED, AWAKE})):
        found = start_positions(shared[0], states(row, (REST, ())), 16)
        assert list(found.states) == [1]
        assert list(found.refused.values()) == [1]
        assert found.refused.keys() <= reasons
    assert len(start_positions(shared[0], states(*[(REST, ())] * 5), 2)) == 2, "no more than asked for"


def test_without_states_there_is_the_kitchen_as_built(shared: list[SharedModel]) -> None:
    found = start_positions(shared[0], None, 16, (1.0, -2.0, 0.3))
    assert list(found.states) == [-1]
    assert found.base[0] == pytest.approx([1.0, -2.0, 0.3])
    slide = addresses(shared[0].model, shared[0].joints["corner__slide"])
    assert found.qpos[0, slide] == pytest.approx([-0.1], abs=1e-3)


def test_a_kitchen_that_never_rests_is_told_by_name() -> None:
    specs_ = specs()[:1]
    # A thing that floats in the air falls for a metre.
    specs_[0].keys[0].qpos = [0, -0.1, 1, -0.3, 0.92, 1, 0, 0, 0, 0, 0.7, -1.5, 1.5, 1, 0, 0, 0]
    (one,) = share(specs_)
    with pytest.raises(CasaError, match="first: nothing is at rest in the batch form"):
        start_positions(one, None, 16)
