"""A model on its way to becoming an Asset: its parts, what was guessed, what was noticed."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field

from casa_assets.model.asset.asset import Inertial
from casa_assets.model.asset.grasp import Grasp
from casa_assets.model.asset.provenance import Guess
from casa_assets.model.asset.shape import Shape
from casa_assets.model.ingest.source import RawPart
from casa_assets.model.issue import Issue, Severity
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record


class PlacedShape(Record):
    """A collision shape and where it sits (asset from shape), metres."""

    shape: Shape
    pose: Pose = Pose()


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

    def guessed(self, subject: str, value: str, confidence: float, reason: str) -> tuple[Guess, ...]:
        """The guesses and one more; confidence is kept to two digits."""
        guess = Guess(subject=subject, value=value, confidence=round(float(confidence), 2), reason=reason)
        return (*self.guesses, guess)

    def noted(self, *notes: Issue) -> tuple[Issue, ...]:
        """The notes and some more, each once."""
        return (*self.notes, *(n for n in notes if n not in self.notes))

    def soup(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
        """All parts as one set of triangles: (V, 3) vertices and (F, 3) faces."""
        vertices = np.concatenate([p.mesh.vertices for p in self.parts])
        starts = np.cumsum([0] + [len(p.mesh.vertices) for p in self.parts[:-1]])
        faces = np.concatenate([p.mesh.faces.astype(np.int64) + s for p, s in zip(self.parts, starts, strict=True)])
        return vertices, faces


def warning(code: str, pointer: str, message: str) -> Issue:
    """An issue that is kept with the asset but does not keep it out."""
    return Issue(code=code, severity=Severity.WARNING, pointer=pointer, message=message)
