"""Whole things, built of plain solids: which parts move, how, and that nothing is invented."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.plan import Articulation, HingeEdge, PartKind, PartPlan
from casa_assets.model.asset.parts import JointKind
from tests.unit.articulate.blocks import box, carcass, drawers, microwave, together
from tests.unit.articulate.fragmented import found_on


def parts_of(found: Articulation, kind: PartKind) -> list[PartPlan]:
    return [p for p in found.parts if p.kind is kind]


def test_a_microwave_has_a_door_a_knob_and_four_buttons() -> None:
    vertices, faces, owner = microwave()
    found = found_on(vertices, faces)
    (door,) = parts_of(found, PartKind.DOOR)
    assert set(owner[door.faces].tolist()) == {5, 6}
    assert set(owner[door.grip].tolist()) == {6}
    (knob,) = parts_of(found, PartKind.KNOB)
    assert set(owner[knob.faces].tolist()) == {8}
    assert [set(owner[b.faces].tolist()) for b in parts_of(found, PartKind.BUTTON)] == [{10}, {12}, {9}, {11}]
    assert len(found.parts) == 6


def test_the_door_hinges_opposite_its_handle_and_opens_outwards() -> None:
    found = found_on(*microwave()[:2])
    (door,) = parts_of(found, PartKind.DOOR)
    joint = door.joint
    assert joint.kind is JointKind.HINGE
    assert joint.edge is HingeEdge.LEFT
    anchor = found.frame.to_file(np.array([joint.anchor]))[0]
    assert anchor[0] == pytest.approx(0.0, abs=1e-6)
    assert -0.02 <= anchor[1] <= 0.0
    far = np.array([0.37, -0.01, 0.15]) - anchor
    assert np.cross(found.frame.direction_to_file(joint.axis), far)[1] < 0


def test_drawers_take_their_boxes_and_leave_the_carcass() -> None:
    vertices, faces, owner = drawers()
    found = found_on(vertices, faces)
    assert [p.kind for p in found.parts] == [PartKind.DRAWER] * 2
    taken = sorted(sorted(set(owner[p.faces].tolist())) for p in found.parts)
    assert taken == [list(range(5, 11)), list(range(11, 17))]
    for part in found.parts:
        assert part.joint.kind is JointKind.SLIDE
        assert part.joint.axis == pytest.approx((0, -1, 0))
        assert 0.3 < part.joint.range[1] / found.frame.scale < 0.5


def test_a_flap_with_a_level_handle_at_its_top_folds_down() -> None:
    parts = [
        *carcass(0.6, 0.5, 0.55),
        box((0.0, -0.02, 0.0), (0.6, 0.0, 0.45)),
        box((0.0, -0.02, 0.46), (0.6, 0.0, 0.55)),
    ]
    parts += [
        box((0.05, -0.07, 0.4), (0.55, -0.05, 0.415)),
        *(box((x, -0.05, 0.4), (x + 0.02, -0.02, 0.415)) for x in (0.05, 0.53)),
    ]
    vertices, faces, owner = together(*parts)
    (door,) = parts_of(found_on(vertices, faces), PartKind.DOOR)
    assert door.joint.edge is HingeEdge.BOTTOM
    assert set(owner[door.faces].tolist()) == {5, 7, 8, 9}


def test_a_door_of_boards_is_one_door() -> None:
    parts = [
        *carcass(0.5, 0.4, 0.7),
        box((0.0, -0.02, 0.0), (0.07, 0.0, 0.7)),
        box((0.43, -0.02, 0.0), (0.5, 0.0, 0.7)),
        box((0.07, -0.02, 0.0), (0.43, 0.0, 0.07)),
        box((0.07, -0.02, 0.63), (0.43, 0.0, 0.7)),
        box((0.07, -0.016, 0.07), (0.43, -0.012, 0.63)),
        box((0.455, -0.05, 0.3), (0.47, -0.02, 0.45)),
    ]
    vertices, faces, owner = together(*parts)
    (door,) = found_on(vertices, faces).parts
    assert set(owner[door.faces].tolist()) == set(range(5, 11))


def test_the_same_mesh_gives_the_same_decisions() -> None:
    vertices, faces, _ = microwave()
    assert found_on(vertices, faces).to_json() == found_on(vertices.copy(), faces.copy()).to_json()
