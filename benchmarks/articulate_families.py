"""Static appliances drawn from this project's own families, as cases of the articulation benchmark's form.

Each is one mesh without groups or names: `input` (the parts' surfaces, one after the other), `welded` (vertices within
1e-4 of the diagonal merged), `fused` (what is seen from outside of a grid of cubes); with the joints that the family
gave it as ground truth. Used by `benchmarks/articulate.py --families`.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from casa_assets.articulate.segment.welded_mesh import weld_triangles
from casa_assets.geometry.grid.voxel import boundary, voxelise
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.mesh.topology import weld
from casa_assets.geometry.solid.coverage import surface_samples
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from casa_assets.pipeline.families.run import FamilyRequest, build_asset, family, params_of

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

FAMILIES = (
    *("microwave", "wall_oven", "range", "dishwasher", "toaster_oven", "hob", "toaster", "coffee_machine"),
    *("fridge_top_freezer", "fridge_bottom_freezer", "fridge_side_by_side", "fridge_french_door"),
    *("base_cabinet", "wall_cabinet", "tall_cabinet", "drawer_stack", "sink_base", "island_base", "sink", "kettle"),
)
EACH = 2
# Members that nothing else draws: the frame was trained on seed 0.
SEED = 7001
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
) - {"door", "drawer", "handle"}
# Keys of a panel without joints are not scored either: pieces of a panel that are no longer than this, metres.
KEYS, KEY_M = "panel", 0.05
CELLS, SAMPLES = 112, 60_000


def write_cases(folder: Path, names: Sequence[str] = FAMILIES, each: int = EACH) -> Path:
    """Write the cases below a folder; returns the folder of the cases."""
    cases = folder / "cases"
    with tempfile.TemporaryDirectory() as cache:
        for name in names:
            for i in range(each):
                wish = FamilyRequest(name, seed=SEED, index=i)
                asset = build_asset(family(name), params_of(wish), Path(cache))
                _case(cases / f"{name}_{i}", name, asset)
    rows = [{"name": p.name, "tags": ["core", "proc"]} for p in sorted(cases.iterdir()) if p.is_dir()]
    (cases / "index.json").write_text(json.dumps({"cases": rows}), encoding="utf-8")
    return cases


def _case(folder: Path, category: str, asset: Asset) -> None:
    folder.mkdir(parents=True)
    points, faces, owner = _merged(asset)
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    extent = float(np.ptp(points, axis=0).max())
    welded, place = weld(points, 1e-4 * diagonal / extent)
    grid = voxelise(points, faces, CELLS)
    outer, skin = boundary(grid)
    near = _nearest(points, faces, owner, outer, skin)
    for variant, (vertices, triangles) in {
        "input": (points, faces),
        "welded": (welded, place[faces]),
        "fused": (outer, skin),
    }.items():
        _obj(folder / f"{variant}.obj", vertices, triangles)
    _, areas = face_normals(points, faces)
    _, skin_areas = face_normals(outer, skin)
    parts: list[dict[str, Any]] = []
    for joint in asset.joints:
        number = [k.name for k in asset.links].index(joint.child)
        rows = np.flatnonzero(owner == number)
        if len(rows):
            parts.append(
                _part(asset, joint, number, points[faces[rows]].reshape(-1, 3), rows, float(areas[rows].sum()))
            )
            parts[-1]["visible"] = min(1.0, float(skin_areas[near == number].sum() / max(parts[-1]["area"], 1e-12)))
    for number in range(len(asset.links), int(owner.max()) + 1):
        rows = np.flatnonzero(owner == number)
        area = float(areas[rows].sum())
        seen = min(1.0, float(skin_areas[near == number].sum() / max(area, 1e-12)))
        parts.append(
            {"id": number, "name": f"loose_{number}", "type": "other", "scored": False, "interior": False}
            | {"area": area, "visible": seen, "faces": _runs(rows)}
        )
    runs = {str(p["id"]): _runs(np.flatnonzero(near == p["id"])) for p in parts}
    truth = {
        "name": folder.name,
        "category": category,
        "up": "+Z",
        "front": "-Y",
        "metric": True,
        "mesh": {"diagonal": diagonal},
        "parts": parts,
        "welded": {},
        "fused": {"parts": runs},
    }
    (folder / "gt.json").write_text(json.dumps(truth), encoding="utf-8")


def _merged(asset: Asset) -> tuple[Floats, Ints, Ints]:
    """All that is seen as one mesh: vertices, faces, and the link of each face; one without a joint is its parent's.

    What is not scored (UNSCORED, of a link that has other things too, or no joint) counts on from the last link.
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


def _part(asset: Asset, joint: Joint, number: int, cloud: Floats, rows: Ints, area: float) -> dict[str, Any]:
    pose = asset.asset_from_link(joint.child)
    origin = pose.apply(np.array([joint.anchor]))[0]
    axis = pose.apply(np.array([joint.axis]))[0] - pose.apply(np.zeros((1, 3)))[0]
    low, high = joint.range
    if abs(low) > abs(high):  # ground truth opens in the positive sense
        axis, low, high = -axis, -high, -low
    link = asset.link(joint.child)
    kind = _kind(asset, joint.child)
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
        "bbox": [cloud.min(axis=0).tolist(), cloud.max(axis=0).tolist()],
        "area": area,
        "faces": _runs(rows),
    }


def _small(vertices: Floats, faces: npt.NDArray[np.int32]) -> npt.NDArray[np.bool_]:
    """(F,) faces of pieces of a mesh that are as small as keys."""
    mesh = weld_triangles(vertices, faces.astype(np.int64))
    label = mesh.fragment_labels
    low, high = np.full((int(label.max()) + 2, 3), np.inf), np.full((int(label.max()) + 2, 3), -np.inf)
    np.minimum.at(low, label, mesh.points[mesh.faces].min(axis=1))
    np.maximum.at(high, label, mesh.points[mesh.faces].max(axis=1))
    found: npt.NDArray[np.bool_] = ((high - low).max(axis=1) <= KEY_M)[label] & (label >= 0)
    return found


def _kind(asset: Asset, link: str) -> str:
    """What a link is, by the labels of its shapes."""
    found = asset.link(link)
    labels = [c.label or "" for c in found.colliders] + [v.label or "" for v in found.visuals]
    return next((t for word, t in TYPES.items() if word in labels), "other")


def _nearest(points: Floats, faces: Ints, owner: Ints, outer: Floats, skin: Ints) -> Ints:
    """Link of each face of the fused shell: that of the nearest sample of the parts' surfaces."""
    clouds, ids = [], []
    _, areas = face_normals(points, faces)
    for number in np.unique(owner).tolist():
        rows = owner == number
        count = max(200, int(SAMPLES * float(areas[rows].sum() / areas.sum())))
        clouds.append(surface_samples(points, faces[rows], count))
        ids.append(np.full(count, number, dtype=np.int64))
    _, at = cKDTree(np.concatenate(clouds)).query(outer[skin].mean(axis=1))
    found: Ints = np.concatenate(ids)[at]
    return found


def _runs(rows: Ints) -> list[list[int]]:
    """Ascending indices as (start, count)."""
    if not len(rows):
        return []
    starts = np.flatnonzero(np.diff(rows, prepend=rows[0] - 2) != 1)
    counts = np.diff(np.append(starts, len(rows)))
    return [[int(rows[s]), int(c)] for s, c in zip(starts, counts, strict=True)]


def _obj(path: Path, vertices: Floats, faces: Ints) -> None:
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
