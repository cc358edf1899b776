"""Plans of the corpus of `tests/unit/plans`, mended as `check-plan` mends them, built and checked as whole kitchens."""

from __future__ import annotations

from pathlib import Path

from casa_assets.pipeline.kitchens import check
from casa_assets.pipeline.kitchens.recipe import SceneRecipe
from casa_assets.pipeline.plans.check import check_plan, plan_id
from casa_assets.registry.kitchens import load_style
from tests.plan_corpus import plans
from tests.projects import Project


def problems_when_built(name: str, style: str, project: Project, out: Path) -> list[str]:
    """What a plan of the corpus lacks as a kitchen: no mend that works, no kitchen, or checks that it does not pass.

    Args:
        project: writes the mended plan into its `plans/`. out: folder of the scenes, not there yet.
    """
    found = check_plan(plans()[name], f"{name}.yaml", load_style(style)[0])
    if not found.mended:
        return [f"{told.fault.expected}, got {told.fault.got}" for told in found.faults if told.fault.mend is None]
    plan = plan_id(f"{name}.yaml")
    project({f"plans/{plan}.yaml": found.text})
    done = check.check_one(SceneRecipe(plan, style), out, drawn=False, in_3d=False)
    return [done.message] if done.message else [f"{i.code} {i.pointer}: {i.message}" for i in done.problems]
