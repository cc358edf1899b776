"""Measure a plan of moving parts as a whole: numbers from which a forest tells whether it is right."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.frame.kind import kind_by_parts
from casa_assets.articulate.frame.score_candidate import SCORE_NAMES, score_articulation
from casa_assets.articulate.plan import Articulation, PartKind
from casa_assets.articulate.segment.fragment_measures import FRONT, SIDES, MeasuredFragments
from casa_assets.articulate.segment.segmentations import Segmentation
from casa_assets.core.typing import Floats

PLAN_FEATURES = (
    *SCORE_NAMES,
    *(f"split by {way.value}" for way in Segmentation),
    "cut out of a shell",
    "fragments, log",
    "fragments seen from the front, log",
    "share of the front that moves",
    "share of the front in its largest resting fragment",
    "share of the front in other resting fragments",
    "largest resting front rectangle",
    "parts, log",
    "least confidence of a part",
    "mean confidence of the parts",
    "least confidence of a joint",
    "overlap of fronts",
    "fronts that have an equal",
    "edges of fronts in line",
    "pieces of each front",
    "keys and knobs that are one of a kind",
    "spread of sizes of knobs",
    "spread of sizes of keys",
    "likeliest kind",
    "confidence of the frame",
)
# Edges of fronts that differ by less are in line, diagonals; sizes of fronts that differ by less are equal.
LINE_TOLERANCE, SIZE_TOLERANCE = 0.01, 0.02
_FRONTS = (PartKind.DOOR, PartKind.DRAWER)
_CONTROLS = (PartKind.KNOB, PartKind.BUTTON)


def plan_features(
    articulation: Articulation, measured: MeasuredFragments, way: Segmentation, from_shell: bool
) -> Floats:
    """Return the (len(PLAN_FEATURES),) numbers of a plan.

    Args:
        measured: the fragments that it is made of. way: in which the mesh was split. from_shell: parts were cut out.
    """
    parts = articulation.parts
    boxes = {p.name: _corners(measured, p.faces) for p in parts}
    fronts = [boxes[p.name] for p in parts if p.kind in _FRONTS]
    confidence = [p.confidence for p in parts] or [0.0]
    moving, largest, others, rectangle = _front_shares(articulation, measured)
    x, y, z = (float(v) for v in np.ptp(measured.mesh.points, axis=0))
    seen = measured.visible_area[:, FRONT] > 0
    return np.array(
        [
            *score_articulation(articulation, measured),
            *(float(way is w) for w in Segmentation),
            float(from_shell),
            np.log1p(measured.count),
            np.log1p(float(seen.sum())),
            moving,
            largest,
            others,
            rectangle,
            np.log1p(len(parts)),
            min(confidence),
            float(np.mean(confidence)),
            min((p.joint.confidence for p in parts), default=0.0),
            _overlap(fronts),
            _share_with_equal(fronts),
            _share_in_line(fronts),
            _pieces_of_fronts(articulation, measured),
            _share_alone(articulation),
            *(_spread([boxes[p.name] for p in parts if p.kind is kind]) for kind in _CONTROLS),
            kind_by_parts((x, y, z), articulation)[1],
            articulation.frame.confidence,
        ],
        dtype=np.float64,
    )


def _corners(measured: MeasuredFragments, faces: np.ndarray[tuple[int], np.dtype[np.int64]]) -> Floats:
    """Return the (2, 3) lower and upper corner of some faces as right, up and depth."""
    flat = measured.mesh.points[measured.mesh.faces[faces].reshape(-1)] @ SIDES[FRONT].T
    return np.stack([flat.min(axis=0), flat.max(axis=0)]) if len(flat) else np.zeros((2, 3))


def _front_shares(articulation: Articulation, measured: MeasuredFragments) -> tuple[float, float, float, float]:
    """Return shares of the picture of the front: what moves, the largest resting fragment, and all other fragments.

    The last number is the largest share that the rectangle of one of those others has.
    """
    face = measured.depth_images[FRONT].face
    seen = face[face >= 0]
    if not len(seen):
        return 0.0, 0.0, 0.0, 0.0
    moves = articulation.face_owner(len(measured.label)) >= 0
    label = measured.label[seen]
    resting = ~moves[seen] & (label >= 0)
    pixels = np.bincount(label[resting], minlength=max(measured.count, 1))
    size = (measured.upper - measured.lower)[:, [0, 2]]
    whole = np.ptp(measured.mesh.points, axis=0)
    rectangles = size[:, 0] * size[:, 1] / max(float(whole[0] * whole[2]), 1e-12) if measured.count else np.zeros(1)
    largest = int(np.argmax(pixels))
    shown = (pixels >= 0.5 * rectangles * len(seen)) & (pixels > 0)
    shown[largest] = False
    total = float(len(seen))
    rest = float(pixels.sum() - pixels[largest]) / total
    biggest = float(rectangles[shown].max()) if shown.any() else 0.0
    return float(moves[seen].sum()) / total, float(pixels[largest]) / total, rest, biggest


def _overlap(fronts: list[Floats]) -> float:
    """Return the share of the area of fronts that lies in front of another one."""
    total = sum(float(np.prod(b[1, :2] - b[0, :2])) for b in fronts)
    shared = 0.0
    for i, a in enumerate(fronts):
        for b in fronts[:i]:
            both = np.minimum(a[1, :2], b[1, :2]) - np.maximum(a[0, :2], b[0, :2])
            shared += float(np.prod(np.maximum(both, 0.0)))
    return shared / max(total, 1e-12)


def _share_with_equal(fronts: list[Floats]) -> float:
    """Return the share of fronts that have the size of another one."""
    sizes = [b[1, :2] - b[0, :2] for b in fronts]
    alike = [
        any(i != k and float(np.abs(a - b).max()) < SIZE_TOLERANCE for k, b in enumerate(sizes))
        for i, a in enumerate(sizes)
    ]
    return sum(alike) / max(len(alike), 1)


def _share_in_line(fronts: list[Floats]) -> float:
    """Return the share of edges of fronts that are in line with an edge of another front."""
    edges = [(i, k, float(b[e, k])) for i, b in enumerate(fronts) for k in (0, 1) for e in (0, 1)]
    lined = [any(i != j and k == m and abs(at - other) < LINE_TOLERANCE for j, m, other in edges) for i, k, at in edges]
    return sum(lined) / max(len(lined), 1)


def _pieces_of_fronts(articulation: Articulation, measured: MeasuredFragments) -> float:
    """Return the mean number of fragments of a front, as a logarithm."""
    counts = [len(np.unique(measured.label[p.faces])) for p in articulation.parts if p.kind in _FRONTS]
    return float(np.log1p(np.mean(counts))) if counts else 0.0


def _share_alone(articulation: Articulation) -> float:
    """Return the share of knobs and keys that are the only one of their type."""
    kinds = [p.kind for p in articulation.parts if p.kind in _CONTROLS]
    return sum(kinds.count(k) == 1 for k in kinds) / max(len(kinds), 1)


def _spread(boxes: list[Floats]) -> float:
    """Return the spread of sizes of boxes relative to their mean; 0 for fewer than two."""
    sizes = np.array([float((b[1, :2] - b[0, :2]).max()) for b in boxes])
    return float(sizes.std()) / max(float(sizes.mean()), 1e-9) if len(sizes) > 1 else 0.0
