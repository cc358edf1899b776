"""Score a candidate frame by the moving parts that would be found if its two sides were the front and the top.

The fragments are measured once; for each candidate they are rotated by quarter turns, depth images included.
"""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.infer import articulate_fragments
from casa_assets.articulate.plan import Articulation, Frame, HingeEdge, PartKind, PartPlan
from casa_assets.articulate.segment.fragments import FRONT, SIDES, MeasuredFragments
from casa_assets.articulate.segment.orthographic import DepthImage
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.parts import JointKind

# Scores of a candidate; the sign of its weight in SCORE_WEIGHTS (frame/axes.py) tells whether a score speaks for it.
SCORE_NAMES = (
    "front_coverage",
    "doors",
    "drawers",
    "drawers_with_box",
    "drawers_without_box",
    "knobs",
    "buttons",
    "levers",
    "faucet_levers",
    "lids",
    "racks",
    "turntables",
    "front_confidence",
    "joint_confidence",
    "with_handle",
    "hinged_aside",
    "hinged_below",
    "hinged_above",
    "no_parts",
)
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
    frame = Frame(rotation=np.eye(3), origin=(0.0, 0.0, 0.0), scale=1.0)
    return score_articulation(articulate_fragments(seen, frame), seen)


def score_articulation(articulation: Articulation, measured: MeasuredFragments) -> Floats:
    """Return the (len(SCORE_NAMES),) scores of an articulation."""
    fronts = [p for p in articulation.parts if p.kind in (PartKind.DOOR, PartKind.DRAWER)]
    doors = [p for p in fronts if p.kind is PartKind.DOOR]
    trays = [p for p in articulation.parts if p.kind is PartKind.TRAY]
    hinged = max(len(doors), 1)
    coverage = _covered(fronts, measured)
    # The confidence in fronts says little where they cover only a small share of the side.
    coverage_weight = min(1.0, coverage / FULL_WEIGHT_COVERAGE)
    with_box = sum(p.kind is PartKind.DRAWER and _reaches(p, measured) for p in fronts)
    return np.array(
        [
            coverage,
            _log(len(doors)),
            _log(len(fronts) - len(doors)),
            _log(with_box),
            _log(len(fronts) - len(doors) - with_box),
            _log(sum(p.kind is PartKind.KNOB for p in articulation.parts)),
            _log(sum(p.kind is PartKind.BUTTON for p in articulation.parts)),
            _log(sum(p.kind is PartKind.LEVER for p in articulation.parts)),
            float(any(p.kind is PartKind.LEVER and p.joint.kind is JointKind.HINGE for p in articulation.parts)),
            _log(sum(p.kind is PartKind.LID for p in articulation.parts)),
            _log(sum(p.joint.kind is JointKind.SLIDE for p in trays)),
            _log(sum(p.joint.kind is JointKind.HINGE for p in trays)),
            coverage_weight * float(np.mean([p.confidence for p in fronts])) if fronts else 0.0,
            coverage_weight * float(np.mean([p.joint.confidence for p in fronts])) if fronts else 0.0,
            coverage_weight * sum(len(p.grip) > 0 for p in fronts) / max(len(fronts), 1),
            sum(p.joint.edge in (HingeEdge.LEFT, HingeEdge.RIGHT) for p in doors) / hinged,
            sum(p.joint.edge is HingeEdge.BOTTOM for p in doors) / hinged,
            sum(p.joint.edge is HingeEdge.TOP for p in doors) / hinged,
            float(not articulation.parts),
        ]
    )


def _log(count: int) -> float:
    """Return log(1 + count), with the count capped."""
    return float(np.log1p(min(count, MAX_COUNT)))


def _reaches(part: PartPlan, measured: MeasuredFragments) -> bool:
    """Return whether a drawer reaches far enough back to have a box."""
    deep = np.ptp(measured.mesh.points[measured.mesh.faces[part.faces], 1])
    return float(deep) > max(MIN_BOX_DEPTH_SHARE * float(np.ptp(measured.mesh.points[:, 1])), MIN_BOX_DEPTH)


def _covered(fronts: list[PartPlan], measured: MeasuredFragments) -> float:
    """Return the share of the image of the front that doors and drawers cover."""
    face = measured.depth_images[FRONT].face
    moves = np.zeros(len(measured.label) + 1, dtype=bool)
    for part in fronts:
        moves[part.faces] = True
    return float((moves[face] & (face >= 0)).sum() / max(int((face >= 0).sum()), 1))
