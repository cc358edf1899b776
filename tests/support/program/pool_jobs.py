"""What workers are asked to do in the tests of the pool: behave, and misbehave in every way that was thought of."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np

from casa_assets.core.system import is_worker
from casa_assets.projects import project_folder


class Unsendable:
    """Cannot be pickled."""

    def __reduce__(self) -> str:
        raise TypeError("not to be sent")


class Unreadable:
    """Can be pickled, and fails when it is unpickled."""

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return (int, ("not a number",))


def nothing() -> None:
    """Warm nothing up."""


def broken() -> None:
    raise ImportError("libnothing.so: cannot be loaded")


def deadly() -> None:
    os._exit(5)


def do(job: tuple[str, str]) -> object:
    """Do what the first word says; the second is a path or a text."""
    what, value = job
    return (SIMPLE.get(what) or globals()[f"_{what}"])(value)


SIMPLE: dict[str, Callable[[str], object]] = {
    "answer": str.upper,
    "nothing": lambda value: None,
    "is_worker": lambda value: is_worker(),
    "large": lambda value: value.encode() * 5_000_000,
    "abort": lambda value: os.abort(),
    "segfault": lambda value: os.kill(os.getpid(), 11),
    "exit": lambda value: os._exit(int(value)),
    "sys_exit": lambda value: sys.exit(int(value)),
    "eat": lambda value: int(np.ones(400_000_000, dtype=np.uint64).sum()),
    "unsendable": lambda value: Unsendable(),
    "unreadable": lambda value: Unreadable(),
    "oom_score": lambda value: int(Path("/proc/self/oom_score_adj").read_text(encoding="ascii")),
    "take": lambda value: (np.ones(int(float(value) * 1e9 / 8), dtype=np.uint64).sum(), value)[1],
    "hang": lambda value: time.sleep(100_000),
    "threads": lambda value: os.environ["OPENBLAS_NUM_THREADS"],
    # The clock, and where temporary files go, after some seconds of processor time.
    "clock": lambda value: (_burn(value), time.time())[1],
    "temporary_folder": lambda value: (_burn(value), tempfile.gettempdir())[1],
    "die_with_grandchild": lambda value: (_grandchild(value), os.abort()),
    "hang_with_grandchild": lambda value: (_grandchild(value), time.sleep(100_000)),
}


def _burn(value: str) -> str:
    while time.process_time() < float(value):
        pass
    return "burnt"


def _burn_in_children(value: str) -> str:
    """The same, in processes of a tenth of a second each, so that no single one is over a limit."""
    code = "import time\nwhile time.process_time() < 0.1: pass"
    for _ in range(int(float(value) * 10)):
        subprocess.run([sys.executable, "-c", code], check=True, start_new_session=True)
    return "burnt"


def _raise(value: str) -> None:
    raise ValueError(value)


def _out_of_memory_inside(value: str) -> None:
    """As a library that meets the limit and says something else."""
    try:
        raise MemoryError
    except MemoryError as error:
        raise ValueError(value) from error


def _out_of_memory_at_import(value: str) -> None:
    raise ImportError("libx.so: failed to map segment from shared object")


def _out_of_memory_in_other_words(value: str) -> None:
    """As a library that is refused memory and knows no error for it."""
    held = []
    with suppress(MemoryError):
        while True:
            held.append(bytearray(16_000_000))
    raise OSError("codec configuration error")


def _out_of_memory_when_told(value: str) -> None:
    class Untold(Exception):
        def __str__(self) -> str:
            raise MemoryError

    raise Untold


def _grandchild(value: str) -> str:
    """Leave a process behind that holds everything open; `value` is where its number is written."""
    child = subprocess.Popen(["sleep", "1000"], close_fds=False)
    Path(value).write_text(str(child.pid), encoding="ascii")
    return "answered"


def _die_once(value: str) -> str:
    """As if killed from outside the first time."""
    return _kill_once(os.getpid(), Path(value))


def _kill_server_once(value: str) -> str:
    return _kill_once(os.getppid(), Path(value))


def _kill_once(process: int, mark: Path) -> str:
    if not mark.exists():
        mark.touch()
        os.kill(process, 9)
        time.sleep(60)
    return "second time"


def _kill_all_above(value: str) -> None:
    """End the server, and the process that keeps the pool, each time; `value` takes a line each time."""
    with Path(value).open("a", encoding="ascii") as mark:
        mark.write("once\n")
    server = os.getppid()
    pool = int(Path(f"/proc/{server}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[1])
    for process in (pool, server):
        os.kill(process, 9)
    time.sleep(60)


def folder_in_use(_: object) -> Path | None:
    return project_folder()
