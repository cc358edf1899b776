"""Compute the signature that an asset is compared by, and its surface for registration with another."""

from __future__ import annotations

import numpy as np

from casa_assets.core.typing import Floats, Ints
from casa_assets.errors import DegenerateShape
from casa_assets.geometry.mesh.shape_descriptor import shape_descriptor
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.signature import Signature
from casa_assets.preview.color_statistics import color_histogram


def signature(asset: Asset) -> Signature | None:
    """Form and colours of all that is seen of an asset, joints at zero; None where nothing with an area is."""
    try:
        return Signature(shape=shape_descriptor(*surface(asset)), color=color_histogram(asset))
    except DegenerateShape:
        return None


def surface(asset: Asset) -> tuple[Floats, Ints]:
    """(P, 3) points and (F, 3) faces of all that is seen of an asset, asset frame, joints at zero, metres."""
    points, faces, start = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        for visual in link.visuals:
            points.append(pose.apply(visual.mesh.vertices))
            faces.append(visual.mesh.faces.astype(np.int64) + start)
            start += len(visual.mesh.vertices)
    return np.concatenate(points), np.concatenate(faces)
