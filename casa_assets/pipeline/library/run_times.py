"""Seconds that the stages of each entry took when it was last made, and what it cost, beside the library and not in it.

No entry holds a time: the same input gives the same bytes. They are kept in the cache, one JSON object a line, the last
line of an entry counts; deleting the file loses the times and nothing else.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from typing import Any

from casa_assets.pipeline.library import library as disk

NAME = "times.jsonl"
DIGITS = 4
MOST_LINES_PER_ENTRY = 3  # on average; with more the file is written anew


@dataclass(frozen=True)
class Cost:
    """What the work on one input took.

    Attributes:
        cpu_s: processor seconds, of all processes. peak_bytes: most memory at once, with what workers share.
        written_bytes: of its entry.
        clock_s: seconds of the clock, with what a busy machine made it wait.
    """

    cpu_s: float
    peak_bytes: int
    written_bytes: int
    clock_s: float


def keep_times(library: disk.Library, entry_id: str, seconds: Mapping[str, float], cost: Cost | None = None) -> None:
    """Add the seconds of an entry, by stage, and its cost. A file that cannot be written is no reason to stop a run."""
    if not seconds:
        return
    rounded = {stage: round(value, DIGITS) for stage, value in seconds.items()}
    if cost is not None:
        cost = replace(cost, cpu_s=round(cost.cpu_s, DIGITS), clock_s=round(cost.clock_s, DIGITS))
    with suppress(OSError):
        library.cache.mkdir(parents=True, exist_ok=True)
        with (library.cache / NAME).open("a", encoding="utf-8") as file:
            file.write(_line(entry_id, rounded, cost))


def tidy_times(library: disk.Library) -> None:
    """Leave one line for each entry where the file has grown by many runs; to be called where the library is locked."""
    path = library.cache / NAME
    known, costs = read_times(library), read_costs(library)
    with suppress(OSError, UnicodeDecodeError):
        with path.open(encoding="utf-8") as file:
            lines = sum(1 for _ in file)
        if lines <= MOST_LINES_PER_ENTRY * len(known):
            return
        fresh = path.with_name(f".{NAME}.{os.getpid()}")
        lines_kept = (_line(name, seconds, costs.get(name)) for name, seconds in known.items())
        fresh.write_text("".join(lines_kept), encoding="utf-8")
        fresh.replace(path)


def _line(entry_id: str, seconds: Mapping[str, float], cost: Cost | None) -> str:
    row: dict[str, Any] = {"id": entry_id, "seconds": seconds}
    return json.dumps(row if cost is None else {**row, "cost": asdict(cost)}) + "\n"


def read_times(library: disk.Library) -> dict[str, dict[str, float]]:
    """Seconds by stage of every entry that is known, by id; lines that a killed run left unfinished are passed over."""
    found: dict[str, dict[str, float]] = {}
    for row in _rows(library):
        with suppress(ValueError, KeyError, TypeError, AttributeError):
            found[str(row["id"])] = {str(stage): float(value) for stage, value in row["seconds"].items()}
    return found


def read_costs(library: disk.Library) -> dict[str, Cost]:
    """Cost of every entry whose last line tells one, by id."""
    found: dict[str, Cost] = {}
    for row in _rows(library):
        with suppress(ValueError, KeyError, TypeError, AttributeError):
            name = str(row["id"])
            found.pop(name, None)
            cost = row["cost"]
            found[name] = Cost(
                float(cost["cpu_s"]), int(cost["peak_bytes"]), int(cost["written_bytes"]), float(cost["clock_s"])
            )
    return found


def _rows(library: disk.Library) -> Iterator[Any]:
    with suppress(OSError, UnicodeDecodeError), (library.cache / NAME).open(encoding="utf-8") as file:
        for line in file:
            with suppress(ValueError):
                yield json.loads(line)
