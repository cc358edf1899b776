"""Steps of a state machine as a page asks for them."""

from __future__ import annotations

import json
from typing import Any

import pytest

from casa_assets.errors import CasaError
from casa_assets.model.asset.asset import Asset
from casa_assets.registry.families import family
from casa_assets.show.view import model as machines
from tests.support.asset.family_members import preset


def stepped(asset: Asset, state: dict[str, Any], **said: Any) -> dict[str, Any]:
    """The answer to a page that sends the last state back."""
    assert asset.behavior is not None
    kept = {name: state[name] for name in ("values", "before", "held_s") if name in state}
    sent = machines.parse(json.dumps({**kept, **said}).encode())
    answer: dict[str, Any] = json.loads(json.dumps(machines.step(asset.behavior, sent)))
    return answer


def test_a_knob_lights_its_burner_and_turned_back_puts_it_out() -> None:
    hob = preset("hob", "gas_five")
    assert hob.behavior is not None
    knob = hob.behavior.joints[0]
    end = max(next(joint.range for joint in hob.joints if joint.name == knob), key=abs)
    off = stepped(hob, {}, joints={knob: 0.0})
    assert off["effects"] == []
    lit = stepped(hob, off, joints={knob: end}, dt_s=0.1)
    assert {effect["kind"] for effect in lit["effects"]} >= {"show", "heat"}
    (target,) = {effect["target"] for effect in lit["effects"]}
    assert target.startswith("burner_on_")
    assert stepped(hob, lit, joints={knob: 0.0}, dt_s=0.1)["effects"] == []


def test_a_key_starts_and_another_stops() -> None:
    microwave = preset("microwave", "steel")
    begin = stepped(microwave, {})
    assert begin["values"]["power"] == "off"
    on = stepped(microwave, begin, touched=["start_button"], dt_s=0.1)
    assert on["values"]["power"] == "on"
    on = stepped(microwave, on, dt_s=0.1)
    assert on["values"]["power"] == "on"
    assert stepped(microwave, on, touched=["stop_button"], dt_s=0.1)["values"]["power"] == "off"


def test_time_alone_ends_what_runs_for_a_while() -> None:
    machine = preset("coffee_machine", "espresso_steel")
    on = stepped(machine, stepped(machine, {}), touched=["start_button"], dt_s=0.1)
    assert on["values"]["power"] == "on"
    state = stepped(machine, on, dt_s=0.5)
    assert state["waits"]
    done = stepped(machine, state, dt_s=30.0)
    assert done["values"]["power"] == "off"
    assert not stepped(machine, done, dt_s=0.5)["waits"]


def test_what_is_no_step_is_told(subtests: pytest.Subtests) -> None:
    for said, what in [
        (b"no json", "no step of a state machine"),
        (b'{"joints": {"a": "far"}}', "joints.a"),
        (b'{"command": "rm"}', "command"),
        (b'{"dt_s": "NaN"}', "dt_s"),
    ]:
        with subtests.test(said=said, what=what), pytest.raises(CasaError, match=what):
            machines.parse(said)


def test_a_state_that_the_machine_cannot_be_in_is_refused() -> None:
    microwave = preset("microwave", "steel")
    begin = stepped(microwave, {})
    for wrong in (
        {"values": {"power": "melted", "lamp": "off"}},
        {"values": {"power": "on"}},
        {"held_s": [0.0]},
        {"before": [[True]] * len(begin["held_s"])},
    ):
        with pytest.raises(CasaError):
            stepped(microwave, {**begin, **wrong})


def test_a_page_is_told_where_what_acts_is() -> None:
    hob, microwave, knife = (
        preset("hob", "gas_five"),
        preset("microwave", "steel"),
        preset("knife_block", next(iter(family("knife_block").presets))),
    )
    told = machines.describe(hob, "stove")
    assert told is not None
    assert told["placement"] == "stove"
    assert set(told["variables"]) == {variable.name for variable in hob.behavior.variables}  # type: ignore[union-attr]
    flame = next(iter(told["targets"].values()))
    assert (flame["is"], len(flame["size"]), len(flame["quaternion"])) == ("site", 3, 4)
    told = machines.describe(microwave)
    assert told is not None
    lamp = told["targets"]["lamp_visual"]
    assert lamp["is"] == "visual"
    assert max(max(face) for face in lamp["faces"]) == len(lamp["points"]) - 1
    assert told["targets"]["int"]["is"] == "region"
    assert {key["name"]: key["joint"] for key in told["contacts"]} == {
        "start_button": "start_button_joint",
        "stop_button": "stop_button_joint",
    }
    assert machines.describe(knife) is None
