"""Limit the joints of an articulated asset to the range in which its parts move freely; all in memory."""

from __future__ import annotations

import math
from collections.abc import Mapping

from casa_assets.articulate.decisions import hinge_at_face
from casa_assets.articulate.plan import JointPlan
from casa_assets.checks.motion.joint_travel import JointTravel, joint_travels
from casa_assets.errors import Rejected
from casa_assets.export import mjcf
from casa_assets.model.asset.joint import JointKind
from casa_assets.pipeline.articulate.build import ArticulateResult

# A part that moves through less than this share of its range before it meets something has a wrong joint, or shapes
# that are too coarse to tell: its range stays.
MIN_FREE_TRAVEL = 0.25
# A hinge is moved to the face of its door where that frees so much more of the range.
MIN_TRAVEL_GAIN = 0.05


def limit_ranges(built: ArticulateResult) -> ArticulateResult:
    """Return the asset with each joint limited to the range before its part meets something.

    A door that is stuck in its frame first gets its axis at its face, where that frees it.
    """
    travel = _free_travel(built)
    stuck = {
        part.name: hinge_at_face(part, built.placed)
        for part in built.articulation.parts
        if travel[part.name].free_share < MIN_FREE_TRAVEL and part.joint.edge
    }
    if stuck:
        moved = built.with_joints(stuck)
        freed = _free_travel(moved)
        helped = {n: j for n, j in stuck.items() if freed[n].free_share > travel[n].free_share + MIN_TRAVEL_GAIN}
        if len(helped) == len(stuck):
            built, travel = moved, freed
        elif helped:
            built = built.with_joints(helped)
            travel = _free_travel(built)
    limited, is_behind = _limited(built, travel)
    # What lies behind a door that now opens less far has less room than was measured.
    return _limited(limited, _free_travel(limited))[0] if is_behind else limited


def _limited(built: ArticulateResult, travel: Mapping[str, JointTravel]) -> tuple[ArticulateResult, bool]:
    """Return the asset with joints limited to the range that is free, and whether something lies behind one of them."""
    metres = built.articulation.frame.metres or 1.0
    limited = {}
    for part in built.articulation.parts:
        free, joint = travel[part.name].free_share, part.joint
        if MIN_FREE_TRAVEL <= free < 1.0 and not joint.endless:
            end = _round_down(joint.range[1] * free, joint, metres)
            reason = f"{joint.reason}; then it runs into {travel[part.name].blocked_by}"
            limited[part.name] = joint.replace(range=(0.0, end), reason=reason)
    names = {joint.name for joint in built.asset.joints if joint.child in limited}
    return built.with_joints(limited), any(joint.behind in names for joint in built.asset.joints)


def _free_travel(built: ArticulateResult) -> Mapping[str, JointTravel]:
    """Return how far each part moves before it meets something, by its name.

    Raises:
        Rejected: MuJoCo cannot read the model (MJC001).
    """
    try:
        found = joint_travels(built.asset, mjcf.write(built.asset), pushed=False)
    except ValueError as error:
        raise Rejected("MJC001", f"MuJoCo cannot read the model: {error}") from error
    return {j.child: t for j, t in zip(built.asset.joints, found, strict=True)}


def _round_down(end: float, joint: JointPlan, metres: float) -> float:
    """Round the end of a range down to what decisions.yaml can express: tenths of a degree, or of a millimetre.

    Args:
        end: rad or diagonals. metres: length of the diagonal.
    """
    if joint.kind is JointKind.HINGE:
        return math.radians(math.floor(math.degrees(end) * 10) / 10)
    return math.floor(end * metres * 1e4) / 1e4 / metres
