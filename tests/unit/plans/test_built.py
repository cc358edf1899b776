"""Two mended plans of the corpus really built: `tests/consumers/test_mended_plans.py` builds many."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.mended_plans import problems_when_built
from tests.projects import Project

# A row whose cooker needs room beside the refrigerator, and a U with two corners.
PLANS = {"draft_farmhouse": "farmhouse", "draft_chatty": "modern_1"}


@pytest.mark.slow
@pytest.mark.parametrize("name", PLANS)
def test_a_mended_plan_is_a_kitchen_that_passes(name: str, project: Project, tmp_path: Path, cache: Path) -> None:
    assert problems_when_built(name, PLANS[name], project, tmp_path / "out", cache) == []
