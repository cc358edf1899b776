"""Wait until the files under some folders have changed and settled, again and again.

A run that begins then may find a file that has come in the meantime and is half-written: it is told the time since when
nothing had changed, and leaves out what is younger (`Options.not_after_ns`). That change ends the next wait.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

# Seconds between two looks. What is the same at both has settled: a file that is still being written grows.
LOOK_EVERY_S = 2.0
# Time of the content, time of the last change of any kind, and size, by path.
States = dict[str, tuple[int, int, int]]


def settled_changes(
    roots: Sequence[Path], library: Path, pause: Callable[[], None] = lambda: time.sleep(LOOK_EVERY_S)
) -> Iterator[int]:
    """Yield once the files have settled, and each time that they have changed and settled anew; without end.

    Yields a time, nanoseconds since 1970: what changed after it was not among what had settled.

    Args:
        roots: files and folders. library: what is written there is no change. pause: waits between two looks.
    """
    done: States | None = None
    began, last = time.time_ns(), _state(roots, library)
    while True:
        pause()
        begin, now = time.time_ns(), _state(roots, library)
        if now == last and now != done:
            done = now
            # The clock of a file server may be ahead of ours.
            yield max([began, *(changed for _, changed, _ in now.values())])
        began, last = begin, now


def _state(roots: Sequence[Path], library: Path) -> States:
    """Times and size of every file under the roots by its path; hidden ones and those of the library are left out."""
    own = os.path.realpath(library)
    found: States = {}
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


def _add(path: str, found: States) -> None:
    try:
        state = os.stat(path)  # noqa: PTH116
    except OSError:
        return  # it is gone, or may not be looked at, which the run tells
    found[path] = (state.st_mtime_ns, state.st_ctime_ns, state.st_size)
