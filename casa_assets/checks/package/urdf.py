"""Find differences between an asset and its URDF, read back from the files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from casa_assets.checks.check import Problem
from casa_assets.checks.package import parity
from casa_assets.checks.readers import asset_facts, urdf_facts
from casa_assets.checks.readers.urdf_facts import UrdfLink
from casa_assets.core.typing import Floats
from casa_assets.model.asset.asset import Asset

# Of ratios, unit vectors and radians: a URDF has nine digits of a number.
TOLERANCE = 1e-6
LENGTH_TOLERANCE_M = 1e-6  # a float32 six metres from the origin is right to 2.4e-7


def asset_differences(path: Path, asset: Asset) -> list[Problem]:
    """One problem for each cell in which a URDF differs from the asset that it was written from.

    Args:
        path: of the URDF; the JSON and the folders that it names are in the same folder.
    """
    try:
        return table_differences(urdf_facts.links(path), path.parent, urdf_facts.beside(path), asset)
    except (ValueError, KeyError, TypeError) as error:
        return [(path.name, f"cannot be read: {' '.join(str(error).split())}")]


def table_differences(
    tree: tuple[UrdfLink, ...], folder: Path, aside: Mapping[str, object], asset: Asset, prefix: str = ""
) -> list[Problem]:
    """Differences between the links of one asset and the asset: the table of facts, and the bounds of each visual.

    Args:
        tree, folder, aside, prefix: see `urdf_facts.table`.
    Raises:
        ValueError, KeyError, TypeError: the files do not say what a table needs.
    """
    expected = urdf_facts.on_joint_axes(asset_facts.facts(asset))
    actual = urdf_facts.table(tree, folder, aside, prefix)
    problems = parity.compare(expected, actual, TOLERANCE, LENGTH_TOLERANCE_M)
    return problems + _visual_differences(asset, urdf_facts.visual_bounds(tree, folder, prefix))


def _visual_differences(asset: Asset, found: Mapping[str, Floats]) -> list[Problem]:
    """Visuals that are not where those of the asset are; their names are compared with the looks."""
    problems = []
    for link in asset.links:
        joint = asset.joint_of(link.name)
        anchor = np.array(joint.anchor if joint else (0.0, 0.0, 0.0))
        for visual in link.visuals:
            off = float(np.abs(found.get(visual.name, np.inf) - (visual.mesh.bounds - anchor)).max())
            if not off <= LENGTH_TOLERANCE_M:
                problems.append((f"visuals/{visual.name}", f"its bounds differ by {off:.3g} m"))
    return problems
