"""Choose collision shapes: try strategies in turn and take the first whose error is within the bound."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.ingest.collision.components import measure_part
from casa_assets.ingest.collision.convex_decomposition import DecompositionFailed, decompose
from casa_assets.ingest.collision.fit import (
    SAMPLES,
    SOUND_SHARE,
    CollideParams,
    FitErrors,
    describe_fit,
    fit_reference,
    measure_fit,
    on_flat_foot,
)
from casa_assets.ingest.collision.solid_proxy import solid_proxy
from casa_assets.ingest.collision.strategies import (
    STRATEGIES,
    CollisionTask,
    Decomposer,
    clouds_of,
    one_shape,
    whole_shape,
)
from casa_assets.ingest.draft import Draft, PlacedShape, warning
from casa_assets.mesh.grid.voxels import NO_ROOMS, OpenRooms, open_rooms
from casa_assets.mesh.solid.deviation import surface_samples
from casa_assets.model.issue import REVIEW_CODE, Issue
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

    @property
    def rank(self) -> tuple[bool, float]:
        """Smaller is better: first what the checks accept, then the least error."""
        return not self.errors.is_sound, self.errors.normalized_error


def collide(draft: Draft, category: Category, params: CollideParams, decomposer: Decomposer = decompose) -> Draft:
    """Choose collision shapes: the first strategy whose error is within the bound, else the one with the least error.

    Vessels keep their opening; solid and filled things are closed where the mesh, metres, z up, is not. The decomposer
    runs CoACD or V-HACD out of process. Raises Rejected: no shape with a volume can be made (MSH004).
    """
    points, faces = draft.surface.points, draft.surface.welded_faces
    rooms = _open_rooms(points, faces)
    is_full, is_packed = _is_full(category, rooms), category.build is MatterFill.FILLED
    rests_any_way = _is_known(category) and category.upright is RestingPose.ANY
    kept_rooms = rooms.kept(with_gaps=not is_full)
    whole = measure_part(points, faces, close_gaps=is_full)
    if whole is None:
        raise Rejected("MSH004", "no collision shape with a volume fits; the mesh is a sheet or a line")
    notes: list[Issue] = []
    reason = f"the mesh fills {whole.hull_fill:.0%} of its hull"
    is_one_shape = is_full and whole.hull_fill >= params.hull_ratio and not kept_rooms
    proxy = None if is_one_shape else solid_proxy(points, faces, is_full)
    task, best = None, None
    if proxy is not None:
        reference = fit_reference(points, faces, proxy.solid, not is_full, rooms, kept_rooms)
        fill = whole.hull_fill
        task = CollisionTask(
            points, faces, is_full, fill, rests_any_way, is_packed, proxy, reference, params, decomposer
        )
        best = _best(task, notes)
    shapes: tuple[PlacedShape, ...]
    if is_one_shape:
        samples = surface_samples(points, faces, SAMPLES)
        shapes = (whole_shape(whole.points, whole.hull_fill, is_packed, params, samples),)
        name, confidence = "one shape: the mesh fills its hull", 1.0
    elif task is not None and best is not None:
        shapes, name, confidence = best.shapes, best.name, 1 / (1 + max(0.0, best.errors.normalized_error - 1))
        if best.errors.closed_share > SOUND_SHARE * params.closed_share:
            notes.append(_closed_room_note(best.errors.closed_share, best.name, params))
        reason += f"; {task.proxy.message}; {describe_fit(clouds_of(shapes), task.reference, best.errors)}"
    else:
        message = "no decomposition covers the surface; one hull closes every opening"
        notes.append(warning("MSH020", "collision", message))
        shapes, name, confidence = (one_shape(whole.points, params),), "one hull", 0.5
        if kept_rooms:
            notes.append(_closed_room_note(1.0, name, params))
    guesses = draft.guessed("collision", name, confidence, reason)
    return draft.replace(colliders=shapes, guesses=guesses, notes=draft.noted(*notes))


def _closed_room_note(closed_share: float, name: str, params: CollideParams) -> Issue:
    """The question to a person where no shapes within the limits keep an open room open."""
    message = f"no {params.hull_count} shapes keep its open rooms: the best close {closed_share:.0%} of one ({name})"
    advice = "what is put in there is pushed out. Accept or reject it in review.csv"
    return warning(REVIEW_CODE, "collision", f"{message}; {advice}")


def _best(task: CollisionTask, notes: list[Issue]) -> Candidate | None:
    """The result of the best strategy, or None if no result covers the surface."""
    best: Candidate | None = None
    for strategy, good_enough in STRATEGIES:
        if best is not None and best.errors.is_sound and best.errors.normalized_error <= good_enough:
            break
        try:
            shapes, name = strategy(task)
            if not 0 < len(shapes) <= task.params.hull_count:
                continue
            found = _candidate(shapes, name, task)
        except DecompositionFailed as error:
            notes.append(warning("MSH019", "collision", str(error)))
            continue
        except DegenerateShape:
            continue
        if found.errors.bare_share <= MAX_BARE_SHARE and (best is None or found.rank < best.rank):
            best = found
    return best


def _candidate(shapes: Sequence[PlacedShape], name: str, task: CollisionTask) -> Candidate:
    """Shapes with their error, on a flat foot where that is as near: under a tube it would be a bottom."""
    plain = Candidate(tuple(shapes), name, measure_fit(clouds_of(tuple(shapes)), task.reference, task.params))
    if len(shapes) > task.part_count or task.rests_any_way:
        return plain
    standing = on_flat_foot(shapes, task.proxy.solid)
    if standing == plain.shapes:
        return plain
    footed = Candidate(standing, name, measure_fit(clouds_of(standing), task.reference, task.params))
    worst = max(1.0, plain.errors.normalized_error)
    is_near = footed.errors.normalized_error <= worst and footed.errors.is_sound >= plain.errors.is_sound
    return footed if is_near else plain


def _open_rooms(points: Floats, faces: Ints) -> OpenRooms:
    """The open rooms of a surface, or no rooms if it spans no volume."""
    used, compact = np.unique(faces, return_inverse=True)
    try:
        return open_rooms(points[used], compact.reshape(-1, 3))
    except DegenerateShape:
        return NO_ROOMS


def _is_full(category: Category, rooms: OpenRooms) -> bool:
    """True if holes in the surface are damage: something solid or filled, and no room that closing them would fill.

    Where only the backs of faces look into a room it is a gap in the surface of something that is known to be full. Of
    what is of no known kind that cannot be said.
    """
    is_usually_full = category.build in (MatterFill.SOLID, MatterFill.FILLED)
    return is_usually_full and not rooms.encloses(with_gaps=not _is_known(category))


def _is_known(category: Category) -> bool:
    """True unless it is the class above all others, which says nothing of how a thing is filled or rests."""
    return category.id != category.parent
