"""Speed up SimReady's rule against coincident meshes (VG.008), without changing its verdict.

The rule rounds every coordinate of a stage in Python, which takes 3 s for a large kitchen. Meshes that it finds have
the same topology and points that agree within its rounding: if no two meshes do, which numpy determines in a tenth of a
second, the rule would find none.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
import usd_validation_nvidia
from pxr import Usd, UsdGeom

from casa_assets.core.numeric import Floats

REQUIREMENT = "com.nvidia.simready.VG.008"
# What the rule rounds to the same number is no farther apart than the step of its rounding; 1 % for the floats' sake.
POINTS_TO, PLACES_TO = 1.01e-6, 1.01e-4


def make_swift() -> None:
    """Put the swift form of the rule into its place. The rules of SimReady have been registered."""
    rules = usd_validation_nvidia.RequirementsRegistry()
    requirement = rules.find_requirement(REQUIREMENT)
    theirs = rules.get_validator(requirement)

    def check_stage(rule: usd_validation_nvidia.BaseRuleChecker, stage: Usd.Stage) -> None:
        if could_coincide(stage):
            theirs.CheckStage(rule, stage)

    swift = type("CoincidentMeshes", (theirs,), {"CheckStage": check_stage})
    usd_validation_nvidia.register_requirements(requirement, override=True)(swift)


def could_coincide(stage: Usd.Stage) -> bool:
    """True if two meshes of a stage have the same faces and, within the rule's rounding, points and pose."""
    alike: dict[tuple[bytes, bytes], list[tuple[Floats, Floats]]] = defaultdict(list)
    cache, first = UsdGeom.XformCache(), Usd.TimeCode.EarliestTime()
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if not prim.IsA(UsdGeom.Mesh):
            continue
        mesh = UsdGeom.Mesh(prim)
        counts, indices = mesh.GetFaceVertexCountsAttr().Get(first), mesh.GetFaceVertexIndicesAttr().Get(first)
        points = np.array(mesh.GetPointsAttr().Get(first) or (), dtype=np.float64).reshape(-1, 3)
        place = np.array(cache.GetLocalToWorldTransform(prim))
        alike[np.array(counts or ()).tobytes(), np.array(indices or ()).tobytes()].append((place, points))
    return any(_any_meet(group) for group in alike.values())


def _any_meet(meshes: Sequence[tuple[Floats, Floats]]) -> bool:
    """True if any two (4x4 place, points) are the same but for the rounding."""
    ordered = sorted((mesh for mesh in meshes if len(mesh[1])), key=lambda mesh: float(mesh[0][3, 0]))
    for i, (place, points) in enumerate(ordered):
        for place_2, points_2 in ordered[i + 1 :]:
            if place_2[3, 0] - place[3, 0] > PLACES_TO:
                break
            near = np.abs(place_2 - place).max() <= PLACES_TO and points_2.shape == points.shape
            if near and np.abs(points_2 - points).max() <= POINTS_TO:
                return True
    return False
