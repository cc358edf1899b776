"""Python's start on a machine whose disk for temporary files is full: it says so, and nothing can be written there."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from typing import Any

disk_usage = shutil.disk_usage


def full(path: Any) -> Any:
    """What shutil.disk_usage says: nothing is free where temporary files go."""
    found = disk_usage(path)
    return found._replace(free=0) if str(path) == tempfile.gettempdir() else found


def refuse(*_: Any, **__: Any) -> Any:
    """What a full disk says to a file that is written."""
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


shutil.disk_usage = full
for name in ("TemporaryFile", "NamedTemporaryFile", "mkstemp"):
    setattr(tempfile, name, refuse)
