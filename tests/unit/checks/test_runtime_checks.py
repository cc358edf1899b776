"""Each CON and BEH code: silent on what is sound, and alone where one thing is wrong; and the interpreter itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from casa_assets import registry
from casa_assets.checks.check import run
from casa_assets.checks.runtime import contract
from casa_assets.checks.runtime.behavior import fingertip_model, unreached
from casa_assets.checks.runtime.contract import axis_of, missing_requirements, opening, regions
from casa_assets.checks.table import TABLE
from casa_assets.model.asset.asset import Asset, JointKind, Keyframe, Region
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
from casa_assets.model.pose import Pose
from casa_assets.model.registry.contract import (
    Alternatives,
    Contract,
    OpeningSide,
    PlaceRule,
    RegionRule,
    Requirements,
    Threshold,
)
from tests.support.asset.assets import microwave, rigid_mug
from tests.support.asset.contract_fixtures import HIGH, block, burning, heating, hob, oven, packed
from tests.support.asset.packages import edit, tamper, tripped

KNOWN = registry.load()
Make = Callable[[], Asset]
# An edit of model.xml that trips CON005 alone.
TAMPERED: list[tuple[Make, str]] = [
    (oven, '<body name="object" pos="0 0 {0|0.1}"'),
    (oven, '<body name="{object|thing}"'),
    (hob, '<site name="{burner_on_left|flame}"'),
    (hob, '<geom name="{reg_main|main}"'),
    (hob, '<site name="{ext_px|outer_px}"'),
    (hob, '{range="0 3.14159265"|}'),
    (oven, "{|<actuator/>}</mujoco>"),
]
SWITCH = Variable(name="power", values=("off", "on"), initial="off")
KEY, PRESS = Condition(contact="key"), Condition(contact="key", begins=True)
IDLE: tuple[dict[str, float], set[str]] = ({}, set())
HELD: tuple[dict[str, float], set[str]] = ({}, {"key"})
ROWS = [check for check in TABLE if check.code.startswith(("CON", "BEH"))]


def codes(asset: Asset, folder: Path, contract: Contract | None = None) -> set[str]:
    package = packed(asset, folder, contract)
    found = [run(s, "subject", KNOWN.limits, table=ROWS) for s in (package.asset, package)]
    return {issue.code for report in found for issue in report.issues}


def door(asset: Asset, **changes: object) -> Asset:
    return asset.replace(joints=(asset.joints[0].replace(**changes), *asset.joints[1:]))


def messages(asset: Asset, folder: Path, codes: str) -> list[str]:
    rows = [row for row in ROWS if row.code.startswith(codes)]
    report = run(packed(asset, folder), "subject", KNOWN.limits, table=rows)
    return [f"{issue.pointer}: {issue.message}" for issue in report.issues]


def without(asset: Asset, collider: str) -> Asset:
    links = [k.replace(colliders=tuple(c for c in k.colliders if c.name != collider)) for k in asset.links]
    return asset.replace(links=tuple(links))


def relabelled(asset: Asset, label: str | None) -> Asset:
    looks = [tuple(v.replace(label=label) if v.label == "burner" else v for v in k.visuals) for k in asset.links]
    return asset.replace(links=tuple(k.replace(visuals=v) for k, v in zip(asset.links, looks, strict=True)))


def nested() -> Asset:
    plain = hob()
    knob = plain.link("knob_left")
    between = plain.root.replace(name="panel", parent="object", visuals=(), colliders=())
    return plain.replace(links=(plain.root, between, knob.replace(parent="panel")))


def region(name: str, **changes: object) -> Asset:
    plain = oven()
    return plain.replace(regions=tuple(r.replace(**changes) if r.name == name else r for r in plain.regions))


def shallow() -> Asset:
    """A knob that stops before the burner is high, with poses that it can take."""
    return door(still_when_on(), range=(0.0, 1.39))


def ajar_when_open() -> Asset:
    plain = oven()
    half = plain.keyframes[1].joints[0].replace(value=-0.8)
    return plain.replace(keyframes=(plain.keyframes[0], Keyframe(name="open", joints=(half,))))


def with_door_bin() -> Asset:
    """A region on the door, whose frame is at the hinge: a loader that leaves bodies out takes it to be elsewhere."""
    plain = oven()
    box = Region(name="bin", link="door", pose=Pose(position=(0.1, 0.0, 0.0)), size=(0.1, 0.01, 0.1))
    return plain.replace(regions=(*plain.regions, box))


BAD: list[tuple[str, Make]] = [
    ("CON001", lambda: oven().replace(contract="wardrobe")),
    ("CON001", lambda: door(oven(), axis=(0.0, 0.0, -1.0))),
    ("CON002", lambda: hob().replace(sites=hob().sites[:1])),
    ("CON003", lambda: without(oven(), "tray")),
    ("CON003", lambda: relabelled(hob(), "plate")),
    ("CON004", lambda: oven().replace(regions=tuple(r for r in oven().regions if r.name != "tray"))),
    ("CON004", lambda: oven().replace(regions=oven().regions[1:])),
    ("CON004", lambda: region("main", size=(0.4, 0.41, 0.3))),
    ("CON004", lambda: region("main", size=(0.7, 0.41, 0.3))),
    ("CON004", lambda: region("int", size=(0.36, 0.34, 0.4))),
    ("CON006", ajar_when_open),
    ("CON006", lambda: oven().replace(keyframes=oven().keyframes[:1])),
    ("CON008", with_door_bin),
    ("CON008", lambda: region("tray", pose=Pose(position=(-0.04, 0.0, 0.2)))),
]


def read_at(rule: PlaceRule, folder: Path) -> list[str]:
    package = packed(oven(), folder)
    assert package.contract is not None
    return [message for _, message in contract.faults(package.mjcf, package.contract.replace(places=(rule,)))]


class TestPlaces:
    """CON008 reads a file as the loader of RoboCasa v1.0 does."""

    def test_heights_are_above_the_floor_of_the_kitchen(self, tmp_path: Path) -> None:
        high = PlaceRule(regions="tray", stands_m=1.0, heights_m=(0.45, 1.5))
        assert read_at(high, tmp_path / "high") == []
        assert "0 regions 'tray'" in read_at(high.replace(stands_m=0.0), tmp_path / "low")[0]

    def test_low_regions_and_those_of_moving_parts_are_no_shelves(self, tmp_path: Path) -> None:
        assert "0 regions" in read_at(PlaceRule(regions="tray", min_height_m=2.0), tmp_path / "tall")[0]
        package = packed(with_door_bin(), tmp_path / "bin")
        assert package.contract is not None
        shelf = package.contract.replace(places=(PlaceRule(regions="bin", fixed=True),))
        told = [message for _, message in contract.faults(package.mjcf, shelf)]
        assert any("takes it for a shelf" in message for message in told)

    def test_sites_beside_object_and_above_a_basin(self, tmp_path: Path) -> None:
        package = packed(hob(), tmp_path)
        assert package.contract is not None
        asked = package.contract.replace(beside=("lid_site",), falls_into={"burner_on_left": "basin"})
        pointers = [pointer for pointer, _ in contract.faults(package.mjcf, asked)]
        assert pointers == ["model.xml/site/lid_site", "model.xml/site/burner_on_left"]
        found = package.contract.replace(beside=("bottom_site",), falls_into={"burner_on_left": "main"})
        assert list(contract.faults(package.mjcf, found)) == []


@pytest.mark.parametrize("make", [oven, hob, rigid_mug, microwave])
def test_good_is_silent_and_every_row_looks_at_what_has_a_contract(make: Make, tmp_path: Path) -> None:
    assert codes(make(), tmp_path) == set()
    if make in (oven, hob):
        numbers = {r.code: r.number for r in run(packed(make(), tmp_path), "x", KNOWN.limits, table=ROWS).results}
        assert [code for code, number in numbers.items() if number is None] == []


class TestBad:
    @pytest.mark.parametrize(("code", "make"), BAD)
    def test_trips_one_code(self, code: str, make: Make, tmp_path: Path) -> None:
        assert codes(make(), tmp_path) == {code}

    @pytest.mark.parametrize(("make", "text"), TAMPERED)
    def test_file_trips_one_code(self, make: Make, text: str, tmp_path: Path) -> None:
        package = packed(make(), tmp_path)
        tamper(package.mjcf, edit(text))
        assert tripped(package, ("CON",)) == {"CON005"}

    def test_a_knob_that_stops_short(self, tmp_path: Path) -> None:
        """It breaks the range that is asked for, the threshold in it, and what turning it does."""
        assert codes(shallow(), tmp_path) == {"CON001", "CON006", "BEH001", "BEH003"}

    def test_what_is_nested_is_not_where_the_runtime_looks(self, tmp_path: Path) -> None:
        assert codes(nested(), tmp_path / "knob") == {"CON001", "CON005"}
        turned = "burner_left_place_site"
        sites = tuple(s.replace(link="knob_left") if s.name == turned else s for s in hob().sites)
        assert codes(hob().replace(sites=sites), tmp_path / "site") == {"CON002", "CON005"}

    def test_a_threshold_out_of_range_no_burner_at_all_and_several_faults_of_a_joint(self, tmp_path: Path) -> None:
        far = Threshold(name="burner_full", joint="knob_.*_joint", at=3.2)
        contract = KNOWN.contracts["stovetop"]
        asked = contract.replace(thresholds=(*contract.thresholds, far))
        assert codes(hob(), tmp_path / "far", asked) == {"CON006"}
        bare = hob().replace(links=hob().links[:1], joints=(), sites=(), behavior=None, keyframes=())
        assert [one.split(":")[0] for one in messages(bare, tmp_path, "CON001")] == ["contract/for_each/loc"]
        other = door(oven().replace(keyframes=()), kind=JointKind.SLIDE, range=(0.0, 0.3))
        told = " ".join(messages(other, tmp_path, "CON001"))
        assert all(part in told for part in ("is a slide, not a hinge", "should open negative", "travels 0.3"))


class TestRules:
    """Choices, values in use, and directions, on contracts made for the purpose."""

    def test_the_nearest_choice_is_reported(self) -> None:
        def sink(names: tuple[str, ...]) -> Asset:
            return hob().replace(regions=tuple(Region(name=n, size=(0.1, 0.1, 0.1)) for n in names))

        choices = (("basin",), ("left", "right"))
        one, two = (Requirements(regions=tuple(RegionRule(name=n) for n in names)) for names in choices)
        asked = Contract(id="sink", title="Sink", one_of=(Alternatives(any_of=(one, two)),))
        found = [missing_requirements(sink(n), asked, regions) for n in (("basin",), ("left", "right"), ("left",))]
        assert found[:2] == [[], []]
        assert [pointer for pointer, _ in found[2]] == ["regions/basin"]
        assert len(missing_requirements(sink(("bowl",)), asked, regions)) == 1

    def test_opening_and_axis_in_the_asset_frame(self) -> None:
        plain = hob()
        spans = [(0.0, 1.0), (-1.0, 0.0), (-1.0, 2.0), (0.5, 1.0)]
        ways = [OpeningSide.POSITIVE, OpeningSide.NEGATIVE, OpeningSide.BOTH, None]
        assert [opening(plain.joints[0].replace(range=span)) for span in spans] == ways
        turned = Pose(position=(0.0, -0.2, 0.02), quaternion=(math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0))
        askew = Pose(position=(0.0, -0.2, 0.02), quaternion=(math.cos(0.2), math.sin(0.2), 0.0, 0.0))
        for pose, axis in ((Pose(), "-z"), (turned, "+y"), (askew, "askew")):
            moved = plain.replace(links=(plain.root, plain.links[1].replace(pose=pose)))
            assert axis_of(moved, moved.joints[0]) == axis


def behaving(asset: Asset, **changes: object) -> Asset:
    assert asset.behavior is not None
    return asset.replace(behavior=asset.behavior.replace(**changes))


def affecting(kind: EffectKind, target: str, **changes: object) -> Asset:
    effect = Effect(variable="burner_left", value="low", kind=kind, target=target)
    return behaving(hob(), effects=(effect.replace(**changes),))


def deaf_to_the_door() -> Asset:
    return behaving(oven(), rules=heating().rules[1:])


def still_when_on() -> Asset:
    return hob().replace(keyframes=(Keyframe(name="closed"), Keyframe(name="on")))


def walled_in() -> Asset:
    """An oven whose start button lies in a recess that no finger fits."""
    plain = oven()
    upright, level = (0.005, 0.02, 0.04), (0.04, 0.02, 0.005)
    sides = [(upright, (0.2 + x, -0.19, 0.05)) for x in (-0.0175, 0.0175)]
    ends = [(level, (0.2, -0.19, 0.05 + z)) for z in (-0.0125, 0.0125)]
    parts = (*sides, *ends, ((0.026, 0.002, 0.018), (0.2, -0.192, 0.05)))
    walls = (block(f"wall_{i}", size, at) for i, (size, at) in enumerate(parts))
    root = plain.root.replace(colliders=(*plain.root.colliders, *walls))
    return plain.replace(links=(root, *plain.links[1:]))


MISBEHAVED: list[tuple[str, Make, Make]] = [
    ("BEH001", oven, lambda: behaving(oven(), variables=(SWITCH.replace(values=("off", "on", "grill")),))),
    ("BEH002", hob, lambda: affecting(EffectKind.SHOW, "main")),
    ("BEH002", hob, lambda: affecting(EffectKind.SPIN, "burner_on_left")),
    ("BEH002", hob, lambda: affecting(EffectKind.SHOW, "burner_on_left", color=(1.0, 0.0, 0.0, 0.0))),
    ("BEH002", hob, lambda: affecting(EffectKind.LIGHT, "ring", color=(0.0, 0.0, 0.0, 1.0))),
    ("BEH003", oven, lambda: oven().replace(behavior=None)),
    ("BEH003", oven, deaf_to_the_door),
    ("BEH003", oven, walled_in),
    ("BEH003", hob, lambda: hob().replace(behavior=burning(0.45, HIGH))),
    ("BEH003", hob, still_when_on),
]
EXAMPLES: dict[str, tuple[Make, object]] = {
    **{code: (good, bad) for code, good, bad in MISBEHAVED},
    **{code: (oven, make) for code, make in BAD},
    "CON005": TAMPERED[0],
}


@pytest.mark.parametrize(("code", "good", "bad"), MISBEHAVED)
def test_behaviour_trips_one_code(code: str, good: Make, bad: Make, tmp_path: Path) -> None:
    assert codes(good(), tmp_path / "good") == set()
    assert codes(bad(), tmp_path / "bad") == {code}


def test_says_what_is_wrong_and_where(tmp_path: Path) -> None:
    found = messages(deaf_to_the_door(), tmp_path, "BEH")
    assert found == ["trials/the_door_ends_it/1: after microjoint to 1 power is 'on', not 'off'"]
    found = messages(hob().replace(behavior=burning(0.45, HIGH)), tmp_path, "BEH")
    assert [one for one in found if "0.45" in one and "burner_on 0.35" in one]
    found = messages(still_when_on(), tmp_path, "BEH")
    assert found == ["keyframes/on: in this pose burner_left is 'off', not 'low|high'"]


def walk(behavior: Behavior, acts: list[tuple[dict[str, float], set[str]]], dt: float = 0.05) -> list[str]:
    machine, found = start_behavior(behavior), []
    for joints, touched in acts:
        machine = step_behavior(machine, Stimulus(joints, frozenset(touched)), dt)
        found.append(machine.values[behavior.variables[0].name])
    return found


def becomes(to: str, *when: Condition, **more: Any) -> Rule:
    return Rule(variable="power", to=to, when=when, **more)


def switch(*rules: Rule) -> Behavior:
    return Behavior(variables=(SWITCH,), rules=rules)


class TestMachine:
    def test_a_press_counts_once(self) -> None:
        rule = becomes("on", PRESS, from_values=("off",))
        other = becomes("off", Condition(contact="stop"), from_values=("on",))
        acts = [IDLE, HELD, ({}, {"key", "stop"}), HELD, IDLE, HELD]
        assert walk(switch(rule, other), acts) == ["off", "on", "off", "off", "off", "on"]

    def test_both_ends_of_an_interval_count(self) -> None:
        within = Condition(joint="knob", interval=(0.35, 1.0))
        machine = switch(becomes("on", within), becomes("off", within.replace(negated=True)))
        turned = [({"knob": at}, set[str]()) for at in (0.349, 0.35, 0.7, 1.0, 1.001)]
        assert walk(machine, turned) == ["off", "on", "on", "on", "off"]

    def test_waiting_begins_anew_where_it_is_interrupted(self) -> None:
        machine = switch(becomes("on", KEY, after_s=0.15))
        assert walk(machine, [HELD, HELD, IDLE, HELD, HELD, HELD]) == ["off"] * 5 + ["on"]

    def test_rules_of_a_step_see_the_values_of_before_and_the_first_of_a_variable_decides(self) -> None:
        lamp = Variable(name="lamp", values=("dark", "bright"), initial="dark")
        on, off = becomes("on", KEY), becomes("off", KEY)
        then = Rule(variable="lamp", to="bright", when=(Condition(variable="power", equals="on"),))
        for rules in ((on, then), (then, on)):
            assert walk(Behavior(variables=(lamp, SWITCH), rules=rules), [HELD, HELD]) == ["dark", "bright"]
        assert walk(switch(on, off), [HELD, HELD]) == ["on", "on"]
        assert walk(switch(off, on), [HELD, HELD]) == ["off", "off"]


class TestReachable:
    def test_finds_what_takes_several_moves(self) -> None:
        """A door has to be shut, then a key pressed, then a minute has to pass."""
        shut = Condition(joint="door", interval=(-0.01, 0.01))
        pressed = becomes("on", PRESS, shut, from_values=("off",))
        waited = becomes("done", shut, from_values=("on",), after_s=60.0)
        power = SWITCH.replace(values=("off", "on", "done"))
        machine = Behavior(variables=(power,), rules=(pressed, waited))
        assert unreached(machine, {"door": (-1.5, 0.0)}) == []
        assert unreached(machine, {"door": (-1.5, -0.5)}) == [("power", "on"), ("power", "done")]

    def test_an_interval_out_of_range_is_never_met(self) -> None:
        machine = switch(becomes("on", Condition(joint="knob", interval=(2.0, 3.0))))
        assert unreached(machine, {"knob": (0.0, 1.9)}) == [("power", "on")]
        assert unreached(machine, {"knob": (0.0, 2.0)}) == []


def test_a_fingertip_touches_one_key(tmp_path: Path) -> None:
    model = fingertip_model(packed(oven(), tmp_path))
    assert model is not None
    pressed = model.press({}, "stop_button")
    assert pressed is not None
    assert pressed.touched == {"stop_button"}
