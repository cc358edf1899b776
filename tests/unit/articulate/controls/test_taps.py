"""Handles of faucets, spouts, and what looks like either and is none."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.plan import PartKind
from casa_assets.model.asset.parts import JointKind
from tests.unit.articulate.blocks import Part, box, disc
from tests.unit.articulate.fragmented import found_in


def upright(bottom: tuple[float, float, float], radius: float, height: float) -> Part:
    """A cylinder along z that stands on a point."""
    points, faces = disc((0.0, 0.0, 0.0), radius, height)
    return points[:, [0, 2, 1]] + np.array(bottom), faces[:, ::-1]


def faucet(sticks: int = 2) -> list[Part]:
    """A plate, a body, two valves across it with a stick on each, a column with an arm: the last two parts."""
    parts = [box((-0.15, -0.1, 0.0), (0.15, 0.1, 0.01)), upright((0.0, 0.0, 0.01), 0.022, 0.04)]
    for x in (-0.06, 0.02):
        points, faces = disc((0.0, 0.0, 0.0), 0.012, 0.04)
        parts.append((points[:, [1, 0, 2]] + np.array([x, 0.0, 0.035]), faces[:, ::-1]))
    parts += [upright((x, 0.0, 0.04), 0.004, 0.05) for x in (-0.045, 0.045)[:sticks]]
    return [*parts, upright((0.0, 0.0, 0.05), 0.015, 0.2), box((-0.015, -0.18, 0.24), (0.015, 0.015, 0.27))]


def test_a_stick_turns_with_its_valve_about_the_axis_of_that() -> None:
    found, owner = found_in(faucet())
    levers = [p for p in found.parts if p.kind is PartKind.LEVER]
    assert {int(owner[f]) for p in levers for f in p.faces} == {2, 3, 4, 5}
    for lever in levers:
        assert lever.joint.kind is JointKind.HINGE
        assert np.abs(lever.joint.axis) == pytest.approx([1, 0, 0])
        y, z = (np.array(lever.joint.anchor) / found.frame.scale + np.array(found.frame.origin))[1:]
        assert (y, z) == pytest.approx((0.0, 0.035), abs=1e-6)
        assert lever.joint.range[0] == 0.0 < lever.joint.range[1]


def test_the_spout_beside_sticks_swivels_about_its_column() -> None:
    found, owner = found_in(faucet())
    (spout,) = [p for p in found.parts if p.kind is PartKind.SPOUT]
    assert set(owner[spout.faces].tolist()) == {6, 7}
    assert spout.joint.axis == pytest.approx((0, 0, 1))
    assert spout.joint.anchor[0] == pytest.approx(-found.frame.origin[0] * found.frame.scale, abs=1e-6)


def test_no_spout_without_sticks_and_no_sticks_on_a_rail() -> None:
    whole = faucet(sticks=0)
    bare, _ = found_in([*whole[:2], *whole[4:]])
    assert not [p for p in bare.parts if p.kind in (PartKind.SPOUT, PartKind.LEVER)]
    rail = box((-0.2, -0.008, 0.02), (0.2, 0.008, 0.036))
    rods = [upright((x, 0.0, 0.036), 0.004, 0.06) for x in (-0.15, -0.05, 0.05, 0.15)]
    rack, _ = found_in([box((-0.2, -0.1, 0.0), (0.2, 0.1, 0.02)), rail, *rods])
    assert not rack.parts


def test_a_short_pin_is_pressed_and_a_long_one_is_not() -> None:
    def kinds(height: float) -> set[PartKind]:
        parts = [box((0.0, 0.0, 0.0), (0.3, 0.3, 0.2)), upright((0.08, 0.1, 0.2), 0.006, height)]
        return {p.kind for p in found_in(parts)[0].parts}

    assert kinds(0.02) == {PartKind.BUTTON}
    assert kinds(0.06) == set()
