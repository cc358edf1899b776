"""Static appliances drawn from this project's own families, as cases of the articulation benchmark's form.

Each is one mesh without groups or names, with the joints that the family gave it as ground truth.
"""

from __future__ import annotations

import functools
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.articulate.labelled import LabelledMesh
from casa_assets.articulate.segment.fragments import corners_of_labels, weld_triangles
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.families.build import FamilyRequest, build_asset, family, params_of
from casa_assets.model.asset.asset import Asset, Joint, JointKind

FAMILIES = (
    *("microwave", "wall_oven", "range", "dishwasher", "toaster_oven", "hob", "toaster", "coffee_machine"),
    *("fridge_top_freezer", "fridge_bottom_freezer", "fridge_side_by_side", "fridge_french_door"),
    *("base_cabinet", "wall_cabinet", "tall_cabinet", "drawer_stack", "sink_base", "island_base", "sink", "kettle"),
)
# Further ones whose members have joints that are scored.
MORE = (
    *("corner_cabinet_blind", "corner_cabinet_diagonal", "housing_oven", "housing_microwave", "window", "door"),
    *("switch", "hood", "blender"),
)
# What a label of a link's shapes says of its type, the first that fits.
TYPES = {
    "door": "door",
    "drawer": "drawer",
    "knob": "knob",
    "button": "button",
    "key": "button",
    "lever": "lever",
    "rack": "tray",
    "tray": "tray",
    "lid": "lid",
    "spout": "spout",
    "window": "door",
    "handle": "lever",
}
# What no joint of ours moves though it may: of a real one it is pressed, turned, drawn or lifted off, and whoever finds
# it is not wrong, nor is who leaves it. So it is not scored, as the benchmark does with wheels, burners and lights.
UNSCORED = frozenset(
    {
        *TYPES,
        "burner",
        "cap",
        "crank",
        "crumb_tray",
        "dial",
        "hopper",
        "jug",
        "lamp",
        "portafilter",
        "print",
        "tank",
        "wheel",
    }
) - {"door", "drawer", "handle", "window"}
# What slides this nearly along the way that the front faces is pulled out.
PULLED_COS = 0.9
# Keys of a panel without joints are not scored either: pieces of a panel that are no longer than this, metres.
KEYS, KEY_M = "panel", 0.05


def family_case(name: str, seed: int, index: int) -> LabelledMesh:
    """A member of a family as one mesh, with the parts that its joints move."""
    asset = build_asset(family(name), params_of(FamilyRequest(name, seed=seed, index=index)), Path(_cache().name))
    points, faces, owner = _merged(asset)
    parts: list[dict[str, Any]] = []
    for joint in asset.joints:
        number = [k.name for k in asset.links].index(joint.child)
        if (owner == number).any():
            parts.append(_part(asset, joint, number))
    for number in range(len(asset.links), int(owner.max()) + 1):
        parts.append({"id": number, "name": f"loose_{number}", "type": "other", "scored": False, "interior": False})
    truth = {
        "name": f"{name}_{index}",
        "category": name,
        "up": "+Z",
        "front": "-Y",
        "metric": True,
        "source": {"repo": "families"},
        "parts": parts,
    }
    return LabelledMesh(points, faces, owner, truth)


@functools.cache
def _cache() -> tempfile.TemporaryDirectory[str]:
    """A folder for what members have in common, gone when the process ends."""
    return tempfile.TemporaryDirectory()


def _merged(asset: Asset) -> tuple[Floats, Ints, Ints]:
    """All that is seen as one mesh: vertices, faces, and of each face its link.

    A face of a link without a joint is its parent's. What is not scored (UNSCORED, of a link that has other things
    too, or no joint) counts on from the last link.
    """
    names = [k.name for k in asset.links]
    points, faces, owner, start, more = [], [], [], 0, len(asset.links)
    for link in asset.links:
        carrier = link
        while carrier.parent is not None and asset.joint_of(carrier.name) is None:
            carrier = asset.link(carrier.parent)
        pose = asset.asset_from_link(link.name)
        for visual in link.visuals:
            points.append(pose.apply(visual.mesh.vertices))
            faces.append(visual.mesh.faces.astype(np.int64) + start)
            joint = asset.joint_of(link.name)
            loose = visual.label in UNSCORED and (joint is None or _kind(asset, link.name) != TYPES.get(visual.label))
            free = _small(visual.mesh.vertices, visual.mesh.faces) & (visual.label == KEYS) | loose
            owner.append(np.where(free, more, names.index(carrier.name)))
            more += bool(free.any())
            start += len(visual.mesh.vertices)
    return np.concatenate(points), np.concatenate(faces), np.concatenate(owner)


def _part(asset: Asset, joint: Joint, number: int) -> dict[str, Any]:
    pose = asset.asset_from_link(joint.child)
    origin = pose.apply(np.array([joint.anchor]))[0]
    axis = pose.apply(np.array([joint.axis]))[0] - pose.apply(np.zeros((1, 3)))[0]
    low, high = joint.range
    if abs(low) > abs(high):  # ground truth opens in the positive sense
        axis, low, high = -axis, -high, -low
    link = asset.link(joint.child)
    kind = _kind(asset, joint.child)
    # The front of a freezer that is pulled out towards the user is a drawer; a sash that slides sideways is none.
    if kind == "door" and joint.kind is JointKind.SLIDE and abs(float(axis[1])) > PULLED_COS:
        kind = "drawer"
    row = {
        "type": "prismatic" if joint.kind is JointKind.SLIDE else "revolute",
        "axis": axis.tolist(),
        "origin": origin.tolist(),
        "range": [low, high],
    }
    return {
        "id": number,
        "name": joint.child,
        "type": kind,
        "parent": "base" if link.parent == "object" else str(link.parent),
        "scored": kind != "other",
        "interior": False,
        "joint": row,
    }


def _small(vertices: Floats, faces: npt.NDArray[np.int32]) -> Mask:
    """(F,) faces of pieces of a mesh that are as small as keys."""
    mesh = weld_triangles(vertices, faces.astype(np.int64))
    label = mesh.fragment_labels
    lower, upper = corners_of_labels(mesh, label)
    small = np.append((upper - lower).max(axis=1) <= KEY_M, False)  # The last is taken for label -1.
    found: Mask = small[label]
    return found


def _kind(asset: Asset, link: str) -> str:
    """What a link is, by the labels of its shapes."""
    found = asset.link(link)
    labels = [c.label or "" for c in found.colliders] + [v.label or "" for v in found.visuals]
    return next((t for word, t in TYPES.items() if word in labels), "other")
