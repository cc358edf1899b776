"""Whether a thing stands by itself on its collision shapes."""

from __future__ import annotations

import numpy as np

from casa_assets.geometry.planar import outline_of
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.model.asset.asset import Asset

# What ends so near above the lowest point stands there, too, metres: a thing rocks by no more.
LEVEL_M = 0.002
# The middle of mass has to be so far inside of what it stands on, metres.
MARGIN_M = 0.004


def stands_by_itself(asset: Asset) -> bool:
    """True if the centre of mass of an asset, joints at zero, is over the footprint of its collision shapes."""
    points, mass, middle = [np.empty((0, 3))], 0.0, np.zeros(3)
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        points += [pose.apply(tessellate(c.shape, c.pose)[0]) for c in link.colliders]
        mass += link.inertial.mass
        middle = middle + link.inertial.mass * pose.apply(np.array([link.inertial.center_of_mass]))[0]
    every = np.concatenate(points)
    if not len(every):
        return False
    foot = every[every[:, 2] < every[:, 2].min() + LEVEL_M]
    corners = outline_of(foot[:, :2])
    if len(corners) < 3:
        return False
    edges = np.roll(corners, -1, axis=0) - corners
    to_middle = (middle / mass)[:2] - corners
    # Counter-clockwise: what is inside is on the left of every edge.
    left = (edges[:, 0] * to_middle[:, 1] - edges[:, 1] * to_middle[:, 0]) / np.linalg.norm(edges, axis=1)
    return bool(left.min() >= MARGIN_M)
