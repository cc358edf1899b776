"""A mended plan of the corpus really built: `tests/consumers/test_mended_plans.py` builds many."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.mended_plans import problems_when_built
from tests.projects import Project


@pytest.mark.slow
def test_a_mended_plan_is_a_kitchen_that_passes(project: Project, tmp_path: Path) -> None:
    """A row whose cooker needs room beside the refrigerator."""
    assert problems_when_built("draft_farmhouse", "farmhouse", project, tmp_path / "out") == []
