"""What is known of a report that was written, and how its files are."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from casa_assets.pipeline.reports.library.conditions import Outcome


@dataclass(frozen=True)
class WrittenReport:
    """A report that was written. page, json: its files. outcomes: of the conditions that were set."""

    page: Path
    json: Path
    outcomes: tuple[Outcome, ...] = ()


def write_text(target: Path, text: str) -> None:
    """Write a file by one rename."""
    fresh = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(target)
    finally:
        with suppress(OSError):
            fresh.unlink(missing_ok=True)
