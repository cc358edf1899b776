"""Seconds that the stages of each entry took when it was last made, beside the library and not in it.

No entry holds a time: the same input gives the same bytes. They are kept in the cache, one JSON object a line, the last
line of an entry counts; deleting the file loses the times and nothing else.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress

from casa_assets.pipeline.library import library as disk

NAME = "times.jsonl"
DIGITS = 4
MOST_LINES_PER_ENTRY = 3  # on average; with more the file is written anew


def keep_times(library: disk.Library, entry_id: str, seconds: Mapping[str, float]) -> None:
    """Add the seconds of an entry, by stage. A file that cannot be written is no reason to stop a run."""
    if not seconds:
        return
    rounded = {stage: round(value, DIGITS) for stage, value in seconds.items()}
    with suppress(OSError):
        library.cache.mkdir(parents=True, exist_ok=True)
        with (library.cache / NAME).open("a", encoding="utf-8") as file:
            file.write(_line(entry_id, rounded))


def tidy_times(library: disk.Library) -> None:
    """Leave one line for each entry where the file has grown by many runs; to be called where the library is locked."""
    path = library.cache / NAME
    known = read_times(library)
    with suppress(OSError, UnicodeDecodeError):
        with path.open(encoding="utf-8") as file:
            lines = sum(1 for _ in file)
        if lines <= MOST_LINES_PER_ENTRY * len(known):
            return
        fresh = path.with_name(f".{NAME}.{os.getpid()}")
        fresh.write_text("".join(_line(name, seconds) for name, seconds in known.items()), encoding="utf-8")
        fresh.replace(path)


def _line(entry_id: str, seconds: Mapping[str, float]) -> str:
    return json.dumps({"id": entry_id, "seconds": seconds}) + "\n"


def read_times(library: disk.Library) -> dict[str, dict[str, float]]:
    """Seconds by stage of every entry that is known, by id; lines that a killed run left unfinished are passed over."""
    found: dict[str, dict[str, float]] = {}
    with suppress(OSError, UnicodeDecodeError), (library.cache / NAME).open(encoding="utf-8") as file:
        for line in file:
            with suppress(ValueError, KeyError, TypeError, AttributeError):
                row = json.loads(line)
                found[str(row["id"])] = {str(stage): float(value) for stage, value in row["seconds"].items()}
    return found
