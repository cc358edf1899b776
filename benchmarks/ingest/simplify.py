"""Simplification of textured meshes: ours against meshoptimizer's, in the same run, where that is installed.

    ./dev bench ingest_simplify folder_of_meshes... [--every 1] [--shares 0.25 0.08]

Each textured part of at least 3,000 faces is brought to the limit of faces, if it has more, and to shares of its faces.
Distances (both ways) and the error of the silhouette are percent of the extent and of the picture; the colour is that
of points on the simplified surface against the nearest point of the original, percent of full scale, and the percent
of these points that are far off; cracks are open edges where the original has none.
Writes out/bench/ingest_simplify.json and prints the means.
"""

from __future__ import annotations

import argparse
import ctypes
import io
import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw
from scipy.spatial import cKDTree

from benchmarks.ingest.judging.distance import distances, ruler, sample
from casa_assets import registry
from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import CasaError
from casa_assets.geometry.mesh.topology import edge_counts, weld
from casa_assets.ingest.clean import clean
from casa_assets.ingest.load import load
from casa_assets.ingest.simplify import TARGET_ERROR, simplified
from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import RawPart

LEAST_FACES, SAMPLES, COLOURED, PICTURE_PX = 3000, 20_000, 400_000, 384
WRONG = 10.0  # percent of full scale, by which a colour is off that is not that of a neighbour
LOOKS = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1), (1, -1, 1), (-1, 1, 1))
Method = Callable[[Mesh, int], Mesh]


def by_meshoptimizer() -> Method | None:
    """Its simplification with attributes, over vertices welded by place and uv; None where it is not installed."""
    try:
        import meshoptimizer
    except ImportError:
        return None

    def run(mesh: Mesh, target: int) -> Mesh:
        assert mesh.uv is not None
        rows = np.column_stack([mesh.vertices / np.ptp(mesh.vertices, axis=0).max(), mesh.uv])
        _, first, place = np.unique(np.round(rows, 6), axis=0, return_index=True, return_inverse=True)
        index = place.ravel()[mesh.faces].ravel().astype(np.uint32)
        out = np.zeros_like(index)
        points, uv = (np.ascontiguousarray(a[first], dtype=np.float32) for a in (mesh.vertices, mesh.uv))
        # The binding declares no argument types for this function: numbers have to be of their C types already.
        sizes = {"index_count": len(index), "vertex_count": len(points), "target_index_count": target * 3}
        sizes |= {"vertex_positions_stride": 12, "vertex_attributes_stride": 8, "attribute_count": 2}
        count = meshoptimizer.simplify_with_attributes(
            *(out, index, points, uv, np.array([0.5, 0.5], dtype=np.float32)),
            target_error=ctypes.c_float(TARGET_ERROR),
            options=ctypes.c_uint(0),
            **{name: ctypes.c_size_t(value) for name, value in sizes.items()},
        )
        faces = first[out[: int(count)]].reshape(-1, 3)
        return Mesh(vertices=mesh.vertices, faces=faces.astype(np.int32), uv=mesh.uv)

    return run


def textured(folders: list[Path], every: int) -> Iterator[tuple[str, RawPart]]:
    """Every textured part of every input, cleaned."""
    limits = registry.load().limits
    for one in [f for f in discover(folders) if isinstance(f, Found)][::every]:
        try:
            draft = clean(load(collect(one, limits), limits))
        except CasaError as error:
            print(f"{one.source.path}: {error}", flush=True)
            continue
        for part in draft.parts:
            if part.mesh.uv is not None and part.material.base_color_texture and len(part.mesh.faces) >= LEAST_FACES:
                yield f"{one.source.path}#{part.name}", part


def surface(mesh: Mesh) -> tuple[Floats, Ints]:
    return mesh.vertices, mesh.faces.astype(np.int64)


def colours(mesh: Mesh, picture: Floats, count: int, seed: int) -> tuple[Floats, Floats]:
    """Points spread over the surface and what the picture shows there."""
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    rng = np.random.default_rng(seed)
    face = rng.choice(len(corners), size=count, p=areas / areas.sum())
    weights = rng.dirichlet((1, 1, 1), count)[:, :, None]
    assert mesh.uv is not None
    uv = (mesh.uv[mesh.faces[face]] * weights).sum(axis=1) % 1
    size = np.array(picture.shape[:2])
    row, column = np.minimum(np.column_stack([1 - uv[:, 1], uv[:, 0]]) * size, size - 1).astype(int).T
    return (corners[face] * weights).sum(axis=1), picture[row, column]


def silhouettes(mesh: Mesh, low: Floats, extent: float) -> Iterator[Floats]:
    """Masks from all sides, in the frame of the original."""
    for look in LOOKS:
        ahead = np.array(look) / np.linalg.norm(look)
        right = np.cross(ahead, (0.3, 0.5, 0.8))
        right /= np.linalg.norm(right)
        flat = (mesh.vertices - low - extent / 2) @ np.column_stack([right, np.cross(ahead, right)])
        picture = Image.new("1", (PICTURE_PX, PICTURE_PX))
        pen = ImageDraw.Draw(picture)
        for triangle in ((flat / extent / 1.8 + 0.5) * PICTURE_PX)[mesh.faces].reshape(-1, 6).tolist():
            pen.polygon(triangle, fill=1)
        yield np.asarray(picture)


def open_edges(mesh: Mesh) -> Floats:
    """(E, 2, 3) ends of the edges of one face, over welded points."""
    points, place = weld(mesh.vertices[mesh.faces.ravel()])
    ids = place.reshape(-1, 3)
    ids = ids[(ids != np.roll(ids, 1, axis=1)).all(axis=1)]
    ends, uses, _ = edge_counts(ids)
    return points[ends[uses == 1]]


def judged(before: Mesh, after: Mesh, picture: Floats) -> dict[str, float]:
    low = before.vertices[before.faces].min(axis=(0, 1))
    extent = float((before.vertices[before.faces].max(axis=(0, 1)) - low).max())
    there = distances(sample(surface(after), SAMPLES, 1)[0], ruler(surface(before)))
    back = distances(sample(surface(before), SAMPLES, 2)[0], ruler(surface(after)))
    masks = zip(*(silhouettes(m, low, extent) for m in (before, after)), strict=True)
    points, seen = colours(before, picture, COLOURED, 3)
    places, shown = colours(after, picture, SAMPLES, 4)
    apart = np.abs(shown - seen[cKDTree(points).query(places)[1]]).mean(axis=1) * 100 / 255
    rims = open_edges(before)
    spread = (rims[:, :1] + np.linspace(0, 1, 33)[:, None] * (rims[:, 1:] - rims[:, :1])).reshape(-1, 3)
    middles = open_edges(after).mean(axis=1)
    far = cKDTree(spread).query(middles)[0] > TARGET_ERROR * extent if len(spread) else np.ones(len(middles))
    return {
        "faces": len(after.faces),
        "max": 100 / extent * float(max(there.max(), back.max())),
        "mean": 50 / extent * float(there.mean() + back.mean()),
        "silhouette": 100 * float(np.mean([(a ^ b).sum() / max((a | b).sum(), 1) for a, b in masks])),
        "colour": float(apart.mean()),
        "colour_p95": float(np.percentile(apart, 95)),
        "wrong": 100 * float((apart > WRONG).mean()),
        "cracks": float(far.sum()),
    }


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--shares", nargs="*", type=float, default=[0.25, 0.08])
    asked = parser.parse_args()
    peer = by_meshoptimizer()
    print("compared with meshoptimizer" if peer else "meshoptimizer is not installed: ours alone")
    methods = {"ours": simplified} | ({"meshoptimizer": peer} if peer else {})
    limit = int(registry.load().limits["visual_faces"])
    rows: list[dict[str, object]] = []
    for path, part in textured(asked.folders, asked.every):
        texture = part.material.base_color_texture
        assert texture is not None
        picture = np.asarray(Image.open(io.BytesIO(texture.png)).convert("RGB"), dtype=np.float64)
        count = len(part.mesh.faces)
        for target in ([limit] if count > limit else []) + [int(count * share) for share in asked.shares]:
            for name, method in methods.items():
                begin = time.process_time()
                after = method(part.mesh, target)
                seconds = time.process_time() - begin
                row = judged(part.mesh, after, picture) | {"seconds": round(seconds, 3)}
                rows.append({"path": path, "target": target, "method": name, **row})
                print(rows[-1], flush=True)
    keys = ("max", "mean", "silhouette", "colour", "colour_p95", "wrong", "cracks", "seconds")
    for name in methods:
        mine = [row for row in rows if row["method"] == name]
        print(name, len(mine), {key: round(float(np.mean([row[key] for row in mine])), 4) for key in keys})
    out = Path("out/bench/ingest_simplify.json")
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(json.dumps(rows, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
