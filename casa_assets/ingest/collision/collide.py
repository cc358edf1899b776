"""Choose collision shapes: try strategies in turn and take the first whose error is within the bound."""

from __future__ import annotations

from dataclasses import dataclass

from casa_assets.core.typing import Floats
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

# The share of the surface that may be bare; a little below the limit of the check, which samples the finished mesh.
BARE_BAD = 0.04


@dataclass(frozen=True)
class Candidate:
    """Collision shapes of one strategy, with its name and their error; a normalized error of 1 is the bound."""

    shapes: tuple[PlacedShape, ...]
    how: str
    found: FitErrors


def collide(draft: Draft, category: Category, params: CollideParams, decomposer: Decomposer = decompose) -> Draft:
    """Choose collision shapes that stand for the surface in contacts.

    The cheap and exact ways come first; the first that lies close enough all over is taken, else the closest.

    Args:
        draft: metres, z up.
        category: vessels keep their opening; solid and filled things are closed where the mesh is not.
        decomposer: runs CoACD or V-HACD out of process.
    Raises:
        Rejected: no shape with a volume can be made (MSH004).
    """
    points, ids = draft.surface.points, draft.surface.welded_faces
    full = category.build in (MatterFill.SOLID, MatterFill.FILLED)
    whole = measure_part(points, ids, bridge=full)
    if whole is None:
        raise Rejected("MSH004", "no collision shape with a volume fits; the mesh is a sheet or a line")
    notes: list[Issue] = []
    reason = f"the mesh fills {whole.fill:.0%} of its hull"
    is_one = full and whole.fill >= params.hull_ratio
    made = None if is_one else solid_proxy(points, ids, full)
    shapes: tuple[PlacedShape, ...]
    if is_one:
        samples = surface_samples(points, ids, SAMPLES)
        one = whole_shape(whole.points, category.build is MatterFill.FILLED, params, samples)
        shapes, how, confidence = (one,), "one shape: the mesh fills its hull", 1.0
    elif made is None:
        shapes, how, confidence = (_last_resort(whole.points, params, notes),), "one hull", 0.5
    else:
        by = fit_reference(points, ids, made.solid, not full)
        rolls = category.upright is RestingPose.ANY
        packed = category.build is MatterFill.FILLED
        best = _best(CollisionTask(points, ids, full, whole.fill, rolls, packed, made, by, params, decomposer), notes)
        if best is None:
            shapes, how, confidence = (_last_resort(whole.points, params, notes),), "one hull", 0.5
        else:
            shapes, how, confidence = best.shapes, best.how, 1 / (1 + max(0.0, best.found.normalized_error - 1))
            reason += f"; {made.message}; {describe_fit(clouds_of(best.shapes), by, best.found)}"
    return draft.replace(
        colliders=shapes, guesses=draft.guessed("collision", how, confidence, reason), notes=draft.noted(*notes)
    )


def _last_resort(points: Floats, params: CollideParams, notes: list[Issue]) -> PlacedShape:
    notes.append(warning("MSH020", "collision", "no decomposition covers the surface; one hull closes every opening"))
    return one_shape(points, params)


def _best(task: CollisionTask, notes: list[Issue]) -> Candidate | None:
    """The first way that stays within the bound, else the one that comes closest; None where none covers."""
    best: Candidate | None = None
    for way, enough in STRATEGIES:
        if best is not None and best.found.normalized_error <= enough:
            break
        try:
            shapes, how = way(task)
            if not 0 < len(shapes) <= task.params.hull_count:
                continue
            found = measure_fit(clouds_of(tuple(shapes)), task.by, task.params.error_m)
        except DecompositionFailed as error:
            notes.append(warning("MSH019", "collision", str(error)))
            continue
        except DegenerateShape:
            continue
        if found.bare <= BARE_BAD and (best is None or found.normalized_error < best.found.normalized_error):
            best = Candidate(tuple(shapes), how, found)
    return best
