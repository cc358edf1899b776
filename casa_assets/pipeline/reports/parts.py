"""Data of a page in parts: inside it where there is little, else in script files that the page loads as it needs them.

A page that is opened as a file may not fetch JSON, but it may load scripts. A part is a script that hands one JSON
array to the page: `casaPart("rows", 0, [...]);`. Its kind and number are in its name: `rows_0.js`.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from casa_assets.pipeline.library.library import exchange

# Of so many entries the data still fits into the page itself, so that it can be sent to somebody as one file.
MAX_INLINE = 400
T = TypeVar("T")


@dataclass(frozen=True)
class Part:
    """One part of the data of a page.

    Attributes:
        kind: such as `rows`. number: its place among those of its kind, from 0. content: what `json` can write.
    """

    kind: str
    number: int
    content: Sequence[Any]

    @property
    def name(self) -> str:
        """Name without its suffix, such as `rows_0`."""
        return f"{self.kind}_{self.number}"


def chunks(items: Sequence[T], size: int) -> Iterator[Sequence[T]]:
    """The items in their order, `size` at a time."""
    for begin in range(0, len(items), size):
        yield items[begin : begin + size]


def folder_of(page: Path) -> Path:
    """Folder of the script files of a page, such as `report_parts` beside `report.html`."""
    return page.with_name(f"{page.stem}_parts")


def write_parts(page: Path, parts: Iterable[Part]) -> None:
    """Write the script files of a page, put in place by one rename; those of an earlier page go.

    Raises:
        OSError: they cannot be written.
    """
    target = folder_of(page)
    fresh = target.with_name(f".{target.name}.{os.getpid()}") / target.name
    shutil.rmtree(fresh.parent, ignore_errors=True)
    try:
        fresh.mkdir(parents=True)
        for part in parts:
            text = f"casaPart({json.dumps(part.kind)},{part.number},{_json(part.content)});\n"
            (fresh / f"{part.name}.js").write_text(text, encoding="utf-8")
        exchange(fresh, target)
    finally:
        shutil.rmtree(fresh.parent, ignore_errors=True)


def remove_parts(page: Path) -> None:
    """Remove the script files of an earlier page that had some."""
    with suppress(FileNotFoundError):
        shutil.rmtree(folder_of(page))


def _json(content: Any) -> str:
    return json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
