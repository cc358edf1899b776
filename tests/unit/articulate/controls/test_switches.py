"""Wall switches, and thin things with keys."""

from __future__ import annotations

import math

import pytest

from casa_assets.articulate.plan import PartKind
from casa_assets.model.asset.parts import JointKind
from tests.unit.articulate.blocks import Part, box, carcass, disc
from tests.unit.articulate.fragmented import found_in

PLATE = box((-0.06, 0.0, -0.04), (0.06, 0.008, 0.04))


def rocker(x: float, z: float = 0.0) -> Part:
    return box((x - 0.015, -0.004, z - 0.022), (x + 0.015, -0.0002, z + 0.022))


def test_rockers_tilt_about_a_level_axis_to_either_side() -> None:
    parts = found_in([PLATE, rocker(-0.025), rocker(0.025)])[0].parts
    assert [p.kind for p in parts] == [PartKind.LEVER] * 2
    assert all(p.joint.kind is JointKind.HINGE and abs(p.joint.axis[0]) == pytest.approx(1) for p in parts)
    assert all(p.joint.range[0] < 0 < p.joint.range[1] for p in parts)


def test_a_stick_is_a_toggle_that_goes_farther_than_a_rocker() -> None:
    (toggle,) = found_in([PLATE, box((-0.003, -0.02, -0.006), (0.003, -0.0002, 0.006))])[0].parts
    assert toggle.kind is PartKind.LEVER
    assert toggle.joint.range[1] > 0.4


def test_a_round_one_is_a_dimmer() -> None:
    (knob,) = found_in([PLATE, disc((0.0, -0.015, 0.0), 0.018, 0.0148)])[0].parts
    assert (knob.kind, knob.joint.endless) == (PartKind.KNOB, True)
    assert knob.joint.range[1] == pytest.approx(2 * math.pi)


def test_pieces_off_the_middle_or_of_two_sizes_are_no_switches() -> None:
    small = box((0.02, -0.004, -0.01), (0.03, -0.0002, 0.01))
    for parts in ((rocker(-0.025, 0.015), rocker(0.025, 0.015)), (rocker(-0.025), small)):
        assert not [p for p in found_in([PLATE, *parts])[0].parts if p.kind is PartKind.LEVER]


def test_the_leaf_of_a_cupboard_is_no_plate() -> None:
    leaf, handle = box((0.0, -0.02, 0.0), (0.5, -0.0002, 0.6)), box((0.24, -0.05, 0.28), (0.26, -0.0202, 0.32))
    assert not [p for p in found_in([*carcass(0.5, 0.4, 0.6), leaf, handle])[0].parts if p.kind is PartKind.LEVER]


def test_the_face_of_a_remote_control_is_no_door() -> None:
    shell, face = box((-0.03, 0.001, -0.1), (0.03, 0.02, 0.1)), box((-0.03, -0.002, -0.1), (0.03, 0.0, 0.1))
    keys = [box((x, -0.004, z), (x + 0.012, -0.0021, z + 0.01)) for x in (-0.022, 0.008) for z in (-0.05, 0.0, 0.05)]
    assert not [p for p in found_in([shell, face, *keys])[0].parts if p.kind is PartKind.DOOR]
