"""Collision shapes of ingest against CoACD as obj2mjcf 0.0.25 calls it and V-HACD, on the same meshes, in the same run.

    ./dev bench ingest_collision [folders of meshes] [--limit 20] [--every 6] [--only mug bowl]
                                 [--peers coacd=4 vhacd=20]

Writes out/bench/ingest_collision.json and .md, and prints the latter: a page for each folder. All tools get the mesh as
our stages leave it before collision: clean, upright, metres. One input at a time, each in a process; seconds are those
of the processor, children included, so that a busy machine changes nothing. Ours includes deciding that one shape is
enough, making open meshes solid and measuring the result. CoACD runs as obj2mjcf calls it.
"""

from __future__ import annotations

import argparse
import itertools
import multiprocessing
import os
import platform
import resource
import statistics
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from benchmarks.ingest import peer_coacd
from benchmarks.ingest.collision_fit import Truth, fit, truth
from benchmarks.ingest.inputs import Prepared, prepared, publish
from casa_assets.core.numeric import Floats
from casa_assets.errors import CasaError
from casa_assets.ingest.collision.collide import collide
from casa_assets.ingest.collision.decompose import Budget, DecompositionFailed, decompose
from casa_assets.ingest.collision.fit import CollideParams
from casa_assets.ingest.draft import PlacedShape
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.solid.solids import convex_hull, hull_volume
from casa_assets.model.asset.parts import Hull, Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.registry.category import MatterFill

# Report ---------------------------------------------------------------------------------------------------------------

OURS, COACD, VHACD = "casa_assets", "CoACD as in obj2mjcf 0.0.25", "V-HACD, 32 hulls"
# What the project promises: surface within max(2 mm, 1.5 % of the longest side) for 95 % and 5 % at worst.
P95_MM, P95_RATIO, WORST_RATIO, MOST_SHAPES = 2.0, 0.015, 0.05, 32


@dataclass(frozen=True)
class Row:
    """One tool on one input; lengths in mm, None where it cannot be said."""

    path: str
    category: str
    build: str
    tool: str
    seconds: float
    memory_mb: int = 0
    longest_mm: float = 0.0
    message: str = ""
    shapes: int | None = None
    kinds: str = ""
    hull_vertices: int | None = None
    volume_ratio: float | None = None
    iou: float | None = None
    bare_p95_mm: float | None = None
    bare_max_mm: float | None = None
    phantom_p95_mm: float | None = None
    phantom_max_mm: float | None = None
    kept: float | None = None
    held: float | None = None
    closed: float | None = None
    folder: str = ""

    @property
    def is_close(self) -> bool:
        """Within the promised distances with few enough shapes."""
        near = [self.bare_p95_mm, self.phantom_p95_mm]
        worst = [self.bare_max_mm, self.phantom_max_mm]
        if self.shapes is None or self.shapes > MOST_SHAPES:
            return False
        limit = max(P95_MM, P95_RATIO * self.longest_mm)
        return all(v is not None and v <= limit for v in near) and all(
            v is not None and v <= WORST_RATIO * self.longest_mm for v in worst
        )


def report(rows: Sequence[Row], folder: str) -> str:
    """Markdown: machine, totals, every asset, and how they were judged."""
    tools = list(dict.fromkeys(r.tool for r in rows))
    machine = (
        f"Machine: {platform.machine()}, {len(os.sched_getaffinity(0))} cores, Python {platform.python_version()}."
    )
    lines = ["# Collision shapes", "", f"{len({r.path for r in rows})} inputs of `{folder}`. {machine}", ""]
    lines += [*LEGEND.strip().splitlines(), "", "## Totals", "", *totals(rows, tools), "", *against(rows, tools)]
    heads = ["input", "category", "tool", *(head for _, head, _ in COLUMNS), "close", "message"]
    lines += ["## Every input", "", f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for r in rows:
        cells = [_text(getattr(r, name), digits) for name, _, digits in COLUMNS]
        message = r.message.replace("|", "/")
        lines.append(
            f"| {r.path} | {r.category} | {r.tool} | {' | '.join(cells)} | {'yes' if r.is_close else ''} | {message} |"
        )
    return "\n".join(lines) + "\n"


COLUMNS: tuple[tuple[str, str, int], ...] = (
    ("seconds", "CPU s", 1),
    ("shapes", "shapes", 0),
    ("kinds", "kinds", 0),
    ("hull_vertices", "vertices", 0),
    ("volume_ratio", "volume", 2),
    ("iou", "IoU", 2),
    ("bare_p95_mm", "mesh p95 mm", 2),
    ("bare_max_mm", "mesh max mm", 1),
    ("phantom_p95_mm", "shapes p95 mm", 2),
    ("phantom_max_mm", "shapes max mm", 1),
    ("kept", "open", 2),
    ("held", "holds", 2),
    ("closed", "room closed", 2),
)
LEGEND = """
volume: union of the shapes over the closed mesh. IoU: of the two. mesh: distance of the outer surface of the mesh to
that of the shapes. shapes: distance of the outer surface of the shapes to the mesh. What is outer is told on cubes of
1/66 of the longest side: a gap narrower than the promised 1.5 % is closed, for the mesh and the shapes of every tool.
open: share of the room that would hold water which no shape fills. holds: share of it that holds water in the shapes,
too. room closed: largest share of an open room (what a ball gets into from above or beside, water or not) that shapes
fill or close off, as AST018 measures it. vertices: of the largest hull. close: within the promised distances, with 32
shapes at most.
"""


def totals(rows: Sequence[Row], tools: Sequence[str]) -> list[str]:
    """One line per tool: medians over the inputs that every tool took."""
    common = set.intersection(*({r.path for r in rows if r.tool == t and r.shapes} for t in tools))
    numbers = [c for c in COLUMNS if c[0] != "kinds"]
    heads = ["tool", "took", "failed", "p95 CPU s", "most MB", *(f"median {head}" for _, head, _ in numbers)]
    lines = [f"Medians are over the {len(common)} inputs that every tool took.", ""]
    lines += [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for tool in tools:
        mine = [r for r in rows if r.tool == tool]
        good = [r for r in mine if r.shapes]
        times = np.percentile([r.seconds for r in mine], 95)
        cells = [tool, str(len(good)), str(len(mine) - len(good)), f"{times:.1f}", str(max(r.memory_mb for r in mine))]
        for name, _, digits in numbers:
            values = [v for r in good if r.path in common and (v := getattr(r, name)) is not None]
            cells.append(_text(statistics.median(values) if values else None, digits))
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def against(rows: Sequence[Row], tools: Sequence[str]) -> list[str]:
    """Seconds and IoU of the other tools over ours, where both can be said."""
    mine = {r.path: r for r in rows if r.tool == OURS and r.shapes}
    lines = ["## Against each other", ""]
    for tool in tools:
        pairs = [(mine[r.path], r) for r in rows if r.tool == tool != OURS and r.path in mine and r.shapes]
        if pairs:
            pace = statistics.median(b.seconds / max(a.seconds, 0.01) for a, b in pairs)
            better = [(a.iou, b.iou) for a, b in pairs if a.iou is not None and b.iou is not None]
            words = f"- {tool}: {pace:.1f} times our CPU seconds (median of {len(pairs)})"
            if better:
                least = sum(a >= b - 0.005 for a, b in better)
                words += f"; our IoU is equal or better on {least} of {len(better)}"
            lines.append(words)
    return [*lines, ""] if len(lines) > 2 else []


def _text(value: float | str | None, digits: int) -> str:
    return "" if value is None else value if isinstance(value, str) else f"{value:.{digits}f}"


# Tools ----------------------------------------------------------------------------------------------------------------


ROUND_STEPS = 96  # a cylinder so drawn lacks 0.07 % of its volume
ROUNDS = 4  # a run that is stopped has seen inputs from all over the folder
DEATH_S = 900  # wall seconds after which a process is given up; CPU limits come first

Tool = Callable[[Prepared, int], tuple[list[PlacedShape], str]]


def ours(item: Prepared, _: int) -> tuple[list[PlacedShape], str]:
    """The stage of ingest."""
    out = collide(item.draft, item.category, CollideParams())
    return list(out.colliders), out.guesses[-1].value


def coacd(item: Prepared, cpu_s: int) -> tuple[list[PlacedShape], str]:
    """CoACD with obj2mjcf's defaults; it sets no limit to the vertices of a hull."""
    clouds, message = peer_coacd.run(*item.mesh, cpu_s)
    return _placed(clouds), message


def vhacd(item: Prepared, cpu_s: int) -> tuple[list[PlacedShape], str]:
    """V-HACD of everything at once: 32 hulls of 64 vertices, 400,000 voxels."""
    try:
        return _placed(decompose("vhacd", *item.mesh, Budget(hulls=32, hull_vertices=64, cpu_s=cpu_s))), ""
    except DecompositionFailed as error:
        return [], str(error)


TOOLS: dict[str, tuple[str, Tool]] = {
    "ours": (OURS, ours),
    "coacd": (COACD, coacd),
    "vhacd": (VHACD, vhacd),
}


def _placed(clouds: Sequence[Floats]) -> list[PlacedShape]:
    hulls = [convex_hull(cloud) for cloud in clouds if hull_volume(cloud) > 0]
    # Hulls of more vertices than the model allows are measured as they are.
    shapes = [Hull.model_construct(mesh=Mesh(vertices=points, faces=faces)) for points, faces in hulls]
    return [PlacedShape.model_construct(shape=shape, pose=Pose()) for shape in shapes]


def judged(item: Prepared, names: Sequence[str], cpu_s: int) -> Iterator[Row]:
    """Every tool on an input, as each is done: a process's peak of memory never goes down again."""
    full = item.category.build in (MatterFill.SOLID, MatterFill.FILLED)
    of = truth(item.mesh, full)
    for name in names:
        title, tool = TOOLS[name]
        before = _cpu()
        try:
            shapes, message = tool(item, cpu_s)
        except CasaError as error:
            shapes, message = [], str(error)
        seconds = _cpu() - before
        base = Row(item.path, item.category.id, item.category.build.value, title, round(seconds, 2))
        yield _row(base, shapes, of, message)


def _row(base: Row, shapes: list[PlacedShape], of: Truth, message: str) -> Row:
    hulls = [len(s.shape.mesh.vertices) for s in shapes if isinstance(s.shape, Hull)]
    measured = fit([tessellate(s.shape, s.pose, ROUND_STEPS)[0] for s in shapes], of) if shapes else None
    numbers = {} if measured is None else asdict(measured)
    return Row(
        **{
            **asdict(base),
            **{k: None if v is None else float(f"{v:.4g}") for k, v in numbers.items()},
            "longest_mm": round(1000 * of.longest, 1),
            "message": message,
            "shapes": len(shapes) if measured is not None else None,
            "kinds": " ".join(sorted({s.shape.kind for s in shapes})),
            "hull_vertices": max(hulls, default=0),
        }
    )


def _cpu() -> float:
    now = os.times()
    return now.user + now.system + now.children_user + now.children_system


def _child(item: Prepared, names: Sequence[str], cpu_s: int, answer: Connection) -> None:
    rows = []
    for row in judged(item, names, cpu_s):
        own, others = (resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        rows.append(replace(row, memory_mb=max(own, others) // 1024))
    answer.send(rows)


def apart(item: Prepared, names: Sequence[str], cpu_s: int) -> list[Row]:
    """`judged` in a process of its own; what kills it is said in the rows."""
    here, there = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.Process(target=_child, args=(item, names, cpu_s, there))
    child.start()
    there.close()
    try:
        if here.poll(DEATH_S):
            rows: list[Row] = here.recv()
            return rows
        message = f"still running after {DEATH_S} s"
        child.kill()
    except EOFError:
        message = "its process died"
    finally:
        child.join()
    base = (item.path, item.category.id, item.category.build.value)
    return [Row(*base, TOOLS[name][0], 0.0, message=f"{message} ({child.exitcode})") for name in names]


def main() -> None:
    """Parse, run, write, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="*", default=[Path("examples/meshes")], help="meshes")
    parser.add_argument("--every", type=int, default=1, help="only every n-th input")
    parser.add_argument("--limit", type=int, default=None, help="only so many inputs of each folder")
    parser.add_argument("--only", nargs="*", default=[], help="only inputs of these categories")
    parser.add_argument("--peers", nargs="*", default=["coacd", "vhacd"], help="others; NAME=8: on the first 8 inputs")
    parser.add_argument("--cpu", type=int, default=120, help="CPU seconds for a peer on one input")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="where results go")
    given = parser.parse_args()
    most = dict(_counted(word) for word in given.peers)
    rows: list[Row] = []
    for folder in given.folders:
        inputs = prepared(folder, given.every, given.only, ROUNDS)
        for number, item in enumerate(itertools.islice(inputs, given.limit)):
            names = ["ours", *(n for n, count in most.items() if number < count)]
            for row in apart(item, names, given.cpu):
                rows.append(replace(row, folder=folder.as_posix()))
                print(f"{row.path}: {row.tool}: {row.seconds:.1f} s, {row.shapes} shapes, IoU {row.iou} {row.message}")
    folders = dict.fromkeys(r.folder for r in rows)
    text = "\n".join(report([r for r in rows if r.folder == folder], folder) for folder in folders)
    publish(given.out / "ingest_collision", [asdict(r) for r in rows], text)


def _counted(word: str) -> tuple[str, float]:
    """Name and number of inputs of a word such as coacd=4; raises KeyError for a tool that there is not."""
    name, _, count = word.partition("=")
    return name if name in TOOLS else TOOLS[name][0], float(count or "inf")


if __name__ == "__main__":
    main()
