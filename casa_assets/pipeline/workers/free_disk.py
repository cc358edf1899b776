"""Whether the disk for temporary files of this machine has room; libraries fail in many ways where it has none."""

from __future__ import annotations

import shutil
import tempfile

from casa_assets.errors import OutputError

# With less a job cannot count on its temporary files; those of readers and validators are a few megabytes. A choice.
LEAST_FREE_BYTES = 64_000_000


def full_disk() -> OutputError | None:
    """Say that the disk for temporary files of this machine is full, and what to do; None where it has room."""
    advice = "make room, or set TMPDIR to a folder on another disk"
    try:
        place = tempfile.gettempdir()
        free = shutil.disk_usage(place).free
    except OSError as error:  # no folder can be written to, which is what a full disk looks like too
        return OutputError("folder for temporary files", f"{error.strerror}; {advice}")
    if free >= LEAST_FREE_BYTES:
        return None
    return OutputError(place, f"{free / 1e6:.1f} MB are free, jobs need {LEAST_FREE_BYTES / 1e6:.0f} MB; {advice}")
