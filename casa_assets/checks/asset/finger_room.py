"""Find handles and knobs without room next to them for the two fingers of a gripper."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from casa_assets.checks.asset.applicability import NO_JOINTS, NOT_BUILT, colliders_of, is_from_family
from casa_assets.checks.check import Measurement, all_at_least, not_applicable
from casa_assets.checks.motion.motion_model import grip_of
from casa_assets.core.typing import Floats
from casa_assets.geometry.solid.bounds import shape_bounds
from casa_assets.geometry.solid.coverage import distances_outside_hulls
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.model.asset.asset import Asset, Collider, Joint
from casa_assets.model.asset.shape import MeshShape
from casa_assets.model.pose import Pose

# What two fingers close on; keys are pressed, and rims, trays and racks are pushed along.
HELD_LABELS = frozenset({"handle", "pull", "knob", "lever"})
# A finger as a bar. Ref: the fingers of a Panda hand are 2 cm wide and some 5 cm long; here, half of their pad's width.
PAD_M, FINGER_M, OPENING_M = 0.01, 0.05, 0.08
DEEPEST_M, LAYER_M = 0.02, 0.002  # thickness of a finger up to which room is looked for, and the steps of it
POINT_M = 0.005  # between points along a finger
PLACES = (0.0, 0.5, -0.5, 0.95, -0.95)  # along a handle, as shares of half its length
FREE_M = 1e-4  # distance from other parts at which a point lies free


def fingers_have_room(asset: Asset, limit: float) -> Measurement:
    """KIN011: thickness of the fingers that find room on both sides of each handle and knob, metres; the least."""
    if not is_from_family(asset):
        return not_applicable(NOT_BUILT)
    rooms = {}
    for joint in asset.joints:
        link, grip = grip_of(asset, joint)
        if grip is not None and grip.label in HELD_LABELS:
            rooms[f"joints/{joint.name}"] = _room(asset, joint, link, grip)
    message = "beside its grip, fingers of {:.3f} m at most find room on both sides; bring it out"
    return all_at_least(rooms, limit, message, NO_JOINTS)


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
    for _, owner, collider in colliders_of(asset):
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
