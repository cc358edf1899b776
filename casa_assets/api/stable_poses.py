"""Poses in which an asset rests on a plane, for placing or dropping it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.geometry.mesh.trimesh_exchange import resting_sides
from casa_assets.model.asset.asset import Asset
from casa_assets.model.pose import Pose

# Sides whose normals differ by less than this are one pose: the facets of something round. A choice.
SAME_SIDE_RAD = np.radians(10.0)


@dataclass(frozen=True)
class StablePose:
    """A way to rest on a plane.

    Attributes:
        pose: world_from_asset: the lowest point is at z = 0, the centre of mass above the origin.
        probability: probability of this pose if the asset is put down in a random orientation and only tips over edges.
    """

    pose: Pose
    probability: float


def stable_poses(asset: Asset, least: float = 0.02) -> list[StablePose]:
    """Return the poses in which an asset can rest on a plane, from its collision shapes, the most likely first.

    Joints are closed. Rolling is ignored, so that a round object rests in many poses, each of which is unlikely.

    Args:
        least: poses with a lower probability are left out.
    """
    masses = np.array([link.inertial.mass for link in asset.links])
    centers = [
        asset.asset_from_link(link.name).apply(np.array([link.inertial.center_of_mass]))[0] for link in asset.links
    ]
    center: Floats = masses @ np.array(centers) / masses.sum()
    points, rotations, shares = resting_sides(asset, center)
    sides: list[Floats] = []
    sums: list[float] = []
    for rotation, share in zip(rotations, shares.tolist(), strict=True):
        near = [k for k, side in enumerate(sides) if float(side[2] @ rotation[2]) >= np.cos(SAME_SIDE_RAD)]
        if near:
            sums[near[0]] += share
        else:
            sides.append(rotation)
            sums.append(share)
    order = sorted(range(len(sides)), key=lambda k: -sums[k])
    return [StablePose(_set_down(sides[k], points, center), sums[k]) for k in order if sums[k] >= least]


def _set_down(rotation: Floats, points: Floats, center: Floats) -> Pose:
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:2, 3] = -(rotation @ center)[:2]
    matrix[2, 3] = -float((points @ rotation[2]).min())
    return Pose.from_matrix(matrix)
