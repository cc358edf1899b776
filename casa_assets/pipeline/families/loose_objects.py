"""Complete an object out of numbers: add sites where a hand can take it, and its split for training or for testing."""

from __future__ import annotations

import math

import numpy as np

from casa_assets.families.family import Params
from casa_assets.geometry.mesh.hand_grasps import choose_grasps, grasp_site
from casa_assets.geometry.mesh.topology import weld
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.grasp import Grasp
from casa_assets.model.asset.provenance import split_of
from casa_assets.model.registry.category import Category
from casa_assets.pipeline.cache.cache_key import digest_of

# Two members have the same proportions where the logarithms of these fall into one step of this width: about a sixth.
PROPORTION_STEP = 0.15


def complete(asset: Asset, params: Params, category: Category, opening_m: float) -> Asset:
    """The object with its split, and with a site `grasp_<feature>` for each way in which a hand can take it.

    Args:
        params: its numbers. opening_m: largest opening of the gripper.
    """
    split = split_of(shape_digest(asset, params))
    grasps = tuple(grasp_site(grasp, np.zeros(3)) for grasp in _grasps(asset, category, opening_m))
    return asset.replace(labels=asset.labels.replace(split=split), sites=(*asset.sites, *grasps))


def shape_digest(asset: Asset, params: Params) -> str:
    """64 hex digits that members of a category share where they have the same design and about the same proportions.

    Colours, labels and what is random in a surface have no part in it, and neither has the size.
    """
    x, y, z = (float(side) for side in np.ptp(asset.bounds, axis=0))
    proportions = [round(math.log(ratio) / PROPORTION_STEP) for ratio in (y / x, z / x)]
    return digest_of("shape", asset.labels.category, params.design, proportions)


def _grasps(asset: Asset, category: Category, opening_m: float) -> tuple[Grasp, ...]:
    """Grasps of the root link: what takes a lid lifts the lid and not the pot."""
    root = asset.root
    parts = [visual.mesh for visual in root.visuals]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in parts[:-1])])
    points, point_of_vertex = weld(np.concatenate([mesh.vertices for mesh in parts]).astype(np.float64))
    faces = np.concatenate([mesh.faces.astype(np.int64) + start for mesh, start in zip(parts, starts, strict=True)])
    return choose_grasps(points, point_of_vertex[faces], root.inertial.center_of_mass, category, opening_m)
