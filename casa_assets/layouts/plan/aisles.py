"""Measure the aisles of a kitchen: their narrowest width, and whether people work there or only pass."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

import numpy as np

from casa_assets.mesh.outline import contains_point
from casa_assets.model.kitchen.floor import Aisle, AisleKind, Corners, PlacedRun, RoomWall, RunEnd
from casa_assets.model.record import Vec2

RAY_SPACING_M = 0.05  # between the rays that are cast from a face
MIN_WIDTH_M = 0.02  # nearer faces touch
PASSAGE_BEYOND_M = 0.3  # how far beyond its ends a strip has to be free, to count as a passage


class FaceKind(StrEnum):
    """Side of a run that a face belongs to."""

    FRONT = "front"
    BACK = "back"
    END = "end"
    WALL = "wall"


@dataclass(frozen=True)
class RunFace:
    """An upright face, seen from above: from `start` to `end`, free space to the right of that way."""

    kind: FaceKind
    owner: str
    start: Vec2
    end: Vec2

    @property
    def direction(self) -> np.ndarray:
        """Unit vector from its start to its end."""
        d = np.subtract(self.end, self.start)
        length = float(np.linalg.norm(d))
        return np.asarray(d / length if length else d)

    @property
    def normal(self) -> np.ndarray:
        """Unit vector into the room."""
        x, y = self.direction
        return np.array([y, -x])


def find_aisles(
    runs: Sequence[PlacedRun],
    walls: Sequence[RoomWall],
    outline: Corners,
    columns: Mapping[str, Corners] = MappingProxyType({}),
) -> tuple[Aisle, ...]:
    """Narrowest place between each two faces that look at each other; columns: clockwise from above, metres."""
    faces = [f for run in runs for f in _faces(run)]
    faces += [RunFace(FaceKind.WALL, w.id, w.start, w.end) for w in walls if not w.is_open]
    for name, corners in columns.items():
        # A face has free space to the right of its way.
        faces += [RunFace(FaceKind.WALL, name, a, b) for a, b in zip((*corners[1:], corners[0]), corners, strict=True)]
    # Each run and its bounds: left, right, front.
    bodies = [(run, *run.span, max((u.front for u in run.units), default=run.depth_before)) for run in runs]
    narrowest: dict[tuple[str, str, str], Aisle] = {}
    for face in faces:
        if face.kind is FaceKind.WALL:
            continue
        for aisle in _aisles_before(face, faces, bodies, outline):
            first, second = sorted((aisle.first, aisle.second))
            key = (aisle.kind.value, first, second)
            if key not in narrowest or aisle.width < narrowest[key].width:
                narrowest[key] = aisle.replace(first=first, second=second)
    return tuple(narrowest[key] for key in sorted(narrowest))


def _faces(run: PlacedRun) -> Iterator[RunFace]:
    """Sides of a run: fronts of its units, its back if it is away from walls, and its free ends."""
    for unit in run.units:
        if unit.kind != "gap":
            yield RunFace(FaceKind.FRONT, run.id, run.at(unit.left, unit.front), run.at(unit.right, unit.front))
    if not run.units:
        return
    first, last = run.units[0].left, run.units[-1].right
    if not run.at_wall:
        yield RunFace(FaceKind.BACK, run.id, run.at(last, -run.depth_behind), run.at(first, -run.depth_behind))
    if run.left_end is RunEnd.FREE:
        yield RunFace(FaceKind.END, run.id, run.at(first, -run.depth_behind), run.at(first, run.units[0].front))
    if run.right_end is RunEnd.FREE:
        yield RunFace(FaceKind.END, run.id, run.at(last, run.units[-1].front), run.at(last, -run.depth_behind))


def _aisles_before(
    face: RunFace, faces: Sequence[RunFace], bodies: Sequence[tuple[PlacedRun, float, float, float]], outline: Corners
) -> Iterator[Aisle]:
    """Aisles that rays from a face find: the first other face that they meet."""
    length = float(np.linalg.norm(np.subtract(face.end, face.start)))
    facing = [f for f in faces if float(f.normal @ face.normal) < -0.9 and f is not face]
    found: dict[int, list[tuple[float, float]]] = {}
    half = RAY_SPACING_M / 2
    for u in np.linspace(half, max(length - half, half), max(2, int(length / RAY_SPACING_M))):
        start = np.array(face.start) + u * face.direction
        nearest: tuple[float, int] | None = None
        for k, other in enumerate(facing):
            far = float((np.array(other.start) - start) @ face.normal)
            side = float((start + far * face.normal - np.array(other.start)) @ other.direction)
            size = float(np.linalg.norm(np.subtract(other.end, other.start)))
            if far > MIN_WIDTH_M and 0.0 <= side <= size and (nearest is None or far < nearest[0]):
                nearest = (far, k)
        if nearest is not None:
            found.setdefault(nearest[1], []).append((float(u), nearest[0]))
    for k, hits in found.items():
        other = facing[k]
        if other.owner == face.owner:
            continue
        width = min(d for _, d in hits)
        at = np.array(face.start) + np.mean([u for u, _ in hits]) * face.direction + width / 2 * face.normal
        both = {face.kind, other.kind}
        if both == {FaceKind.FRONT}:
            kind = AisleKind.WORK
        elif FaceKind.FRONT in both or _is_passage(face, hits, width, bodies, outline):
            kind = AisleKind.WALK
        else:
            continue
        middle = (round(float(at[0]), 4), round(float(at[1]), 4))
        yield Aisle(kind=kind, first=face.owner, second=other.owner, width=round(width, 4), position=middle)


def _is_passage(
    face: RunFace,
    hits: Sequence[tuple[float, float]],
    width: float,
    bodies: Sequence[tuple[PlacedRun, float, float, float]],
    outline: Corners,
) -> bool:
    """True if the strip before a face goes on at both ends."""
    for u in (hits[0][0] - PASSAGE_BEYOND_M, hits[-1][0] + PASSAGE_BEYOND_M):
        x, y = np.array(face.start) + u * face.direction + width / 2 * face.normal
        if not contains_point(outline, (float(x), float(y))):
            return False
        for run, left, right, front in bodies:
            along, before = run.to_local((float(x), float(y)))
            if left < along < right and -run.depth_behind < before < front:
                return False
    return True
