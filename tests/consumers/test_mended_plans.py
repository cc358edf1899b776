"""Plans that are right, and plans with faults: corrected, built, passed by every check, in all styles between them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from casa_assets.layouts.check_plan.check import check_plan, plan_id
from casa_assets.layouts.run import check
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.registry.kitchens import load_style, style_names
from tests.support.kitchen.plan_corpus import plans
from tests.support.program.projects import Project, project_in

# Plans that are right, and plans whose rows, rooms, openings, islands and corners are corrected.
PLANS = {
    "draft_huge_room": "transitional_2",
    "draft_tiny": "transitional_1",
    "ok_corner": "coastal",
    "ok_galley": "mediterranean",
    "ok_island": "traditional_1",
    "ok_studio": "rustic",
    "aisle_too_narrow": "industrial",
    "door_beyond_wall": "modern_1",
    "island_too_large": "farmhouse",
    "no_corner": "scandinavian",
    "row_too_long": "modern_2",
    "walls_aslant_do_not_close": "traditional_2",
}

pytestmark = pytest.mark.certify


def problems_when_built(name: str, style: str, project: Project, out: Path) -> list[str]:
    """What a plan of the corpus lacks as a kitchen: no mend that works, no kitchen, or checks that it does not pass.

    Args:
        project: writes the mended plan into its `plans/`. out: folder of the scenes, not there yet.
    """
    found = check_plan(plans()[name], f"{name}.yaml", load_style(style)[0])
    if not found.mended:
        return [f"{told.expected}, got {told.got}" for told in found.faults if told.mend is None]
    plan = plan_id(f"{name}.yaml")
    project({f"plans/{plan}.yaml": found.text})
    done = check.check_one(SceneRecipe(plan, style), out, drawn=False, in_3d=False)
    return [done.message] if done.message else [f"{i.code} {i.pointer}: {i.message}" for i in done.problems]


@pytest.fixture
def own(tmp_path: Path) -> Iterator[Project]:
    """A project in the folder of the test."""
    with project_in(tmp_path) as written:
        yield written


def test_every_style_is_among_them() -> None:
    assert set(PLANS.values()) == set(style_names())


@pytest.mark.parametrize("name", PLANS)
def test_a_mended_plan_is_a_kitchen_that_passes(name: str, own: Project, tmp_path: Path) -> None:
    assert problems_when_built(name, PLANS[name], own, tmp_path / "out") == []
