"""A model on its way to becoming an Asset: its parts, what was guessed, what was noticed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.topology import weld
from casa_assets.model.asset.asset import Guess, Inertial
from casa_assets.model.asset.parts import Grasp, Hull, Mesh, Shape
from casa_assets.model.issue import Issue, Severity
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record
from casa_assets.model.source import RawPart


class PlacedShape(Record):
    """A collision shape and where it sits (asset from shape), metres."""

    shape: Shape
    pose: Pose = Pose()


def placed_hull(points: Floats, faces: Ints) -> PlacedShape:
    """A hull, (P, 3) points and (F, 3) faces, in the asset frame."""
    return PlacedShape(shape=Hull(mesh=Mesh(vertices=points, faces=faces)))


@dataclass(frozen=True, eq=False)
class Surface:
    """The triangles of all parts in one set, over the parts' own vertices and over welded points; arrays are read-only.

    Attributes:
        vertices: (V, 3) of all parts, one part after another. faces: (F, 3) indices into `vertices`.
    """

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


class Draft(Record):
    """State between two stages. Each stage returns a new one.

    Attributes:
        parts: meshes with materials; file units and axes until `orient` and `scale` have run, then metres, z up.
        metres_per_unit, up, format: as read from the file, see RawModel.
        guesses: decisions so far. notes: warnings so far.
        colliders: from `collide` on.
        inertial: from `mass` on; asset frame.
        grasps: from `grasp` on.
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
