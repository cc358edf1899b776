"""Hours on a cluster with faults at random: each library that comes out is the one of an undisturbed machine.

    CASA_SOAK_MINUTES=20 .venv/bin/python -m pytest -m certify -s tests/consumers/cluster/test_soak.py

Each round brings meshes into a fresh library by one run after the other until one of them ends by itself. In each run
one process of a job or of Ray is killed at most (an input whose process is killed twice is rejected, as it should be),
machines are lost and come back, and the run itself is killed or stopped with Ctrl-C once it has finished something.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

import pytest
import trimesh

from tests.consumers.cluster.machines import JOB, MESHES, RAY_WORKER, Machines, end, machines, start, start_on
from tests.support.library.libraries import differences, entries_of

pytestmark = pytest.mark.certify

MINUTES = float(os.environ.get("CASA_SOAK_MINUTES", "120"))
SEED = 19
# Seconds between two faults, and machines that one run may lose: fewer than what makes an input be given up.
LEAST_S, MOST_S, MOST_LOST = 5.0, 40.0, 3
GROWTH = 1.07  # between the copies of a mesh: another asset, and no copy of the first


def scaled_meshes(folder: Path) -> Path:
    """The sample meshes, the broken one with them, and a larger one of each."""
    folder.mkdir()
    for path in sorted(MESHES.iterdir()):
        (folder / path.name).write_bytes(path.read_bytes())
        try:
            mesh = trimesh.load(path, force="mesh")
        except Exception:  # noqa: BLE001  one of them is broken on purpose, others are no meshes
            continue
        mesh.apply_scale(GROWTH)
        mesh.export(folder / f"{path.stem}_large.glb")
    return folder


def disturb(
    run: subprocess.Popen[str], library: Path, cluster: Machines, chance: random.Random, faults: Counter[str]
) -> bool:
    """Do something bad from time to time until the run has ended; True if that was by itself."""
    killed = lost = 0
    before = len(entries_of(library))
    while True:
        with suppress(subprocess.TimeoutExpired):
            run.wait(chance.uniform(LEAST_S, MOST_S))
            return True
        kinds = ["driver", "stop"] if len(entries_of(library)) > before else []
        kinds += ["job", "worker"] * 2 if not killed else []
        kinds += ["machine"] * 2 if lost < MOST_LOST else []
        if not kinds:
            continue
        kind = chance.choice(kinds)
        faults[kind] += 1
        if kind == "machine":
            lost += 1
            cluster.order("kill")
            cluster.order("add")
        elif kind in ("job", "worker"):
            killed += bool(cluster.kill(JOB if kind == "job" else RAY_WORKER))
        else:
            run.send_signal(signal.SIGKILL if kind == "driver" else signal.SIGINT)
            run.communicate(timeout=300)
            return False


def test_faults_at_random_change_no_library(tmp_path: Path) -> None:
    chance, faults, rounds = random.Random(SEED), Counter[str](), 0
    inputs = scaled_meshes(tmp_path / "meshes")
    end(start("ingest", inputs, "--library", tmp_path / "expected"), most_s=None)
    over = time.monotonic() + 60 * MINUTES
    with machines({}, {}) as cluster:
        while rounds == 0 or time.monotonic() < over:
            rounds += 1
            library = tmp_path / f"library_{rounds}"
            while True:
                run = start_on(cluster.address, inputs, library)
                if disturb(run, library, cluster, chance, faults):
                    break
            end(run, most_s=None)
            assert differences(library, tmp_path / "expected") == [], f"round {rounds} after {dict(faults)}"
            print(f"round {rounds}: {sum(faults.values())} faults so far: {dict(sorted(faults.items()))}", flush=True)
    assert faults
