"""State machines on the names of a kind: what moving a joint or touching a key brings about."""

from __future__ import annotations

import math

import pytest

from casa_assets.articulate.runtime_semantics import behavior_for
from casa_assets.core.behavior_interpreter import BehaviorState, Stimulus, start, step
from casa_assets.model.asset.asset import Asset, Collider, Joint, JointKind, Link, Region, Site
from casa_assets.model.asset.parts import Box
from casa_assets.model.record import Vec2
from tests.support.asset.articulated_assets import microwave
from tests.support.asset.asset_parts import box_inertial

SMALL = (0.02, 0.02, 0.02)


def thing(joints: dict[str, Vec2], keys: tuple[str, ...] = (), sites: tuple[str, ...] = ()) -> Asset:
    """A body with a link to each joint and a collider to each key."""
    plain = microwave()
    boxes = tuple(Collider(name=k, shape=Box(size=SMALL), substance="steel") for k in keys)
    links = [plain.root.replace(colliders=(*plain.root.colliders, *boxes))]
    moved = []
    for name, span in joints.items():
        child = name.removesuffix("_joint") or "part"
        grip = Collider(name=f"{child}_main", shape=Box(size=SMALL), substance="steel")
        inertial = box_inertial(0.1, SMALL, (0.0, 0.0, 0.0))
        links.append(Link(name=child, parent="object", inertial=inertial, colliders=(grip,)))
        moved.append(Joint(name=name, child=child, kind=JointKind.HINGE, axis=(0.0, 0.0, 1.0), range=span))
    return plain.replace(
        links=tuple(links),
        joints=tuple(moved),
        states=(),
        exclusions=(),
        keyframes=(),
        behavior=None,
        sites=tuple(Site(name=s) for s in sites),
        regions=(Region(name="int", size=SMALL), Region(name="fridge_shelf0", size=SMALL)),
    )


class Run:
    """A machine that is operated step by step."""

    def __init__(self, asset: Asset, category: str) -> None:
        behavior = behavior_for(asset, category)
        assert behavior is not None
        self.machine: BehaviorState = start(behavior)
        self.joints = {j.name: 0.0 for j in asset.joints}
        self.go()

    def go(self, touched: str = "", steps: int = 3, **moved: float) -> dict[str, str]:
        self.joints |= moved
        for _ in range(steps):
            self.machine = step(self.machine, Stimulus(self.joints, frozenset([touched] if touched else [])), 0.05)
        return dict(self.machine.values)


def test_a_microwave_heats_while_it_is_shut() -> None:
    run = Run(thing({"microjoint": (-1.57, 0.0)}, ("start_button", "stop_button")), "microwave")
    assert run.go() == {"power": "off"}
    assert run.go("start_button") == {"power": "on"}
    assert [(e.kind.value, e.target) for e in run.machine.effects] == [("heat", "int")]
    run.go()
    assert run.go("stop_button") == {"power": "off"}
    run.go()
    run.go("start_button")
    assert run.go(microjoint=-0.4) == {"power": "off"}
    assert run.go("start_button") == {"power": "off"}


def test_a_knob_turns_its_burner_low_and_high() -> None:
    joints = {"knob_left_joint": (0.0, 5.24), "knob_right_joint": (0.0, 5.24)}
    run = Run(thing(joints, sites=("burner_on_left", "burner_on_right")), "hob")
    assert run.go(knob_left_joint=0.3) == {"burner_left": "off", "burner_right": "off"}
    assert run.go(knob_left_joint=0.5)["burner_left"] == "low"
    assert run.go(knob_left_joint=math.radians(100)) == {"burner_left": "high", "burner_right": "off"}
    assert {e.target for e in run.machine.effects} == {"burner_on_left"}
    assert run.go(knob_left_joint=0.0)["burner_left"] == "off"


@pytest.mark.parametrize("far", [-1.57, 1.57])
def test_a_fridge_lights_while_one_of_its_doors_is_open(far: float) -> None:
    span = (min(far, 0.0), max(far, 0.0))
    doors = {"fridge_left_door_joint": span, "fridge_right_door_joint": span, "freezer_door_joint": span}
    run = Run(thing(doors, sites=("lamp",)), "refrigerator")
    assert run.go() == {"light": "off"}
    assert run.go(freezer_door_joint=far) == {"light": "off"}
    assert run.go(fridge_right_door_joint=far) == {"light": "on"}
    assert run.go(fridge_right_door_joint=0.002 * far) == {"light": "off"}


def test_the_lever_of_a_toaster_switches_it_on_and_its_key_off() -> None:
    run = Run(thing({"lever_joint": (-0.05, 0.0)}, ("button_cancel",)), "toaster")
    assert run.go(lever_joint=-0.03) == {"power": "off"}
    assert run.go(lever_joint=-0.05) == {"power": "on"}
    assert run.go("button_cancel") == {"power": "off"}
    run.go(lever_joint=0.0)
    assert run.go(lever_joint=-0.05) == {"power": "on"}
    assert run.go(lever_joint=0.0) == {"power": "off"}


def test_a_coffee_machine_pours_and_stops_by_itself() -> None:
    run = Run(thing({}, ("start_button",), ("coffee_liquid",)), "coffee_machine")
    assert run.go("start_button") == {"power": "on"}
    assert {e.kind.value for e in run.machine.effects} == {"show", "flow"}
    assert run.go(steps=200) == {"power": "on"}
    assert run.go(steps=320) == {"power": "off"}


def test_water_runs_by_how_far_the_handle_is_turned() -> None:
    run = Run(thing({"handle_joint": (0.0, 1.57), "handle_temp_joint": (-1.0, 1.0)}, sites=("water",)), "sink")
    assert run.go(handle_joint=0.3) == {"water": "off", "temperature": "cold"}
    assert run.go(handle_joint=0.6, handle_temp_joint=0.9) == {"water": "low", "temperature": "hot"}
    assert run.go(handle_joint=1.4)["water"] == "high"


def test_what_has_no_controls_has_no_states() -> None:
    assert behavior_for(thing({"microjoint": (-1.57, 0.0)}), "microwave") is None
    assert behavior_for(thing({"knob_left_joint": (0.0, 5.0)}), "hob") is None
    assert behavior_for(thing({"doorhinge": (-1.57, 0.0)}), "base_cabinet") is None
