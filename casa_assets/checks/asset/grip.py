"""Find grips that do not fit a gripper, joints off the axes, and inertia unlike that of the shapes."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.asset.built import NO_COLLIDERS, NO_JOINTS, NOT_BUILT, is_fixture_like
from casa_assets.checks.check import Measurement, largest, not_applicable
from casa_assets.checks.motion.motion_model import carried
from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.bounds import link_bounds, shape_bounds
from casa_assets.geometry.solid.coverage import distances_outside_hulls, surface_samples
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.model.asset.asset import Asset, Collider, Joint, Link
from casa_assets.model.asset.shape import Hull, MeshShape
from casa_assets.model.pose import Pose

# What a hand may take. A rim or a tray is held where a thing has no handle of its own.
HELD = frozenset(
    {"handle", "knob", "button", "lever", "key", "lid", "rim", "pull", "spout", "roll", "tray", "rack", "seat"}
)
# What fingers close on: one side of it at least is no thinner than this. Our choice: finger pads of rubber give by a
# millimetre or two, and slip off an edge that is thinner than both of them.
GRASPED = frozenset({"handle", "pull"})
THIN_HANDLE_M = 0.005
# What is pushed round or along and need not fit between two fingers.
PUSHED = frozenset({"roll", "seat", "lid", "rack", "tray"})
THINNEST_M = 0.0015
# Points of a grip's surface that are looked at, the share of them that has to lie free, and how far from other parts.
SAMPLES = 64
FREE_SHARE = 0.1
FREE_M = 2e-4
# How far a centre of mass may lie outside the hull of its link's shapes: what thin walls that are not touched weigh.
OFF_HULL_M = 0.001


def _spread(count: int) -> Floats:
    """(count, 3) unit vectors all around, evenly spread. Ref: Gonzalez 2010, the Fibonacci lattice."""
    z = 1 - (2 * np.arange(count) + 1) / count
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    across = np.sqrt(1 - z * z)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)


DIRECTIONS = _spread(256)


def grips_fit_a_gripper(asset: Asset, limit: float | None) -> Measurement:
    """KIN007: each joint has a labelled grip that is free and fits a gripper; metres of the widest."""
    assert limit is not None
    if not is_fixture_like(asset) or not asset.joints:
        return not_applicable(NO_JOINTS if is_fixture_like(asset) else NOT_BUILT)
    problems, widest = [], 0.0
    for joint in asset.joints:
        pointer = f"joints/{joint.name}"
        link, grip = _grip(asset, joint)
        if joint.grip is None:
            problems.append((pointer, "names no collider that a hand takes"))
        elif grip is None:
            problems.append((pointer, f"its grip {joint.grip!r} does not move with it"))
        elif grip.label not in HELD:
            problems.append((pointer, f"its grip is labelled {grip.label!r}, not one of {', '.join(sorted(HELD))}"))
        else:
            sides = _sides(grip)
            if grip.label not in PUSHED:
                widest = max(widest, sides[0])
            message = _misfit(grip, sides, limit)
            if message:
                problems.append((pointer, message))
            elif _free_share(asset, joint, link, grip) < FREE_SHARE:
                problems.append((pointer, f"its grip {grip.name!r} is buried in other parts; bring it out"))
    return Measurement(widest, tuple(problems))


def joint_axes_are_aligned(asset: Asset, limit: float | None) -> Measurement:
    """KIN008: joint axes of built things lie along x, y or z; largest deviation, rad."""
    assert limit is not None
    if not is_fixture_like(asset) or not asset.joints:
        return not_applicable(NO_JOINTS if is_fixture_like(asset) else NOT_BUILT)
    problems, worst = [], 0.0
    for joint in asset.joints:
        pose = asset.asset_from_link(joint.child)
        axis = np.sort(np.abs(pose.rotation @ np.array(joint.axis)))
        # The arc cosine of a number near 1 would lose half of the digits.
        off = float(np.arctan2(np.hypot(axis[0], axis[1]), axis[2]))
        worst = max(worst, off)
        if off > limit:
            problems.append((f"joints/{joint.name}", f"its axis is {off:.3g} rad off x, y or z; turn it straight"))
    return Measurement(worst, tuple(problems))


def inertia_matches_colliders(asset: Asset, limit: float | None) -> Measurement:
    """AST017: largest radius of gyration of a link over half the diagonal of its shapes."""
    assert limit is not None
    if not is_fixture_like(asset):
        return not_applicable(NOT_BUILT)
    problems, shares = [], []
    for link in asset.links:
        bounds = link_bounds(link)
        if bounds is None:
            continue
        half = float(np.linalg.norm(bounds[1] - bounds[0])) / 2
        gyration = float(np.sqrt(np.trace(link.inertial.tensor) / 2 / link.inertial.mass))
        share = gyration / half
        shares.append(share)
        pointer = f"links/{link.name}/inertial"
        if not 0.15 * limit <= share <= limit:
            message = f"turns as if its mass were {gyration:.3f} m from its middle; its shapes reach {half:.3f} m"
            problems.append((pointer, message))
        out = _off_hull(link)
        if out > OFF_HULL_M:
            problems.append((pointer, f"centre of mass is {out:.3f} m outside the hull of its shapes"))
    return largest(shares, tuple(problems), NO_COLLIDERS)


def _off_hull(link: Link) -> float:
    """How far the centre of mass lies outside the convex hull of the shapes, metres, seen along many directions."""
    points = []
    for collider in link.colliders:
        shape, pose = collider.shape, collider.pose
        if isinstance(shape, Hull | MeshShape):  # its corners do, and no hull has to be made of them anew
            points.append(pose.apply(shape.mesh.vertices))
        else:
            points.append(tessellate(shape, pose)[0])
    cloud = np.concatenate(points)
    return float((DIRECTIONS @ np.array(link.inertial.center_of_mass) - (DIRECTIONS @ cloud.T).max(axis=1)).max())


def _grip(asset: Asset, joint: Joint) -> tuple[str, Collider | None]:
    """The link that bears what a hand takes of a joint, and its collider; None where it is not one that it moves."""
    for link, _ in carried(asset, joint.child):
        for collider in asset.link(link).colliders:
            if collider.name == joint.grip:
                return link, collider
    return "", None


def _sides(grip: Collider) -> list[float]:
    """Full sizes of a shape along its own axes, metres, the least first."""
    low, high = shape_bounds(grip.shape, Pose())
    return sorted(float(side) for side in high - low)


def _misfit(grip: Collider, sides: list[float], limit: float) -> str:
    """Why no gripper of that opening takes a shape; empty where one does."""
    if grip.label in PUSHED:
        return ""
    if not THINNEST_M <= sides[0] <= limit:
        return f"its grip is {sides[0]:.4f} m across at its thinnest; no gripper holds that"
    if grip.label in GRASPED and not any(THIN_HANDLE_M <= side <= limit for side in sides):
        return f"no side of its handle is {THIN_HANDLE_M:g} to {limit:g} m; fingers find no hold on it"
    return ""


def _free_share(asset: Asset, joint: Joint, link: str, grip: Collider) -> float:
    """Share of the surface of a grip that lies in no other part, joints at zero. Parts that move with it count, too."""
    asset_from_grip = asset.asset_from_link(link) @ grip.pose
    points = surface_samples(*tessellate(grip.shape, asset_from_grip), SAMPLES)
    low, high = points.min(axis=0), points.max(axis=0)
    clouds = []
    for other in asset.links:
        frame = asset.asset_from_link(other.name)
        for collider in other.colliders:
            corners = shape_bounds(collider.shape, frame @ collider.pose)
            beside = (corners[0] > high).any() or (corners[1] < low).any()
            # Fingers close on a grip as on its neighbours of the same label: a handle in pieces.
            same = other.name == link and collider.label == grip.label
            if not beside and not same and not isinstance(collider.shape, MeshShape):
                clouds.append(tessellate(collider.shape, frame @ collider.pose)[0])
    return float((distances_outside_hulls(points, clouds) > FREE_M).mean()) if clouds else 1.0
