"""registry/contracts as they come with the package: each reads well, holds together, and says where it is wrong."""

from __future__ import annotations

import re
import shutil
from functools import cache
from pathlib import Path

import pytest
from hypothesis import find, settings, strategies

from casa_assets import registry
from casa_assets.errors import RegistryError
from casa_assets.model.registry.contract import Contract, Requirements

KNOWN = registry.load()
# What the reference runtime has classes for, by the names of ours.
CLASSES = """
microwave sink stove stovetop oven fridge_french_door fridge_side_by_side fridge_bottom_freezer fridge_top_freezer
dishwasher coffee_machine toaster toaster_oven electric_kettle stand_mixer blender hood hinge_cabinet single_cabinet
drawer open_cabinet panel_cabinet housing_cabinet counter stool window wall_accessory accessory paper_towel plant
knife_block utensil_holder utensil_rack dish_rack blender_lid
"""
CONTRACTS = list(KNOWN.contracts.values())
ID = re.compile(r"[a-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*")  # colliders and regions may have capitals
QUIET = settings(database=None, derandomize=True, max_examples=2000, deadline=None)


def needs_of(contract: Contract) -> list[Requirements]:
    """Every set of needs in it, `for_each` filled with its first value."""
    sets: list[Requirements] = [contract, *(n for c in contract.one_of for n in c.any_of)]
    return sets + [e.needs.filled(e.key, e.values[0]) for e in contract.for_each]


@cache
def sample(pattern: str) -> str:
    """The simplest name that a pattern was written for."""
    letters = strategies.characters(categories=("Ll", "Nd"), max_codepoint=127, include_characters="_LR")
    names = strategies.from_regex(pattern, fullmatch=True, alphabet=letters)
    return find(names, lambda name: ID.fullmatch(name) is not None, settings=QUIET)


def fits(pattern: str, name: str) -> bool:
    """Whether a pattern of a trial or threshold speaks of what a rule asks for by `name`."""
    return pattern == name or re.fullmatch(pattern, sample(name)) is not None


def test_every_class_of_the_runtime_has_a_contract() -> None:
    assert set(CLASSES.split()) - KNOWN.contracts.keys() == set()


@pytest.mark.content("code", "families", keep=0)
def test_each_holds_together(subtests: pytest.Subtests) -> None:
    """A trial that presses, moves or expects what no rule asks for would pass on anything."""
    for contract in CONTRACTS:
        with subtests.test(contract=contract.id):
            assert [r.min_count for r in contract.regions if r.matches("main")] == [1]
            sets = needs_of(contract)
            names = {
                "press": [r.name for n in sets for r in n.colliders],
                "move": [r.name for n in sets for r in n.joints],
                "then": [r.name for n in sets for r in n.variables],
            }
            used: dict[str, list[str]] = {"press": [], "move": [t.joint for t in contract.thresholds], "then": []}
            expected = [v for key in contract.keyframes for v in key.values.values()]
            for trial in contract.trials:
                assert any(step.expect for step in trial.steps), f"{trial.name} expects nothing"
                for step in trial.steps:
                    used["press"] += [step.press] if step.press else []
                    used["move"] += step.move
                    used["then"] += step.expect
                    expected += step.expect.values()
            for key in contract.keyframes:
                used["move"] += key.joint_shares
                used["then"] += key.values
            for kind, patterns in used.items():
                for pattern in patterns:
                    assert any(fits(pattern, name) for name in names[kind]), f"{kind} {pattern!r}"
            values = {v for n in sets for r in n.variables for v in r.values}
            assert {one for v in expected for one in v.split("|")} <= values
            forbidden = [(n, p) for n in names["move"] for p in contract.forbidden_joints]
            forbidden += [(n, p) for n in names["press"] for p in contract.forbidden_geoms]
            assert not [name for name, pattern in forbidden if re.fullmatch(pattern, sample(name))]
            for rule in (r for n in sets for r in n.joints if r.reach):
                for threshold in contract.thresholds:
                    if threshold.at is not None and fits(threshold.joint, rule.name):
                        assert rule.reach[0] < threshold.at < rule.reach[1], "its range reaches the threshold"


def test_thresholds_are_those_of_the_runtime() -> None:
    """Ref: RoboCasa, Stove.update_state, Sink.get_handle_state, Microwave.is_open, ElectricKettle, Toaster."""
    found = {(name, t.name): (t.at, t.share) for name, contract in KNOWN.contracts.items() for t in contract.thresholds}
    assert KNOWN.contracts["stovetop"].thresholds == KNOWN.contracts["stove"].thresholds
    for key, expected in {
        ("stovetop", "burner_on"): (0.35, None),
        ("sink", "flow_begins"): (0.40, None),
        ("microwave", "closed"): (None, 0.005),
        ("microwave", "open"): (None, 0.90),
        ("electric_kettle", "switch_is_on"): (None, 0.95),
        ("toaster", "lever_down"): (None, 0.90),
    }.items():
        assert found[key] == expected, key


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    root = tmp_path / "registry"
    shutil.copytree(registry.data_root(), root)
    return root


def test_faults_name_their_line(copy: Path) -> None:
    path = copy / "contracts" / "microwave.yaml"
    text = path.read_text(encoding="utf-8")
    for old, new, line, pointer, expected in [
        ("title: Microwave oven", "title: Microwave oven\ntitel: x", 3, "titel", "one of"),
        ("  - {name: door, depth: 1}", "  - {name: door, depht: 1}", 5, "links.0.depht", "one of"),
        ("axis: +z", "axis: up", 8, "joints.0.axis", "or '-z'"),
        ("share: 0.9}", "share: 1.9}", 24, "thresholds.1.share", "less than or equal to 1"),
        ("{name: start_button, label", "{name: '(start', label", 10, "colliders.0.name", "no pattern"),
    ]:
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        with pytest.raises(RegistryError) as caught:
            registry.load(copy)
        fault = caught.value
        assert (fault.file, fault.line, fault.pointer) == ("contracts/microwave.yaml", line, pointer)
        assert expected in fault.expected


def test_a_contract_counts_in_the_digest(copy: Path) -> None:
    before = registry.load(copy).digest
    path = copy / "contracts" / "hood.yaml"
    path.write_text(path.read_text(encoding="utf-8") + "# more\n", encoding="utf-8")
    registry.load.cache_clear()
    assert registry.load(copy).digest != before
