"""Wait until the files under some folders have changed and settled, again and again."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

# Seconds between two looks. What is the same at both has settled: a file that is still being written grows.
LOOK_EVERY_S = 2.0


def settled_changes(
    roots: Sequence[Path], library: Path, pause: Callable[[], None] = lambda: time.sleep(LOOK_EVERY_S)
) -> Iterator[None]:
    """Yield once the files have settled, and each time that they have changed and settled anew; without end.

    Args:
        roots: files and folders. library: what is written there is no change. pause: waits between two looks.
    """
    done: dict[str, tuple[int, int]] | None = None
    last = _state(roots, library)
    while True:
        pause()
        now = _state(roots, library)
        if now == last and now != done:
            done = now
            yield
        last = now


def _state(roots: Sequence[Path], library: Path) -> dict[str, tuple[int, int]]:
    """Time and size of every file under the roots by its path; hidden ones and those of the library are left out."""
    own = os.path.realpath(library)
    found: dict[str, tuple[int, int]] = {}
    for root in roots:
        if not root.is_dir():
            _add(str(root), found)
            continue
        for folder, folders, names in os.walk(root):
            folders[:] = [
                n
                for n in folders
                if not n.startswith(".") and os.path.realpath(os.path.join(folder, n)) != own  # noqa: PTH118
            ]
            for name in names:
                if not name.startswith("."):
                    _add(os.path.join(folder, name), found)  # noqa: PTH118  twenty thousand of them, every two seconds
    return found


def _add(path: str, found: dict[str, tuple[int, int]]) -> None:
    try:
        state = os.stat(path)  # noqa: PTH116
    except OSError:
        return  # it is gone, or may not be looked at, which the run tells
    found[path] = (state.st_mtime_ns, state.st_size)
