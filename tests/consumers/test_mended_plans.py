"""Plans that are right, and plans with faults: corrected, built, passed by every check, in all styles between them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from casa_assets.registry.kitchens import style_names
from tests.mended_plans import problems_when_built
from tests.projects import Project, project_in

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
