"""Choose grasps of an ingested thing: body, rim and handle, each with the opening of the gripper that it needs."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.geometry.mesh.antipodal_grasps import AntipodalGrasp, antipodal_grasps
from casa_assets.ingest.draft import Draft
from casa_assets.model.asset.grasp import Grasp, GraspFeature
from casa_assets.model.registry.category import Category, FrontRule, MatterFill

# A rim is no thicker than this and this near to the top, metres, and is taken from within so many degrees of above.
RIM_THICK, RIM_DEEP = 0.015, 0.035
FROM_ABOVE = 0.7
# What fingers close on is a wall where they close no steeper than this.
LEVEL_SINE = 0.5
# A handle is no thicker than this, metres.
HANDLE_THICK = 0.05
# What is this near to the centre of mass, as a part of the longest level side, is the body.
BODY_REACH_SHARE = 0.25
# What is thin and this far from the centre of mass of a vessel with a handle is its handle.
HANDLE_DISTANCE_SHARE = 0.45
# Fingers on the body of a vessel reach over this part of its lesser level side at least.
MIN_BODY_WIDTH_SHARE = 0.5


def grasp(draft: Draft, category: Category, opening: float) -> Draft:
    """The best grasp of each kind that there is.

    Args:
        draft: metres, z up, as it rests, with its mass.
        category: vessels have a rim; some categories have a handle.
        opening: how far the gripper opens, metres.
    """
    assert draft.inertial is not None, "the mass stage ran"
    if category.fixed:
        return draft.replace(grasps=())
    points = draft.surface.points
    center = np.array(draft.inertial.center_of_mass)
    sides, top = np.ptp(points, axis=0), float(points[:, 2].max())
    best: dict[GraspFeature, tuple[float, AntipodalGrasp]] = {}
    for pinch in antipodal_grasps(points, draft.surface.welded_faces, opening):
        off = (pinch.center - center)[:2] / float(sides[:2].max())
        aside = float(np.linalg.norm(off))
        hold = _hold(pinch, aside, top, category)
        is_part = (
            hold is GraspFeature.BODY
            and category.build is MatterFill.VESSEL
            and pinch.width < MIN_BODY_WIDTH_SHARE * sides[:2].min()
        )
        if hold is None or is_part:
            continue
        score = _score(pinch, hold, off)
        if hold not in best or score > best[hold][0]:
            best[hold] = (score, pinch)
    if category.front is not FrontRule.HANDLE and len(best) > 1:
        best.pop(GraspFeature.HANDLE, None)
    return draft.replace(grasps=tuple(_record(hold, best[hold][1]) for hold in GraspFeature if hold in best))


def _hold(pinch: AntipodalGrasp, aside: float, top: float, category: Category) -> GraspFeature | None:
    """Part that a grasp holds (body, rim or handle); None for the wall of a vessel elsewhere than at its rim."""
    if category.build is MatterFill.VESSEL and pinch.width <= RIM_THICK:
        is_at_top = pinch.center[2] >= top - RIM_DEEP and -pinch.approach[2] >= FROM_ABOVE
        if (
            is_at_top
            and abs(pinch.closing[2]) < LEVEL_SINE
            and (category.front is not FrontRule.HANDLE or aside < HANDLE_DISTANCE_SHARE)
        ):
            return GraspFeature.RIM
        return GraspFeature.HANDLE if category.front is FrontRule.HANDLE and aside >= HANDLE_DISTANCE_SHARE else None
    if aside <= BODY_REACH_SHARE:
        return GraspFeature.BODY
    return GraspFeature.HANDLE if pinch.width <= HANDLE_THICK else None


def _score(pinch: AntipodalGrasp, hold: GraspFeature, off: Floats) -> float:
    """Higher is better: from above; a body near its middle, a rim at its highest, a handle far out and to the right."""
    steep, aside = -float(pinch.approach[2]), float(np.linalg.norm(off))
    if hold is GraspFeature.BODY:
        return 0.5 * steep - 2 * aside
    return 0.5 * steep + (aside + float(off[0]) if hold is GraspFeature.HANDLE else 10 * float(pinch.center[2]))


def _record(hold: GraspFeature, pinch: AntipodalGrasp) -> Grasp:
    return Grasp(
        feature=hold,
        center=_rounded(pinch.center),
        closing=_rounded(pinch.closing),
        approach=_rounded(pinch.approach),
        width=round(pinch.width, 5),
    )


def _rounded(vector: Floats) -> tuple[float, float, float]:
    """Six digits after the point: samples say no more, and two machines agree on them."""
    x, y, z = (round(float(v), 6) for v in vector)
    return (x, y, z)
