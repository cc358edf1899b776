"""Near-duplicates by form: made copies of real meshes that are found, and different meshes that are taken for copies.

    ./dev bench ingest_duplicates [folder of meshes, or a library] [--every 1] [--pairs 5000] [--copies-of-every 1]

Writes out/bench/ingest_duplicates.json and .md, and prints the latter. Each copy is written to a file and read again as
any input is: turned, scaled, with a quarter of the faces, cut into single triangles and welded more coarsely in another
order, as STL, and all of that at once. What is no copy: pairs of different meshes of the set, and each mesh stretched
along its longest axis. Colours and sizes are left out: form alone decides here, which is the harder half.

`--same one=other` names a pair that is one mesh in two prints, as its source says; it is listed and not counted.

The peer is `identifier_hash` of trimesh, made to find the same mesh however it is turned; it needs trimesh, else its
column is left out. It is asked with scale taken out, since it tells sizes apart on purpose.
"""

from __future__ import annotations

import argparse
import importlib.util
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.ingest.judging.distance import Surface
from benchmarks.ingest.judging.inputs import dump
from casa_assets import registry
from casa_assets.checks.library import ShapePair
from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.ingest.clean import clean
from casa_assets.ingest.run.survey import find_category
from casa_assets.ingest.simplify import simplified
from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found
from casa_assets.library.library import Library, read_asset
from casa_assets.library.pairs import MAX_DESCRIPTOR_DISTANCE
from casa_assets.library.pairs import surface as surface_of
from casa_assets.mesh.registration import (
    SampledSurface,
    align,
    descriptor_distance,
    sampled_surface,
    shape_descriptor,
)
from casa_assets.mesh.topology import weld
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.asset.provenance import ShapeDescriptor
from casa_assets.model.source import Bundle

Make = Callable[[Surface, np.random.Generator], tuple[str, bytes]]
RECALL, PRECISION = 0.95, 0.99
COARSE = 1e-4  # of the longest side: what a careless exporter welds


@dataclass(frozen=True)
class Known:
    """A mesh as it is compared."""

    name: str
    surface: Surface
    shape_descriptor: ShapeDescriptor
    sampled_surface: SampledSurface


def moved(surface: Surface, rng: np.random.Generator, factor: float = 1.0) -> Surface:
    """Turned, pushed, scaled."""
    turn = Rotation.random(random_state=rng).as_matrix()
    return surface[0] @ turn.T * factor + rng.normal(size=3), surface[1]


def fewer(surface: Surface) -> Surface:
    """With a quarter of the faces, or as few as an error of 1 % allows."""
    mesh = simplified(Mesh(vertices=surface[0], faces=surface[1]), max(100, len(surface[1]) // 4))
    return mesh.vertices, mesh.faces.astype(np.int64)


def rewelded(surface: Surface, rng: np.random.Generator) -> Surface:
    """Single triangles in another order, welded coarsely."""
    points, faces = surface
    corners = points[faces[rng.permutation(len(faces))]].reshape(-1, 3)
    welded, place = weld(corners, COARSE)
    order = rng.permutation(len(welded))
    back = np.empty_like(order)
    back[order] = np.arange(len(order))
    return welded[order], back[place].reshape(-1, 3)


def obj(surface: Surface) -> tuple[str, bytes]:
    """Wavefront OBJ, nine digits."""
    lines = ["v %.9g %.9g %.9g" % tuple(p) for p in surface[0].tolist()]  # noqa: UP031
    lines += ["f %d %d %d" % tuple(f) for f in (surface[1] + 1).tolist()]  # noqa: UP031
    return "copy.obj", ("\n".join(lines) + "\n").encode()


def stl(surface: Surface) -> tuple[str, bytes]:
    """Binary STL: float32, no vertex is shared."""
    corners = surface[0][surface[1]].astype("<f4")
    rows = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    rows["corners"] = corners
    return "copy.stl", b"made".ljust(80) + np.uint32(len(corners)).tobytes() + rows.tobytes()


COPIES: dict[str, Make] = {
    "turned": lambda s, rng: obj(moved(s, rng)),
    "a hundredth as large": lambda s, rng: obj((s[0] * 0.01, s[1])),
    "a quarter of the faces": lambda s, rng: obj(fewer(s)),
    "welded anew, another order": lambda s, rng: obj(rewelded(s, rng)),
    "as STL": lambda s, rng: stl(s),
    "all at once": lambda s, rng: stl(moved(rewelded(fewer(s), rng), rng, 37.0)),
}


def stretched(surface: Surface, factor: float) -> Surface:
    """Longer along its longest axis."""
    sides = np.ones(3)
    sides[int(np.argmax(np.ptp(surface[0], axis=0)))] = factor
    return surface[0] * sides, surface[1]


OTHERS: dict[str, Make] = {
    "stretched by 10 %": lambda s, rng: obj(moved(stretched(s, 1.10), rng)),
    "stretched by 35 %": lambda s, rng: obj(moved(stretched(s, 1.35), rng)),
}


def read(name: str, bundle: Bundle, category: str = registry.FALLBACK) -> Known:
    """A bundle as ingest reads and cleans it."""
    known = registry.load()
    surface = clean(load(bundle, known.limits), known.category(category)).surface
    return signed(name, (surface.vertices, surface.faces))


def signed(name: str, surface: Surface) -> Known:
    """A surface made ready."""
    return Known(name, surface, shape_descriptor(*surface), sampled_surface(*surface))


def gather(folder: Path, every: int) -> Iterator[Known]:
    """Every input, or every n-th one, that can be read; of a library its accepted assets as they are seen."""
    if (folder / ".casa").is_dir():
        for place in list(Library(folder).accepted())[::every]:
            yield signed(place.name, surface_of(read_asset(place)))
        return
    for one in [f for f in discover([folder]) if isinstance(f, Found)][::every]:
        try:
            yield read(one.source.path, collect(one, registry.load().limits), find_category(one, "")[0].id)
        except Rejected as error:
            print(f"left out: {one.source.path}: {error}")


def compared(one: Known, other: Known, limit: float) -> tuple[float, float, float, bool]:
    """Gap of the forms, how near most and nearly all of the surfaces lie (2 where it was not tried), the verdict."""
    gap = descriptor_distance(one.shape_descriptor, other.shape_descriptor)
    if gap > MAX_DESCRIPTOR_DISTANCE:
        return gap, 2.0, 2.0, False
    found = align(one.sampled_surface, other.sampled_surface)
    pair = ShapePair(one.name, other.name, found.p95, found.p995, 1.0, 0.0, True)
    return gap, found.p95, found.p995, pair.same_form(limit)


def peer_mark(surface: Surface) -> str:
    """trimesh's identifier of a mesh brought to one size; empty without trimesh."""
    if importlib.util.find_spec("trimesh") is None:
        return ""
    import trimesh

    points = surface[0] / max(float(np.ptp(surface[0], axis=0).max()), 1e-30)
    mesh = trimesh.Trimesh(points, surface[1], process=True)
    mesh.apply_scale(1.0 / max(float(mesh.scale), 1e-30))
    return str(mesh.identifier_hash)


def trial(one: Known, seed: int, makes: dict[str, Make], limit: float) -> list[dict[str, object]]:
    """One row per way of making another of a mesh."""
    rows: list[dict[str, object]] = []
    mark = peer_mark(one.surface)
    for kind, make in makes.items():
        name, data = make(one.surface, np.random.default_rng(seed))
        try:
            other = read(f"{one.name} {kind}", Bundle(main=name, files={name: data}))
        except Rejected as error:
            rows.append({"name": one.name, "kind": kind, "found": False, "message": str(error)})
            continue
        gap, most, every, found = compared(one, other, limit)
        row = {"name": one.name, "kind": kind, "gap": gap, "most": most, "all": every, "found": found}
        rows.append({**row, "peer": bool(mark) and peer_mark(other.surface) == mark})
    return rows


def strangers(known: Sequence[Known], count: int, limit: float) -> list[dict[str, object]]:
    """One row per pair of different meshes, `count` of all pairs."""
    every = [(i, j) for i in range(len(known)) for j in range(i + 1, len(known))]
    order = np.random.default_rng(0).permutation(len(every))[:count]
    marks = [peer_mark(one.surface) for one in known]
    rows = []
    for i, j in (every[k] for k in order):
        gap, most, wide, found = compared(known[i], known[j], limit)
        row = {"name": f"{known[i].name} and {known[j].name}", "gap": gap, "most": most, "all": wide, "found": found}
        rows.append({**row, "peer": bool(marks[i]) and marks[i] == marks[j]})
    return rows


def markdown(copies: list[dict[str, object]], near: list[dict[str, object]], far: list[dict[str, object]]) -> str:
    """Tables, and whether the targets are met."""
    has_peer = importlib.util.find_spec("trimesh") is not None
    lines = ["| made of a mesh | made | taken for it | trimesh's hash |", "|---|---|---|---|"]
    for rows in (copies, near):
        for kind in dict.fromkeys(str(r["kind"]) for r in rows):
            own = [r for r in rows if r["kind"] == kind]
            theirs = str(sum(bool(r.get("peer")) for r in own)) if has_peer else "not installed"
            lines.append(f"| {kind} | {len(own)} | {sum(bool(r['found']) for r in own)} | {theirs} |")
    wrong = [r for r in far if r["found"]]
    theirs = str(sum(bool(r["peer"]) for r in far)) if has_peer else "not installed"
    lines += [f"| nothing: pairs of different meshes | {len(far)} | {len(wrong)} | {theirs} |", ""]
    found = sum(bool(r["found"]) for r in copies)
    recall, precision = found / max(len(copies), 1), found / max(found + len(wrong), 1)
    for name, value, target in (("recall", recall, RECALL), ("precision", precision, PRECISION)):
        verdict = "pass" if value >= target else f"miss by {target - value:.3f}"
        lines.append(f"- {name}: {value:.3f}, target {target}: {verdict}")
    lines += [f"- taken for each other: {r['name']} (gap {r['gap']:.3f}, within {r['most']:.3f})" for r in wrong]
    lines += [f"- not found: {r['name']}, {r['kind']} ({_why(r)})" for r in copies if not r["found"]]
    lines += [f"- taken for it: {r['name']}, {r['kind']} ({_why(r)})" for r in near if r["found"]]
    return "\n".join(lines) + "\n"


def _why(row: dict[str, object]) -> str:
    if "gap" not in row:
        return str(row["message"])
    return f"gap {row['gap']:.3f}, within {row['most']:.3f}, nearly all within {row['all']:.3f}"


def main() -> None:
    """Run it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("../shared/data/dev"))
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--pairs", type=int, default=5000)
    parser.add_argument("--copies-of-every", type=int, default=1)
    parser.add_argument("--same", nargs="*", default=[])
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    asked = parser.parse_args()
    limit = registry.load().limits["alike_form"]
    begin = time.process_time()
    known = list(gather(asked.folder, asked.every))
    read_s = time.process_time() - begin
    far = strangers(known, asked.pairs, limit)
    pairs_s = time.process_time() - begin - read_s
    tried = sum(float(str(r["most"])) < 2.0 for r in far)
    really = [r for r in far if str(r["name"]).replace(" and ", "=") in asked.same]
    some, text = known[:: asked.copies_of_every], ""
    copies: list[dict[str, object]] = []
    near: list[dict[str, object]] = []
    for number, one in enumerate(some):  # written anew after each, so that a run that is stopped leaves what it has
        copies += trial(one, number, COPIES, limit)
        near += trial(one, number, OTHERS, limit)
        text = markdown(copies, near, [r for r in far if r not in really])
        text += "".join(f"- one mesh in two prints, left out: {r['name']} (within {r['most']:.3f})\n" for r in really)
        text += (
            f"- copies of {number + 1} of {len(known)} meshes; {read_s:.0f} s of the processor to read and sign all, "
        )
        text += f"{pairs_s:.0f} s to compare {len(far)} pairs, of which {tried} were laid over each other\n"
        dump(asked.out / "ingest_duplicates.json", {"copies": copies, "stretched": near, "pairs": far})
        (asked.out / "ingest_duplicates.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
