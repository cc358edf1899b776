"""Name of this process, and whether it is a worker: for files that are not finished yet, and for threads."""

from __future__ import annotations

import os

# Environment variable that the fork server of workers sets for them.
WORKER = "CASA_ASSETS_WORKER"


def process_name() -> str:
    """Name of the machine and number of the process: machines of a cluster may have processes of the same number."""
    return f"{os.uname().nodename.replace('/', '_')}.{os.getpid()}"


def is_worker() -> bool:
    """Return True in a worker of `pipeline.workers`, while others work on the other cores."""
    return WORKER in os.environ
