"""Fronts beyond the plain ones: open carcasses, tubs behind doors, sliding doors, boards that are no racks."""

from __future__ import annotations

import pytest

from casa_assets.articulate.plan import Articulation, HingeEdge, PartKind, PartPlan
from casa_assets.model.asset.parts import JointKind
from tests.unit.articulate.blocks import Part, box, carcass
from tests.unit.articulate.fragmented import found_in


def of_kind(found: Articulation, kind: PartKind) -> list[PartPlan]:
    return [p for p in found.parts if p.kind is kind]


def tub(low: tuple[float, float, float], high: tuple[float, float, float], wall: float = 0.01) -> list[Part]:
    """Five boards, open at the top."""
    (x, y, z), (a, b, c) = low, high
    return [
        box((x, y, z), (a, b, z + wall)),
        box((x, y, z + wall), (x + wall, b, c)),
        box((a - wall, y, z + wall), (a, b, c)),
        box((x + wall, y, z + wall), (a - wall, y + wall, c)),
        box((x + wall, b - wall, z + wall), (a - wall, b, c)),
    ]


def bar(low: tuple[float, float, float], high: tuple[float, float, float], front: float) -> list[Part]:
    """A handle with two feet that reach a front at `y = front`."""
    wide = high[0] - low[0] > high[2] - low[2]
    size = 0.012
    ends = [low, (high[0] - size, low[1], low[2]) if wide else (low[0], low[1], high[2] - size)]
    feet = [box((e[0], high[1], e[2]), (e[0] + size, front, e[2] + size)) for e in ends]
    return [box(low, high), *feet]


def test_a_drawer_over_an_open_floor_takes_its_box() -> None:
    walls = [p for i, p in enumerate(carcass(0.5, 0.5, 0.4)) if i != 2]
    parts = [*walls, box((0.0, -0.02, 0.1), (0.5, 0.0, 0.38)), *bar((0.15, -0.06, 0.25), (0.35, -0.05, 0.262), -0.02)]
    start = len(parts)
    parts += tub((0.03, 0.0, 0.12), (0.47, 0.45, 0.3))
    found, owner = found_in(parts)
    (drawer,) = found.parts
    assert drawer.kind is PartKind.DRAWER
    assert set(range(start, start + 5)) <= set(owner[drawer.faces].tolist())
    assert not set(range(4)) & set(owner[drawer.faces].tolist())


def test_a_basin_that_one_looks_into_stays_behind_a_false_front() -> None:
    walls = [p for i, p in enumerate(carcass(0.6, 0.5, 0.7)) if i != 3]
    parts = [*walls, box((0.0, -0.02, 0.5), (0.6, 0.0, 0.7)), *tub((0.1, 0.01, 0.52), (0.5, 0.45, 0.7))]
    found, _ = found_in(parts)
    assert of_kind(found, PartKind.DRAWER) == []


def test_a_tub_behind_a_door_is_a_drawer_of_its_own() -> None:
    parts = [*carcass(0.5, 0.5, 0.9), box((0.0, -0.02, 0.0), (0.5, 0.0, 0.9))]
    parts += bar((0.44, -0.06, 0.4), (0.452, -0.05, 0.6), -0.02)
    start = len(parts)
    parts += tub((0.03, 0.02, 0.1), (0.47, 0.45, 0.25))
    found, owner = found_in(parts)
    (door,), (drawer,) = of_kind(found, PartKind.DOOR), of_kind(found, PartKind.DRAWER)
    assert set(owner[drawer.faces].tolist()) == set(range(start, start + 5))
    assert set(owner[door.faces].tolist()) == {5, 6, 7, 8}
    assert drawer.joint.axis == pytest.approx((0, -1, 0))


def oven(*inside: Part) -> list[Part]:
    """A carcass whose front folds down, and what is in it. Parts: 0..4 carcass, 5 door, 6..8 handle, 9.. inside."""
    front = [box((0.0, -0.02, 0.0), (0.6, 0.0, 0.5)), *bar((0.05, -0.06, 0.45), (0.55, -0.05, 0.462), -0.02)]
    return [*carcass(0.6, 0.5, 0.5), *front, *inside]


def test_a_rack_of_rods_slides_and_a_shelf_between_walls_does_not() -> None:
    rods = [box((0.03, 0.05 + 0.05 * k, 0.25), (0.57, 0.054 + 0.05 * k, 0.254)) for k in range(8)]
    rods += [box((x, 0.04, 0.254), (x + 0.004, 0.44, 0.258)) for x in (0.03, 0.298, 0.566)]
    shelf = box((0.02, 0.02, 0.12), (0.58, 0.48, 0.13))
    found, owner = found_in(oven(shelf, *rods))
    (door,), (rack,) = of_kind(found, PartKind.DOOR), of_kind(found, PartKind.TRAY)
    assert door.joint.edge is HingeEdge.BOTTOM
    assert set(owner[rack.faces].tolist()) == set(range(10, 21))


def test_a_shelf_right_behind_a_wide_front_makes_it_a_door() -> None:
    fronts: list[Part] = []
    for z in (0.0, 0.31):
        fronts.append(box((0.0, -0.02, z), (0.8, 0.0, z + 0.29)))
        fronts += bar((0.3, -0.06, z + 0.2), (0.5, -0.05, z + 0.212), -0.02)
    shelves = [box((0.02, 0.01, z), (0.78, 0.28, z + 0.012)) for z in (0.15, 0.46)]
    found, _ = found_in([*carcass(0.8, 0.3, 0.6), *fronts, *shelves])
    assert [p.kind for p in found.parts] == [PartKind.DOOR] * 2


def test_a_door_in_a_niche_twice_as_wide_runs_sideways() -> None:
    niche = [*carcass(1.0, 0.3, 0.5), box((0.02, 0.1, 0.02), (0.5, 0.12, 0.48))]
    found, _ = found_in([*niche, *bar((0.25, 0.06, 0.15), (0.262, 0.07, 0.35), 0.1)])
    (door,) = found.parts
    assert door.kind is PartKind.DOOR
    assert door.joint.kind is JointKind.SLIDE
    assert door.joint.axis == pytest.approx((1, 0, 0))


def test_a_plate_on_a_closed_block_is_no_door() -> None:
    found, _ = found_in([box((0, 0, 0), (0.6, 0.5, 0.5)), box((0.02, -0.02, 0.02), (0.58, 0.0, 0.48))])
    assert found.parts == ()


def test_a_block_with_a_front_of_its_own_behind_a_door_is_a_drawer() -> None:
    door = box((0.0, -0.02, 0.0), (0.5, 0.0, 1.2))
    handle = bar((0.46, -0.06, 0.5), (0.472, -0.05, 0.8), -0.02)
    block = box((0.05, 0.06, 0.03), (0.45, 0.45, 0.2))
    plate = box((0.05, 0.04, 0.03), (0.45, 0.058, 0.2))
    found, owner = found_in([*carcass(0.5, 0.5, 1.2), door, *handle, block, plate])
    (drawer,) = of_kind(found, PartKind.DRAWER)
    assert set(owner[drawer.faces].tolist()) == {9, 10}
    bare, _ = found_in([*carcass(0.5, 0.5, 1.2), door, *handle, block])
    assert not of_kind(bare, PartKind.DRAWER)


def test_a_wide_front_under_a_pair_of_doors_is_a_drawer() -> None:
    doors = [box((x, -0.02, 0.5), (x + 0.445, 0.0, 1.6)) for x in (0.0, 0.455)]
    handles = [b for x in (0.42, 0.47) for b in bar((x, -0.06, 0.9), (x + 0.012, -0.05, 1.2), -0.02)]
    low = box((0.0, -0.02, 0.0), (0.9, 0.0, 0.49))
    found, _ = found_in([*carcass(0.9, 0.6, 1.6), box((0.02, 0.0, 0.48), (0.88, 0.6, 0.5)), *doors, *handles, low])
    assert sorted(p.kind for p in found.parts) == [PartKind.DOOR, PartKind.DOOR, PartKind.DRAWER]


def test_closed_blocks_of_one_size_in_a_column_are_drawers() -> None:
    walls = carcass(0.5, 0.5, 0.62)
    blocks = [box((0.02, -0.02, z), (0.48, 0.45, z + 0.18)) for z in (0.025, 0.215, 0.405)]
    found, owner = found_in([*walls, *blocks])
    assert [p.kind for p in found.parts] == [PartKind.DRAWER] * 3
    assert sorted({int(k) for p in found.parts for k in owner[p.faces]}) == [5, 6, 7]


def test_a_rail_behind_two_fronts_is_no_front() -> None:
    fronts = [box((0.0, -0.02, z), (0.5, 0.0, z + 0.27)) for z in (0.0, 0.33)]
    handles = [b for z in (0.1, 0.43) for b in bar((0.15, -0.06, z), (0.35, -0.05, z + 0.012), -0.02)]
    rail = box((0.02, 0.02, 0.255), (0.48, 0.03, 0.345))
    pull = box((0.2, 0.0, 0.29), (0.3, 0.01, 0.305))
    found, owner = found_in([*carcass(0.5, 0.5, 0.6), *fronts, *handles, rail, pull])
    assert len(found.parts) == 2
    assert 13 not in {int(k) for p in found.parts for k in owner[p.faces]}


def test_the_loop_of_a_heating_element_is_no_rack() -> None:
    loop = [box((0.06, y, 0.25), (0.54, y + 0.006, 0.256)) for y in (0.06, 0.42)]
    loop += [box((x, 0.066, 0.25), (x + 0.006, 0.42, 0.256)) for x in (0.06, 0.534)]
    found, _ = found_in(oven(*loop))
    assert not of_kind(found, PartKind.TRAY)
