"""Inputs of a scene, its id, and the outcome of building it."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from itertools import combinations
from pathlib import Path

from casa_assets.core.system import kept_json
from casa_assets.errors import CasaError, UnknownId
from casa_assets.model.issue import Issue, Report
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.files import SCENE_JSON
from casa_assets.registry.kitchens import plan_names, style_names


@dataclass(frozen=True)
class SceneRecipe:
    """Inputs of a scene: plan, style, seed and finishes.

    Attributes:
        plan, style: names. seed: draws the lengths of the plan; None: as the plan has them.
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
    """Return the digest that represents a choice in the id of a scene: eight hexadecimal digits."""
    text = ",".join(f"{key}={name}" for key, name in pairs)
    return hashlib.sha256(text.encode()).hexdigest()[:8]


@dataclass(frozen=True)
class SceneResult:
    """Outcome of building one scene.

    Attributes:
        recipe: of the scene. folder: where it is; empty if building failed.
        message: reason of a failure. is_fault: it is a fault of the program; then the message is a traceback.
        report: of all checks; None if they did not run.
        build_s, write_s, draw_s, check_s: wall-clock seconds. cpu_s: processor seconds by step, as far as measured.
        counts: number of items in the scene, by kind. kept: made by an earlier run, and nothing has changed since.
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


# What names the ids that there are, for errors.
LISTED_BY = "`casa-assets scenes list` lists plans and styles"
_OBJECTS = r"(?:__o(?P<objects>\d+)(?:s(?P<objects_seed>\d+))?)?"
_REST = re.compile(
    r"(?:__s(?P<seed>\d+))?(?:__t(?P<finishes>[0-9a-f]{8}))?(?:__m(?P<models>[0-9a-f]{8}))?"
    r"(?P<mixed>__mixed)?(?P<closed>__closed)?" + _OBJECTS
)


def split_objects(name: str) -> tuple[str, int, int]:
    """Split `<id or glob>__o40s3` into what is before the objects, their number and their seed; 0 and 0 without."""
    fields = re.fullmatch(r"(?P<before>.*?)" + _OBJECTS, name)
    assert fields is not None, "an empty end matches every name"
    return fields["before"], int(fields["objects"] or 0), int(fields["objects_seed"] or 0)


def recipe_of(scene_id: str, places: Sequence[Path] = ()) -> SceneRecipe:
    """Parse the id of a kitchen into its recipe.

    The id holds only digests of finishes and models. Finishes are found by drawing them again from the seed
    (`--textures random`); finishes and models are also found if the kitchen is in one of `places`.

    Args:
        scene_id: such as `galley__rustic__s7__t5c1d2e3f`. places: folders of scenes, searched in this order.
    Raises:
        UnknownId: no such plan or style, or not an id. CasaError: the finishes or the models cannot be found.
    """
    plan, _, tail = scene_id.partition("__")
    style, _, rest = tail.partition("__")
    fields = _REST.fullmatch(f"__{rest}" if rest else "")
    if plan not in plan_names() or style not in style_names() or fields is None:
        raise UnknownId("scene", scene_id, [f"{p}__{s}" for p in plan_names() for s in style_names()], LISTED_BY)
    seed = None if fields["seed"] is None else int(fields["seed"])
    _, objects, objects_seed = split_objects(scene_id)
    is_closed, is_mixed = fields["closed"] is not None, fields["mixed"] is not None
    bare = SceneRecipe(plan, style, seed, (), is_closed, objects, objects_seed, is_mixed)
    has_finishes, has_models = fields["finishes"] is not None, fields["models"] is not None
    for models in _stated_models(scene_id, places) if has_models else [()]:
        for surfaces in _candidates(scene_id, seed, places) if has_finishes else [()]:
            recipe = replace(bare, surfaces=surfaces, models=models)
            if recipe.scene_id == scene_id:
                return recipe
    where = ", ".join(str(place) for place in places) or "no folder"
    hidden = [("t" + fields["finishes"], "finishes", "surfaces={'wall': ...}")] if has_finishes else []
    hidden += [("m" + fields["models"], "models", "models={'range': ...}")] if has_models else []
    digests = " and ".join(f"'{digits}' is a digest of its {name}" for digits, name, _ in hidden)
    raise CasaError(
        f"{scene_id}: {digests}; which they are cannot be read from that, and no scene of this id is in {where}. "
        f"Give the folder that it is in, or make it again with "
        f"casa_assets.kitchen({plan!r}, {style!r}, seed={seed}, {', '.join(option for *_, option in hidden)})"
    )


def _stated_models(scene_id: str, places: Sequence[Path]) -> Iterator[tuple[tuple[str, str], ...]]:
    from casa_assets.layouts.run.resolve import ordered_models  # here and below, since it loads all families

    for place in places:
        with suppress(KeyError, TypeError, AttributeError, CasaError):
            found = kept_json(place / scene_id / SCENE_JSON)["models"]
            yield ordered_models((role, str(name)) for role, name in found.items())


def _candidates(scene_id: str, seed: int | None, places: Sequence[Path]) -> Iterator[tuple[tuple[Surface, str], ...]]:
    """Yield sets of finishes that may have the digest of the id."""
    from casa_assets.layouts.run.resolve import draw_surfaces, ordered_surfaces

    yield draw_surfaces(seed or 0)
    for place in places:
        try:
            finishes = kept_json(place / scene_id / SCENE_JSON)["surfaces"]
            pairs = [(Surface(name), str(finish)) for name, finish in finishes.items()]
        except (ValueError, KeyError, TypeError, AttributeError):
            continue
        # scene.json names the finishes of all surfaces; the id those alone that differ from the style's.
        for count in range(1, len(pairs) + 1):
            for some in combinations(pairs, count):
                with suppress(UnknownId):  # a finish of a pack that is not here, or of an older registry
                    yield ordered_surfaces(some)


def all_recipes() -> list[SceneRecipe]:
    """Every plan in every style."""
    return [SceneRecipe(plan, style) for plan in plan_names() for style in style_names()]


def recipes_matching(patterns: Sequence[str]) -> list[SceneRecipe]:
    """The plain scenes whose ids match one of some globs. Raises UnknownId where one matches nothing."""
    every = all_recipes()
    out: list[SceneRecipe] = []
    for pattern in patterns:
        found = [r for r in every if fnmatchcase(r.scene_id, pattern)]
        if not found:
            raise UnknownId("scene", pattern, [r.scene_id for r in every], LISTED_BY)
        out += [r for r in found if r not in out]
    return out


def recipes_named(names: Sequence[str], out: Path) -> list[SceneRecipe]:
    """Return scenes by globs of plain ids, with or without objects (`l_*__coastal__o40`), or by complete ids.

    `out`: folder of scenes, searched for finishes that an id holds only as a digest. Raises UnknownId: a glob matches
    nothing, or an id names no plan or style. CasaError: see `recipe_of`.
    """
    found: list[SceneRecipe] = []
    for name in names:
        pattern, objects, seed = split_objects(name)
        is_plain = any(sign in name for sign in "*?[") or pattern.count("__") < 2
        recipes = (
            [replace(recipe, objects=objects, objects_seed=seed) for recipe in recipes_matching([pattern])]
            if is_plain
            else [recipe_of(name, (out,))]
        )
        found += [recipe for recipe in recipes if recipe not in found]
    return found
