"""Name of this process, whether it is a worker, and files that appear whole under their names."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

# Environment variable that the fork server of workers sets for them.
WORKER = "CASA_ASSETS_WORKER"


def process_name() -> str:
    """Name of the machine and number of the process: machines of a cluster may have processes of the same number."""
    return f"{os.uname().nodename.replace('/', '_')}.{os.getpid()}"


def replace_file(path: Path, data: bytes) -> Path:
    """Write a file by one rename, in a folder that is made where it is missing: a reader sees all of it or none."""
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = path.with_name(f".{path.name}.{process_name()}")
    try:
        fresh.write_bytes(data)
        return fresh.replace(path)
    finally:
        with suppress(OSError):
            fresh.unlink(missing_ok=True)


def is_worker() -> bool:
    """Return True in a worker of `runs`, while others work on the other cores."""
    return WORKER in os.environ
