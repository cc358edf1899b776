"""Draw articulated furniture and appliances with scene_synthesizer, in an environment that has it; no import of ours.

    PYTHON benchmarks/articulate/cases/peer_assets.py OUT --seed 78 --each 5

Writes OUT/<kind>_<k>.npz (`points` (P, 3) metres, `faces` (F, 3), `part` (F,) 0 for what does not move) and .json (the
kind, and of each part its number, name, joint type, axis, origin and range). Joints are at zero. Run by
benchmarks/articulate/peer.py.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import scene_synthesizer.procedural_assets as assets
import trimesh

Rng = np.random.Generator


def partitioned_cabinet(rng: Rng) -> Any:
    """A cabinet whose front is divided again and again into doors and drawers."""
    return assets.RecursivelyPartitionedCabinetAsset(
        width=float(rng.uniform(0.4, 1.2)),
        depth=float(rng.uniform(0.35, 0.6)),
        height=float(rng.uniform(0.5, 1.8)),
        split_decay=float(rng.uniform(0.4, 0.65)),
        handle_width=float(rng.uniform(0.08, 0.2)),
        seed=int(rng.integers(1 << 30)),
    )


def grid_cabinet(rng: Rng) -> Any:
    """A grid of doors, drawers and open compartments, with handles now and then wider than their fronts."""
    rows, columns = int(rng.integers(1, 4)), int(rng.integers(1, 4))
    cells = np.arange(rows * columns).reshape(rows, columns)
    if rng.random() < 0.4 and min(rows, columns) > 1:
        cells[0, :] = cells[0, 0]
    cells = np.unique(cells, return_inverse=True)[1].reshape(rows, columns)
    kinds = ["drawer", "door_left", "door_right", "open"]
    return assets.CabinetAsset(
        width=float(rng.uniform(0.4, 1.3)),
        depth=float(rng.uniform(0.35, 0.6)),
        height=float(rng.uniform(0.4, 1.6)),
        compartment_mask=cells,
        compartment_types=[str(rng.choice(kinds, p=[0.45, 0.22, 0.22, 0.11])) for _ in range(cells.max() + 1)],
        handle_width=float(rng.uniform(0.06, 0.2)),
        handle_depth=float(rng.uniform(0.015, 0.04)),
        frontboard_thickness=float(rng.uniform(0.012, 0.03)),
        frontboard_overlap=float(rng.choice([0.0, 0.5, 0.9])),
    )


def microwave(rng: Rng) -> Any:
    """A microwave without controls; three in ten have their handle at the left."""
    return assets.MicrowaveAsset(
        width=float(rng.uniform(0.42, 0.62)),
        depth=float(rng.uniform(0.3, 0.45)),
        height=float(rng.uniform(0.26, 0.38)),
        thickness=float(rng.uniform(0.02, 0.05)),
        display_panel_width=float(rng.uniform(0.08, 0.16)),
        handle_left=bool(rng.random() < 0.3),
        handle_depth=float(rng.uniform(0.03, 0.07)),
        handle_thickness=float(rng.uniform(0.02, 0.05)),
    )


def any_of(name: str) -> Callable[[Rng], Any]:
    """What the package itself draws of a class."""
    return lambda rng: getattr(assets, name).random(seed=int(rng.integers(1 << 30)))


KINDS: dict[str, Callable[[Rng], Any]] = {
    "partitioned": partitioned_cabinet,
    "cabinet": grid_cabinet,
    "microwave": microwave,
    "refrigerator": any_of("RefrigeratorAsset"),
    "dishwasher": any_of("DishwasherAsset"),
    "range": any_of("RangeAsset"),
    "sinkcabinet": any_of("SinkCabinetAsset"),
    "basecabinet": any_of("BaseCabinetAsset"),
    "wallcabinet": any_of("WallCabinetAsset"),
}


def labelled(asset: Any) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """The arrays of a mesh, and its moving parts."""
    scene = asset.scene("x")
    scene.update_configuration(np.zeros(len(scene.get_joint_names())))
    graph = scene.graph
    joints = {}
    for (parent, child), data in graph.transforms.edge_data.items():
        joint = (data.get("metadata") or {}).get("joint")
        if joint and joint["type"] != "fixed":
            joints[child] = (parent, joint)
    numbers = {child: k + 1 for k, child in enumerate(sorted(joints))}
    points, faces, part, count = [], [], [], 0
    for node in graph.nodes_geometry:
        place, geometry = graph.get(node)
        mesh, owner = scene.geometry[geometry], node
        while owner is not None and owner not in numbers:
            owner = graph.transforms.parents.get(owner)
        points.append(trimesh.transform_points(mesh.vertices, place))
        faces.append(np.asarray(mesh.faces) + count)
        part.append(np.full(len(mesh.faces), numbers.get(owner, 0)))
        count += len(mesh.vertices)
    rows = []
    for child, number in numbers.items():
        parent, joint = joints[child]
        place = graph.get(parent)[0] @ np.array(joint["origin"])
        row = {"id": number, "name": child.split("/")[-1], "type": joint["type"], "origin": place[:3, 3].tolist()}
        row["axis"] = (place[:3, :3] @ np.array(joint["axis"], dtype=float)).tolist()
        rows.append(row | {"range": [float(joint["limit_lower"]), float(joint["limit_upper"])]})
    arrays = {"points": np.concatenate(points), "faces": np.concatenate(faces), "part": np.concatenate(part)}
    return arrays, rows


def main() -> None:
    """Draw and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--each", type=int, required=True)
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    for at, (kind, make) in enumerate(KINDS.items()):
        for k in range(args.each):
            arrays, rows = labelled(make(np.random.default_rng([args.seed, at, k])))
            np.savez(args.out / f"{kind}_{k}.npz", **arrays)
            (args.out / f"{kind}_{k}.json").write_text(json.dumps({"kind": kind, "parts": rows}), encoding="utf-8")


if __name__ == "__main__":
    main()
