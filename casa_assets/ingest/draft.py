"""A model on its way to becoming an Asset, with what was guessed and noticed; and the Asset of a finished one."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field

from casa_assets.core.numeric import Floats, Ints, Mask, seven_digits
from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.mesh.grasps import choose_grasps, grasp_site
from casa_assets.mesh.solid.primitive import box_around, shape_bounds
from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.mesh.surface import picked, weld, with_normals
from casa_assets.model.asset.asset import Asset, Base, Collider, Guess, Inertial, Labels, Link, Region, Visual, split_of
from casa_assets.model.asset.material import Material, Substance
from casa_assets.model.asset.parts import Box, Grasp, Hull, Mesh, MeshShape, Shape
from casa_assets.model.issue import Issue, Severity
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record, Vec3
from casa_assets.model.registry.category import Category
from casa_assets.model.source import RawPart, Source


class PlacedShape(Record):
    """A collision shape and where it sits (asset from shape), metres."""

    shape: Shape
    pose: Pose = Pose()


def placed_hull(points: Floats, faces: Ints) -> PlacedShape:
    """A hull, (P, 3) points and (F, 3) faces, in the asset frame."""
    return PlacedShape(shape=Hull(mesh=Mesh(vertices=points, faces=faces)))


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles of all parts: (V, 3) vertices, (F, 3) faces, and the same over welded points; arrays are read-only."""

    vertices: Floats
    faces: Ints

    @cached_property
    def _welded(self) -> tuple[Floats, Ints]:
        points, point_of_vertex = weld(self.vertices)
        _make_read_only(points, point_of_vertex)
        return points, point_of_vertex

    @property
    def points(self) -> Floats:
        """(P, 3) welded points: vertices at one place count once."""
        return self._welded[0]

    @property
    def point_of_vertex(self) -> Ints:
        """(V,) index of each vertex's point."""
        return self._welded[1]

    @cached_property
    def welded_faces(self) -> Ints:
        """(F, 3) indices into `points`."""
        faces = self.point_of_vertex[self.faces]
        _make_read_only(faces)
        return faces


def merge_parts(parts: Sequence[RawPart]) -> Surface:
    """The triangles of some parts in one set, in the order of the parts."""
    vertices = np.concatenate([p.mesh.vertices for p in parts])
    starts = np.cumsum([0] + [len(p.mesh.vertices) for p in parts[:-1]])
    faces = np.concatenate([p.mesh.faces.astype(np.int64) + s for p, s in zip(parts, starts, strict=True)])
    _make_read_only(vertices, faces)
    return Surface(vertices, faces)


def submesh(mesh: Mesh, faces: Ints, keep_normals: bool = True) -> Mesh:
    """The mesh with these (F, 3) faces of it alone, and the vertices that they use in the order that they had."""
    used, local = np.unique(faces, return_inverse=True)
    out = picked(mesh, used, local.reshape(-1, 3))
    return out if keep_normals else out.replace(normals=None)


def keep_faces(parts: Sequence[RawPart], keep: Mask) -> tuple[RawPart, ...]:
    """The parts with the faces that are kept, (F,) over all of them; parts that lose all go, whole ones stay as is."""
    out, start = [], 0
    for part in parts:
        rows = keep[start : start + len(part.mesh.faces)]
        start += len(rows)
        if rows.any():
            mesh = part.mesh if rows.all() else submesh(part.mesh, part.mesh.faces[rows].astype(np.int64))
            out.append(part.replace(mesh=mesh))
    return tuple(out)


class Draft(Record):
    """State between two stages. Each stage returns a new one.

    `parts`: meshes with materials; file units and axes until `orient` and `scale` have run, then metres, z up.
    `metres_per_unit`, `up`, `format`: as read from the file, see RawModel. `guesses`: decisions so far. `notes`:
    warnings so far. `colliders`: from `collide` on. `inertial`: from `mass` on; asset frame. `grasps`: from `grasp` on.
    """

    parts: Annotated[tuple[RawPart, ...], Field(min_length=1)]
    metres_per_unit: float | None = None
    up: str | None = None
    format: str = "unknown"
    guesses: tuple[Guess, ...] = ()
    notes: tuple[Issue, ...] = ()
    colliders: tuple[PlacedShape, ...] = ()
    inertial: Inertial | None = None
    grasps: tuple[Grasp, ...] = ()

    @cached_property
    def surface(self) -> Surface:
        """All parts as one set of triangles; computed once for as long as the parts stay the same."""
        return merge_parts(self.parts)

    def replace(self, **changes: Any) -> Self:
        """A validated copy with some fields changed; it shares the surface where the parts are not among them."""
        copy = super().replace(**changes)
        if "parts" not in changes and "surface" in self.__dict__:
            copy.__dict__["surface"] = self.surface
        return copy

    def __getstate__(self) -> dict[Any, Any]:
        """State for pickling, without `surface`: it is large and can be computed again."""
        state = super().__getstate__()
        fields = {name: value for name, value in state["__dict__"].items() if name != "surface"}
        return {**state, "__dict__": fields}

    def guessed(self, subject: str, value: str, confidence: float, reason: str) -> tuple[Guess, ...]:
        """The guesses and one more; confidence is kept to two digits."""
        guess = Guess(subject=subject, value=value, confidence=round(float(confidence), 2), reason=reason)
        return (*self.guesses, guess)

    def confidence_in(self, subject: str) -> float:
        """Confidence of the guess about a subject, such as `category`; 1 where nothing was guessed."""
        return next((guess.confidence for guess in self.guesses if guess.subject == subject), 1.0)

    def with_confidence(self, subject: str, confidence: float) -> Self:
        """A copy that is as sure as that of what it guessed about a subject; to two digits."""
        sure = round(float(confidence), 2)
        guesses = tuple(g.replace(confidence=sure) if g.subject == subject else g for g in self.guesses)
        return self.replace(guesses=guesses)

    def noted(self, *notes: Issue) -> tuple[Issue, ...]:
        """The notes and some more, each once."""
        return (*self.notes, *(n for n in notes if n not in self.notes))


def warning(code: str, pointer: str, message: str) -> Issue:
    """An issue that is kept with the asset but does not keep it out."""
    return Issue(code=code, severity=Severity.WARNING, pointer=pointer, message=message)


def _make_read_only(*arrays: Floats | Ints) -> None:
    for array in arrays:
        array.setflags(write=False)


def grasp(draft: Draft, category: Category, opening_m: float) -> Draft:
    """The best grasp of each kind that is possible; draft: metres, z up, as it rests, with its mass."""
    assert draft.inertial is not None, "the mass stage ran"
    surface, center = draft.surface, draft.inertial.center_of_mass
    return draft.replace(grasps=choose_grasps(surface.points, surface.welded_faces, center, category, opening_m))


def assemble(
    draft: Draft,
    asset_id: str,
    category: Category,
    classes: tuple[str, ...],
    substance: Substance,
    source: Source,
    sha256: str,
) -> Asset:
    """Build a rigid asset of one link from a draft that went through every stage.

    The origin goes to the centre of the footprint on the ground. Vertices are rounded to float32, which both formats
    carry exactly. Raises Rejected: nothing to be seen (MSH001) or touched (MSH004) is left at that precision.
    """
    assert draft.inertial is not None, "the mass stage ran"
    vertices = draft.surface.vertices
    lower, upper = vertices.min(axis=0), vertices.max(axis=0)
    shift = _float32(-np.array([(lower[0] + upper[0]) / 2, (lower[1] + upper[1]) / 2, lower[2]]))
    visuals, materials = _visuals(draft, shift, substance)
    colliders = tuple(
        Collider(name=f"object_collider_{i:03d}", shape=shape, pose=pose, substance=substance.id)
        for i, (shape, pose) in enumerate(_all_moved(draft.colliders, shift))
    )
    inertial = draft.inertial.replace(center_of_mass=_seven_digits(np.array(draft.inertial.center_of_mass) + shift))
    link = Link(name="object", inertial=inertial, visuals=visuals, colliders=colliders)
    # The box around all collision shapes, by which RoboCasa places objects.
    lower, upper = box_around(np.array([shape_bounds(c.shape, c.pose) for c in colliders]))
    middle, size = _seven_digits((lower + upper) / 2), _seven_digits(upper - lower)
    return Asset(
        id=asset_id,
        base=Base.FIXED if category.fixed else Base.FREE,
        links=(link,),
        sites=tuple(grasp_site(grasp, shift) for grasp in draft.grasps),
        regions=(Region(name="bbox", pose=Pose(position=middle), size=size),),
        materials=materials,
        substances=(substance,),
        labels=Labels(category=category.id, classes=classes, qcode=category.qcode, split=split_of(sha256)),
        provenance=source.provenance(sha256, draft.guesses),
    )


def _seven_digits(vector: Floats) -> Vec3:
    x, y, z = (seven_digits(float(v)) for v in vector)
    return x, y, z


def _visuals(draft: Draft, shift: Floats, substance: Substance) -> tuple[tuple[Visual, ...], tuple[Material, ...]]:
    visuals: list[Visual] = []
    materials: list[Material] = []
    for part in draft.parts:
        mesh = _in_float32(part.mesh if part.mesh.normals is not None else with_normals(part.mesh), shift)
        if not len(mesh.faces):
            continue
        name = f"look_{len(visuals):03d}"
        materials.append(part.material.replace(id=name, substance=substance.id))
        visuals.append(Visual(name=f"object_visual_{len(visuals):03d}", mesh=mesh, material=name))
    if not visuals:
        raise Rejected("MSH001", "no face is left once coordinates have the precision that the formats carry")
    return tuple(visuals), tuple(materials)


def _in_float32(mesh: Mesh, shift: Floats) -> Mesh:
    """The mesh moved and rounded to float32; faces that this collapses are left out."""
    vertices = _float32(mesh.vertices + shift)
    corners = vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    has_area = np.linalg.norm(cross, axis=1) > 0
    faces = mesh.faces[has_area]
    used, local = np.unique(faces, return_inverse=True)
    normals = None if mesh.normals is None else _float32(_unit(mesh.normals[used]))
    uv = None if mesh.uv is None else _float32(mesh.uv[used])
    out = Mesh(vertices=vertices[used], faces=local.reshape(-1, 3), uv=uv, normals=normals)
    return _with_center(out) if len(used) == 3 else out


def _with_center(mesh: Mesh) -> Mesh:
    """A single triangle cut into three at its centre, since MuJoCo refuses meshes of fewer than four vertices."""
    a, b, c = mesh.faces[0]
    normals = None if mesh.normals is None else np.vstack([mesh.normals, _unit(mesh.normals.sum(axis=0)[None])])
    return Mesh(
        vertices=_float32(np.vstack([mesh.vertices, mesh.vertices.mean(axis=0)])),
        faces=np.array([(a, b, 3), (b, c, 3), (c, a, 3)]),
        uv=None if mesh.uv is None else _float32(np.vstack([mesh.uv, mesh.uv.mean(axis=0)])),
        normals=None if normals is None else _float32(normals),
    )


def _float32(values: Floats) -> Floats:
    return np.asarray(values, dtype=np.float32).astype(np.float64)


def _unit(normals: Floats) -> Floats:
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.where(length > 1e-6, normals / np.maximum(length, 1e-30), np.array([0.0, 0.0, 1.0])))


def _all_moved(placed: tuple[PlacedShape, ...], shift: Floats) -> list[tuple[Shape, Pose]]:
    """The shapes, moved; hulls that rounding makes flat are left out."""
    moved = []
    for collider in placed:
        with suppress(DegenerateShape):
            moved.append(_moved(collider, shift))
    if not moved:
        raise Rejected("MSH004", "no collision shape has a volume once coordinates have the formats' precision")
    return moved


def _moved(placed: PlacedShape, shift: Floats) -> tuple[Shape, Pose]:
    shape, pose = placed.shape, placed.pose
    if isinstance(shape, Hull | MeshShape):
        points = _float32(pose.apply(shape.mesh.vertices) + shift)
        if isinstance(shape, Hull):
            points, faces = convex_hull(points)
            return Hull(mesh=Mesh(vertices=points, faces=faces)), Pose()
        return MeshShape(mesh=Mesh(vertices=points, faces=shape.mesh.faces)), Pose()
    quaternion = tuple(seven_digits(q) for q in pose.quaternion)
    pose = Pose(position=_seven_digits(np.array(pose.position) + shift), quaternion=quaternion)
    if isinstance(shape, Box):
        return Box(size=_seven_digits(np.array(shape.size))), pose
    return shape.replace(**{name: seven_digits(value) for name, value in shape if name != "kind"}), pose
