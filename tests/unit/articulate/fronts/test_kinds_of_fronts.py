"""Fronts that have no handle, are round, or open as their kind does."""

from __future__ import annotations

import pytest

from casa_assets.articulate.plan import Articulation, HingeEdge, PartKind
from tests.unit.articulate.blocks import box, carcass, disc
from tests.unit.articulate.fragmented import found_in


def edges(found: Articulation) -> list[HingeEdge | None]:
    """The hinge edges of the doors, from left to right."""
    doors = [p for p in found.parts if p.kind is PartKind.DOOR]
    return [p.joint.edge for p in sorted(doors, key=lambda p: p.joint.anchor[0])]


def test_a_door_without_a_handle_opens_as_its_kind_does(subtests: pytest.Subtests) -> None:
    for kind, edge in [
        ("dishwasher", HingeEdge.BOTTOM),
        ("wall_oven", HingeEdge.BOTTOM),
        ("microwave", HingeEdge.LEFT),
    ]:
        with subtests.test(kind=kind, edge=edge):
            parts = [*carcass(0.6, 0.55, 0.62), box((0.003, -0.02, 0.01), (0.597, -0.001, 0.61))]
            assert edges(found_in(parts, kind)[0]) == [edge]


def test_an_upright_handle_at_one_side_beats_the_kind() -> None:
    parts = [
        *carcass(0.6, 0.55, 0.6),
        box((0.003, -0.02, 0.01), (0.597, -0.001, 0.59)),
        box((0.54, -0.06, 0.1), (0.56, -0.045, 0.5)),
        box((0.545, -0.045, 0.11), (0.555, -0.02, 0.12)),
        box((0.545, -0.045, 0.48), (0.555, -0.02, 0.49)),
    ]
    assert edges(found_in(parts, "microwave")[0]) == [HingeEdge.LEFT]
    assert edges(found_in(parts, "wall_oven")[0]) == [HingeEdge.LEFT]


def test_a_washing_machine_has_a_round_door_a_drawer_and_a_knob() -> None:
    parts = [
        box((0, 0, 0), (0.6, 0.55, 0.85)),
        disc((0.3, -0.04, 0.4), 0.18, 0.039, 32),
        disc((0.3, -0.05, 0.4), 0.12, 0.009, 32),
        box((0.02, -0.01, 0.73), (0.17, -0.001, 0.83)),
        disc((0.33, -0.03, 0.78), 0.03, 0.029),
    ]
    found, _ = found_in(parts)
    kinds = sorted(p.kind.value for p in found.parts)
    assert kinds == ["door", "drawer", "knob"]
    assert edges(found) == [HingeEdge.LEFT]
    assert "round" in found.traits


def test_a_control_panel_over_a_door_is_no_front() -> None:
    parts = [
        *carcass(0.6, 0.55, 0.6),
        box((0.0, -0.02, 0.5), (0.6, -0.001, 0.6)),
        *(disc((x, -0.04, 0.55), 0.018, 0.019) for x in (0.1, 0.2, 0.3, 0.4, 0.5)),
        box((0.0, -0.02, 0.01), (0.6, -0.001, 0.497)),
    ]
    found, _ = found_in(parts)
    assert edges(found) == [HingeEdge.BOTTOM]
    assert [p.kind for p in found.parts].count(PartKind.KNOB) == 5
    assert all(p.kind in (PartKind.DOOR, PartKind.KNOB) for p in found.parts)
