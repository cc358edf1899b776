"""Kitchens for RoboCasa: fixtures, frames, what is told of them, registration; and their start states."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from lxml import etree

from casa_assets.addons.robocasa import casa_kitchens, kitchens, parts
from casa_assets.addons.robocasa.kitchens import translated
from casa_assets.addons.robocasa.run import classes
from casa_assets.formats import mjcf
from casa_assets.layouts.run.state_file import write_states
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.kitchen.scene import Light, Placement, Scene, StartStates
from casa_assets.model.pose import Pose
from tests.support.asset.assets import write_to
from tests.support.asset.family_members import preset
from tests.support.kitchen.rooms import at, block
from tests.support.kitchen.scenes import QUARTER, start_states

UNIT, CORNER = ("drawer_stack", "navy_cups_four"), ("counter_corner", "upstand")
COUNTER, OVEN = ("counter", "quartz_eased"), ("microwave", "steel")
TOP_M = 0.92


@cache
def kitchen() -> Scene:
    """Drawers below a worktop with a microwave on it, all of them turned, and a sun."""
    unit, counter, oven = preset(*UNIT), preset(*COUNTER), preset(*OVEN)
    depth = parts.main_center(counter)[2] + parts.main_region(counter).size[2] / 2
    return Scene(
        id="test_room",
        assets=(unit, counter, oven),
        placements=(
            Placement(name="stack_1", asset=unit.id, pose=Pose(position=(1.0, 2.0, 0.0), quaternion=QUARTER)),
            Placement(name="counter_1", asset=counter.id, pose=Pose(position=(1.0, 2.0, TOP_M - depth))),
            Placement(name="oven", asset=oven.id, pose=Pose(position=(1.0, 2.0, TOP_M))),
        ),
        lights=(Light(name="sun", position=(0.0, 0.0, 2.4), direction=(0.0, 0.5, -1.0)),),
    )


def fixtures() -> tuple[kitchens.Placed, ...]:
    return kitchens.fixtures_of(kitchen(), classes())


def positions(asset: Asset, folder: Path, opened: float) -> dict[str, np.ndarray]:
    """Name of each collider -> its place when every joint stands at this share of its range, asset frame, metres."""
    model = mujoco.MjModel.from_xml_path(str(write_to(mjcf.write(asset), folder) / kitchens.MODEL))
    data = mujoco.MjData(model)
    for index in range(model.njnt):
        low, high = model.jnt_range[index]
        data.qpos[model.jnt_qposadr[index]] = low + opened * (high - low)
    mujoco.mj_kinematics(model, data)
    return {model.geom(i).name: data.geom_xpos[i].copy() for i in range(model.ngeom) if model.geom_contype[i]}


@pytest.mark.parametrize("which", [UNIT, CORNER, OVEN])
def test_what_is_divided_and_centred_moves_as_before(which: tuple[str, str], tmp_path: Path) -> None:
    whole = preset(*which)
    for opened in (0.0, 0.7):
        expected = positions(whole, tmp_path / f"whole{opened}", opened)
        found: dict[str, np.ndarray] = {}
        for number, part in enumerate(parts.divide(whole)):
            middle = np.array(parts.main_center(part.asset))
            moved = positions(parts.moved(part.asset, middle), tmp_path / f"{number}_{opened}", opened)
            found |= {name: part.whole_from_part.apply(place + middle) for name, place in moved.items()}
        assert found.keys() == expected.keys()
        for name, place in expected.items():
            assert found[name] == pytest.approx(place, abs=1e-6), name


@pytest.mark.parametrize("which", ["left", "right"])
def test_an_l_shaped_worktop_becomes_two_that_face_the_room(which: str) -> None:
    whole = preset("counter_corner", which)
    wide, deep = parts.main_region(whole).size[:2]
    back = next(region.size[1] for region in whole.regions if region.name == "top")
    side = next(region.size[0] for region in whole.regions if region.name == parts.SIDE_TOP)
    for is_corner_of_side in (False, True):
        found = parts.divide(whole, is_corner_of_side)
        faces = [sum(len(v.mesh.faces) for link in part.asset.links for v in link.visuals) for part in found]
        assert sum(faces) == sum(len(v.mesh.faces) for link in whole.links for v in link.visuals)
        assert min(faces) > 0
        sizes = [parts.main_region(part.asset).size[:2] for part in found]
        lengths = (wide - side, deep) if is_corner_of_side else (wide, deep - back)
        assert sizes == [pytest.approx((lengths[0], back)), pytest.approx((lengths[1], side))]
        # The wall behind the second arm is on the other side of its front, which looks into the room.
        front = found[1].whole_from_part.rotation @ np.array([0.0, -1.0, 0.0])
        assert front == pytest.approx([1.0 if which == "left" else -1.0, 0.0, 0.0], abs=1e-9)


def test_what_is_described_of_a_kitchen_and_its_arena() -> None:
    rows = {row["name"]: row for row in kitchens.describe(kitchen(), fixtures(), kitchens.FIXTURES)["fixtures"]}
    assert [name for name, row in rows.items() if row["class"] == "Drawer"] == [f"unit_1_drawer{k}" for k in range(4)]
    rest, *drawers = parts.divide(preset(*UNIT))
    assert (rest.asset.joints, len({round(parts.main_center(part.asset)[2], 3) for part in drawers})) == ((), 4)
    for part in drawers:
        assert (part.asset.contract, [joint.name for joint in part.asset.joints]) == ("drawer", ["slidejoint"])
        assert {"main", "int"} <= {region.name for region in part.asset.regions}
    assert (rows["counter_1"]["class"], rows["oven"]["class"]) == ("Counter", "Microwave")
    assert (rows["oven"]["is_standing"], rows["unit_1"]["is_standing"]) == (True, False)
    # Below its tray, which RoboCasa fills while it lets nothing overlap what stands on a worktop.
    assert 0.02 <= rows["oven"]["solid_height"] < 0.12
    assert rows["unit_1"]["placement"] == "stack_1"
    height = parts.main_region(preset(*COUNTER)).size[2]
    assert rows["counter_1"]["position"][2] + height / 2 == pytest.approx(TOP_M, abs=1e-6)
    assert json.loads(kitchens.write_kitchen(kitchen(), fixtures()).entries[kitchens.FILE])["id"] == "test_room"
    pairs = kitchens.excluded_bodies(kitchen(), fixtures())
    root = etree.fromstring(kitchens.arena(kitchen(), pairs))
    assert [light.get("directional") for light in root.iter("light")] == ["true"]
    assert root.find(".//light").get("ambient")
    assert len(root.findall(".//exclude")) == len(pairs)
    links = [(item.name, ("main", *(link.name for link in item.centered.links))) for item in fixtures()]
    assert {body for pair in pairs for body in pair} <= {f"{item}_{name}" for item, names in links for name in names}


def test_register_touches_only_its_own_kitchens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The two modules of RoboCasa in which names are replaced, each name as a function that says that it was called.
    module: Any = ModuleType("robocasa.environments.kitchen.kitchen")
    vars(module)["KitchenArena"] = lambda layout_id, **_: ("their arena", layout_id)
    vars(module)["EnvUtils"] = SimpleNamespace(get_single_fixture_sampler=lambda env, cfg: "their sampler")
    scenes: Any = ModuleType("robocasa.models.scenes.scene_registry")
    vars(scenes)["get_layout_path"] = lambda layout_id: f"theirs {layout_id}"
    for made in (module, scenes):
        monkeypatch.setitem(sys.modules, made.__name__, made)
    before = (module.KitchenArena, module.EnvUtils.get_single_fixture_sampler, scenes.get_layout_path)
    (tmp_path / "kitchens.json").write_text('{"kitchens": {"a__b": 1000000007, "a__c": 1000000008}}')
    try:
        assert casa_kitchens.register(tmp_path) == ("a__b", "a__c")
        assert casa_kitchens.register(tmp_path) == casa_kitchens.ids() == ("a__b", "a__c")
        assert casa_kitchens.layout_and_style_ids("a__c") == [[1000000008, 1000000008]]
        assert len(casa_kitchens.layout_and_style_ids()) == 2
        (tmp_path / "kitchens" / "a__c").mkdir(parents=True)
        (tmp_path / "kitchens" / "a__c" / "kitchen.json").write_text('{"tasks": ["OpenDrawer"]}')
        assert casa_kitchens.tasks_of("a__c") == ("OpenDrawer",)
        with pytest.raises(KeyError, match="no kitchen 'z' is registered; there are a__b, a__c"):
            casa_kitchens.layout_and_style_ids("z")
        assert casa_kitchens.kitchen_of(SimpleNamespace(layout_id=1000000007)) == "a__b"
        assert module.KitchenArena(layout_id=3, style_id=3) == ("their arena", 3)
        assert module.EnvUtils.get_single_fixture_sampler(SimpleNamespace(layout_id=3), {}) == "their sampler"
        assert scenes.get_layout_path(3) == "theirs 3"
        assert scenes.get_layout_path(1000000007) == str(tmp_path / "kitchens" / "a__b" / "layout.yaml")
    finally:
        casa_kitchens.unregister()
    assert (module.KitchenArena, module.EnvUtils.get_single_fixture_sampler, scenes.get_layout_path) == before
    assert casa_kitchens.ids() == ()


NAME, NUMBER = "test_room", 1_000_000_007
MOVED = Pose(position=(0.3, 0.4, 1.2), quaternion=(0.6, 0.0, 0.8, 0.0))


@cache
def scene() -> Scene:
    """A stack of drawers, a loose box whose frame is at its foot, and a loose kettle, which RoboCasa fixes."""
    unit, kettle = preset(*UNIT), preset("kettle", "gooseneck_steel")
    box = block("box", (0.1, 0.06, 0.08), Base.FREE)
    return Scene(
        id=NAME,
        assets=(unit, box, kettle),
        placements=(
            Placement(name="stack_1", asset=unit.id, pose=Pose(position=(1.0, 2.0, 0.0), quaternion=QUARTER)),
            Placement(name="box", asset=box.id, pose=at(0.1, 0.2, 0.9)),
            Placement(name="kettle", asset=kettle.id, pose=at(0.5, 0.2, 0.9)),
        ),
    )


def states() -> StartStates:
    """Two: the second has a drawer open and the box elsewhere."""
    joints: list[dict[str, Any]] = [
        *({"name": f"stack_1__drawer{k}_slidejoint", "address": k, "width": 1} for k in range(4)),
        *({"name": f"{name}__free", "address": at, "width": 7} for name, at in (("box", 4), ("kettle", 11))),
    ]
    rows = np.zeros((2, 18))
    rows[:, 4:11] = (0.1, 0.2, 0.9, 1.0, 0.0, 0.0, 0.0)
    rows[:, 11:18] = (0.5, 0.2, 0.9, 1.0, 0.0, 0.0, 0.0)
    rows[1, 1] = 0.25
    rows[1, 4:11] = (*MOVED.position, *MOVED.quaternion)
    return start_states(NAME, joints, rows, base=[[1.0, 2.0, 0.0], [0.5, -1.0, 2.5]])


@cache
def in_robocasa() -> StartStates:
    return translated(states(), scene(), kitchens.fixtures_of(scene(), classes()))


def test_what_is_loose_is_where_its_fixture_would_be() -> None:
    (joint,) = (joint for joint in in_robocasa().joints if joint.width == 7)
    assert joint.name == "box_joint0"
    placements = tuple(p.replace(pose=MOVED) if p.name == "box" else p for p in scene().placements)
    for row, where in enumerate((scene(), scene().replace(placements=placements))):
        wanted = next(item.pose for item in kitchens.fixtures_of(where, classes()) if item.name == "box")
        found = in_robocasa().qpos[row, joint.address : joint.address + 7].tolist()
        assert found == pytest.approx([*wanted.position, *wanted.quaternion], abs=1e-6)


def environment() -> Any:
    """A model with the joints of the states behind those of a base that turns about a point behind its frame."""
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody>
        <body name="root" pos="10 10 0" euler="0 0 90"><body name="base">
          <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
          <joint name="mobilebase0_joint_mobile_forward" type="slide" axis="1 0 0" pos="-0.21 0 0"/>
          <joint name="mobilebase0_joint_mobile_side" type="slide" axis="0 1 0" pos="-0.21 0 0"/>
          <joint name="mobilebase0_joint_mobile_yaw" axis="0 0 1" pos="-0.21 0 0"/>
          <site name="axis" pos="-0.21 0 0"/></body></body>
        <body name="box"><freejoint name="box_joint0"/><geom size="0.1"/></body>"""
        + "".join(
            f'<body><joint name="unit_1_drawer{k}_slidejoint" type="slide"/><geom size="0.1"/></body>' for k in range(4)
        )
        + "</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    # As robosuite has an MjModel and an MjData, as far as they are used.
    names = ("njnt", "jnt_qposadr", "jnt_bodyid", "body_parentid", "jnt_pos", "jnt_axis")
    seen = SimpleNamespace(
        **{name: getattr(model, name) for name in names},
        joint_id2name=lambda number: str(model.joint(number).name),
        joint_name2id=lambda name: int(model.joint(name).id),
    )
    moving = SimpleNamespace(qpos=data.qpos, qvel=data.qvel, body_xpos=data.xpos, body_xmat=data.xmat)
    sim = SimpleNamespace(model=seen, data=moving, forward=lambda: mujoco.mj_kinematics(model, data))
    return SimpleNamespace(sim=sim, layout_id=NUMBER, raw=(model, data))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A kitchen that is registered, with its start states."""
    place = tmp_path / NAME
    place.mkdir()
    box = {"name": "box", "lid_of": "", "position": [0.1, 0.2, 0.94], "quaternion": [1, 0, 0, 0], "is_standing": False}
    (place / "kitchen.json").write_text(json.dumps({"fixtures": [box]}), encoding="ascii")
    monkeypatch.setitem(casa_kitchens._kitchens, NUMBER, place)
    monkeypatch.setitem(casa_kitchens._numbers, NAME, NUMBER)
    write_states(place, in_robocasa())
    yield place
    casa_kitchens.begin_with(None)
    casa_kitchens._states.clear()


def test_a_reset_puts_everything_where_it_was_and_parks_the_base(folder: Path) -> None:
    env = environment()
    _, data = env.raw
    data.qvel[:] = 1.0
    casa_kitchens.reset_to(env, 1)
    assert data.joint("unit_1_drawer1_slidejoint").qpos[0] == pytest.approx(0.25)
    assert data.joint("box_joint0").qpos[:2].tolist() != [0.0, 0.0]
    assert data.body("base").xpos[:2].tolist() == pytest.approx([0.5, -1.0])
    ahead = data.body("base").xmat.reshape(3, 3)[:2, 0]
    assert ahead.tolist() == pytest.approx([np.cos(2.5), np.sin(2.5)])
    assert not data.qvel.any()
    casa_kitchens.reset_to(env, 0, parks=False)
    assert data.joint("unit_1_drawer1_slidejoint").qpos[0] == 0.0
    assert data.body("base").xpos[:2].tolist() == pytest.approx([0.5, -1.0])
    with pytest.raises(IndexError):
        casa_kitchens.reset_to(env, 2)


def test_fixtures_begin_where_a_state_has_them(folder: Path) -> None:
    rows = json.loads((folder / "kitchen.json").read_text())["fixtures"]
    rng = np.random.default_rng(0)
    assert casa_kitchens._begun(rows, folder, rng) == rows
    casa_kitchens.begin_with(1)
    (row,) = casa_kitchens._begun(rows, folder, rng)
    assert row["is_standing"]
    assert row["position"][0] == pytest.approx(MOVED.position[0] + 0.04 * 0.96, abs=1e-3)
    casa_kitchens.begin_with("random")
    assert len({tuple(casa_kitchens._begun(rows, folder, rng)[0]["position"]) for _ in range(20)}) == 2
    casa_kitchens.begin_with(None)
    assert casa_kitchens._begun(rows, folder, rng) == rows
