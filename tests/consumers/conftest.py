"""What several files of these tests share: the library of the sample meshes, made once."""

from __future__ import annotations

import fcntl
import shutil
from pathlib import Path

import pytest

from tests.documents import ROOT, blocks, shell

# The first command of README.md, whose library all pages after it take for granted.
MAKE = next(line for block in blocks("README.md") for line in block.commands if line.startswith("casa-assets ingest"))


@pytest.fixture(scope="session")
def samples(common: Path) -> Path:
    """A folder with the examples, and the library of them in `out/library`; the first process that asks makes it."""
    place, draft = common / "samples", common / "samples_draft"
    with (common / "samples.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not place.exists():
            shutil.rmtree(draft, ignore_errors=True)
            shutil.copytree(ROOT / "examples", draft / "examples")
            done = shell(MAKE, draft)
            assert done.returncode == 1, done.stdout + done.stderr  # one sample is broken on purpose
            draft.rename(place)
    return place
