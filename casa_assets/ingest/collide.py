"""Collision shapes, the cheap and exact ones first: one primitive or hull, one per piece, rings, cuts, decomposers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.geometry.cutting import Solid, hull_points, lean_hull, slimmed, surface_of
from casa_assets.geometry.hull import convex_hull, small_hull
from casa_assets.geometry.primitive import best_primitive
from casa_assets.geometry.solid import simplified_solid
from casa_assets.geometry.tessellate import surface
from casa_assets.geometry.topology import weld
from casa_assets.ingest.collide_judge import Verdict, Yardstick, in_words, verdict, yardstick
from casa_assets.ingest.collide_matter import Matter, matter
from casa_assets.ingest.collide_rings import cut_vessel
from casa_assets.ingest.collide_split import Bound, joined, split_up
from casa_assets.ingest.decompose import Budget, DecompositionFailed, decompose
from casa_assets.ingest.draft import Draft, Placed, warning
from casa_assets.ingest.pieces import any_nested, measured, split, thickness
from casa_assets.model.category import Build, Category, Upright
from casa_assets.model.issue import Issue
from casa_assets.model.mesh import Mesh
from casa_assets.model.record import Record
from casa_assets.model.shape import Hull

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Decomposer = Callable[[str, Floats, Ints, Budget], list[Floats]]

# Faces that the decomposition sees; more change the hulls hardly and the time a lot.
COACD_FACES = 2000
# Faces that cutting by planes works on at most, where that can be had.
CUT_FACES = 2500
# The share of the surface that may be bare; a little below the limit of the check, which samples the finished mesh.
BARE_BAD = 0.04
# Shares of the bound that a way aims at, so that reducing vertices does not break it, and that the reducing may use.
AIM = 0.8
LEAN = 0.15
# A chord of a wall may cut so much of its thickness.
CHORD = 0.4
# What fills this share of its hull is one hull if that is within the bound; a full thing may stick out somewhere.
ONE = 0.8
STALK = 2.0
ROLLING = 0.88
PRIMITIVE = 0.85
# A thing that is full is a primitive that its hull fills so far: a can with its rims is a cylinder, a carton a box.
WHOLE_PRIMITIVE = 0.89
# A general decomposition is tried where the best so far is so many times beyond the bound.
POOR = 1.6
BAD = 3.0
# Hollow under a floor, as a part of the longest side, that may be filled.
FOOT = 0.04
# A hull thinner than this, metres, is a splinter that no contact feels.
SPLINTER_M = 1e-5


class CollideParams(Record):
    """Limits of the stage: most hulls and vertices, least volume ratios, surface error in metres."""

    hull_count: int = 32
    hull_vertices: int = 64
    primitive_ratio: float = 0.95
    hull_ratio: float = 0.95
    error_m: float = 0.004


@dataclass(frozen=True)
class Task:
    """What a way of making shapes works on.

    Attributes:
        points, faces: (P, 3) welded, metres, and (F, 3).
        full: matter all through, so that holes in the surface are closed. fill: of the hull, 0..1.
        rolls: it has no pose of its own.
        made: the solid that the surface stands for. by: what shapes are held against.
        params: limits. decomposer: runs CoACD or V-HACD out of process.
    """

    points: Floats
    faces: Ints
    full: bool
    fill: float
    rolls: bool
    made: Matter
    by: Yardstick
    params: CollideParams
    decomposer: Decomposer

    @property
    def budget(self) -> Budget:
        """What a decomposition may make of it."""
        return Budget(hulls=self.params.hull_count, hull_vertices=self.params.hull_vertices)

    @property
    def aim(self) -> Bound:
        """What cuts are made for."""
        return Bound(AIM * self.by.bound.p95, AIM * self.by.bound.worst)

    @property
    def slack(self) -> float:
        """How far reducing vertices may move a hull, metres."""
        return LEAN * self.by.bound.p95


@dataclass(frozen=True)
class Cover:
    """Shapes, how they were made, and how they do; strain 1 is the bound."""

    shapes: tuple[Placed, ...]
    how: str
    found: Verdict


def collide(draft: Draft, category: Category, params: CollideParams, decomposer: Decomposer = decompose) -> Draft:
    """Shapes that stand in for the surface in contacts.

    The cheap and exact ways come first; the first that lies close enough all over is taken, else the closest.

    Args:
        draft: metres, z up.
        category: vessels keep their opening; solid and filled things are closed where the mesh is not.
        decomposer: runs CoACD or V-HACD out of process.
    Raises:
        Rejected: no shape with a volume can be made (MSH004).
    """
    vertices, faces = draft.soup()
    points, place = weld(vertices)
    ids = place[faces]
    full = category.build in (Build.SOLID, Build.FILLED)
    whole = measured(points, ids, bridge=full)
    if whole is None:
        raise Rejected("MSH004", "no collision shape with a volume fits; the mesh is a sheet or a line")
    notes: list[Issue] = []
    because = f"the mesh fills {whole.fill:.0%} of its hull"
    made = None if whole.fill >= params.hull_ratio else matter(points, ids, full)
    shapes: tuple[Placed, ...]
    if whole.fill >= params.hull_ratio:
        shapes, how, sure = (_whole(whole.points, full, params),), "one shape: the mesh fills its hull", 1.0
    elif made is None:
        shapes, how, sure = (_last_resort(whole.points, params, notes),), "one hull", 0.5
    else:
        by = yardstick(points, ids, made.solid, not full)
        rolls = category.upright is Upright.ANY
        best = _best(Task(points, ids, full, whole.fill, rolls, made, by, params, decomposer), notes)
        if best is None:
            shapes, how, sure = (_last_resort(whole.points, params, notes),), "one hull", 0.5
        else:
            shapes, how, sure = best.shapes, best.how, 1 / (1 + max(0.0, best.found.strain - 1))
            because += f"; {made.says}; {in_words(_clouds(best.shapes), by, best.found)}"
    return draft.replace(
        colliders=shapes, guesses=draft.guessed("collision", how, sure, because), notes=draft.noted(*notes)
    )


def _last_resort(points: Floats, params: CollideParams, notes: list[Issue]) -> Placed:
    notes.append(warning("MSH020", "collision", "no decomposition covers the surface; one hull closes every opening"))
    return _shape(points, params)


def _best(task: Task, notes: list[Issue]) -> Cover | None:
    """The first way that stays within the bound, else the one that comes closest; None where none covers."""
    best: Cover | None = None
    for way, enough in WAYS:
        if best is not None and best.found.strain <= enough:
            break
        try:
            shapes, how = way(task)
            if not 0 < len(shapes) <= task.params.hull_count:
                continue
            found = verdict(_clouds(tuple(shapes)), task.by, task.params.error_m)
        except DecompositionFailed as error:
            notes.append(warning("MSH019", "collision", str(error)))
            continue
        except DegenerateShape:
            continue
        if found.bare <= BARE_BAD and (best is None or found.strain < best.found.strain):
            best = Cover(tuple(shapes), how, found)
    return best


def _by_one(task: Task) -> tuple[list[Placed], str]:
    """One primitive or hull around everything, where it lies close enough."""
    if task.fill < ONE:
        return [], ""
    shell, _ = convex_hull(task.points)
    fit = best_primitive(shell)
    if fit is not None and fit.ratio >= PRIMITIVE:
        placed = Placed(shape=fit.shape, pose=fit.pose)
        if verdict(_clouds((placed,)), task.by, task.params.error_m).strain <= 1:
            return [placed], f"one {fit.shape.kind}"
    found = verdict([small_hull(shell, task.params.hull_vertices)[0]], task.by, task.params.error_m)
    off, bound = found.off, task.by.bound
    # What has no pose of its own rolls: one shape with its stalk does that better than parts with edges.
    rolls = task.rolls and task.fill >= ROLLING
    stalk = off.added_p95 <= bound.p95 and off.added_worst <= STALK * bound.worst
    near = found.strain <= 1 or (task.full and (rolls or stalk))
    return ([_whole(shell, task.full, task.params)], "one shape") if near else ([], "")


def _by_pieces(task: Task) -> tuple[list[Placed], str]:
    """One shape for each piece; none where one of them is not convex."""
    pieces = split(task.points, task.faces, task.params.hull_count)
    if len(pieces) < 2 or any(p.fill < task.params.hull_ratio for p in pieces) or any_nested(pieces):
        return [], ""
    return [_shape(p.points, task.params) for p in pieces], "one shape for each piece"


def _by_rings(task: Task) -> tuple[list[Placed], str]:
    """A vessel as floor, rings of sectors and handles; none where there is no opening, or no such cut."""
    if not len(task.by.room):
        return [], ""
    finest = min(CHORD * task.made.wall, AIM * task.by.bound.p95)
    solid = slimmed(task.made.solid, task.slack / 2)
    vessel = cut_vessel(solid, finest, FOOT * task.by.of.longest, task.params.hull_count)
    if vessel is None:
        return [], ""
    room = task.params.hull_count - len(vessel.floors)
    pieces = [*vessel.floors, *split_up([*vessel.cells, *vessel.rest], task.by.of, task.aim, room)]
    return _hulls([[p] for p in pieces], task), vessel.says


def _by_cuts(task: Task) -> tuple[list[Placed], str]:
    """Cut by planes where hulls would stick out most."""
    solid = slimmed(task.made.solid, task.slack / 2, CUT_FACES, 2 * task.slack)
    pieces = split_up([solid], task.by.of, task.aim, task.params.hull_count)
    groups = joined(pieces, task.by.of, task.aim, task.by.room)
    return _hulls(groups, task), "cut by planes where hulls would stick out"


def _by_coacd(task: Task) -> tuple[list[Placed], str]:
    """CoACD of a closed manifold."""
    solid = simplified_solid(*surface_of(task.made.solid), COACD_FACES)
    if solid is None:
        return [], ""
    # CoACD's surface error is about half the threshold times the longest side.
    threshold = min(max(2 * task.params.error_m / task.by.of.longest, 0.03), 0.2)
    clouds = task.decomposer("coacd", *solid, replace(task.budget, threshold=threshold))
    return _shapes(clouds, task.params), "decomposed by CoACD"


def _by_vhacd(task: Task) -> tuple[list[Placed], str]:
    """V-HACD of the triangles as they are, in case the solid lacks some of them."""
    clouds = task.decomposer("vhacd", task.points, task.faces, task.budget)
    return _shapes(clouds, task.params), "decomposed by V-HACD"


# Each way, and the strain of the best so far at which it is not tried.
WAYS: tuple[tuple[Callable[[Task], tuple[list[Placed], str]], float], ...] = (
    (_by_one, 0.0),
    (_by_pieces, np.inf),
    (_by_rings, 1.0),
    (_by_cuts, 1.0),
    (_by_coacd, POOR),
    (_by_vhacd, BAD),
)


def _hulls(groups: list[list[Solid]], task: Task) -> list[Placed]:
    """A hull of few vertices, or the primitive that it is, around each group of solids."""
    clouds = [lean_hull(hull_points(group), task.params.hull_vertices, task.slack) for group in groups]
    return _shapes(clouds, task.params)


def _clouds(shapes: tuple[Placed, ...]) -> list[Floats]:
    return [surface(s.shape, s.pose)[0] for s in shapes]


def _shapes(clouds: list[Floats], params: CollideParams) -> list[Placed]:
    whole = [cloud for cloud in clouds if thickness(cloud) > SPLINTER_M]
    return [s for s in (_shape_or_none(cloud, params) for cloud in whole) if s is not None]


def _shape_or_none(cloud: Floats, params: CollideParams) -> Placed | None:
    try:
        return _shape(cloud, params)
    except DegenerateShape:
        return None


def _whole(cloud: Floats, full: bool, params: CollideParams) -> Placed:
    """The one shape around everything."""
    least = min(params.primitive_ratio, WHOLE_PRIMITIVE) if full else params.primitive_ratio
    return _shape(cloud, params.replace(primitive_ratio=least))


def _shape(cloud: Floats, params: CollideParams) -> Placed:
    """The primitive around a cloud where it fits tightly, else its hull of few vertices."""
    shell, _ = convex_hull(cloud)
    fit = best_primitive(shell)
    if fit is not None and fit.ratio >= params.primitive_ratio:
        return Placed(shape=fit.shape, pose=fit.pose)
    points, faces = small_hull(shell, params.hull_vertices)
    return Placed(shape=Hull(mesh=Mesh(vertices=points, faces=faces)))
