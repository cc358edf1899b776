"""Name this process among all that write to one disk, for files that are not finished yet."""

from __future__ import annotations

import os


def process_name() -> str:
    """Name of the machine and number of the process: machines of a cluster may have processes of the same number."""
    return f"{os.uname().nodename.replace('/', '_')}.{os.getpid()}"
