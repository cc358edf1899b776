"""Inputs of a scene, and the outcome of building it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, field

from casa_assets.model.issue import Issue, Report
from casa_assets.model.kitchen.surface import Surface


@dataclass(frozen=True)
class SceneRecipe:
    """Inputs of a scene: plan, style, seed and finishes.

    Attributes:
        plan, style: names.
        seed: draws the lengths of the plan; None: as the plan has them.
        surfaces: finishes that differ from the style's, in the order of the surfaces.
        closed: whether open walls are drawn too.
        objects: how many things of registry/objects/ are put into it, where people keep them; 0: none.
        objects_seed: draws which, and where.
        mixed: whether its fronts, models and other parts are drawn out of all styles, by `seed`, or 0 without one.
        models: role -> model in place of the style's, `family/preset` or `library:<id>`, sorted by role.
    """

    plan: str
    style: str
    seed: int | None = None
    surfaces: tuple[tuple[Surface, str], ...] = ()
    closed: bool = False
    objects: int = 0
    objects_seed: int = 0
    mixed: bool = False
    models: tuple[tuple[str, str], ...] = ()

    @property
    def scene_id(self) -> str:
        """`<plan>__<style>`, and what applies of `__s<seed>`, `__t<digest of finishes>` and further parts.

        These are `__m<digest of models>`, `__mixed`, `__closed` and `__o<objects>`. The last has the seed of the
        objects, where it is not 0, right after their number: `__o40s3`.
        """
        parts = [self.plan, self.style]
        if self.seed is not None:
            parts.append(f"s{self.seed}")
        if self.surfaces:
            parts.append("t" + _short_digest((surface.value, name) for surface, name in self.surfaces))
        if self.models:
            parts.append("m" + _short_digest(self.models))
        if self.mixed:
            parts.append("mixed")
        if self.closed:
            parts.append("closed")
        if self.objects:
            parts.append(f"o{self.objects}" + (f"s{self.objects_seed}" if self.objects_seed else ""))
        return "__".join(parts)


def _short_digest(pairs: Iterable[tuple[str, str]]) -> str:
    """The digits that stand for a choice in the id of a scene."""
    text = ",".join(f"{key}={name}" for key, name in pairs)
    return hashlib.sha256(text.encode()).hexdigest()[:8]


@dataclass(frozen=True)
class SceneResult:
    """Outcome of building one scene.

    Attributes:
        recipe: of the scene. folder: where it is; empty where it failed.
        message: why it failed. is_fault: the program is to blame; then that is a trace.
        report: of all checks; None where they did not run.
        build_s, write_s, draw_s, check_s: wall seconds. cpu_s: processor seconds by step, as far as they were counted.
        counts: what the scene holds, by word. kept: an earlier run made it, and nothing has changed.
    """

    recipe: SceneRecipe
    folder: str = ""
    message: str = ""
    report: Report | None = None
    build_s: float = 0.0
    write_s: float = 0.0
    draw_s: float = 0.0
    check_s: float = 0.0
    cpu_s: dict[str, float] = field(default_factory=dict)
    counts: dict[str, float] = field(default_factory=dict)
    kept: bool = False
    is_fault: bool = False

    @property
    def passed(self) -> bool:
        """True if it was built, and no check found an error."""
        return bool(self.folder) and (self.report is None or self.report.passed)

    @property
    def problems(self) -> tuple[Issue, ...]:
        """Errors of its checks."""
        return () if self.report is None else self.report.errors
