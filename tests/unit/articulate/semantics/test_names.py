"""Which part is which: parts laid out by hand, and the names that runtimes look for."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.interior.regions import Burner
from casa_assets.articulate.part_names import PlacedPart, RuntimeName, runtime_names
from casa_assets.articulate.plan import HingeEdge, JointPlan, PartKind, PartPlan
from casa_assets.model.asset.parts import JointKind

NONE = np.empty(0, dtype=np.int64)
SLIDES = frozenset({PartKind.DRAWER, PartKind.BUTTON, PartKind.TRAY})


def at(
    name: str,
    kind: PartKind,
    middle: tuple[float, float, float],
    size: tuple[float, float, float] = (0.02, 0.02, 0.02),
    edge: HingeEdge | None = None,
    turns: bool | None = None,
    on: str = "",
) -> PlacedPart:
    """A part of a kind with its middle there."""
    hinged = kind not in SLIDES if turns is None else turns
    joint = JointPlan(
        kind=JointKind.HINGE if hinged else JointKind.SLIDE,
        axis=(0.0, 0.0, 1.0),
        anchor=middle,
        range=(0.0, 1.0),
        endless=kind is PartKind.TRAY and hinged,
        edge=edge,
    )
    part = PartPlan(name=name, kind=kind, parent=on, faces=NONE, grip=NONE, joint=joint)
    return PlacedPart(part, np.array(middle), np.array(size))


def joints(places: list[PlacedPart], category: str, burners: tuple[Burner, ...] = ()) -> dict[str, str]:
    return {part: name.joint for part, name in runtime_names(places, category, burners).items()}


def test_the_lowest_keys_of_a_microwave_stop_and_start_it() -> None:
    keys = [(0.40, 0.2), (0.44, 0.2), (0.40, 0.16), (0.44, 0.16)]
    places = [at(f"b{i}", PartKind.BUTTON, (x, -0.2, z)) for i, (x, z) in enumerate(keys)]
    places += [
        at("door_0", PartKind.DOOR, (0, -0.2, 0.2), edge=HingeEdge.LEFT),
        at("disc", PartKind.TRAY, (0, 0, 0.05), turns=True),
    ]
    names = runtime_names(places, "microwave")
    assert names["b3"] == RuntimeName("start_button", "start_button_joint", "start_button")
    assert names["b2"] == RuntimeName("stop_button", "stop_button_joint", "stop_button")
    assert names["door_0"] == RuntimeName("door", "microjoint")
    assert names["disc"] == RuntimeName("tray", "tray_joint", "tray")
    assert set(names) == {"b2", "b3", "door_0", "disc"}


BURNERS = tuple(
    Burner(loc, (x, y, 0.9), 0.08)
    for loc, x, y in (
        ("front_left", -0.2, -0.1),
        ("front_right", 0.2, -0.1),
        ("rear_left", -0.2, 0.2),
        ("rear_right", 0.2, 0.2),
    )
)


def test_knobs_in_a_row_belong_to_the_burners_of_their_side() -> None:
    places = [at(f"k{i}", PartKind.KNOB, (x, -0.35, 0.8)) for i, x in enumerate((-0.3, -0.2, 0.2, 0.3))]
    assert joints(places, "hob", BURNERS) == {
        "k0": "knob_front_left_joint",
        "k1": "knob_rear_left_joint",
        "k2": "knob_rear_right_joint",
        "k3": "knob_front_right_joint",
    }


def test_knobs_in_a_column_belong_to_the_burners_from_the_far_end() -> None:
    places = [at(f"k{i}", PartKind.KNOB, (0.35, y, 0.9)) for i, y in enumerate((-0.2, -0.1, 0.1, 0.2))]
    assert joints(places, "hob", BURNERS) == {
        "k3": "knob_rear_left_joint",
        "k2": "knob_rear_right_joint",
        "k1": "knob_front_left_joint",
        "k0": "knob_front_right_joint",
    }


def test_the_knob_in_the_middle_of_a_range_is_that_of_its_oven() -> None:
    row = [at(f"k{i}", PartKind.KNOB, (x, -0.35, 0.8)) for i, x in enumerate((-0.3, -0.2, 0.0, 0.2, 0.3))]
    found = joints([*row, at("door_0", PartKind.DOOR, (0, -0.3, 0.4), edge=HingeEdge.BOTTOM)], "range", BURNERS)
    assert found["k2"] == "knob_temp_joint"
    assert found["k0"] == "knob_front_left_joint"
    assert found["k4"] == "knob_front_right_joint"
    assert found["door_0"] == "door_joint"
    # A hob has no oven: one knob more than burners means that a burner was not found.
    assert joints(row, "hob", BURNERS) == {}
    assert joints(row[:3], "hob", BURNERS) == {}


def test_knobs_of_ovens_from_above(subtests: pytest.Subtests) -> None:
    for category, knobs, wanted in [
        ("wall_oven", 2, ["temp", "time"]),
        ("toaster_oven", 3, ["temp", "function", "time"]),
        ("wall_oven", 1, []),
        ("wall_oven", 5, []),
    ]:
        with subtests.test(category=category, knobs=knobs, wanted=wanted):
            places = [at(f"k{i}", PartKind.KNOB, (0.2, -0.2, 0.3 - 0.05 * i)) for i in range(knobs)]
            assert list(joints(places, category).values()) == [f"knob_{w}_joint" for w in wanted]


def test_doors_of_cabinets_by_the_side_that_they_hinge_on() -> None:
    left, right = (
        at(e.value, PartKind.DOOR, (x, -0.3, 0.5), edge=e) for e, x in ((HingeEdge.LEFT, -0.2), (HingeEdge.RIGHT, 0.2))
    )
    assert joints([left, right], "base_cabinet") == {"left": "leftdoorhinge", "right": "rightdoorhinge"}
    assert joints([right], "wall_cabinet") == {"right": "doorhinge"}
    more = at("more", PartKind.DOOR, (0.6, -0.3, 0.5), edge=HingeEdge.LEFT)
    found = joints([left, right, more], "tall_cabinet")
    assert found == {"left": "unit0_leftdoorhinge", "right": "rightdoorhinge", "more": "unit1_leftdoorhinge"}
    flap = at("flap", PartKind.DOOR, (0.0, -0.3, 0.5), edge=HingeEdge.TOP)
    assert joints([flap], "wall_cabinet") == {}


def test_toaster_coffee_machine_and_kettle() -> None:
    lever = at("l", PartKind.LEVER, (0, -0.15, 0.15), turns=False)
    keys = [at("high", PartKind.BUTTON, (0.05, -0.15, 0.1)), at("low", PartKind.BUTTON, (0.05, -0.15, 0.05))]
    found = runtime_names([lever, *keys, at("k", PartKind.KNOB, (0, -0.15, 0.05))], "toaster")
    assert found["l"] == RuntimeName("lever", "lever_joint")
    assert found["low"] == RuntimeName("button_cancel", "button_cancel_joint", "button_cancel")
    assert found["k"].joint == "knob_doneness_joint"
    wide = at("wide", PartKind.BUTTON, (0, -0.1, 0.3), size=(0.05, 0.01, 0.03))
    assert joints([*keys, wide], "coffee_machine") == {"wide": "start_button_joint"}
    lid = at("lid", PartKind.LID, (0, 0, 0.2))
    assert joints([lid, *keys], "kettle") == {"lid": "lid_joint", "low": "switch_joint", "high": "button_lid_joint"}


def test_spout_and_handles_of_a_faucet() -> None:
    spout = at("s", PartKind.SPOUT, (0, 0, 0.3))
    handles = [at("right", PartKind.LEVER, (0.1, 0, 0.1)), at("left", PartKind.LEVER, (-0.1, 0, 0.1))]
    assert joints([spout, *handles], "sink") == {
        "s": "spout_joint",
        "right": "handle_joint",
        "left": "handle_temp_joint",
    }
