"""Remember small values that follow from the program, its registry and the project alone, until any of these changes.

They are found again without loading what they were made by. Deleting the folder costs time and nothing else.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from casa_assets.core.cache_folder import cache_dir, keep_json, kept_json
from casa_assets.pipeline.cache.cache_key import digest_of, last_change_ns, state_of_everything
from casa_assets.projects import STARTED_NS

KEPT_IN = "remembered"  # folder of the cache


def recall(*of: str) -> Any:
    """The value that was remembered since anything changed; None if there is none."""
    return kept_json(_place(of))


def remember(value: Any, *of: str) -> None:
    """Remember a value that JSON can hold. Where the cache cannot be written to, nothing is remembered.

    Nor is it if a file has changed since this process started: the value may come from what was read before.

    Args:
        of: names what it is.
    """
    if last_change_ns() <= STARTED_NS:
        keep_json(_place(of), value)


def _place(of: tuple[str, ...]) -> Path:
    return cache_dir() / KEPT_IN / digest_of(state_of_everything(), of)
