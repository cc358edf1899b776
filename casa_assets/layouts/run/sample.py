"""Draw kitchens at random, and make them: in parallel, each once, from where an earlier run was stopped."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from casa_assets.core.numeric import rng_for
from casa_assets.core.system import replace_file
from casa_assets.errors import CasaError
from casa_assets.layouts.run import check
from casa_assets.layouts.run.diversity import Choices, Diversity, Traits, diversity_of
from casa_assets.layouts.run.mix import kinds_of_fronts, models_of_roles
from casa_assets.layouts.run.recipe import SceneRecipe, SceneResult, all_recipes
from casa_assets.layouts.run.resolve import draw_surfaces, resolve
from casa_assets.layouts.run.scene_folders import BUILD, CHECK, DRAW, WRITE, run_recipes
from casa_assets.library.library import Library
from casa_assets.model.issue import Issue, Report
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.record import Record
from casa_assets.registry.kitchens import plan_names, style_names
from casa_assets.runs.limits import cpu_seconds
from casa_assets.runs.pool import Workers
from casa_assets.show.stills.kitchen import PictureSettings
from casa_assets.textures.run.recipes import available_finishes

FOLDER = "draws"
MAX_SEED = 1_000_000  # seeds of kitchens are drawn below this, so that ids stay short
# Of overviews, which are looked at by the dozen: about a quarter of the work of one that `scenes build` draws.
FRAME = PictureSettings(640, 480, passes=2, shadow_px=512)
REST = "rest"  # step of a draw: keys, publishing, what is loaded once per process
REJECTED = "rejected.json"
STEPS = (BUILD, WRITE, DRAW, CHECK, REST)
FAULT, MISFIT = "fault of the program", "cannot be built"


def draw_recipes(count: int, seed: int, objects: int = 0) -> list[SceneRecipe]:
    """Draw `count` different recipes. With the same seed, a longer list begins with the shorter one.

    Every draw has a separate random stream, so that it does not depend on which process works on it. `objects`: number
    of loose objects in each; which ones, and their places, are drawn with the lengths of its plan.
    """
    plans, styles = plan_names(), style_names()
    found: dict[str, SceneRecipe] = {}
    number = 0
    while len(found) < count:
        rng = rng_for(seed, f"scenes/draw/{number}")
        number += 1
        plan, style = plans[int(rng.integers(len(plans)))], styles[int(rng.integers(len(styles)))]
        own = int(rng.integers(MAX_SEED))
        recipe = SceneRecipe(plan, style, own, draw_surfaces(own), mixed=True)
        if objects:
            recipe = replace(recipe, objects=objects, objects_seed=own)
        found.setdefault(recipe.scene_id, recipe)  # one that was drawn before is drawn again, and counts once
    return list(found.values())


def traits_of(recipe: SceneRecipe) -> Traits:
    """Traits of the kitchen of a recipe, which need not be built. Raises as `resolve` does."""
    kitchen = resolve(recipe)
    style = kitchen.style
    (x0, y0), (x1, y1) = kitchen.room.bounds()
    base = style.cabinets.base
    return Traits(
        id=recipe.scene_id,
        plan=recipe.plan,
        style=recipe.style,
        lengths={
            name: (kitchen.parameters[name] - p.low) / (p.high - p.low) if p.high > p.low else 0.0
            for name, p in kitchen.plan.parameters.items()
        },
        floor_m2=(x1 - x0) * (y1 - y0),
        surfaces=style.surfaces,
        fronts=f"{base.front}, {base.handle}",
        fixtures={item.role: item.choice.preset for item in kitchen.items if item.role in style.models},
    )


def diversity_of_recipes(recipes: Iterable[SceneRecipe]) -> Diversity:
    """How diverse the kitchens of some recipes are, which need not be built. Raises as `resolve` does."""
    return diversity_of([traits_of(recipe) for recipe in recipes], choices())


def diversity_of_reference() -> Diversity:
    """How diverse every plan in every style is, each as it is: what random kitchens are compared with."""
    return diversity_of_recipes(all_recipes())


def choices() -> Choices:
    """How many values the traits can have, with the plans, styles and textures in use."""
    models, finishes = models_of_roles(), available_finishes().surfaces
    return Choices(
        plans=len(plan_names()),
        styles=len(style_names()),
        fronts=len(kinds_of_fronts()),
        surfaces={surface.value: len(finishes[surface]) for surface in Surface},
        fixtures={role: len(names) for role, names in models.items()},
    )


class DrawRecord(Record):
    """Outcome of one draw, in `<out>/.casa/cache/draws/<id>.json`: a run that was stopped goes on from there.

    Attributes:
        id: of the scene. key: of the verdict; a record with another key was made by older code or data.
        passed: whether it was accepted. message, issues: why not. cpu_s: processor seconds by step.
    """

    id: str
    key: str
    passed: bool
    message: str = ""
    issues: tuple[Issue, ...] = ()
    cpu_s: dict[str, float]


def read_draw(out: Path, recipe: SceneRecipe, key: str) -> DrawRecord | None:
    """Return the record of a draw under that key, or None if it is missing or damaged."""
    try:
        record = DrawRecord.from_json(_path(out, recipe.scene_id).read_text(encoding="utf-8"))
    except (OSError, ValidationError):
        return None
    return record if record.key == key else None


def keep_draw(out: Path, done: SceneResult, key: str) -> None:
    """Keep what became of a draw. Raises OSError where the folder cannot be written to."""
    record = DrawRecord(
        id=done.recipe.scene_id,
        key=key,
        passed=done.passed,
        message=done.message,
        issues=done.problems,
        cpu_s=done.cpu_s,
    )
    replace_file(_path(out, record.id), (record.to_json() + "\n").encode())


def _path(out: Path, scene_id: str) -> Path:
    return Library(out).cache / FOLDER / f"{scene_id}.json"


def sample_all(
    recipes: Sequence[SceneRecipe], out: Path, jobs: Workers = 0, drawn: bool = True, in_3d: bool = False
) -> Iterator[SceneResult]:
    """Yield draws as `run_recipes` does; only kitchens that pass every check are put into the folder.

    A draw that fails, for whatever reason, does not stop the others. `drawn`: with an overview. `in_3d`: with a model
    for the page, about 4 MB each.
    """
    work = partial(sample_one, out=out, drawn=drawn, in_3d=in_3d)
    return run_recipes(work, recipes, out, jobs, f"{check.__name__}:warm", goes_on=True)


def sample_one(recipe: SceneRecipe, out: Path, drawn: bool = True, in_3d: bool = False) -> SceneResult:
    """Make and check one draw, or take what an earlier run found of it; what it cost is kept with it."""
    begin = cpu_seconds()
    try:
        key = check.verdict_key(recipe)
    except CasaError:
        key = ""  # it cannot be resolved, which `check_one` says again and which costs little
    record = read_draw(out, recipe, key) if key else None
    if record is not None and not record.passed:
        report = Report(subject=record.id, issues=record.issues) if record.issues else None
        return SceneResult(recipe, message=record.message, report=report, cpu_s=record.cpu_s, kept=True)
    done = check.check_one(recipe, out, strict=True, drawn=drawn, in_3d=in_3d, frame=FRAME)
    if done.kept:
        return replace(done, cpu_s=record.cpu_s if record is not None else {})
    rest = cpu_seconds() - begin - sum(done.cpu_s.values())
    done = replace(done, cpu_s={**done.cpu_s, REST: round(rest, 2)})
    if key and not done.is_fault:  # after a fault of the program the draw is made again
        keep_draw(out, done, key)
    return done


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
    """Mean processor seconds of the steps of a kitchen.

    `kitchens`: number of those whose cost is known, accepted and refused ones, of this run and an interrupted one.
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
    if result.passed:
        return {}
    if result.is_fault:
        return {FAULT: result.message.strip().rpartition("\n")[2]}
    found: dict[str, str] = {}
    for issue in result.problems:
        found.setdefault(issue.code, f"{issue.pointer} {issue.message}".strip())
    return found or {MISFIT: result.message}


def cost_of(done: Sequence[SceneResult]) -> Cost:
    """Return the mean processor time per kitchen by step, over the results for which it is known."""
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
