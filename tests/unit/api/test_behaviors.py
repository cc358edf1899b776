"""State machines and joint states of fixtures, beside a simulation of them."""

from __future__ import annotations

import math

import mujoco
import pytest

import casa_assets as casa
from casa_assets.asset.lightweight import light_scene
from casa_assets.formats.mjcf import kitchen
from casa_assets.layouts.run.load_scene import spec_of
from casa_assets.mesh.inertia import ready_to_simulate
from casa_assets.model.asset.behavior import Behavior, Condition, Rule, Variable
from casa_assets.model.asset.parts import State
from casa_assets.model.kitchen.scene import Placement, Scene
from casa_assets.model.pose import Pose
from tests.support.asset.contract_fixtures import hob, oven

# The face of the start button of `oven`, seen from the middle of its foot, and the radius of a ball that touches it.
BUTTON, BALL = (0.2, -0.189, 0.05), 0.005
STATES = (
    State(name="microjoint_closed", joint="microjoint", value="closed", interval=(0.0, 0.005)),
    State(name="microjoint_open", joint="microjoint", value="open", interval=(0.9, 1.0)),
)


def room() -> Scene:
    """Two ovens with a hob between them, on the x axis."""
    heater = oven().replace(states=STATES)
    places = (("oven", heater), ("hob", hob()), ("oven_2", heater))
    placements = (
        Placement(name=name, asset=asset.id, pose=Pose(position=(float(x), 0.0, 0.0)))
        for x, (name, asset) in enumerate(places)
    )
    return ready_to_simulate(Scene(id="room", assets=(heater, hob()), placements=tuple(placements)))


class Bench:
    """A room with a ball in it that touches what it is put before; time goes on by hand."""

    def __init__(self, light: bool = False, prefix: str = "") -> None:
        spec = spec_of(kitchen.write(light_scene(room()) if light else room(), shared="assets"))
        if prefix:
            host = mujoco.MjSpec()
            host.attach(spec, frame=host.worldbody.add_frame(), prefix=prefix)
            spec = host
        ball = spec.worldbody.add_body(name="ball")
        ball.add_geom(size=[BALL, 0, 0], mass=0.01)
        ball.add_freejoint(name="ball")
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.behaviors = casa.Behaviors(self.model)
        self.put_ball((0.0, 0.0, 5.0))
        self.behaviors.reset(self.data)

    def put_ball(self, at: tuple[float, float, float]) -> None:
        """Put the middle of the ball there, metres."""
        self.data.joint("ball").qpos[:3] = at
        mujoco.mj_forward(self.model, self.data)

    def press(self, x: float) -> None:
        """Touch the start button of the oven there."""
        self.put_ball((x + BUTTON[0], BUTTON[1] - BALL + 0.0005, BUTTON[2]))

    def turn(self, joint: str, position: float) -> None:
        """Put a joint there, rad."""
        self.data.joint(joint).qpos[0] = position
        mujoco.mj_forward(self.model, self.data)

    def tick(self, seconds: float = 0.05) -> casa.FixtureStates:
        """One control step later."""
        self.data.time += seconds
        return self.behaviors.update(self.data)


@pytest.mark.parametrize("light", [False, True])
def test_a_touched_key_starts_its_own_oven_until_the_door_opens(light: bool) -> None:
    bench = Bench(light)
    bench.press(2.0)
    assert bench.behaviors.reset(bench.data)["oven_2"]["power"] == "off", "what is touched at a reset is not pressed"
    assert bench.tick()["oven_2"]["power"] == "off"
    bench.put_ball((0.0, 0.0, 5.0))
    bench.tick()
    bench.press(2.0)
    states = bench.tick()
    assert states["oven"] == {"power": "off", "microjoint": "closed"}
    assert states["oven_2"] == {"power": "on", "microjoint": "closed"}
    assert list(bench.behaviors.effects) == ["oven_2"]
    assert [e.target for e in bench.behaviors.effects["oven_2"]] == ["int"]
    bench.turn("oven_2__microjoint", -math.pi / 2)
    assert bench.tick()["oven_2"] == {"power": "off", "microjoint": "open"}


class TestStates:
    def test_a_knob_sets_its_burner(self) -> None:
        bench = Bench()
        for angle, state in ((0.0, "off"), (0.5, "low"), (2.0, "high")):
            bench.turn("hob__knob_left_joint", angle)
            assert bench.tick()["hob"]["burner_left"] == state

    def test_a_joint_is_in_a_state_or_between_two(self) -> None:
        bench = Bench()
        for angle, state in [(0.01, "closed"), (-0.1, None), (-1.5, "open"), (-1.7, "open")]:
            bench.turn("oven__microjoint", angle)
            assert bench.behaviors.states(bench.data)["oven"]["microjoint"] == state, angle

    def test_names_of_a_merged_model(self) -> None:
        bench = Bench(prefix="left_")
        assert sorted(bench.behaviors.values) == ["left_hob", "left_oven", "left_oven_2"]
        bench.press(0.0)
        bench.turn("left_oven_2__microjoint", -math.pi / 2)
        states = bench.tick()
        assert states["left_oven"]["power"] == "on"
        assert states["left_oven_2"]["microjoint"] == "open"


def model_with(rule: Rule, bodies: str) -> mujoco.MjModel:
    """A model of bodies of which one has a power that a rule turns on."""
    power = Variable(name="power", values=("off", "on"), initial="off")
    text = Behavior(variables=(power,), rules=(rule,)).to_json()
    head = f"<custom><text name='behavior' data='{text}'/></custom>"
    return mujoco.MjModel.from_xml_string(f"<mujoco>{head}<worldbody>{bodies}</worldbody></mujoco>")


KEY = """<body name="object"><geom name="key" type="box" size=".1 .1 .1"/>
  <body pos="0 0 .3"><joint name="lid" type="slide" axis="0 0 1" range="-.2 0"/><geom size=".11"/></body>
  <body pos=".3 0 0"><body><geom size=".1"/><joint type="slide"/></body></body>
</body>
<body name="finger" pos="0 .3 0"><joint name="finger" type="slide" axis="0 1 0"/><geom size=".11"/></body>
"""


class TestOneAsset:
    def test_its_own_parts_do_not_press_its_keys(self) -> None:
        model = model_with(Rule(variable="power", to="on", when=(Condition(contact="key"),)), KEY)
        data, behaviors = mujoco.MjData(model), casa.Behaviors(model)
        assert behaviors.reset(data) == {"object": {"power": "off"}}
        for touching, (part, power) in enumerate((("lid", "off"), ("finger", "on")), start=1):
            data.joint(part).qpos[0] = -0.1
            mujoco.mj_forward(model, data)
            assert data.ncon == touching
            assert behaviors.update(data) == {"object": {"power": power}}

    def test_waiting_goes_by_the_time_of_the_simulation(self) -> None:
        turned = Condition(joint="dial", interval=(0.5, 1.0))
        dial = '<body name="object"><joint name="dial" range="0 1" limited="true"/><geom size=".1"/></body>'
        model = model_with(Rule(variable="power", to="on", when=(turned,), after_s=1.0), dial)
        data, behaviors = mujoco.MjData(model), casa.Behaviors(model)
        data.qpos[0] = 0.7
        found = [behaviors.reset(data)["object"]["power"]]
        for data.time in (0.4, 0.9, 1.0):
            found.append(behaviors.update(data)["object"]["power"])
        assert found == ["off", "off", "off", "on"]

    def test_a_forgotten_reset_is_an_error(self) -> None:
        bench = Bench()
        bench.tick()
        mujoco.mj_resetData(bench.model, bench.data)
        with pytest.raises(casa.CasaError, match="reset"):
            bench.behaviors.update(bench.data)
