"""Lids of boxes, and boxes that have none."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.plan import PartKind
from tests.unit.articulate.blocks import Floats, Part, box, disc
from tests.unit.articulate.fragmented import found_in


def chest() -> list[Part]:
    """The floor and four walls of a chest 0.8 wide, 0.4 deep and 0.3 high."""
    return [
        box((-0.4, -0.2, 0.0), (0.4, 0.2, 0.02)),
        box((-0.4, -0.2, 0.02), (-0.38, 0.2, 0.3)),
        box((0.38, -0.2, 0.02), (0.4, 0.2, 0.3)),
        box((-0.38, -0.2, 0.02), (0.38, -0.18, 0.3)),
        box((-0.38, 0.18, 0.02), (0.38, 0.2, 0.3)),
    ]


def test_what_covers_a_hollow_box_is_hinged_at_its_back() -> None:
    found, _ = found_in([*chest(), box((-0.4, -0.2, 0.3), (0.4, 0.2, 0.36))])
    (lid,) = found.parts
    assert lid.kind is PartKind.LID
    assert lid.joint.axis == pytest.approx((-1, 0, 0))
    _, y, z = found.frame.to_file(np.array([lid.joint.anchor]))[0]
    assert (y, z) == pytest.approx((0.2, 0.3), abs=1e-3)


def test_a_lid_is_hinged_opposite_to_its_lock() -> None:
    lock = box((-0.03, 0.2, 0.27), (0.03, 0.22, 0.33))
    found, _ = found_in([*chest(), box((-0.4, -0.2, 0.3), (0.4, 0.2, 0.36)), lock])
    (lid,) = (p for p in found.parts if p.kind is PartKind.LID)
    assert lid.joint.axis == pytest.approx((1, 0, 0))


def test_a_table_top_and_an_open_box_have_no_lid() -> None:
    legs = [box((x, y, 0.0), (x + 0.04, y + 0.04, 0.3)) for x in (-0.4, 0.36) for y in (-0.2, 0.16)]
    table, _ = found_in([*legs, box((-0.4, -0.2, 0.3), (0.4, 0.2, 0.36))])
    assert not [p for p in (*table.parts, *found_in(chest())[0].parts) if p.kind is PartKind.LID]


def test_a_plate_with_several_knobs_is_no_lid() -> None:
    plate = box((-0.4, -0.2, 0.3), (0.4, 0.2, 0.32))
    knobs = []
    for x in (-0.2, 0.0, 0.2):
        points, faces = disc((x, 0.0, 0.0), 0.025, 0.03)
        knobs.append((points[:, [0, 2, 1]] * [1, 1, -1] + [0.0, -0.12, 0.35], faces))
    found, _ = found_in([*chest(), plate, *knobs])
    kinds = [p.kind for p in found.parts]
    assert PartKind.LID not in kinds
    assert kinds.count(PartKind.KNOB) == 3


def test_a_bin_with_a_pedal_opens_away_from_it() -> None:
    angle = np.arange(24) / 24 * 2 * np.pi
    ring = np.stack([0.15 * np.cos(angle), 0.15 * np.sin(angle)], axis=1)
    pedal = box((-0.04, -0.2, 0.01), (0.04, -0.1, 0.03))
    parts = [_upright(ring, 0.0, 0.4), _upright(ring, 0.401, 0.46)]
    (lid,) = found_in([*parts, pedal])[0].parts
    assert lid.kind is PartKind.LID
    assert lid.joint.axis == pytest.approx((-1, 0, 0))
    assert not found_in(parts)[0].parts


def _upright(ring: Floats, low: float, high: float) -> Part:
    """A closed prism of (N, 2) corners between two heights."""
    n = len(ring)
    points = np.concatenate([np.column_stack([ring, np.full(n, z)]) for z in (low, high)])
    i = np.arange(n)
    j = (i + 1) % n
    walls = np.concatenate([np.column_stack([i, j, j + n]), np.column_stack([i, j + n, i + n])])
    fan = np.column_stack([np.zeros(n - 2, dtype=np.int64), i[1:-1], i[2:]])
    return points, np.concatenate([walls, fan[:, ::-1], fan + n])
