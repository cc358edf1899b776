"""Rows of the collision benchmark, and the page that is made of them."""

from __future__ import annotations

import os
import platform
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

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
    far = [r for r in rows if r.tool == OURS and not r.is_close]
    lines += ["## Farther off than promised", "", *(_far(r) for r in far), ""] if far else []
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


def _far(row: Row) -> str:
    """One line about an input that is farther off than promised: by how much."""
    if row.bare_p95_mm is None or row.phantom_p95_mm is None or row.bare_max_mm is None or row.phantom_max_mm is None:
        return f"- {row.path} ({row.category}): {row.message}"
    near, worst = max(P95_MM, P95_RATIO * row.longest_mm), WORST_RATIO * row.longest_mm
    p95, most = max(row.bare_p95_mm, row.phantom_p95_mm), max(row.bare_max_mm, row.phantom_max_mm)
    words = f"95 % within {p95:.1f} mm of {near:.1f}, worst {most:.1f} mm of {worst:.1f}"
    return f"- {row.path} ({row.category}): {words}; {row.shapes} shapes, {row.message}"


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
