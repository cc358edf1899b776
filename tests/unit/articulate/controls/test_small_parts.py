"""Levers in slots, tilted knobs, pins, burners that are no knobs, lids."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.controls.controls import find_controls
from casa_assets.articulate.controls.levers_and_buttons import Lever, find_levers
from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.segment.fragments import measure_fragments
from casa_assets.articulate.segment.orthographic import FRONT
from tests.unit.articulate.blocks import Floats, Part, box, carcass, disc, together
from tests.unit.articulate.fragmented import found_in, in_its_frame

SQUARE = np.array([[0, 1, 2], [0, 2, 3]])


def turned(part: Part, degrees: float, about: tuple[float, float, float]) -> Part:
    """A part turned about a line along x through a point."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    rotation: Floats = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    points, faces = part
    return (points - np.array(about)) @ rotation.T + np.array(about), faces


def slotted() -> list[Part]:
    """A block of which the front has an upright slot at x = 0.15, z = 0.06..0.2. Parts 0..4."""
    return [
        box((0.0, 0.03, 0.0), (0.3, 0.3, 0.25)),
        box((0.0, 0.0, 0.0), (0.145, 0.03, 0.25)),
        box((0.155, 0.0, 0.0), (0.3, 0.03, 0.25)),
        box((0.145, 0.0, 0.0), (0.155, 0.03, 0.06)),
        box((0.145, 0.0, 0.2), (0.155, 0.03, 0.25)),
    ]


def levers_in(parts: list[Part]) -> tuple[list[Lever], float]:
    """Levers on the front of some parts, and metres in a unit of the frame."""
    placed, frame = in_its_frame(*together(*parts)[:2])
    pieces = measure_fragments(placed, placed.fragment_labels)
    levers, _ = find_levers(pieces, find_controls(pieces, FRONT, []))
    return levers, 1 / frame.scale


def test_a_pad_at_the_end_of_a_slot_is_a_lever_that_goes_along_it() -> None:
    (lever,), unit = levers_in([*slotted(), box((0.13, -0.03, 0.18), (0.17, -0.005, 0.19))])
    assert lever.way == pytest.approx((0, -1, 0), abs=0.02)
    assert lever.length * unit == pytest.approx(0.12, abs=0.01)
    assert (lever.control.upper - lever.control.lower) * unit == pytest.approx((0.04, 0.01, 0.025), abs=1e-6)


def test_a_slot_that_falls_back_in_stairs_has_their_slope() -> None:
    steps = 20
    parts = [box((0.0, 0.06, 0.0), (0.3, 0.3, 0.3))]
    for k in range(steps):
        low, high, y = 0.3 * k / steps, 0.3 * (k + 1) / steps, 0.003 * k
        parts += [box((0.0, y, low), (0.145, 0.06, high)), box((0.155, y, low), (0.3, 0.06, high))]
    parts += [box((0.145, 0.0, 0.0), (0.155, 0.06, 0.06))]
    levers, _ = levers_in([*parts, box((0.13, 0.01, 0.24), (0.17, 0.044, 0.25))])
    lever = max(levers, key=lambda v: float(v.control.middle[1]))
    assert lever.way[2] / lever.way[1] == pytest.approx(0.2, abs=0.05)


def test_a_gap_between_two_fronts_is_no_slot() -> None:
    fronts = [box((0.0, 0.0, z), (0.3, 0.02, z + 0.12)) for z in (0.0, 0.13)]
    beside = [box((x, 0.0, 0.0), (x + 0.145, 0.02, 0.25)) for x in (0.0, 0.155)]
    pad = box((0.13, -0.03, 0.18), (0.17, -0.005, 0.19))
    assert levers_in([box((0.0, 0.05, 0.0), (0.3, 0.3, 0.25)), *fronts, pad])[0] == []
    assert levers_in([box((0.0, 0.05, 0.0), (0.3, 0.3, 0.25)), *beside, pad])[0] == []


def test_a_knob_on_a_slope_turns_about_the_normal_of_its_cap() -> None:
    parts = [box((0, 0, 0), (0.5, 0.4, 0.3))]
    parts += [turned(disc((x, -0.018, 0.15), 0.02, 0.02), 15.0, (x, 0.0, 0.15)) for x in (0.1, 0.25, 0.4)]
    found, _ = found_in(parts)
    assert [p.kind for p in found.parts] == [PartKind.KNOB] * 3
    slope = np.radians(15.0)
    for part in found.parts:
        assert np.abs(np.array(part.joint.axis) @ [0, -np.cos(slope), -np.sin(slope)]) > 0.9999


def test_one_of_a_row_of_knobs_need_not_be_round() -> None:
    knobs = [disc((x, -0.02, 0.15), 0.02, 0.02) for x in (0.1, 0.2, 0.3, 0.4)]
    found, _ = found_in([box((0, 0, 0), (0.6, 0.4, 0.3)), *knobs, box((0.48, -0.02, 0.13), (0.52, 0.0, 0.17))])
    assert [p.kind for p in found.parts] == [PartKind.KNOB] * 5


def test_a_pin_is_pushed_and_a_knob_is_turned() -> None:
    pin, knob = disc((0.15, -0.02, 0.15), 0.012, 0.06), disc((0.35, -0.02, 0.15), 0.02, 0.03)
    parts = [box((0, 0, 0), (0.5, 0.4, 0.3)), pin, knob]
    found, owner = found_in(parts)
    kinds = {int(owner[p.faces[0]]): p.kind for p in found.parts}
    assert kinds == {1: PartKind.BUTTON, 2: PartKind.KNOB}


def lying(part: Part) -> Part:
    """A disc of `blocks` with its axis made upright: (x, y, z) -> (x, z, -y)."""
    points, faces = part
    return points @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], dtype=np.float64), faces


def hob(*more: Part) -> list[Part]:
    """A slab with four knobs in a row at its front, and more. Parts: 0 slab, 1..4 knobs, 5.. more."""
    knobs = [lying(disc((x, -0.06, 0.05), 0.02, 0.03)) for x in (0.12, 0.24, 0.36, 0.48)]
    return [box((0, 0, 0), (0.6, 0.5, 0.03)), *knobs, *more]


def test_burners_under_grates_are_no_knobs() -> None:
    burner = lying(disc((0.3, -0.06, 0.3), 0.03, 0.03))
    bars = [box((0.15, y, 0.058), (0.45, y + 0.012, 0.07)) for y in (0.25, 0.338)]
    bars += [box((x, 0.15, 0.058), (x + 0.012, 0.45, 0.07)) for x in (0.25, 0.338)]
    found, owner = found_in(hob(burner, *bars))
    assert {int(owner[p.faces[0]]) for p in found.parts} == {1, 2, 3, 4}


def test_a_round_cover_with_a_knob_is_a_lid_that_opens_upwards() -> None:
    pot = [box((0, 0, 0), (0.3, 0.3, 0.2))]
    cover = lying(disc((0.15, -0.215, 0.15), 0.1, 0.015))
    found, owner = found_in([*pot, cover, lying(disc((0.15, -0.24, 0.15), 0.015, 0.025))])
    (lid,) = found.parts
    assert lid.kind is PartKind.LID
    assert set(owner[lid.faces].tolist()) == {1, 2}
    assert set(owner[lid.grip].tolist()) == {2}
    anchor = np.array(lid.joint.anchor)
    front = np.array([0.0, -0.1, 0.0])
    assert anchor[1] > 0
    assert np.cross(lid.joint.axis, front - anchor)[2] > 0


def test_a_turntable_turns_behind_a_door() -> None:
    parts = [*carcass(0.5, 0.4, 0.3), box((0.0, -0.02, 0.0), (0.5, 0.0, 0.3))]
    parts += [box((0.46, -0.05, 0.05), (0.475, -0.02, 0.25)), lying(disc((0.25, -0.05, 0.2), 0.14, 0.01))]
    found, owner = found_in(parts)
    (tray,) = [p for p in found.parts if p.kind is PartKind.TRAY]
    assert set(owner[tray.faces].tolist()) == {7}
    assert tray.joint.endless
    assert tray.joint.axis == pytest.approx((0, 0, 1))


def toaster(*more: Part) -> list[Part]:
    """A body with two slots for bread in its top, and what else there is; its front lies at y = 0."""
    walls = [box((0.0, y, 0.05), (0.4, y + 0.07, 0.25)) for y in (0.0, 0.09, 0.18)]
    ends = [box((x, y, 0.05), (x + 0.05, y + 0.02, 0.25)) for x in (0.0, 0.35) for y in (0.07, 0.16)]
    return [box((0.0, 0.0, 0.0), (0.4, 0.25, 0.05)), *walls, *ends, *more]


def test_what_stands_on_a_plate_of_a_toaster_is_its_lever_and_its_knob() -> None:
    plate = box((0.22, -0.006, 0.02), (0.38, 0.0, 0.23))
    bar = box((0.275, -0.03, 0.19), (0.325, -0.006, 0.21))
    found = found_in(toaster(plate, bar, disc((0.3, -0.03, 0.06), 0.02, 0.024)))[0]
    assert sorted(p.kind for p in found.parts) == [PartKind.KNOB, PartKind.LEVER]
    (lever,) = (p for p in found.parts if p.kind is PartKind.LEVER)
    assert lever.joint.axis == pytest.approx((0, 0, -1))


def test_a_sheet_that_a_knob_stands_on_stays() -> None:
    sheet = (np.array([[0.1, -0.01, 0.1], [0.18, -0.01, 0.1], [0.18, -0.01, 0.18], [0.1, -0.01, 0.18]]), SQUARE)
    parts = [box((0.0, 0.0, 0.0), (0.5, 0.3, 0.5)), sheet, disc((0.14, -0.035, 0.14), 0.025, 0.025)]
    mesh, _ = in_its_frame(*together(*parts)[:2])
    (knob,) = find_controls(measure_fragments(mesh, mesh.fragment_labels), FRONT, [])
    assert knob.is_round
    assert len(knob.fragments) == 1
