"""Choose grasps of an object: body, rim and handle, each with the gripper opening that it needs, and mark them."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from casa_assets.core.rounding import seven_digits
from casa_assets.core.typing import Floats, Ints
from casa_assets.geometry.mesh.antipodal_grasps import AntipodalGrasp, antipodal_grasps
from casa_assets.model.asset.grasp import Grasp, GraspFeature
from casa_assets.model.asset.site import Site
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Category, FrontRule, MatterFill

# All numbers below are choices.
# Largest thickness of a rim, and largest distance from the top, metres.
RIM_THICKNESS_M, RIM_DEPTH_M = 0.015, 0.035
# A rim is grasped from above: smallest cosine between the approach and straight down, and largest sine between the
# closing direction and the horizontal.
MIN_DOWNWARD_COSINE = 0.7
MAX_CLOSING_SINE = 0.5
# Largest thickness of a handle, metres.
HANDLE_THICKNESS_M = 0.05
# Horizontal distance from the centre of mass, as a share of the longer horizontal side, up to which a grasp is of the
# body, and from which on a thin grasp of a vessel is of its handle.
BODY_REACH_SHARE = 0.25
HANDLE_DISTANCE_SHARE = 0.45
# Smallest width of a grasp of the body of a vessel, as a share of its shorter horizontal side.
MIN_BODY_WIDTH_SHARE = 0.5
# Side of the finger pads that a grasp is shown with, metres; a choice.
PAD_M = 0.02


def choose_grasps(
    points: Floats, faces: Ints, center_of_mass: Vec3, category: Category, opening_m: float
) -> tuple[Grasp, ...]:
    """The best grasp of each kind that is possible.

    Args:
        points: (P, 3) metres, z up, of the object as it rests. faces: (F, 3) of its welded surface, facing outwards.
        center_of_mass: metres, the same frame.
        category: vessels have a rim; some categories have a handle; what is fixed is not grasped.
        opening_m: largest opening of the gripper.
    """
    if category.fixed:
        return ()
    center = np.array(center_of_mass)
    sides, top = np.ptp(points, axis=0), float(points[:, 2].max())
    best: dict[GraspFeature, tuple[float, AntipodalGrasp]] = {}
    for candidate in antipodal_grasps(points, faces, opening_m):
        offset = (candidate.center - center)[:2] / float(sides[:2].max())
        aside = float(np.linalg.norm(offset))
        feature = _feature_of(candidate, aside, top, category)
        is_too_narrow = (
            feature is GraspFeature.BODY
            and category.build is MatterFill.VESSEL
            and candidate.width < MIN_BODY_WIDTH_SHARE * sides[:2].min()
        )
        if feature is None or is_too_narrow:
            continue
        score = _score(candidate, feature, offset)
        if feature not in best or score > best[feature][0]:
            best[feature] = (score, candidate)
    if category.front is not FrontRule.HANDLE and len(best) > 1:
        best.pop(GraspFeature.HANDLE, None)
    return tuple(_record(feature, best[feature][1]) for feature in GraspFeature if feature in best)


def grasp_site(grasp: Grasp, shift: Floats) -> Site:
    """A box site `grasp_<feature>`: x along the closing direction, as long as the opening, z along the approach.

    Args:
        shift: (3,) what is added to the centre, metres.
    """
    closing, approach = np.array(grasp.closing), np.array(grasp.approach)
    rotation = Rotation.from_matrix(np.stack([closing, np.cross(approach, closing), approach], axis=1))
    x, y, z, w = (seven_digits(float(v)) for v in rotation.as_quat(canonical=True))
    px, py, pz = (seven_digits(float(v)) for v in np.array(grasp.center) + shift)
    pose = Pose(position=(px, py, pz), quaternion=(w, x, y, z))
    size = (seven_digits(grasp.width), PAD_M, PAD_M)
    return Site(name=f"grasp_{grasp.feature.value}", pose=pose, kind="box", size=size)


def _feature_of(candidate: AntipodalGrasp, aside: float, top: float, category: Category) -> GraspFeature | None:
    """Part that a grasp holds; None for the wall of a vessel below its rim.

    Args:
        aside: horizontal distance from the centre of mass over the longer side. top: height of the mesh, metres.
    """
    if category.build is MatterFill.VESSEL and candidate.width <= RIM_THICKNESS_M:
        is_at_top = candidate.center[2] >= top - RIM_DEPTH_M and -candidate.approach[2] >= MIN_DOWNWARD_COSINE
        if (
            is_at_top
            and abs(candidate.closing[2]) < MAX_CLOSING_SINE
            and (category.front is not FrontRule.HANDLE or aside < HANDLE_DISTANCE_SHARE)
        ):
            return GraspFeature.RIM
        return GraspFeature.HANDLE if category.front is FrontRule.HANDLE and aside >= HANDLE_DISTANCE_SHARE else None
    if aside <= BODY_REACH_SHARE:
        return GraspFeature.BODY
    return GraspFeature.HANDLE if candidate.width <= HANDLE_THICKNESS_M else None


def _score(candidate: AntipodalGrasp, feature: GraspFeature, offset: Floats) -> float:
    """Score of a grasp: from above; a body near its centre, a rim at its highest, a handle far out towards +x."""
    steep, aside = -float(candidate.approach[2]), float(np.linalg.norm(offset))
    if feature is GraspFeature.BODY:
        return 0.5 * steep - 2 * aside
    return 0.5 * steep + (
        aside + float(offset[0]) if feature is GraspFeature.HANDLE else 10 * float(candidate.center[2])
    )


def _record(feature: GraspFeature, candidate: AntipodalGrasp) -> Grasp:
    return Grasp(
        feature=feature,
        center=_rounded(candidate.center),
        closing=_rounded(candidate.closing),
        approach=_rounded(candidate.approach),
        width=round(candidate.width, 5),
    )


def _rounded(vector: Floats) -> tuple[float, float, float]:
    """Six decimals: samples are no more precise, and machines agree on them."""
    x, y, z = (round(float(v), 6) for v in vector)
    return (x, y, z)
