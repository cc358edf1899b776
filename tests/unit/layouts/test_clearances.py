"""Leaves sweep what was foreseen of them; how wide it is between rows, and whether people work there or pass."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from casa_assets.kitchenware.parts.handles import HandleKind, handle_reach
from casa_assets.layouts.floor_facts import facts_of
from casa_assets.layouts.plan.clearances import HANDLES_M, Leaf, Part, find_aisles, leaves_of
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import build_scene, preset_params
from casa_assets.mesh.planar import distance, outline_of
from casa_assets.model.kitchen.floor import Aisle, AisleKind, KitchenFacts, PlacedRun, RoomWall
from casa_assets.registry.tables import load_roles
from tests.support.kitchen.reference_kitchen import OUTLINE, WALLS, unit

pytestmark = pytest.mark.content("code", "layouts", keep=0)

BEYOND_M = 0.01  # that a leaf may reach beyond what was said
RECIPES = (SceneRecipe("l_small", "coastal"), SceneRecipe("u_large", "modern_1"))


@pytest.fixture(scope="module", params=RECIPES, ids=lambda recipe: recipe.scene_id)
def built(request: pytest.FixtureRequest, cache: Path) -> tuple[KitchenFacts, tuple[Leaf, ...]]:
    kitchen, scene = build_scene(request.param, cache)
    models = StyleModels(kitchen.style, preset_params(), load_roles(), kitchen.plan.height)
    return facts_of(kitchen, scene), leaves_of(kitchen.slots, kitchen.holes, models)


def test_handles_stand_out_as_far_as_is_said() -> None:
    assert set(HANDLES_M) == {kind.value for kind in HandleKind}
    for kind in HandleKind:
        assert handle_reach(kind) - 1e-6 <= HANDLES_M[kind.value] < handle_reach(kind) + 0.01, kind


@pytest.mark.representatives(1)
def test_open_leaves_lie_where_they_were_foreseen(built: tuple[KitchenFacts, tuple[Leaf, ...]]) -> None:
    facts, leaves = built
    count = 0
    for fixture, joint in ((one, joint) for one in facts.fixtures for joint in one.joints):
        stands_on_worktop = 0.9 < fixture.bottom < 1.2
        opens = joint.swept_area is not None and joint.behind is None and "rack" not in joint.name
        if not fixture.unit or not opens or stands_on_worktop:
            continue
        own = [leaf for leaf in leaves if leaf.owner == fixture.unit]
        area = joint.swept_area
        run = facts.run(fixture.run)
        # What lies before the fronts is compared: the rest of an open drawer is still in its cabinet.
        front = max(run.to_local(p)[1] for p in fixture.footprint.corners)
        points = np.array([p for p in area.open_outline if run.to_local(p)[1] > front + 0.001])
        foreseen = [outline_of([p for part in leaf.stands for p in part.outline]) for leaf in own]
        apart = min((float(distance(hull, points).max()) for hull in foreseen), default=9.0)
        assert apart < BEYOND_M, (fixture.name, joint.name, apart)
        count += 1
    assert count >= 20


def test_a_door_meets_the_handle_of_a_wall_unit_that_is_shut() -> None:
    near, far = (Part(((x, 0.0), (x + 1.0, 0.0), (x + 1.0, 1.0), (x, 1.0)), 0.0, 1.0) for x in (0.0, 0.6))
    opened, shut = Leaf("a", "main", (near,), (near,)), Leaf("b", "side", (far,), (), shut=(far,))
    assert opened.depth_in(shut) == pytest.approx(0.4)


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


def test_width_and_kind_and_what_lies_between_hides_the_wall() -> None:
    plain, islands_end = row("main", 1.0, 0.0), row("island", 2.8, -2.2, 2, at_wall=False)
    for rows, walls, pair, kind, width in [
        ((plain, ISLAND), WALLS, ("island", "main"), AisleKind.WORK, 2.5 - 0.65 - 0.65),
        ((DEEP, ISLAND), WALLS, ("island", "main"), AisleKind.WORK, 2.5 - 0.8 - 0.65),  # the narrowest place counts
        ((plain,), CLOSED, ("front", "main"), AisleKind.WALK, 4.0 - 0.65),
        ((islands_end,), WALLS, ("island", "left"), AisleKind.WALK, 0.8),
    ]:
        aisle = found(*rows, walls=walls)[pair]
        assert (aisle.kind, aisle.width) == (kind, pytest.approx(width)), pair
        if rows[-1] is ISLAND:
            assert 1.0 < aisle.position[0] < 3.0
            assert rows[0] is DEEP or aisle.position[1] == pytest.approx(-1.25)
    # The island's back looks at the front wall; the long row sees the island, and beside it the wall.
    aisles = found(row("main", 1.5, 0.0), row("island", 3.5, -2.2, 2, at_wall=False, back=0.3), walls=CLOSED)
    back = aisles[("front", "island")]
    assert (back.kind, back.width) == (AisleKind.WALK, pytest.approx(4.0 - 2.2 - 0.3))
    assert ("front", "main") not in aisles
