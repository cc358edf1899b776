"""Tell what became of a run of draws: how many passed, why the others were refused, and what it cost."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from casa_assets.pipeline.kitchens.recipe import SceneRecipe, SceneResult
from casa_assets.pipeline.kitchens.sampling.run import REST
from casa_assets.pipeline.kitchens.scene_folders import BUILD, CHECK, DRAW, WRITE

REJECTED = "rejected.json"
STEPS = (BUILD, WRITE, DRAW, CHECK, REST)
FAULT, MISFIT = "fault of the program", "cannot be built"


@dataclass(frozen=True)
class RefusalRow:
    """Draws of one plan in one style that were refused for one reason.

    Attributes:
        reason: code of a check, `cannot be built`, or `fault of the program`. count: of draws.
        example: what was said of the first one.
    """

    reason: str
    plan: str
    style: str
    count: int
    example: str


@dataclass(frozen=True)
class Cost:
    """Processor seconds per kitchen.

    Attributes:
        kitchens: whose cost is known, accepted and refused ones, of this run and of the one that it went on from.
        steps: seconds of each step, the mean over them.
    """

    kitchens: int
    steps: dict[str, float]

    @property
    def total(self) -> float:
        """Of all steps."""
        return sum(self.steps.values())


def refusals(done: Sequence[SceneResult]) -> list[RefusalRow]:
    """Why draws were refused, the most frequent first; a draw counts once under each of its reasons."""
    counts: Counter[tuple[str, str, str]] = Counter()
    examples: dict[tuple[str, str, str], str] = {}
    for result in done:
        for reason, message in _reasons(result).items():
            at = (reason, result.recipe.plan, result.recipe.style)
            counts[at] += 1
            examples.setdefault(at, message)
    ordered = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return [RefusalRow(*at, count, examples[at]) for at, count in ordered]


def _reasons(result: SceneResult) -> dict[str, str]:
    """Reason -> what was said first."""
    if result.passed:
        return {}
    if result.is_fault:
        return {FAULT: result.message.strip().rpartition("\n")[2]}
    found: dict[str, str] = {}
    for issue in result.problems:
        found.setdefault(issue.code, f"{issue.pointer} {issue.message}".strip())
    return found or {MISFIT: result.message}


def cost_of(done: Sequence[SceneResult]) -> Cost:
    """What a kitchen cost on average, as far as it is known."""
    known = [result.cpu_s for result in done if result.cpu_s]
    if not known:
        return Cost(0, {})
    return Cost(len(known), {step: round(sum(c.get(step, 0.0) for c in known) / len(known), 2) for step in STEPS})


def write_rejected(out: Path, seed: int, wanted: Sequence[SceneRecipe], done: Sequence[SceneResult]) -> Path:
    """Put what was drawn, how much of it passed, and why the rest did not, into rejected.json; returns its path.

    Args:
        out: folder of the scenes. seed: of the draws. wanted: all draws. done: what became of those that were tried.
    """
    results = {d.recipe.scene_id: d for d in done}
    tried = [results[r.scene_id] for r in wanted if r.scene_id in results]
    passed = sum(d.passed for d in tried)
    data = {
        "seed": seed,
        "drawn": len(wanted),
        "tried": len(tried),
        "passed": passed,
        "pass_rate": round(passed / len(tried), 4) if tried else None,
        "reasons": [asdict(row) for row in refusals(tried)],
        "rejected": [_rejected(d) for d in tried if not d.passed],
    }
    path = out / REJECTED
    path.write_text(json.dumps(data, indent=1, sort_keys=True, ensure_ascii=False) + "\n", encoding="utf-8")
    return path


def _rejected(done: SceneResult) -> dict[str, Any]:
    recipe = done.recipe
    return {
        "id": recipe.scene_id,
        "plan": recipe.plan,
        "style": recipe.style,
        "seed": recipe.seed,
        "surfaces": {surface.value: name for surface, name in recipe.surfaces},
        "message": done.message,
        "issues": [{"code": i.code, "pointer": i.pointer, "message": i.message} for i in done.problems],
    }
