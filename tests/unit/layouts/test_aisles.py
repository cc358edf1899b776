"""How wide it is between rows, and whether people work there or pass."""

from __future__ import annotations

import math

import pytest

from casa_assets.layouts.plan.clearances import find_aisles
from casa_assets.model.kitchen.floor import Aisle, AisleKind, PlacedRun, RoomWall
from tests.support.kitchen.reference_kitchen import OUTLINE, WALLS, unit

UNITS = (unit("a", "doors", 0.0, 1.0), unit("b", "doors", 1.0, 2.0))
CLOSED = tuple(w.replace(is_open=False) for w in WALLS)


def row(name: str, x: float, y: float, quarter: int = 0, at_wall: bool = True, back: float = 0.0) -> PlacedRun:
    """Two metres of units with free ends, their line's left end at a point."""
    return PlacedRun(
        id=name, origin=(x, y), yaw=quarter * math.pi / 2, length=2.0, at_wall=at_wall, depth_behind=back, units=UNITS
    )


def found(*rows: PlacedRun, walls: tuple[RoomWall, ...] = WALLS) -> dict[tuple[str, str], Aisle]:
    return {(a.first, a.second): a for a in find_aisles(rows, walls, OUTLINE)}


ISLAND = row("island", 3.0, -2.5, 2, at_wall=False)
DEEP = row("main", 1.0, 0.0).replace(units=(UNITS[0].replace(front=0.8), UNITS[1]))


@pytest.mark.parametrize(
    ("rows", "walls", "pair", "kind", "width"),
    [
        ((row("main", 1.0, 0.0), ISLAND), WALLS, ("island", "main"), AisleKind.WORK, 2.5 - 0.65 - 0.65),
        ((DEEP, ISLAND), WALLS, ("island", "main"), AisleKind.WORK, 2.5 - 0.8 - 0.65),  # the narrowest place counts
        ((row("main", 1.0, 0.0),), CLOSED, ("front", "main"), AisleKind.WALK, 4.0 - 0.65),
        ((row("island", 2.8, -2.2, 2, at_wall=False),), WALLS, ("island", "left"), AisleKind.WALK, 0.8),  # its end
    ],
)
def test_width_and_kind(
    rows: tuple[PlacedRun, ...], walls: tuple[RoomWall, ...], pair: tuple[str, str], kind: AisleKind, width: float
) -> None:
    aisle = found(*rows, walls=walls)[pair]
    assert aisle.kind is kind
    assert aisle.width == pytest.approx(width)
    if rows[-1] is ISLAND:
        assert 1.0 < aisle.position[0] < 3.0
        assert rows[0] is DEEP or aisle.position[1] == pytest.approx(-1.25)


def test_back_of_an_island_is_passed_and_what_lies_between_hides_the_wall() -> None:
    """The island's back looks at the front wall; the long row sees the island, and beside it the wall."""
    aisles = found(row("main", 1.5, 0.0), row("island", 3.5, -2.2, 2, at_wall=False, back=0.3), walls=CLOSED)
    back = aisles[("front", "island")]
    assert back.kind is AisleKind.WALK
    assert back.width == pytest.approx(4.0 - 2.2 - 0.3)
    assert ("front", "main") not in aisles
