"""Keeps what native libraries print out of the terminal."""

from __future__ import annotations

import logging
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout


@contextmanager
def quiet() -> Iterator[list[str]]:
    """Nothing that happens inside reaches standard output, standard error or a log.

    Both copies of USD (that of usd-core and the one inside MuJoCo) and the validators print from C++, so the file
    descriptors themselves are turned away. For the whole process: for use where nothing else runs.

    Yields:
        A list that holds the lines that were printed once the block has ended.
    """
    said: list[str] = []
    with tempfile.TemporaryFile() as sink, ExitStack() as stack:
        stack.enter_context(_descriptor(1, sink.fileno()))
        stack.enter_context(_descriptor(2, sink.fileno()))
        text = stack.enter_context(open(os.dup(sink.fileno()), "w", encoding="utf-8", buffering=1))  # noqa: PTH123
        stack.enter_context(redirect_stdout(text))
        stack.enter_context(redirect_stderr(text))
        stack.enter_context(_no_logging())
        try:
            yield said
        finally:
            text.flush()
            sink.seek(0)
            said.extend(line for line in sink.read().decode("utf-8", "replace").splitlines() if line.strip())
            sink.seek(0, os.SEEK_END)


@contextmanager
def _descriptor(number: int, target: int) -> Iterator[None]:
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    kept = os.dup(number)
    os.dup2(target, number)
    try:
        yield
    finally:
        os.dup2(kept, number)
        os.close(kept)


@contextmanager
def _no_logging() -> Iterator[None]:
    """Also undoes the handler that the first `logging.warning` of a process installs."""
    root = logging.getLogger()
    level, handlers = logging.root.manager.disable, list(root.handlers)
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(level)
        root.handlers[:] = handlers
