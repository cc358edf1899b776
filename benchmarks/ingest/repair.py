"""What is wrong with meshes as they come, what our repair changes of it, and what trimesh's process and repair do.

    ./dev bench ingest_repair [folder of meshes ...] [--every 4]

Writes out/bench/ingest_repair.json and .md, and prints the latter. A folder with an index.json (a set of broken files)
contributes its rows of the class `geometry`. Both tools are handed the triangles as our readers leave them, and what
they make is measured by the same arithmetic, which no repair uses; trimesh gets all parts in one, and its normals,
textures and colours are not looked at. Seconds are those of the processor.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.ingest.inputs import publish
from casa_assets import registry
from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.ingest.clean import clean
from casa_assets.ingest.draft import Draft, merge_parts
from casa_assets.ingest.run.inputs import find_category
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found
from casa_assets.mesh.solid.deviation import measure_visibility
from casa_assets.mesh.surface import edge_counts, face_components, face_normals, weld
from casa_assets.model.source import RawModel

# Soundness ------------------------------------------------------------------------------------------------------------

Surface = tuple[Floats, Ints]

# What floats: a piece this small beside the largest one, and this far from everything else, as parts of the largest.
SPECK, APART = 0.05, 0.03
# Points for saying which side of a surface is seen.
STREWN = 20_000


@dataclass(frozen=True)
class Soundness:
    """Numbers of one surface.

    Attributes:
        faces: their number. closed: every edge has two faces, once each way. open_edges, fins: edges with one face, and
            with more than two. broken: faces without area, or named twice the same way round.
        agree: share of the edges of two faces that run both ways. front: share of what shows only one of its sides that
            shows its front.
        pieces, floating: connected pieces, and small ones that touch nothing. longest: side of the box around it.
    """

    faces: int
    closed: bool
    open_edges: int
    fins: int
    broken: int
    agree: float
    front: float
    pieces: int
    floating: int
    longest: float


def soundness(surface: Surface) -> Soundness:
    """Measure a surface; vertices at one place are one point."""
    vertices, faces = surface
    points, place = weld(vertices)
    ids = place[faces]
    _, areas = face_normals(points, ids)
    longest = float(np.ptp(vertices[faces].reshape(-1, 3), axis=0).max())
    whole = areas > (1e-7 * longest) ** 2
    turn = (np.argmin(ids, axis=1)[:, None] + np.arange(3)) % 3
    doubled = len(ids) - len(np.unique(np.take_along_axis(ids, turn, axis=1), axis=0))
    ids = ids[whole]
    _, uses, balance = edge_counts(ids)
    two = uses == 2
    label = face_components(ids, len(points))
    found = measure_visibility(points, ids, STREWN)
    shown = found.front ^ found.back
    return Soundness(
        faces=len(faces),
        closed=bool(two.all() and (balance == 0).all()),
        open_edges=int((uses == 1).sum()),
        fins=int((uses > 2).sum()),
        broken=int((~whole).sum()) + doubled,
        agree=float((balance[two] == 0).mean()) if two.any() else 1.0,
        front=float((found.front & ~found.back).sum() / shown.sum()) if shown.any() else 1.0,
        pieces=int(label.max()) + 1,
        floating=_floating(points, ids, label),
        longest=longest,
    )


def _floating(points: Floats, ids: Ints, label: Ints) -> int:
    """Small pieces of which no corner comes near the corners, edges or faces of another piece."""
    count = int(label.max()) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, label, points[ids].min(axis=1))
    np.maximum.at(high, label, points[ids].max(axis=1))
    size = (high - low).max(axis=1)
    if count == 1 or count > 3000:
        return 0
    floating = 0
    mids = points[ids].mean(axis=1)
    for piece in np.flatnonzero(size < SPECK * size.max()):
        others = label != piece
        cloud = np.concatenate([points[np.unique(ids[others])], mids[others]])
        gap = float(cKDTree(cloud).query(points[np.unique(ids[~others])])[0].min())
        floating += gap > max(APART * float(size.max()), 3 * float(size[piece]))
    return floating


def trimesh_repaired(surface: Surface) -> tuple[Surface, float]:
    """What trimesh's own cleaning and repair make of a surface, and the CPU seconds it took."""
    import trimesh

    vertices, faces = surface
    before = time.process_time()
    mesh = trimesh.Trimesh(vertices=vertices.copy(), faces=faces.copy(), process=True)
    mesh.update_faces(mesh.unique_faces() & mesh.nondegenerate_faces())
    mesh.remove_unreferenced_vertices()
    trimesh.repair.fix_normals(mesh, multibody=True)
    trimesh.repair.fill_holes(mesh)
    seconds = time.process_time() - before
    return (np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)), seconds


# Report ---------------------------------------------------------------------------------------------------------------

OURS, THEIRS = "casa_assets", "trimesh process + repair"


@dataclass(frozen=True)
class Row:
    """One input: what it was, what both tools made of it, and what ours said.

    Attributes:
        same: our vertices and faces are those of the file, bit for bit.
        notes: codes of what was repaired or remarked. solidity: what it is, with the numbers.
        refused: why nothing was made of it.
    """

    path: str
    category: str
    before: Soundness | None = None
    ours: Soundness | None = None
    theirs: Soundness | None = None
    seconds: float = 0.0
    their_seconds: float = 0.0
    same: bool = False
    notes: tuple[str, ...] = ()
    message: tuple[str, ...] = ()
    solidity: str = ""
    refused: str = ""
    their_refusal: str = ""


# Walls as thin as a pixel of what is seen show their inner side here and there.
FRONT = 0.95
# Head, what is added up over the inputs, and how it is written.
SUMS: tuple[tuple[str, Callable[[Soundness], float], str], ...] = (
    ("inputs with a closed surface", lambda s: s.closed, ".0f"),
    ("open edges", lambda s: s.open_edges, ".0f"),
    ("edges of more than two faces", lambda s: s.fins, ".0f"),
    ("faces without area, or doubled", lambda s: s.broken, ".0f"),
    ("inputs whose faces all wind one way", lambda s: s.agree == 1.0, ".0f"),
    ("inputs of which 95 % of what shows one side shows its front", lambda s: s.front > FRONT, ".0f"),
    ("pieces that float", lambda s: s.floating, ".0f"),
    ("faces", lambda s: s.faces, ".0f"),
)


def report(sets: Mapping[str, Sequence[Row]]) -> str:
    """Markdown: machine, totals by set, what was found, and every input."""
    machine = f"{platform.machine()}, {len(os.sched_getaffinity(0))} cores, Python {platform.python_version()}"
    lines = ["# Repair of meshes", "", f"Machine: {machine}.", ""]
    for name, rows in sets.items():
        lines += [f"## {name}: {len(rows)} inputs", "", *totals(rows), "", *remarks(rows), ""]
    lines += ["## Every input", "", *every([r for rows in sets.values() for r in rows])]
    return "\n".join(lines) + "\n"


def totals(rows: Sequence[Row]) -> list[str]:
    """What was wrong before and after, over the inputs that both tools took."""
    both = [r for r in rows if r.before and r.ours and r.theirs]
    lines = [
        f"Over the {len(both)} inputs that both tools took:",
        "",
        f"| | before | {OURS} | {THEIRS} |",
        "|---|---|---|---|",
    ]
    for head, number, form in SUMS:
        cells = [
            format(sum(number(s) for r in both if (s := getattr(r, k))), form) for k in ("before", "ours", "theirs")
        ]
        lines.append(f"| {head} | {' | '.join(cells)} |")
    if both:
        for head, pick in (("median", statistics.median), ("most", max)):
            lines.append(
                f"| CPU s, {head} | | {pick(r.seconds for r in both):.2f} | {pick(r.their_seconds for r in both):.2f} |"
            )
    sound = [r for r in both if r.before and _is_sound(r.before)]
    lines += ["", f"Sound before: {len(sound)}; untouched by ours, bit for bit: {sum(r.same for r in sound)}."]
    harmed = [r.path for r in both if _worse(r)]
    lines.append(f"Less sound after ours than before: {len(harmed)}{': ' + ', '.join(harmed) if harmed else ''}.")
    return lines


def _is_sound(s: Soundness) -> bool:
    return s.closed and not s.broken and not s.floating and s.agree == 1.0 and s.front > FRONT


def _worse(row: Row) -> bool:
    a, b = row.before, row.ours
    return bool(
        a
        and b
        and (
            (a.closed and not b.closed)
            or b.open_edges > a.open_edges
            or b.broken > a.broken
            or b.agree < a.agree
            or (b.front < a.front - 0.05 and not {"MSH012", "MSH013"} & set(row.notes))
            or b.floating > a.floating
        )
    )


def remarks(rows: Sequence[Row]) -> list[str]:
    """How many inputs got which note, what kind they are, and which were refused."""
    codes = Counter(code for r in rows for code in set(r.notes))
    kinds = Counter(r.solidity.split(":")[0] for r in rows if r.solidity)
    refused = Counter(r.refused.split(" ")[0] for r in rows if r.refused)
    lines = ["Notes: " + (", ".join(f"{c} on {n}" for c, n in sorted(codes.items())) or "none") + "."]
    lines.append("Solidity: " + ", ".join(f"{k} {n}" for k, n in sorted(kinds.items())) + ".")
    if refused:
        lines.append("Refused: " + ", ".join(f"{c} {n}" for c, n in sorted(refused.items())) + ".")
    lost = [f"{r.path} ({r.their_refusal})" for r in rows if r.their_refusal]
    if lost:
        lines.append(f"{THEIRS} failed on: {'; '.join(lost)}.")
    return lines


def every(rows: Sequence[Row]) -> list[str]:
    """One line per input that is not sound and untouched."""
    heads = [
        "input",
        "open edges",
        "fins",
        "broken",
        "wind one way",
        "front",
        "pieces",
        "floating",
        "solidity",
        "message",
    ]
    lines = ["Numbers are before > ours > trimesh.", "", f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for r in rows:
        if r.refused:
            lines.append(f"| {r.path} |{' |' * 8} refused: {r.refused.replace('|', '/')} |")
            continue
        three = [r.before, r.ours, r.theirs]
        cells = [
            " > ".join("-" if s is None else format(getattr(s, name), form) for s in three)
            for name, form in (
                ("open_edges", "d"),
                ("fins", "d"),
                ("broken", "d"),
                ("agree", ".3f"),
                ("front", ".3f"),
                ("pieces", "d"),
                ("floating", "d"),
            )
        ]
        message = "; ".join(r.message).replace("|", "/") or "untouched"
        lines.append(f"| {r.path} | {' | '.join(cells)} | {r.solidity} | {message} |")
    return lines


# Measure --------------------------------------------------------------------------------------------------------------


def found_in(folder: Path) -> Iterator[Found]:
    """The inputs of a folder; of a set of broken files those whose geometry is broken."""
    index = folder / "index.json"
    paths = [folder]
    if index.is_file():
        rows = json.loads(index.read_text(encoding="utf-8"))
        paths = [folder / row["file"] for row in rows if row["cls"] == "geometry"]
    for path in paths:
        yield from (f for f in discover([path]) if isinstance(f, Found))


def judged(one: Found) -> Row:
    """Both tools on one input."""
    known = registry.load()
    category = known.category(find_category(one, "")[0].id)
    path, name = one.source.path, category.id
    limits = {**known.limits, "input_texture_pixels": 1.0}
    try:
        model = load(collect(one, limits), limits)
    except Rejected as error:
        return Row(path, name, refused=f"{error.code} {error.message}")
    start = time.process_time()
    try:
        draft = clean(model, category)
    except Rejected as error:
        return Row(path, name, refused=f"{error.code} {error.message}")
    seconds = time.process_time() - start
    raw = merge_parts(model.parts)
    surface = raw.vertices, raw.faces
    theirs, their_seconds, their_refusal = _theirs(surface)
    own = [n for n in draft.notes if n.code.startswith("MSH")]
    guess = next(g for g in draft.guesses if g.subject == "solidity")
    return Row(
        path,
        name,
        before=soundness(surface),
        ours=soundness((draft.surface.vertices, draft.surface.faces)),
        theirs=theirs,
        seconds=round(seconds, 3),
        their_seconds=round(their_seconds, 3),
        same=_is_same(model, draft),
        notes=tuple(n.code for n in own),
        message=tuple(n.message for n in own),
        solidity=f"{guess.value}: {guess.reason}",
        their_refusal=their_refusal,
    )


def _theirs(surface: Surface) -> tuple[Soundness | None, float, str]:
    try:
        repaired, seconds = trimesh_repaired(surface)
        return (
            (soundness(repaired) if len(repaired[1]) else None),
            seconds,
            "" if len(repaired[1]) else "nothing is left",
        )
    except Exception as error:  # noqa: BLE001 - whatever the peer fails with is its result
        return None, 0.0, f"{type(error).__name__}: {error}"[:120]


def _is_same(model: RawModel, draft: Draft) -> bool:
    return len(model.parts) == len(draft.parts) and all(
        a.mesh.vertices.tobytes() == b.mesh.vertices.tobytes() and a.mesh.faces.tobytes() == b.mesh.faces.tobytes()
        for a, b in zip(model.parts, draft.parts, strict=True)
    )


def main() -> None:
    """Parse, run, write, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="*", default=[Path("examples/meshes")], help="meshes")
    parser.add_argument("--every", type=int, default=1, help="only every n-th input")
    parser.add_argument("--only", default="", help="only inputs with this in their path")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="where results go")
    given = parser.parse_args()
    rows: list[Row] = []
    sets: Sequence[tuple[Path, list[Found]]] = [(f, list(found_in(f))) for f in given.folders]
    by_set: dict[str, list[Row]] = {}
    for folder, inputs in sets:
        for one in [f for f in inputs if given.only in f.source.path][:: given.every]:
            row = judged(one)
            rows.append(row)
            by_set.setdefault(folder.name, []).append(row)
            print(f"{row.path}: {' '.join(row.notes) or row.refused or 'sound'} {row.seconds:.2f} s", flush=True)
    publish(given.out / "ingest_repair", [asdict(r) for r in rows], report(by_set))


if __name__ == "__main__":
    main()
