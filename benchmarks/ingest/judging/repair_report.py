"""The page that is made of the rows of the repair benchmark."""

from __future__ import annotations

import os
import platform
import statistics
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from benchmarks.ingest.judging.repair import Soundness

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
