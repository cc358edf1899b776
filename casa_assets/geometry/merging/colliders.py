"""Colliders that replace others: with rounded sizes, named after the largest that they replace."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.geometry.merging.fit_primitives import FitLimits, fit_primitives
from casa_assets.model.asset.asset import Asset, Collider
from casa_assets.model.asset.shape import Box, Cylinder, Shape
from casa_assets.model.kitchen.scene import LightScene
from casa_assets.model.pose import Pose

# Sizes and positions are multiples of this, metres: the last digits of a computation are no promise.
SIZE_STEP_M = 1e-6
# Points around boxes are this far from them, metres.
AROUND_M = 0.05


def fitted_colliders(colliders: Sequence[Collider], limits: FitLimits) -> tuple[Collider, ...]:
    """Fit fewer colliders around some, named after the largest that each replaces or after a piece of it."""
    if len(colliders) < 2:
        return tuple(colliders)
    found: list[Collider] = []
    taken: set[str] = set()
    for fitted in fit_primitives([(c.shape, c.pose) for c in colliders], limits):
        owner = colliders[fitted.covered[0]]
        name, number = owner.name, 0
        while name in taken:
            number += 1
            name = LightScene.part_name(LightScene.collider_of(owner.name), number)
        taken.add(name)
        found.append(replaced(owner, fitted.shape, fitted.pose).replace(name=name))
    return tuple(found)


def replaced(collider: Collider, shape: Shape, pose: Pose) -> Collider:
    """The collider with another shape, rounded."""
    x, y, z = (round(value / SIZE_STEP_M) * SIZE_STEP_M for value in pose.position)
    pose = pose.replace(position=(x, y, z))
    if isinstance(shape, Box):
        a, b, c = (max(round(size / SIZE_STEP_M), 1) * SIZE_STEP_M for size in shape.size)
        shape = Box(size=(a, b, c))
    elif isinstance(shape, Cylinder):
        radius, height = (max(round(size / SIZE_STEP_M), 1) * SIZE_STEP_M for size in (shape.radius, shape.height))
        shape = Cylinder(radius=radius, height=height)
    return collider.replace(shape=shape, pose=pose)


def box_between(corners: Floats) -> tuple[Box, Pose]:
    """The aligned box between two corners, (2, 3) metres, and its pose."""
    x, y, z = (float(s) for s in corners[1] - corners[0])
    a, b, c = (float(s) for s in corners.mean(axis=0))
    return Box(size=(x, y, z)), Pose(position=(a, b, c))


def is_aligned(pose: Pose) -> bool:
    """True where the axes of a pose are those of the frame, in any order."""
    return bool(np.abs(pose.rotation).max(axis=1).min() > 1 - 1e-9)


def points_around(corners: Floats) -> Floats:
    """(8, 3) points around boxes, from which anything gets at them."""
    low, high = corners[:, 0].min(axis=0) - AROUND_M, corners[:, 1].max(axis=0) + AROUND_M
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


def touched_colliders(form: Asset) -> set[str]:
    """Names of the colliders whose contacts the asset's behaviour looks at."""
    return set() if form.behavior is None else set(form.behavior.contacts)
