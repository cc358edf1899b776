"""Real meshes: doors of layers and boards, colours that part what is one piece, lids; and what is no appliance."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from casa_assets.articulate.plan import PartKind, PartPlan
from casa_assets.model.asset.parts import JointKind
from tests.unit.articulate.blocks import Ints, Part, box, carcass, disc, together
from tests.unit.articulate.fragmented import found_in, found_on
from tests.unit.articulate.fronts.test_fronts import bar, of_kind, tub

pytestmark = pytest.mark.content("code", "articulate", keep=0)


def shape_of(solid: manifold3d.Manifold) -> Part:
    """Vertices and faces of a solid."""
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties, dtype=np.float64)[:, :3], np.array(mesh.tri_verts, dtype=np.int64)


def parts_of(plan: PartPlan, owner: Ints) -> set[int]:
    return set(owner[plan.faces].tolist())


def test_a_painted_slot_makes_a_block_at_its_end_a_lever() -> None:
    body, pad = box((0.0, 0.0, 0.0), (0.2, 0.3, 0.25)), box((0.07, -0.02, 0.05), (0.13, -0.0001, 0.08))
    strip = box((0.09, -0.0001, 0.08), (0.11, 0.0, 0.18))
    (lever,) = found_on(*together(body, strip, pad)[:2]).parts
    assert lever.kind is PartKind.LEVER
    assert lever.joint.kind is JointKind.SLIDE
    assert lever.joint.axis == pytest.approx((0, 0, 1), abs=0.02)
    assert not found_on(*together(body, pad)[:2]).parts


def test_a_door_takes_its_core_its_liner_and_the_bins_on_it() -> None:
    start = 5
    layers = [
        box((0.0, -0.052, 0.0), (0.6, -0.05, 1.2)),
        box((0.001, -0.05, 0.001), (0.599, -0.005, 1.199)),
        box((0.04, -0.005, 0.04), (0.56, 0.006, 1.16)),
        *tub((0.06, 0.006, 0.5), (0.54, 0.07, 0.58)),
    ]
    shelf = box((0.02, 0.15, 0.6), (0.58, 0.55, 0.61))
    handle = bar((0.54, -0.1, 0.4), (0.552, -0.09, 0.9), -0.052)
    parts = [*carcass(0.6, 0.6, 1.2), *layers, *handle, shelf]
    found, owner = found_in(parts)
    (door,) = of_kind(found, PartKind.DOOR)
    assert parts_of(door, owner) == set(range(start, len(parts) - 1))
    assert not of_kind(found, PartKind.DRAWER)


def framed(left: float, right: float, knob: float) -> list[Part]:
    """A door of two stiles, two rails, a sunk panel and a round pull, 0.02 thick, 0.6 high."""
    stile = 0.055
    return [
        box((left, -0.02, 0.0), (left + stile, 0.0, 0.6)),
        box((right - stile, -0.02, 0.0), (right, 0.0, 0.6)),
        box((left + stile, -0.02, 0.0), (right - stile, 0.0, 0.05)),
        box((left + stile, -0.02, 0.55), (right - stile, 0.0, 0.6)),
        box((left + stile - 0.005, -0.017, 0.045), (right - stile + 0.005, -0.004, 0.555)),
        disc((knob, -0.045, 0.52), 0.014, 0.025),
    ]


def test_narrow_framed_doors_with_knobs_are_doors() -> None:
    parts = [*carcass(0.4, 0.5, 0.6), *framed(0.001, 0.199, 0.172), *framed(0.201, 0.399, 0.228)]
    found, owner = found_in(parts)
    assert [p.kind for p in found.parts] == [PartKind.DOOR, PartKind.DOOR]
    assert {frozenset(parts_of(p, owner)) for p in found.parts} == {frozenset(range(5, 11)), frozenset(range(11, 17))}
    assert all(len(p.grip) for p in found.parts)
    assert {p.joint.edge.value for p in found.parts if p.joint.edge} == {"left", "right"}


def test_a_door_flush_in_a_frame_of_the_body_leaves_the_frame() -> None:
    frame = [
        box((0.0, -0.02, 0.0), (0.05, 0.0, 0.8)),
        box((0.55, -0.02, 0.0), (0.6, 0.0, 0.8)),
        box((0.05, -0.02, 0.0), (0.55, 0.0, 0.05)),
        box((0.05, -0.02, 0.75), (0.55, 0.0, 0.8)),
    ]
    door = box((0.053, -0.02, 0.053), (0.547, 0.0, 0.747))
    parts = [*carcass(0.6, 0.5, 0.8), *frame, door, *bar((0.5, -0.06, 0.3), (0.512, -0.05, 0.5), -0.02)]
    found, owner = found_in(parts)
    (only,) = found.parts
    assert parts_of(only, owner) == set(range(9, 13))


def kettle(bail: bool, handle: bool) -> list[Part]:
    """A pot with a lid and its knob (parts 1, 2), with a bail over it from front to back, or a handle at the right."""
    solid = manifold3d.Manifold
    pot = solid.cylinder(0.15, 0.1, 0.1, 64) - solid.cylinder(0.14, 0.09, 0.09, 64).translate((0, 0, 0.02))
    lid = solid.cylinder(0.01, 0.085, 0.085, 64).translate((0, 0, 0.151))
    knob = solid.cylinder(0.03, 0.014, 0.014, 32).translate((0, 0, 0.162))
    parts = [pot, lid, knob]
    if bail:
        parts.append(solid.cube((0.02, 0.24, 0.02)).translate((-0.01, -0.12, 0.26)))
        parts += [solid.cube((0.02, 0.02, 0.2)).translate((-0.01, y, 0.06)) for y in (-0.12, 0.1)]
    if handle:
        parts.append(solid.cube((0.06, 0.02, 0.14)).translate((0.1, -0.01, 0.0)))
    return [shape_of(p) for p in parts]


def test_a_lid_stops_before_the_bail_over_it() -> None:
    (free,) = of_kind(found_in(kettle(False, False))[0], PartKind.LID)
    assert free.joint.range[1] == pytest.approx(np.pi / 2)
    assert free.joint.axis == pytest.approx((-1, 0, 0))
    (lid,) = of_kind(found_in(kettle(True, False))[0], PartKind.LID)
    assert 0.3 < lid.joint.range[1] < 1.2


def test_a_lid_hinges_at_the_handle() -> None:
    found, owner = found_in(kettle(False, True))
    (lid,) = of_kind(found, PartKind.LID)
    assert parts_of(lid, owner) == {1, 2}
    assert lid.joint.axis == pytest.approx((0, 1, 0))
    assert lid.joint.anchor[0] > 0.1


def noisy(solid: manifold3d.Manifold, spread: float) -> Part:
    """A solid of many faces whose points are off, as those of a scan."""
    points, faces = shape_of(solid.refine_to_length(0.04))
    return points + np.random.default_rng(0).normal(0.0, spread, points.shape), faces


@pytest.mark.parametrize(
    "part",
    [
        noisy(manifold3d.Manifold.cube((1, 1, 1)), 0.003),
        noisy(manifold3d.Manifold.cube((0.6, 0.4, 0.8)), 0.001),
        noisy(manifold3d.Manifold.sphere(0.5, 48), 0.004),
        noisy(manifold3d.Manifold.cylinder(1.0, 0.3, 0.2, 48), 0.002),
    ],
    ids=["cube", "carton", "fruit", "bottle"],
)
def test_nothing_moves_on_a_scan_of_a_plain_thing(part: Part) -> None:
    assert not found_on(*part).parts
