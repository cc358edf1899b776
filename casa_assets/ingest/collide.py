"""Collision shapes, the cheap and exact ones first: one primitive or hull, one per piece, then decomposition."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.geometry.hull import convex_hull, small_hull
from casa_assets.geometry.measure import face_normals, signed_volume
from casa_assets.geometry.primitive import best_primitive
from casa_assets.geometry.solid import closed_solid, simplified_solid
from casa_assets.geometry.topology import face_components, weld
from casa_assets.geometry.voxel import voxelise
from casa_assets.ingest.decompose import Budget, DecompositionFailed, decompose
from casa_assets.ingest.draft import Draft, Placed, warning
from casa_assets.model.category import Build, Category
from casa_assets.model.issue import Issue
from casa_assets.model.mesh import Mesh
from casa_assets.model.record import Record
from casa_assets.model.shape import Hull

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Decomposer = Callable[[str, Floats, Ints, Budget], list[Floats]]

# Faces that the decomposition sees; more change the hulls hardly and the time a lot.
COACD_FACES = 2000
# A sheet without thickness gets this much, metres: the thinnest that contacts hold.
SHEET_M = 0.001


class CollideParams(Record):
    """Limits of the stage: most hulls and vertices, least volume ratios, surface error in metres."""

    hull_count: int = 32
    hull_vertices: int = 64
    primitive_ratio: float = 0.95
    hull_ratio: float = 0.95
    error_m: float = 0.004


@dataclass(frozen=True)
class Piece:
    """A connected part: its points and faces, the volume of its hull, how much of that it fills (0..1)."""

    points: Floats
    faces: Ints
    hull_volume: float
    fill: float


def collide(draft: Draft, category: Category, params: CollideParams, decomposer: Decomposer = decompose) -> Draft:
    """Shapes that stand in for the surface in contacts.

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
    whole = _piece(points, ids, bridge=full)
    if whole is None:
        raise Rejected("MSH004", "no collision shape with a volume fits; the mesh is a sheet or a line")
    if whole.fill >= params.hull_ratio:
        found, how = [_shape(whole.points, params)], "one shape: the mesh fills its hull"
        notes: list[Issue] = []
    else:
        found, how, notes = _by_pieces(points, ids, whole, params, decomposer)
    because = f"the mesh fills {whole.fill:.0%} of its hull; {len(found)} shapes"
    return draft.replace(
        colliders=tuple(found),
        guesses=draft.guessed("collision", how, min(1.0, 0.5 + whole.fill / 2), because),
        notes=draft.noted(*notes),
    )


def _by_pieces(
    points: Floats, ids: Ints, whole: Piece, params: CollideParams, decomposer: Decomposer
) -> tuple[list[Placed], str, list[Issue]]:
    pieces = _pieces(points, ids, params.hull_count)
    convex = [p for p in pieces if p.fill >= params.hull_ratio]
    rest = [p for p in pieces if p.fill < params.hull_ratio]
    if not pieces or len(convex) > params.hull_count - 4 * bool(rest) or len(rest) > params.hull_count // 4:
        convex, rest = [], [whole]
    shapes = [_shape(p.points, params) for p in convex]
    if not rest:
        return shapes, "one shape for each piece", []
    room = params.hull_count - len(shapes)
    total = sum(p.hull_volume for p in rest)
    notes: list[Issue] = []
    names = []
    for piece in rest:
        share = max(4, int(room * piece.hull_volume / total)) if len(rest) > 1 else room
        hulls, name = _decomposed(piece, share, params, decomposer, notes)
        shapes += hulls
        names.append(name)
    return shapes[: params.hull_count], f"decomposed by {' and '.join(sorted(set(names)))}", notes


def _decomposed(
    piece: Piece, room: int, params: CollideParams, decomposer: Decomposer, notes: list[Issue]
) -> tuple[list[Placed], str]:
    """CoACD where the piece is a manifold, V-HACD where it is not or CoACD fails, one hull where both fail."""
    extent = float(np.ptp(piece.points, axis=0).max())
    # CoACD's surface error is about half the threshold times the longest side.
    threshold = min(max(2 * params.error_m / extent, 0.03), 0.2)
    budget = Budget(hulls=room, hull_vertices=params.hull_vertices, threshold=threshold)
    tries: list[tuple[str, Floats, Ints]] = [("vhacd", piece.points, piece.faces)]
    solid = simplified_solid(piece.points, piece.faces, COACD_FACES)
    if solid is not None:
        tries.insert(0, ("coacd", *solid))
    for method, points, faces in tries:
        try:
            clouds = decomposer(method, points, faces, budget)
        except DecompositionFailed as error:
            notes.append(warning("MSH019", "collision", str(error)))
            continue
        shapes = [s for s in (_shape_or_none(cloud, params) for cloud in clouds) if s is not None]
        if shapes and len(shapes) <= room:
            return shapes, {"coacd": "CoACD", "vhacd": "V-HACD"}[method]
    notes.append(warning("MSH020", "collision", "no decomposition fits the budget; one hull closes every opening"))
    return [_shape(piece.points, params)], "one hull"


def _pieces(points: Floats, ids: Ints, most: int) -> list[Piece]:
    """Connected parts that have a volume, largest first; specks are left out. Empty where there are far too many."""
    label = face_components(ids, len(points))
    count = int(label.max()) + 1
    if count > 40 * most:
        return []
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    extent = float(np.ptp(points, axis=0).max())
    found = []
    for rows in groups:
        used, local = np.unique(ids[rows], return_inverse=True)
        piece = _piece(points[used], local.reshape(-1, 3), bridge=False)
        if piece is not None and np.ptp(piece.points, axis=0).max() > 0.02 * extent:
            found.append(piece)
    return sorted(found, key=lambda p: -p.hull_volume)


def _piece(points: Floats, faces: Ints, bridge: bool) -> Piece | None:
    """Measure a part; a flat one is given a thickness. None where it has no extent."""
    if _thickness(points) < SHEET_M / 4:
        normals, areas = face_normals(points, faces)
        along = (
            np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][-1] if len(points) > 2 else normals[0]
        )
        if areas.sum() <= 0:
            return None
        points = np.concatenate([points + along * SHEET_M / 2, points - along * SHEET_M / 2])
        return _convex_piece(points)
    try:
        shell = convex_hull(points)
    except DegenerateShape:
        return None
    hull_volume = signed_volume(*shell)
    solid = closed_solid(points, faces)
    if solid is not None and not (bridge and len(np.unique(face_components(faces, len(points)))) > 1):
        volume = signed_volume(*solid)
    else:
        volume = voxelise(points, faces, bridge=bridge).volume
    return Piece(points, faces, hull_volume, min(1.0, volume / hull_volume))


def _convex_piece(points: Floats) -> Piece | None:
    try:
        shell, triangles = convex_hull(points)
    except DegenerateShape:
        return None
    return Piece(shell, triangles, signed_volume(shell, triangles), 1.0)


def _thickness(points: Floats) -> float:
    """Extent along the direction of least spread, metres."""
    if len(points) < 4:
        return 0.0
    _, vectors = np.linalg.eigh(np.cov(points.T))
    return float(np.ptp(points @ vectors[:, 0]))


def _shape_or_none(cloud: Floats, params: CollideParams) -> Placed | None:
    try:
        return _shape(cloud, params)
    except DegenerateShape:
        return None


def _shape(cloud: Floats, params: CollideParams) -> Placed:
    """The primitive around a cloud where it fits tightly, else its hull of few vertices."""
    shell, _ = convex_hull(cloud)
    fit = best_primitive(shell)
    if fit is not None and fit.ratio >= params.primitive_ratio:
        return Placed(shape=fit.shape, pose=fit.pose)
    points, faces = small_hull(shell, params.hull_vertices)
    return Placed(shape=Hull(mesh=Mesh(vertices=points, faces=faces)))
