"""The batch form of a scene: what is merged, what is locked, and what stays as it was."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from casa_assets.addons.batch.merged_form import NEAR_ENOUGH, BatchForms, batch_within, with_joints_locked
from casa_assets.addons.batch.moving_parts import joint_word, meeting_links
from casa_assets.asset.lightweight import light_scene
from casa_assets.checks.scene.light_forms import candidate_pairs
from casa_assets.formats.mjcf import batch
from casa_assets.model.asset.asset import Base
from casa_assets.model.asset.parts import Box
from casa_assets.model.kitchen.choices import JointWord
from casa_assets.model.kitchen.scene import BatchScene, LightScene
from tests.support.asset.cupboard import cupboard
from tests.support.asset.family_members import preset
from tests.support.kitchen.rooms import at, block, room

CUPBOARD_JOINTS = ["door_hinge", "drawer_slide", "key_press", "knob_turn"]


def scene() -> LightScene:
    """Two cupboards side by side, and a crate before them."""
    crate = block("crate", (0.2, 0.2, 0.2), Base.FREE)
    return light_scene(room((cupboard(), at(0, 0, 0)), (cupboard(), at(0.6, 0, 0)), (crate, at(0.3, -1.0, 0))))


def compiled(form: BatchScene) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(batch.write(form).entries[batch.FILE].decode())


def begun(form: BatchScene) -> mujoco.MjData:
    """The form as it begins, with its contacts."""
    model = compiled(form)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    mujoco.mj_forward(model, data)
    return data


def joints_of(form: BatchScene, placement: str) -> list[str]:
    places = [place.name for place in form.scene.placements]
    return sorted(joint.name for joint in form.forms[places.index(placement)].joints)


class TestBatchForm:
    def test_walls_between_neighbours_are_one(self) -> None:
        form = BatchForms(scene()).form()
        names = [f"{item.placement}__{item.collider.name}" for item in form.world]
        assert len(names) == len(set(names))
        light = sum(len(asset.root.colliders) for asset in scene().light_assets) + len(cupboard().root.colliders)
        assert len(form.world) < light
        widths = [item.collider.shape.size[0] for item in form.world if item.collider.shape.kind == "box"]
        assert any(width == pytest.approx(1.16, abs=0.05) for width in widths), "a bottom, a top or a back of both"

    def test_what_moves_keeps_its_mechanism(self) -> None:
        form = BatchForms(scene()).form()
        assert joints_of(form, "thing_0") == CUPBOARD_JOINTS
        for asset in (form.forms[1], cupboard()):
            assert [j.replace(grip=None) for j in asset.joints] == [j.replace(grip=None) for j in cupboard().joints]
        assert [link.inertial for link in form.forms[1].links] == [link.inertial for link in cupboard().links]

    def test_the_same_scene_is_the_same_bytes_and_engines_without_sleep_get_a_file_without_it(self) -> None:
        assert batch.write(BatchForms(scene()).form()) == batch.write(BatchForms(scene()).form())
        assert b"sleep" not in batch.write(BatchForms(scene()).form(), sleeps=False).entries[batch.FILE]

    def test_everything_sleeps_until_it_is_touched(self) -> None:
        data = begun(BatchForms(scene()).form())
        model = data.model
        mujoco.mj_step(model, data, nstep=250)
        assert (data.nv_awake, data.nefc, data.ncon) == (0, 0, 0)
        data.qfrc_applied[model.joint("thing_0__drawer_slide").dofadr[0]] = 20.0
        mujoco.mj_step(model, data, nstep=200)
        assert data.joint("thing_0__drawer_slide").qpos[0] > 0.05
        assert data.nv_awake == 1


class TestPairs:
    def test_only_what_can_touch_is_a_pair(self) -> None:
        model = compiled(BatchForms(scene()).form())
        pairs = candidate_pairs(model)
        assert BatchForms(scene()).form().pair_count == pairs.sum() > 0, "counted without an engine"
        crate = model.body("thing_2").id
        collides = (model.geom_contype | model.geom_conaffinity) != 0
        of_crate = (model.geom_bodyid == crate) & collides
        own = pairs[of_crate].sum() + pairs[:, of_crate].sum()
        assert own == int(of_crate.sum()) * int((collides & ~of_crate).sum()), "a loose thing touches everything"
        for first, second in np.argwhere(pairs):
            names = {str(model.geom(int(i)).name).partition("__")[0] for i in (first, second)}
            assert "thing_2" in names or "ground" not in names, "fixtures never touch the room"

    def test_a_robot_with_the_default_bits_touches_everything(self) -> None:
        spec = mujoco.MjSpec.from_string(batch.write(BatchForms(scene()).form()).entries[batch.FILE].decode())
        body = spec.worldbody.add_body(name="robot", pos=[0, -2, 1])
        body.add_freejoint()
        body.add_geom(name="hand", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.05, 0, 0])
        model = spec.compile()
        hand, pairs = model.geom("hand").id, candidate_pairs(model)
        collides = (model.geom_contype | model.geom_conaffinity) != 0
        assert int(pairs[hand].sum() + pairs[:, hand].sum()) == int(collides.sum()) - 1

    def test_doors_that_can_meet_are_pairs(self) -> None:
        far = light_scene(room((cupboard(), at(0, 0, 0)), (cupboard(), at(3.0, 0, 0)))).scene
        near = light_scene(room((cupboard(), at(0, 0, 0)), (cupboard(), at(0.3, -0.5, 0)))).scene
        met, apart = (meeting_links(s.placements, [s.asset_of[p.name] for p in s.placements]) for s in (near, far))
        assert {("thing_0", "door"), ("thing_1", "door")} <= {link for group in met for link in group}
        assert not any(len({place for place, _ in group}) > 1 for group in apart)


class TestSolid:
    def test_a_seat_that_becomes_a_block_keeps_out_of_what_it_stands_under(self) -> None:
        """Legs spread beside a corbel, which stands in the box around them."""
        legs = [(Box(size=(0.03, 0.03, 0.6)), (x, y, 0.3)) for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
        seat = (Box(size=(0.3, 0.3, 0.04)), (0.0, 0.0, 0.62))
        stool = block("stool", (0.4, 0.4, 0.64), Base.FREE, "stool", [*legs, seat])
        corbel = block("corbel", (0.04, 0.2, 0.3))
        light = light_scene(room((corbel, at(0.2, -0.05, 0.4)), (stool, at(0, 0, 0))))
        for filled in ((), ["thing_1"]):
            deepest = min(begun(BatchForms(light).form((), filled)).contact.dist, default=0.0)
            assert deepest == pytest.approx(0.0, abs=1e-3)

    def test_bins_of_a_door_stay_apart_until_nothing_else_is_left_and_keep_out_of_drawers_as_a_block(self) -> None:
        """What is free between them is seen from the room while the door is open."""
        light = light_scene(room((preset("fridge_side_by_side", "retro_butter"), at(0, 0, 0))))
        forms, fridge = BatchForms(light), ["thing_0"]
        found = [forms.form((), filled, block) for filled, block in (((), ()), (fridge, ()), (fridge, fridge))]
        kept, solid, blocks = (form.collider_count for form in found)
        assert found[1].filled == ("thing_0",)
        assert min(begun(found[1]).contact.dist, default=0.0) > -1e-3
        assert kept > solid > blocks
        assert batch_within(light, solid).collider_count == solid
        assert batch_within(light, blocks + 1).locked, "joints are given up before it"


class TestLocked:
    def test_a_locked_drawer_stands_where_it_was_put_and_is_part_of_the_carcass(self) -> None:
        asset = with_joints_locked(cupboard(), ["drawer_slide"], {"drawer_slide": 0.1})
        assert [joint.name for joint in asset.joints] == ["door_hinge", "knob_turn", "key_press"]
        moved, before = (
            next(c.pose.position for c in link.colliders if c.name == "drawer_front")
            for link in (asset.root, cupboard().link("drawer"))
        )
        assert moved == pytest.approx(np.add(before, (0.0, -0.1, 0.0)))
        assert asset.link("drawer").colliders == ()
        # Named poses and states lose what they say of a locked joint.
        asset = with_joints_locked(cupboard(), ["door_hinge"], {})
        assert asset.states == ()
        assert all(value.joint != "door_hinge" for key in asset.keyframes for value in key.joints)

    def test_behind_a_locked_door_nothing_is_hollow(self) -> None:
        every = [(place, name) for place in ("thing_0", "thing_1") for name in CUPBOARD_JOINTS]
        form = BatchForms(scene()).form(every)
        boxes = [item.collider.shape.size for item in form.world if item.collider.shape.kind == "box"]
        assert any(np.allclose(size, (1.2, 0.4, 0.7), atol=0.01) for size in boxes), "both carcasses are one block"
        assert compiled(form).nv == 6, "the crate alone moves"
        assert {(ref.placement, ref.joint) for ref in form.locked} == set(every)


class TestChoice:
    def test_only_the_words_that_were_asked_for_stay(self) -> None:
        form = batch_within(scene(), 1000, [JointWord.DOORS, JointWord.DRAWERS])
        assert joints_of(form, "thing_0") == ["door_hinge", "drawer_slide"]
        words = {joint.name: joint_word(cupboard(), joint) for joint in cupboard().joints}
        of_cupboard = (JointWord.DOORS, JointWord.DRAWERS, JointWord.BUTTONS, JointWord.KNOBS)
        assert words == dict(zip(CUPBOARD_JOINTS, of_cupboard, strict=True))

    @pytest.mark.parametrize("of", ["collider_count", "pair_count"])
    def test_the_last_of_several_units_is_locked_first(self, of: str) -> None:
        free = batch_within(scene(), 1000)
        most = getattr(free, of) - 1
        form = batch_within(scene(), most) if of == "collider_count" else batch_within(scene(), 1000, most_pairs=most)
        assert joints_of(form, "thing_0") == CUPBOARD_JOINTS
        assert joints_of(form, "thing_1") == []
        assert getattr(form, of) <= most

    def test_near_the_limit_not_everything_is_given_up(self) -> None:
        """All given up is a few primitives below the limit here, and one unit would have been enough."""
        row = light_scene(room(*((cupboard(), at(0.6 * k, 0, 0)) for k in range(3))))
        form = batch_within(row, batch_within(row, 0).collider_count + NEAR_ENOUGH)
        assert [len(joints_of(form, f"thing_{k}")) for k in range(3)] == [4, 4, 0]
        assert batch_within(scene(), 300).locked == (), "where there is room nothing is locked"
