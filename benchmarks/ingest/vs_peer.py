"""Our ingest against obj2mjcf 0.0.25, one convex hull and V-HACD, on the same meshes, in the same run.

    ./dev bench ingest_vs_peer [folder of meshes] [--every 5] [--timeout 120]

Writes out/bench/ingest_vs_peer.json and .md, and prints the latter. The peer reads OBJ only and neither cleans, turns
nor scales; it is handed each mesh cleaned, upright and in metres, so what is compared are collision shapes and mass.
Our time is that of everything from the raw file to a published folder (USD, picture and all checks included); the
peer's is that of its process. One input at a time; every tool may use every core.
"""

from __future__ import annotations

import argparse
import os
import platform
import statistics
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.ingest.judging import inputs, tools
from benchmarks.ingest.judging.inputs import Input
from benchmarks.ingest.judging.shapes import Fit, fit

OURS, PEER, HULL, VHACD = "casa_assets", f"{tools.PEER} {tools.PEER_VERSION}", "one hull", "V-HACD"


@dataclass(frozen=True)
class Row:
    """One tool on one input."""

    path: str
    category: str
    tool: str
    accepted: bool
    seconds: float
    message: str = ""
    shapes: int | None = None
    hull_vertices: int | None = None
    volume_ratio: float | None = None
    bare_p95_mm: float | None = None
    bare_max_mm: float | None = None
    phantom_p95_mm: float | None = None
    phantom_max_mm: float | None = None
    mass_ratio: float | None = None


# column, head, digits, and what a worse value is: larger, or farther from 1
COLUMNS: tuple[tuple[str, str, int, Callable[[float], float]], ...] = (
    ("seconds", "s", 1, float),
    ("shapes", "shapes", 0, float),
    ("hull_vertices", "most vertices", 0, float),
    ("volume_ratio", "volume / mesh", 2, lambda v: abs(v - 1)),
    ("bare_p95_mm", "bare p95 mm", 2, float),
    ("bare_max_mm", "bare max mm", 1, float),
    ("phantom_p95_mm", "phantom p95 mm", 2, float),
    ("phantom_max_mm", "phantom max mm", 1, float),
    ("mass_ratio", "mass / truth", 2, lambda v: abs(v - 1)),
)
LEGEND = """
volume / mesh: union of the collision shapes over the closed mesh. bare: how far points of the mesh lie outside the
shapes. phantom: how far points of the outer surface of the shapes lie from the mesh, which is what a filled opening or
a thickened wall costs. mass / truth: what MuJoCo compiles over volume times density, for closed meshes of things that
are matter all through; the density is that of the substance for ours, 1000 kg/m^3 for the others. most vertices: of a
hull; 0 where all shapes are primitives.
"""


def judge(item: Input, tool: str, run: tools.Tool) -> Row:
    """Run a tool on an input and measure what comes out."""
    answer = run(item)
    row = Row(item.path, item.category, tool, answer.shapes is not None, round(answer.seconds, 2), answer.message)
    if answer.shapes is None or item.mesh is None:
        return row
    truth = item.volume * answer.density if item.volume and item.full else None
    found = fit(answer.shapes, item.mesh, item.volume)
    measured = asdict(found) if isinstance(found, Fit) else {}
    return Row(
        **{
            **asdict(row),
            **{k: None if v is None else float(f"{v:.4g}") for k, v in measured.items()},
            "shapes": len(answer.shapes.clouds),
            "hull_vertices": answer.shapes.hull_vertices,
            "mass_ratio": None if truth is None else float(f"{answer.shapes.mass / truth:.4g}"),
        }
    )


def report(rows: Sequence[Row], folder: str, note: str) -> str:
    """Markdown: machine, totals, where we are worse, and every asset."""
    names = list(dict.fromkeys(r.tool for r in rows))
    count = len({r.path for r in rows})
    lines = ["# Ingest against a peer", "", f"{count} inputs of `{folder}`, one at a time. {machine()}", ""]
    lines += [note, ""] if note else []
    lines += ["## Totals", "", *totals(rows, names), *LEGEND.splitlines(), "", "## Where we are worse", ""]
    lines += [*worse(rows, names), "", "## Every input", ""]
    heads = ["input", "tool", *(head for _, head, _, _ in COLUMNS), "message"]
    lines += [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for r in rows:
        cells = [_text(getattr(r, name), digits) for name, _, digits, _ in COLUMNS]
        lines.append(f"| {r.path} | {r.tool} | {' | '.join(cells)} | {r.message.replace('|', '/')} |")
    return "\n".join(lines) + "\n"


def totals(rows: Sequence[Row], names: Sequence[str]) -> list[str]:
    """One line per tool: accepted, failed, time, and medians over the inputs that every tool took."""
    taken = [{r.path for r in rows if r.tool == name and r.accepted} for name in names]
    common = set.intersection(*taken)
    heads = [f"median {head}" for name, head, _, _ in COLUMNS if name not in ("seconds", "hull_vertices")]
    lines = [f"Medians are over the {len(common)} inputs that every tool took.", ""]
    heads = ["tool", "accepted", "failed", "total s", "median s", "most vertices of all", *heads]
    lines += [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for name in names:
        mine = [r for r in rows if r.tool == name]
        good = [r for r in mine if r.accepted]
        times = [r.seconds for r in good]
        cells = [name, str(len(good)), str(len(mine) - len(good)), _text(sum(r.seconds for r in mine), 0)]
        cells += [_text(statistics.median(times) if times else None, 1)]
        cells += [str(max((r.hull_vertices or 0 for r in good), default=0))]
        for column, _, digits, _ in COLUMNS:
            if column in ("seconds", "hull_vertices"):
                continue
            values = [v for r in good if r.path in common and (v := getattr(r, column)) is not None]
            cells.append(_text(statistics.median(values) if values else None, digits))
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def worse(rows: Sequence[Row], names: Sequence[str]) -> list[str]:
    """On how many of the inputs that both took each other tool beats ours, column by column, and the worst of them."""
    ours = {r.path: r for r in rows if r.tool == OURS and r.accepted}
    lines = []
    for name in names:
        if name == OURS:
            continue
        theirs = {r.path: r for r in rows if r.tool == name and r.accepted}
        missed = sorted(theirs.keys() - ours.keys())
        if missed:
            lines.append(f"- {name} took {len(missed)} that we rejected: {', '.join(missed[:5])}")
        for column, head, digits, badness in COLUMNS:
            pairs = [(getattr(ours[p], column), getattr(theirs[p], column), p) for p in ours.keys() & theirs.keys()]
            pairs = [t for t in pairs if t[0] is not None and t[1] is not None]
            lost = [t for t in pairs if badness(t[0]) > badness(t[1])]
            if lost:
                mine, other, path = max(lost, key=lambda t: (badness(t[0]) - badness(t[1]), t[2]))
                values = f"{_text(mine, digits)} against {_text(other, digits)}"
                lines.append(f"- {head}: {name} is better on {len(lost)} of {len(pairs)}, most on {path} ({values})")
    return lines


def machine() -> str:
    """What it ran on, in words."""
    cores = len(os.sched_getaffinity(0))
    return f"Machine: {platform.machine()}, {cores} cores, Python {platform.python_version()}."


def _text(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"


def main() -> None:
    """Parse, run, write, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("examples/meshes"), help="meshes")
    parser.add_argument("--every", type=int, default=1, help="only every n-th input")
    parser.add_argument("--timeout", type=float, default=120.0, help="seconds for one tool on one input")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="where results and environments go")
    parser.add_argument("--without-peer", action="store_true", help="leave obj2mjcf out")
    given = parser.parse_args()
    out = given.out.absolute()
    out.mkdir(parents=True, exist_ok=True)
    trouble = "left out as asked" if given.without_peer else tools.install_peer(out / f"venv_{tools.PEER}")
    note = f"**{PEER} is missing from this run**: {trouble}" if trouble else ""
    verdicts = tools.ingested(given.folder, out / "library", given.timeout)
    runs: dict[str, tools.Tool] = {OURS: tools.ours(verdicts)}
    if not trouble:
        runs[PEER] = tools.peer(out / f"venv_{tools.PEER}", out / tools.PEER, given.timeout)
    runs |= {HULL: tools.one_hull, VHACD: tools.vhacd}
    rows = []
    for item in inputs.gather(given.folder, given.every, {path: v.category for path, v in verdicts.items()}):
        for name, run in runs.items():
            rows.append(judge(item, name, run))
            print(f"{item.path}: {name}: {rows[-1].seconds:.1f} s {rows[-1].message}", flush=True)
    inputs.dump(out / "ingest_vs_peer.json", {"machine": machine(), "rows": [asdict(r) for r in rows]})
    text = report(rows, given.folder.as_posix(), note)
    (out / "ingest_vs_peer.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
