"""Make the kitchens that were drawn: in parallel, each once, from where an earlier run was stopped."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from casa_assets.errors import CasaError
from casa_assets.pipeline.kitchens import check
from casa_assets.pipeline.kitchens.recipe import SceneRecipe, SceneResult
from casa_assets.pipeline.kitchens.sampling.ledger import keep_draw, read_draw, refused_before
from casa_assets.pipeline.kitchens.scene_folders import run_recipes
from casa_assets.pipeline.workers.limits import cpu_seconds
from casa_assets.pipeline.workers.pool import Workers
from casa_assets.preview.kitchen import PictureSettings

# Of overviews, which are looked at by the dozen: about a quarter of the work of one that `scenes build` draws.
FRAME = PictureSettings(640, 480, passes=2, shadow_px=512)
REST = "rest"  # step of a draw: keys, publishing, what is loaded once per process


def sample_all(
    recipes: Sequence[SceneRecipe], out: Path, jobs: Workers = 0, drawn: bool = True, in_3d: bool = False
) -> Iterator[SceneResult]:
    """Draws in the order in which they are done; only kitchens that pass every check are put into the folder.

    A draw that fails, for whatever reason of its own, leaves the others alone.

    Args:
        out: folder of the scenes. jobs: processes; 0 for one per core. drawn: with an overview. in_3d: with a model for
            the page, about 4 MB each.
    Raises:
        OutputError: the folder is held by another run or cannot be written. CasaError: see run_batch.
    """
    work = partial(sample_one, out=out, drawn=drawn, in_3d=in_3d)
    return run_recipes(work, recipes, out, jobs, f"{check.__name__}:warm", goes_on=True)


def sample_one(recipe: SceneRecipe, out: Path, drawn: bool = True, in_3d: bool = False) -> SceneResult:
    """Make and check one draw, or take what an earlier run found of it; what it cost is kept with it."""
    begin = cpu_seconds()
    try:
        key = check.verdict_key(recipe)
    except CasaError:
        key = ""  # it cannot be resolved, which `check_one` tells again and which costs little
    record = read_draw(out, recipe, key) if key else None
    if record is not None and not record.passed:
        return refused_before(record, recipe)
    done = check.check_one(recipe, out, strict=True, drawn=drawn, in_3d=in_3d, frame=FRAME)
    if done.kept:
        return replace(done, cpu_s=record.cpu_s if record is not None else {})
    rest = cpu_seconds() - begin - sum(done.cpu_s.values())
    done = replace(done, cpu_s={**done.cpu_s, REST: round(rest, 2)})
    if key:
        keep_draw(out, done, key)
    return done
