"""A machine of a cluster whose disk for temporary files is really full; it needs the right to mount one (`unshare`)."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from tests.consumers.cluster.machines import ask, machines

pytestmark = pytest.mark.certify

MOUNT = 'mount -t tmpfs -o size=1m none "$0" && exec "$@"'


def test_a_machine_with_a_disk_of_one_megabyte_gets_no_jobs(tmp_path: Path) -> None:
    within = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c", MOUNT, str(tmp_path)]
    with machines({}, {"TMPDIR": str(tmp_path)}, within=within) as cluster:
        found = ask(cluster.address, *[("temporary_folder", "1")] * 6)
    assert set(found) == {tempfile.gettempdir()} != {str(tmp_path)}
