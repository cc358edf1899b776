"""Each BEH code: silent on what behaves, and alone in speaking where one thing is wrong; and the interpreter itself."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from casa_assets import registry
from casa_assets.checks.check import run
from casa_assets.checks.runtime.behavior import fingertip_model, position, unreached
from casa_assets.checks.table import TABLE
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.behavior import (
    Behavior,
    Condition,
    Effect,
    EffectKind,
    Rule,
    Stimulus,
    Variable,
    start_behavior,
    step_behavior,
)
from casa_assets.model.registry.contract import Contract
from tests.support.asset.contract_fixtures import HIGH, block, burning, hob, oven, packed
from tests.unit.checks.test_contract_checks import codes

KNOWN = registry.load()
ROWS = [check for check in TABLE if check.code.startswith("BEH")]
Make = Callable[[], Asset]
SWITCH = Variable(name="power", values=("off", "on"), initial="off")
PRESS = Condition(contact="key", begins=True)


def behaving(asset: Asset, **changes: object) -> Asset:
    assert asset.behavior is not None
    return asset.replace(behavior=asset.behavior.replace(**changes))


def with_value(value: str) -> Asset:
    power = SWITCH.replace(values=("off", "on", value))
    return behaving(oven(), variables=(power,))


def affecting(kind: EffectKind, target: str, **changes: object) -> Asset:
    effect = Effect(variable="burner_left", value="low", kind=kind, target=target)
    return behaving(hob(), effects=(effect.replace(**changes),))


def deaf_to_the_door() -> Asset:
    plain = oven()
    assert plain.behavior is not None
    return behaving(plain, rules=plain.behavior.rules[1:])


def walled_in() -> Asset:
    """An oven whose start button lies in a recess that no finger fits."""
    plain = oven()
    sizes = ((0.005, 0.02, 0.04), (0.005, 0.02, 0.04), (0.04, 0.02, 0.005), (0.04, 0.02, 0.005), (0.026, 0.002, 0.018))
    places = (
        (0.1825, -0.19, 0.05),
        (0.2175, -0.19, 0.05),
        (0.2, -0.19, 0.0375),
        (0.2, -0.19, 0.0625),
        (0.2, -0.192, 0.05),
    )
    walls = (block(f"wall_{i}", size, at) for i, (size, at) in enumerate(zip(sizes, places, strict=True)))
    root = plain.root.replace(colliders=(*plain.root.colliders, *walls))
    return plain.replace(links=(root, *plain.links[1:]))


BAD: list[tuple[str, Make, Make]] = [
    ("BEH001", oven, lambda: with_value("grill")),
    ("BEH002", hob, lambda: affecting(EffectKind.SHOW, "main")),
    ("BEH002", hob, lambda: affecting(EffectKind.SPIN, "burner_on_left")),
    ("BEH002", hob, lambda: affecting(EffectKind.SHOW, "burner_on_left", color=(1.0, 0.0, 0.0, 0.0))),
    ("BEH002", hob, lambda: affecting(EffectKind.LIGHT, "ring", color=(0.0, 0.0, 0.0, 1.0))),
    ("BEH003", oven, lambda: oven().replace(behavior=None)),
    ("BEH003", oven, deaf_to_the_door),
    ("BEH003", oven, walled_in),
    ("BEH003", hob, lambda: hob().replace(behavior=burning(0.45, HIGH))),
    ("BEH003", hob, lambda: hob().replace(keyframes=(hob().keyframes[0], hob().keyframes[0].replace(name="on")))),
]
EXAMPLES: dict[str, tuple[Make, Make]] = {code: (good, bad) for code, good, bad in BAD}


@pytest.mark.parametrize(("code", "good", "bad"), BAD)
def test_trips_one_code(code: str, good: Make, bad: Make, tmp_path: Path) -> None:
    assert codes(good(), tmp_path / "good") == set()
    assert codes(bad(), tmp_path / "bad") == {code}


def message(asset: Asset, folder: Path, contract: Contract | None = None) -> list[str]:
    report = run(packed(asset, folder, contract), "subject", KNOWN.limits, table=ROWS)
    return [f"{issue.pointer}: {issue.message}" for issue in report.issues]


def test_says_what_is_wrong_and_where(tmp_path: Path) -> None:
    found = message(deaf_to_the_door(), tmp_path)
    assert found == ["trials/the_door_ends_it/1: after microjoint to 1 power is 'on', not 'off'"]
    found = message(hob().replace(behavior=burning(0.45, HIGH)), tmp_path / "threshold")
    assert [one for one in found if "0.45" in one and "burner_on 0.35" in one]
    still = hob().keyframes[0]
    found = message(hob().replace(keyframes=(still, still.replace(name="on"))), tmp_path / "pose")
    assert found == ["keyframes/on: in this pose burner_left is 'off', not 'low|high'"]


def walk(behavior: Behavior, acts: list[tuple[dict[str, float], set[str]]], dt: float = 0.05) -> list[str]:
    machine, found = start_behavior(behavior), []
    for joints, touched in acts:
        machine = step_behavior(machine, Stimulus(joints, frozenset(touched)), dt)
        found.append(machine.values[behavior.variables[0].name])
    return found


IDLE: tuple[dict[str, float], set[str]] = ({}, set())
HELD: tuple[dict[str, float], set[str]] = ({}, {"key"})


class TestMachine:
    def test_a_press_counts_once(self) -> None:
        rules = (Rule(variable="power", from_values=("off",), to="on", when=(PRESS,)),)
        other = Rule(variable="power", from_values=("on",), to="off", when=(Condition(contact="stop"),))
        both = Behavior(variables=(SWITCH,), rules=(*rules, other))
        acts = [IDLE, HELD, ({}, {"key", "stop"}), HELD, IDLE, HELD]
        assert walk(both, acts) == ["off", "on", "off", "off", "off", "on"]

    def test_both_ends_of_an_interval_count(self) -> None:
        rule = Rule(variable="power", to="on", when=(Condition(joint="knob", interval=(0.35, 1.0)),))
        back = Rule(variable="power", to="off", when=(Condition(joint="knob", interval=(0.35, 1.0), negated=True),))
        turned = [({"knob": at}, set[str]()) for at in (0.349, 0.35, 0.7, 1.0, 1.001)]
        assert walk(Behavior(variables=(SWITCH,), rules=(rule, back)), turned) == ["off", "on", "on", "on", "off"]

    def test_waiting_begins_anew_where_it_is_interrupted(self) -> None:
        rule = Rule(variable="power", to="on", when=(Condition(contact="key"),), after_s=0.15)
        machine = Behavior(variables=(SWITCH,), rules=(rule,))
        assert walk(machine, [HELD, HELD, IDLE, HELD, HELD, HELD]) == ["off"] * 5 + ["on"]

    def test_rules_of_a_step_see_the_values_of_before_and_the_first_of_a_variable_decides(self) -> None:
        lamp = Variable(name="lamp", values=("dark", "bright"), initial="dark")
        on = Rule(variable="power", to="on", when=(Condition(contact="key"),))
        then = Rule(variable="lamp", to="bright", when=(Condition(variable="power", equals="on"),))
        for rules in ((on, then), (then, on)):
            assert walk(Behavior(variables=(lamp, SWITCH), rules=rules), [HELD, HELD]) == ["dark", "bright"]
        off = on.replace(to="off")
        assert walk(Behavior(variables=(SWITCH,), rules=(on, off)), [HELD, HELD]) == ["on", "on"]
        assert walk(Behavior(variables=(SWITCH,), rules=(off, on)), [HELD, HELD]) == ["off", "off"]


class TestReachable:
    def test_finds_what_takes_several_moves(self) -> None:
        """A door has to be shut, then a key pressed, then a minute has to pass."""
        shut = Condition(joint="door", interval=(-0.01, 0.01))
        power = Variable(name="power", values=("off", "on", "done"), initial="off")
        rules = (
            Rule(variable="power", from_values=("off",), to="on", when=(PRESS, shut)),
            Rule(variable="power", from_values=("on",), to="done", when=(shut,), after_s=60.0),
        )
        assert unreached(Behavior(variables=(power,), rules=rules), {"door": (-1.5, 0.0)}) == []
        assert unreached(Behavior(variables=(power,), rules=rules), {"door": (-1.5, -0.5)}) == [
            ("power", "on"),
            ("power", "done"),
        ]

    def test_an_interval_out_of_range_is_never_met(self) -> None:
        rule = Rule(variable="power", to="on", when=(Condition(joint="knob", interval=(2.0, 3.0)),))
        machine = Behavior(variables=(SWITCH,), rules=(rule,))
        assert unreached(machine, {"knob": (0.0, 1.9)}) == [("power", "on")]
        assert unreached(machine, {"knob": (0.0, 2.0)}) == []


def test_a_fingertip_touches_one_key(tmp_path: Path) -> None:
    model = fingertip_model(packed(oven(), tmp_path))
    assert model is not None
    pressed = model.press({}, "stop_button")
    assert pressed is not None
    assert pressed.touched == {"stop_button"}


def test_ways_go_from_zero() -> None:
    ways = [((-1.5, 0.0), 1.0), ((0.0, 2.0), 0.5), ((-0.7, 0.7), 1.0), ((-0.7, 0.7), -1.0)]
    assert [position(span, way) for span, way in ways] == pytest.approx([-1.5, 1.0, 0.7, -0.7])
