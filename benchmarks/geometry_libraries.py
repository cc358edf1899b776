"""Compare our functions in mesh/ with those of trimesh and scipy: same result, and how long each takes.

    python -m benchmarks.geometry_libraries examples/meshes ../shared/data/dev

Prints, for each function, on how many meshes both agree to 1e-9 of the size, the worst difference, and both times.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from casa_assets import registry
from casa_assets.core.numeric import Floats, Ints, about_axis
from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found
from casa_assets.mesh.solid.solids import hull_volume
from casa_assets.mesh.surface import consistent_winding, face_components, is_closed, signed_volume, solid_moments, weld

# Relative to the size of the mesh, or to the value where that has no size.
EQUAL = 1e-9
MOST_FACES = 40_000


class Comparison:
    """Meshes, meshes on which both agree, worst difference, seconds of ours and of the library."""

    def __init__(self) -> None:
        self.rows: dict[str, list[float]] = {}

    def add(
        self, name: str, ours: Callable[[], Any], other: Callable[[], Any], gap: Callable[[Any, Any], float]
    ) -> None:
        """Run both on one mesh."""
        start = time.perf_counter()
        one = ours()
        middle = time.perf_counter()
        two = other()
        end = time.perf_counter()
        row = self.rows.setdefault(name, [0, 0, 0.0, 0.0, 0.0])
        worst = float(gap(one, two))
        row[0] += 1
        row[1] += worst <= EQUAL
        row[2] = max(row[2], worst)
        row[3] += middle - start
        row[4] += end - middle


def compare(points: Floats, faces: Ints, table: Comparison) -> None:
    """All functions on one welded mesh."""
    size = float(np.ptp(points, axis=0).max())

    def mesh(moved: Floats | float = 0.0) -> trimesh.Trimesh:
        return trimesh.Trimesh(points + moved, faces, process=False)

    def labels() -> Ints:
        edges = trimesh.geometry.faces_to_edges(faces)
        found: Ints = trimesh.graph.connected_component_labels(edges, node_count=len(points))
        return found

    def count(a: Ints, b: Ints) -> float:
        return abs(len(np.unique(a)) - len(np.unique(b[faces[:, 0]])))

    table.add("components", lambda: face_components(faces, len(points)), labels, count)
    table.add("hull volume", lambda: hull_volume(points), lambda: trimesh.convex.convex_hull(points).volume,
              lambda a, b: abs(a - b) / size**3)  # fmt: skip
    if is_closed(faces) and signed_volume(points, faces) > 1e-6 * size**3:
        table.add("volume, closed", lambda: signed_volume(points, faces), lambda: mesh().volume,
                  lambda a, b: abs(a - b) / size**3)  # fmt: skip
        inertia = solid_moments(points, faces)[2]
        far = np.array([10.0, 20.0, 30.0]) * size
        for name, moved in (("inertia", 0.0 * far), ("inertia, 37 sizes off the origin", far)):

            def off(_: Any, b: Any) -> float:
                return float(np.abs(b - inertia).max() / np.abs(inertia).max())

            table.add(f"{name}, trimesh", lambda: 0, lambda moved=moved: mesh(moved).moment_inertia, off)
            table.add(f"{name}, ours", lambda: 0, lambda moved=moved: solid_moments(points + moved, faces)[2], off)
    turned = faces.copy()
    some = np.random.default_rng(0).random(len(faces)) < 0.3
    turned[some] = turned[some][:, ::-1]

    def wound() -> Ints:
        found = trimesh.Trimesh(points, turned, process=False)
        trimesh.repair.fix_winding(found)
        return np.asarray(found.faces)

    table.add("winding, 30 % of the faces turned", lambda: consistent_winding(turned)[0], wound,
              lambda a, b: float((a != b).any(axis=1).mean()))  # fmt: skip


def main() -> None:
    """Read what is under the folders and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--every", type=int, default=1, help="take one of so many meshes")
    given = parser.parse_args()
    limits = dict(registry.load().limits)
    table = Comparison()
    rng = np.random.default_rng(1)
    for axis, angle in zip(rng.normal(size=(2000, 3)), rng.uniform(-7, 7, 2000), strict=True):
        unit = axis / np.linalg.norm(axis)
        table.add(
            "rotation",
            lambda u=unit, a=float(angle): about_axis(u, a),
            lambda u=unit, a=angle: Rotation.from_rotvec(u * a).as_matrix(),
            lambda a, b: np.abs(a - b).max(),
        )
    for found in list(discover(given.folders))[:: given.every]:
        if not isinstance(found, Found):
            continue
        try:
            model = load(collect(found, limits), limits)
        except Rejected:
            continue
        points, place = weld(np.concatenate([p.mesh.vertices[p.mesh.faces].reshape(-1, 3) for p in model.parts]))
        faces = place.reshape(-1, 3)
        faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
        if 0 < len(faces) <= MOST_FACES:
            compare(points, faces, table)
    for name, (meshes, equal, worst, ours, other) in table.rows.items():
        print(f"{name}: {equal:.0f} of {meshes:.0f}, worst {worst:.2g}, ours {ours:.2f} s, library {other:.2f} s")


if __name__ == "__main__":
    main()
