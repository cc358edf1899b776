"""Score a candidate frame by the moving parts that would be found if its two sides were the front and the top.

The fragments are measured once; for each candidate they are rotated by quarter turns, depth images included.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from casa_assets.articulate.infer import articulate_fragments
from casa_assets.articulate.plan import Frame, HingeEdge, PartKind
from casa_assets.articulate.segment.fragments import FRONT, SIDES, MeasuredFragments
from casa_assets.articulate.segment.orthographic import DepthImage
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.parts import JointKind

# Scores of a candidate by the parts that it would have, and their weights in its log odds. Ref: as WEIGHTS in axes.py.
SCORE_WEIGHTS: Mapping[str, float] = {
    "front_coverage": 1.071,
    "doors": 0.0,
    "drawers": 0.2748,
    "drawers_with_box": 1.119,
    # Cancels `drawers` for drawer fronts without a box. Set by hand.
    "drawers_without_box": -0.2748,
    "knobs": 0.2237,
    "buttons": 0.127,
    "levers": 0.283,
    # A faucet is found only where its spout reaches to the front, over its mount. Set by hand.
    "faucet_levers": 3.0,
    "lids": 1.247,
    "racks": 2.274,
    "turntables": 1.5,
    "front_confidence": 1.565,
    "joint_confidence": 0.7721,
    "with_handle": 0.9607,
    "hinged_aside": -0.11,
    "hinged_below": -0.7205,
    "hinged_above": -1.274,
    "no_parts": -0.4505,
}
SCORE_NAMES = tuple(SCORE_WEIGHTS)
# Counts of parts are capped at this.
MAX_COUNT = 8
# A drawer that reaches back farther than this share of the depth, and than this in diagonals, has a box.
MIN_BOX_DEPTH_SHARE, MIN_BOX_DEPTH = 0.3, 0.1
# Fronts that cover less than this share of the side count in proportion.
FULL_WEIGHT_COVERAGE = 0.25


def candidate_axes(front: int, top: int) -> Floats:
    """Return the (3, 3) rows right, back and up of the candidate, in the axes of the fragments."""
    back, up = SIDES[front][2], -SIDES[top][2]
    return np.stack([np.cross(back, up), back, up])


def rotate_fragments(measured: MeasuredFragments, front: int, top: int) -> MeasuredFragments:
    """Return the fragments in the frame of a candidate: one of their sides the front, another the top."""
    rotation = candidate_axes(front, top)
    a, b = measured.lower @ rotation.T, measured.upper @ rotation.T
    found = [_side(measured, rotation, k) for k in range(len(SIDES))]
    return MeasuredFragments(
        mesh=measured.mesh.transformed(rotation, np.zeros(3), 1.0),
        label=measured.label,
        lower=np.minimum(a, b),
        upper=np.maximum(a, b),
        area=measured.area,
        visible_area=measured.visible_area[:, [old for old, _ in found]],
        depth_images=tuple(image for _, image in found),
    )


def _side(measured: MeasuredFragments, rotation: Floats, side: int) -> tuple[int, DepthImage]:
    """Return the side that becomes this one, and its rotated depth image."""
    right, up, into = SIDES[side] @ rotation
    old = int(np.argmax(SIDES[:, 2] @ into))
    image, axes = measured.depth_images[old], SIDES[old]
    # Rows run down: a step to the next row is a step against `up`.
    face, depth, lower = image.face, image.depth, image.lower
    height, width = face.shape
    upper = lower + image.pixel * np.array([width, height])
    if abs(float(right @ axes[0])) < 0.5:
        face, depth = face.T[::-1, ::-1], depth.T[::-1, ::-1]
        lower, upper, axes = lower[::-1], upper[::-1], axes[[1, 0, 2]]
    corner = lower.copy()
    if float(right @ axes[0]) < 0:
        face, depth, corner[0] = face[:, ::-1], depth[:, ::-1], -upper[0]
    if float(up @ axes[1]) < 0:
        face, depth, corner[1] = face[::-1], depth[::-1], -upper[1]
    return old, DepthImage(np.ascontiguousarray(face), np.ascontiguousarray(depth), corner, image.pixel)


def score_candidate(measured: MeasuredFragments, front: int, top: int) -> Floats:
    """Return the (len(SCORE_NAMES),) scores of what would be found in the frame of a candidate."""
    seen = rotate_fragments(measured, front, top)
    parts = articulate_fragments(seen, Frame(rotation=np.eye(3), origin=(0.0, 0.0, 0.0), scale=1.0)).parts
    fronts = [p for p in parts if p.kind in (PartKind.DOOR, PartKind.DRAWER)]
    doors = [p for p in fronts if p.kind is PartKind.DOOR]
    trays = [p for p in parts if p.kind is PartKind.TRAY]
    hinged = max(len(doors), 1)
    face = seen.depth_images[FRONT].face
    moves = np.zeros(len(seen.label) + 1, dtype=bool)
    for part in fronts:
        moves[part.faces] = True
    coverage = float((moves[face] & (face >= 0)).sum() / max(int((face >= 0).sum()), 1))
    # The confidence in fronts says little where they cover only a small share of the side.
    coverage_weight = min(1.0, coverage / FULL_WEIGHT_COVERAGE)
    points, faces = seen.mesh.points[:, 1], seen.mesh.faces
    deep = max(MIN_BOX_DEPTH_SHARE * float(np.ptp(points)), MIN_BOX_DEPTH)
    with_box = sum(p.kind is PartKind.DRAWER and float(np.ptp(points[faces[p.faces]])) > deep for p in fronts)

    def log_count(kind: PartKind) -> float:
        return _log(sum(p.kind is kind for p in parts))

    return np.array(
        [
            coverage,
            _log(len(doors)),
            _log(len(fronts) - len(doors)),
            _log(with_box),
            _log(len(fronts) - len(doors) - with_box),
            log_count(PartKind.KNOB),
            log_count(PartKind.BUTTON),
            log_count(PartKind.LEVER),
            float(any(p.kind is PartKind.LEVER and p.joint.kind is JointKind.HINGE for p in parts)),
            log_count(PartKind.LID),
            _log(sum(p.joint.kind is JointKind.SLIDE for p in trays)),
            _log(sum(p.joint.kind is JointKind.HINGE for p in trays)),
            coverage_weight * float(np.mean([p.confidence for p in fronts])) if fronts else 0.0,
            coverage_weight * float(np.mean([p.joint.confidence for p in fronts])) if fronts else 0.0,
            coverage_weight * sum(len(p.grip) > 0 for p in fronts) / max(len(fronts), 1),
            sum(p.joint.edge in (HingeEdge.LEFT, HingeEdge.RIGHT) for p in doors) / hinged,
            sum(p.joint.edge is HingeEdge.BOTTOM for p in doors) / hinged,
            sum(p.joint.edge is HingeEdge.TOP for p in doors) / hinged,
            float(not parts),
        ]
    )


def _log(count: int) -> float:
    return float(np.log1p(min(count, MAX_COUNT)))
