"""Find grips that do not fit a gripper or its fingers, joints off the axes, and inertia unlike that of the shapes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from casa_assets.checks import check
from casa_assets.checks.motion.simulation import grip_of
from casa_assets.core.numeric import Floats
from casa_assets.mesh.solid.deviation import distances_outside_hulls, fibonacci_directions, surface_samples
from casa_assets.mesh.solid.primitive import link_bounds, shape_bounds, tessellate
from casa_assets.model.asset.asset import Asset, Collider, Joint
from casa_assets.model.asset.parts import MeshShape
from casa_assets.model.pose import Pose

# What two fingers close on; keys are pressed, and rims, trays and racks are pushed along.
HELD_LABELS = frozenset({"handle", "pull", "knob", "lever"})
# A finger as a bar. Ref: the fingers of a Panda hand are 2 cm wide and some 5 cm long; here, half of their pad's width.
PAD_M, FINGER_M, OPENING_M = 0.01, 0.05, 0.08
DEEPEST_M, LAYER_M = 0.02, 0.002  # thickness of a finger up to which room is looked for, and the steps of it
POINT_M = 0.005  # between points along a finger
PLACES = (0.0, 0.5, -0.5, 0.95, -0.95)  # along a handle, as shares of half its length
FREE_M = 1e-4  # distance from other parts at which a point lies free
# Labels of what a hand may take. A rim or a tray is held where a thing has no handle of its own.
GRIP_LABELS = frozenset(
    {"handle", "knob", "button", "lever", "key", "lid", "rim", "pull", "spout", "roll", "tray", "rack", "seat"}
)
# What fingers close on: one side of it at least is no thinner than this. Our choice: finger pads of rubber give by a
# millimetre or two, and slip off an edge that is thinner than both of them.
HANDLE_LABELS = frozenset({"handle", "pull"})
MIN_HANDLE_M = 0.005
# What is pushed round or along and need not fit between two fingers.
PUSHED_LABELS = frozenset({"roll", "seat", "lid", "rack", "tray"})
MIN_GRIP_M = 0.0015
# Points of a grip's surface that are looked at, the share of them that has to lie free, and how far from other parts.
SAMPLES = 64
MIN_FREE_SHARE = 0.1
FREE_DISTANCE_M = 2e-4
# How far a centre of mass may lie outside the hull of its link's shapes: thin walls without colliders have mass, too.
MAX_OFF_HULL_M = 0.001
# A radius of gyration below this part of the limit is too small. Our choice.
MIN_GYRATION_RATIO = 0.15
DIRECTIONS = fibonacci_directions(256)


def fingers_have_room(asset: Asset, limit: float) -> check.Measurement:
    """KIN011: thickness of the fingers that find room on both sides of each handle and knob, metres; the least."""
    if not check.is_from_family(asset):
        return check.not_applicable(check.NOT_BUILT)
    rooms = {}
    for joint in asset.joints:
        link, grip = grip_of(asset, joint)
        if grip is not None and grip.label in HELD_LABELS:
            rooms[f"joints/{joint.name}"] = _room(asset, joint, link, grip)
    message = "beside its grip, fingers of {:.3f} m at most find room on both sides; bring it out"
    return check.all_at_least(rooms, limit, message, check.NO_JOINTS)


def _room(asset: Asset, joint: Joint, link: str, grip: Collider) -> float:
    """Thickness of the thickest fingers that close on a grip somewhere, metres; at most `DEEPEST_M`."""
    lower, upper = shape_bounds(grip.shape, Pose())
    pose = asset.asset_from_link(link) @ grip.pose
    clouds = _others(asset, joint, grip, shape_bounds(grip.shape, pose))
    if not clouds:
        return DEEPEST_M
    best = 0.0
    for fingers in _grasps((lower + upper) / 2, (upper - lower) / 2):
        free = distances_outside_hulls(pose.apply(fingers.reshape(-1, 3)), clouds) > FREE_M
        # Layers of points from the grip outwards; a finger is as thick as all layers up to it are free.
        layers = free.reshape(fingers.shape[0], -1).all(axis=1)
        best = max(best, LAYER_M * int(np.logical_and.accumulate(layers).sum()))
        if best >= DEEPEST_M:
            break
    return best


def _others(asset: Asset, joint: Joint, grip: Collider, bounds: Floats) -> list[Floats]:
    """Vertices of the shapes near a grip, joints at zero; without the door that has to be open before it is taken."""
    lower, upper = bounds[0] - FINGER_M, bounds[1] + FINGER_M
    door = asset.carried_by([j.child for j in asset.joints if j.name == joint.behind])
    found = []
    for _, owner, collider in check.colliders_of(asset):
        if collider is grip or isinstance(collider.shape, MeshShape) or owner.name in door:
            continue
        pose = asset.asset_from_link(owner.name) @ collider.pose
        low, high = shape_bounds(collider.shape, pose)
        if (low < upper).all() and (high > lower).all():
            found.append(tessellate(collider.shape, pose)[0])
    return found


def _grasps(centre: Floats, half: Floats) -> Iterator[Floats]:
    """Two fingers around a box, in each way: points of shape (layers, points, 3), the layers from the box outwards."""
    layers = np.arange(LAYER_M, DEEPEST_M + LAYER_M / 2, LAYER_M)
    for close in np.argsort(half, kind="stable"):
        if 2 * half[close] > OPENING_M:
            continue
        for come in (k for k in range(3) if k != close):
            across = 3 - close - come
            wide = min(PAD_M / 2, half[across])
            deep = np.arange(-min(PAD_M, half[come]), FINGER_M, POINT_M)
            for sign in (1.0, -1.0):
                for share in PLACES[: 1 if half[across] <= PAD_M else None]:
                    middle = share * (half[across] - wide)
                    grid = np.stack(np.meshgrid(layers, (-1.0, 1.0), (-wide, 0.0, wide), deep, indexing="ij"), axis=-1)
                    points = np.empty((*grid.shape[:-1], 3))
                    points[..., close] = grid[..., 1] * (half[close] + grid[..., 0])
                    points[..., across] = middle + grid[..., 2]
                    points[..., come] = sign * (half[come] + grid[..., 3])
                    yield centre + points.reshape(len(layers), -1, 3)


def grips_fit_a_gripper(asset: Asset, limit: float) -> check.Measurement:
    """KIN007: each joint has a labelled grip that is free and fits a gripper; metres of the widest."""
    if not check.is_fixture_like(asset) or not asset.joints:
        return check.not_applicable(check.NO_JOINTS if check.is_fixture_like(asset) else check.NOT_BUILT)
    problems, widest = [], 0.0
    for joint in asset.joints:
        link, grip = grip_of(asset, joint)
        if joint.grip is None:
            fault = "names no collider that a hand takes"
        elif grip is None:
            fault = f"its grip {joint.grip!r} does not move with it"
        elif grip.label not in GRIP_LABELS:
            fault = f"its grip is labelled {grip.label!r}, not one of {', '.join(sorted(GRIP_LABELS))}"
        else:
            # Full sizes along its own axes, metres.
            sides = np.sort(np.ptp(shape_bounds(grip.shape, Pose()), axis=0)).tolist()
            if grip.label not in PUSHED_LABELS:
                widest = max(widest, sides[0])
            fault = _size_fault(grip, sides, limit)
            if not fault and _free_share(asset, link, grip) < MIN_FREE_SHARE:
                fault = f"its grip {grip.name!r} is buried in other parts; bring it out"
        if fault:
            problems.append((f"joints/{joint.name}", fault))
    return check.Measurement(widest, tuple(problems))


def joint_axes_are_aligned(asset: Asset, limit: float) -> check.Measurement:
    """KIN008: joint axes of built things lie along x, y or z; largest deviation, rad."""
    if not check.is_fixture_like(asset) or not asset.joints:
        return check.not_applicable(check.NO_JOINTS if check.is_fixture_like(asset) else check.NOT_BUILT)
    deviations = {}
    for joint in asset.joints:
        x, y, z = np.sort(np.abs(asset.asset_from_link(joint.child).rotation @ np.array(joint.axis)))
        # The arc cosine of a number near 1 would lose half of the digits.
        deviations[f"joints/{joint.name}"] = float(np.arctan2(np.hypot(x, y), z))
    return check.all_at_most(
        deviations, limit, "its axis is {:.3g} rad off x, y or z; turn it straight", check.NO_JOINTS
    )


def inertia_matches_colliders(asset: Asset, limit: float) -> check.Measurement:
    """AST017: largest radius of gyration of a link over half the diagonal of its shapes."""
    if not check.is_fixture_like(asset):
        return check.not_applicable(check.NOT_BUILT)
    problems, ratios = [], []
    for link in asset.links:
        bounds = link_bounds(link)
        if bounds is None:
            continue
        half = float(np.linalg.norm(bounds[1] - bounds[0])) / 2
        gyration = float(np.sqrt(np.trace(link.inertial.tensor) / 2 / link.inertial.mass))
        ratio = gyration / half
        ratios.append(ratio)
        pointer = f"links/{link.name}/inertial"
        if not MIN_GYRATION_RATIO * limit <= ratio <= limit:
            message = f"turns as if its mass were {gyration:.3f} m from its middle; its shapes reach {half:.3f} m"
            problems.append((pointer, message))
        points = np.concatenate([tessellate(c.shape, c.pose)[0] for c in link.colliders])
        support = (DIRECTIONS @ points.T).max(axis=1)
        # Along the worst direction.
        outside = float((DIRECTIONS @ np.array(link.inertial.center_of_mass) - support).max())
        if outside > MAX_OFF_HULL_M:
            problems.append((pointer, f"centre of mass is {outside:.3f} m outside the hull of its shapes"))
    return check.largest(ratios, problems, check.NO_COLLIDERS)


def _size_fault(grip: Collider, sides: list[float], limit: float) -> str:
    """Why no gripper of that opening takes a shape; empty where one does."""
    if grip.label in PUSHED_LABELS:
        return ""
    if not MIN_GRIP_M <= sides[0] <= limit:
        return f"its grip is {sides[0]:.4f} m across at its thinnest; no gripper holds that"
    if grip.label in HANDLE_LABELS and not any(MIN_HANDLE_M <= side <= limit for side in sides):
        return f"no side of its handle is {MIN_HANDLE_M:g} to {limit:g} m; fingers find no hold on it"
    return ""


def _free_share(asset: Asset, link: str, grip: Collider) -> float:
    """Share of the surface of a grip that lies in no other part, joints at zero. Parts that move with it count, too."""
    asset_from_grip = asset.asset_from_link(link) @ grip.pose
    points = surface_samples(*tessellate(grip.shape, asset_from_grip), SAMPLES)
    lower, upper = points.min(axis=0), points.max(axis=0)
    clouds = []
    for _, other, collider in check.colliders_of(asset):
        pose = asset.asset_from_link(other.name) @ collider.pose
        bounds = shape_bounds(collider.shape, pose)
        is_apart = (bounds[0] > upper).any() or (bounds[1] < lower).any()
        # A handle may be made of several colliders of one label, which fingers close on together.
        is_same = other.name == link and collider.label == grip.label
        if not is_apart and not is_same and not isinstance(collider.shape, MeshShape):
            clouds.append(tessellate(collider.shape, pose)[0])
    return float((distances_outside_hulls(points, clouds) > FREE_DISTANCE_M).mean()) if clouds else 1.0
