"""Choose collision shapes: try strategies in turn and take the first whose error is within the bound."""

from __future__ import annotations

from dataclasses import dataclass

from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.geometry.solid.coverage import surface_samples
from casa_assets.ingest.collision.components import measure_part
from casa_assets.ingest.collision.convex_decomposition import DecompositionFailed, decompose
from casa_assets.ingest.collision.fit import SAMPLES, FitErrors, describe_fit, fit_reference, measure_fit
from casa_assets.ingest.collision.solid_proxy import solid_proxy
from casa_assets.ingest.collision.strategies import (
    STRATEGIES,
    CollideParams,
    CollisionTask,
    Decomposer,
    clouds_of,
    one_shape,
    whole_shape,
)
from casa_assets.ingest.draft import Draft, PlacedShape, warning
from casa_assets.model.issue import Issue
from casa_assets.model.registry.category import Category, MatterFill, RestingPose

# Largest share of the surface that may stick out of the shapes; a little below the limit of the check, which samples
# the finished mesh.
MAX_BARE_SHARE = 0.04


@dataclass(frozen=True)
class Candidate:
    """Collision shapes of one strategy, with its name and their error; a normalized error of 1 is the bound."""

    shapes: tuple[PlacedShape, ...]
    name: str
    errors: FitErrors


def collide(draft: Draft, category: Category, params: CollideParams, decomposer: Decomposer = decompose) -> Draft:
    """Choose collision shapes: the first strategy whose error is within the bound, else the one with the least error.

    Args:
        draft: metres, z up.
        category: vessels keep their opening; solid and filled things are closed where the mesh is not.
        decomposer: runs CoACD or V-HACD out of process.
    Raises:
        Rejected: no shape with a volume can be made (MSH004).
    """
    points, faces = draft.surface.points, draft.surface.welded_faces
    is_full, is_packed = category.build in (MatterFill.SOLID, MatterFill.FILLED), category.build is MatterFill.FILLED
    whole = measure_part(points, faces, close_gaps=is_full)
    if whole is None:
        raise Rejected("MSH004", "no collision shape with a volume fits; the mesh is a sheet or a line")
    notes: list[Issue] = []
    reason = f"the mesh fills {whole.hull_fill:.0%} of its hull"
    is_one_shape = is_full and whole.hull_fill >= params.hull_ratio
    proxy = None if is_one_shape else solid_proxy(points, faces, is_full)
    task = None
    if proxy is not None:
        reference = fit_reference(points, faces, proxy.solid, not is_full)
        rests_any_way, fill = category.upright is RestingPose.ANY, whole.hull_fill
        task = CollisionTask(
            points, faces, is_full, fill, rests_any_way, is_packed, proxy, reference, params, decomposer
        )
    best = None if task is None else _best(task, notes)
    shapes: tuple[PlacedShape, ...]
    if is_one_shape:
        shapes = (whole_shape(whole.points, is_packed, params, surface_samples(points, faces, SAMPLES)),)
        name, confidence = "one shape: the mesh fills its hull", 1.0
    elif task is not None and best is not None:
        shapes, name, confidence = best.shapes, best.name, 1 / (1 + max(0.0, best.errors.normalized_error - 1))
        reason += f"; {task.proxy.message}; {describe_fit(clouds_of(shapes), task.reference, best.errors)}"
    else:
        notes.append(
            warning("MSH020", "collision", "no decomposition covers the surface; one hull closes every opening")
        )
        shapes, name, confidence = (one_shape(whole.points, params),), "one hull", 0.5
    return draft.replace(
        colliders=shapes, guesses=draft.guessed("collision", name, confidence, reason), notes=draft.noted(*notes)
    )


def _best(task: CollisionTask, notes: list[Issue]) -> Candidate | None:
    """The result of the strategy to be taken; None where no result covers the surface."""
    best: Candidate | None = None
    for strategy, good_enough in STRATEGIES:
        if best is not None and best.errors.normalized_error <= good_enough:
            break
        try:
            shapes, name = strategy(task)
            if not 0 < len(shapes) <= task.params.hull_count:
                continue
            errors = measure_fit(clouds_of(tuple(shapes)), task.reference, task.params.error_m)
        except DecompositionFailed as error:
            notes.append(warning("MSH019", "collision", str(error)))
            continue
        except DegenerateShape:
            continue
        if errors.bare_share <= MAX_BARE_SHARE and (
            best is None or errors.normalized_error < best.errors.normalized_error
        ):
            best = Candidate(tuple(shapes), name, errors)
    return best
