"""What leaves are said to sweep before a kitchen is built is what the built ones do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from casa_assets.kitchenware.parts.hardware.handles import HandleKind, handle_reach
from casa_assets.layouts.floor_facts import facts_of
from casa_assets.layouts.plan.clearances import HANDLES_M, Leaf, leaves_of
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import build_scene, preset_params
from casa_assets.mesh.planar import distance, outline_of
from casa_assets.model.kitchen.floor import Fixture, FixtureJoint, KitchenFacts
from casa_assets.registry.tables import load_roles

pytestmark = pytest.mark.content("code", "layouts", keep=0)

# Metres that a leaf may reach beyond what was said, and fall short of it: handles are not all of one depth.
BEYOND_M, SHORT_M = 0.01, 0.06
RECIPES = (SceneRecipe("l_small", "coastal"), SceneRecipe("u_large", "modern_1"))


@pytest.fixture(scope="module", params=RECIPES, ids=lambda recipe: recipe.scene_id)
def built(request: pytest.FixtureRequest, cache: Path) -> tuple[KitchenFacts, tuple[Leaf, ...]]:
    """Facts of a built kitchen, and the leaves that were foreseen of it."""
    kitchen, scene = build_scene(request.param, cache)
    models = StyleModels(kitchen.style, preset_params(), load_roles(), kitchen.plan.height)
    return facts_of(kitchen, scene), leaves_of(kitchen.slots, kitchen.holes, models)


def opened(facts: KitchenFacts) -> list[tuple[Fixture, FixtureJoint]]:
    """Joints of units that open by themselves."""
    return [
        (fixture, joint)
        for fixture in facts.fixtures
        for joint in fixture.joints
        if fixture.unit and joint.swept_area is not None and joint.behind is None and "rack" not in joint.name
    ]


def test_handles_stand_out_as_far_as_is_said() -> None:
    assert set(HANDLES_M) == {kind.value for kind in HandleKind}
    for kind in HandleKind:
        assert handle_reach(kind) - 1e-6 <= HANDLES_M[kind.value] < handle_reach(kind) + 0.01, kind


@pytest.mark.representatives(1)
def test_open_leaves_lie_where_they_were_foreseen(
    built: tuple[KitchenFacts, tuple[Leaf, ...]],
) -> None:
    facts, leaves = built
    count = 0
    for fixture, joint in opened(facts):
        if fixture.bottom > 0.9 and fixture.bottom < 1.2:
            continue  # what stands on worktops
        own = [leaf for leaf in leaves if leaf.owner == fixture.unit]
        area = joint.swept_area
        assert area is not None
        run = facts.run(fixture.run)
        assert run is not None
        # What lies before the fronts is compared: the rest of an open drawer is still in its cabinet.
        front = max(run.to_local(p)[1] for p in fixture.footprint.corners)
        points = np.array([p for p in area.open_outline if run.to_local(p)[1] > front + 0.001])
        foreseen = [outline_of([p for part in leaf.stands for p in part.outline]) for leaf in own]
        apart = min((float(distance(hull, points).max()) for hull in foreseen), default=9.0)
        assert apart < BEYOND_M, (fixture.name, joint.name, apart)
        count += 1
    assert count >= 20


@pytest.mark.representatives(1)
def test_no_more_is_foreseen_than_there_is(built: tuple[KitchenFacts, tuple[Leaf, ...]]) -> None:
    facts, leaves = built
    for unit in {fixture.unit for fixture, _ in opened(facts)}:
        runs = [f.run for f in facts.fixtures if f.unit == unit and f.run]
        run = facts.run(runs[0])
        own = [leaf for leaf in leaves if leaf.owner == unit]
        if run is None or not own:
            continue
        real = max(
            run.to_local(p)[1]
            for fixture, joint in opened(facts)
            if fixture.unit == unit and joint.swept_area is not None
            for p in joint.swept_area.outline
        )
        said = max(run.to_local(p)[1] for leaf in own for part in leaf.way for p in part.outline)
        assert said < real + SHORT_M, (unit, said, real)
