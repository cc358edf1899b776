"""What writers of assets and scenes return does not depend on the process."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from tests.support.library.libraries import ROOT

KITCHEN = (
    "from tests.support.kitchen.scenes import Weight, corner, in_form; "
    "from casa_assets.formats.mjcf.kitchen import write"
)
# Imports, and an expression of what is written.
WRITERS = {
    "mjcf": (
        "from casa_assets.formats.mjcf import write; from tests.support.asset.assets import EVERY",
        "[write(build()).sums() for build in EVERY]",
    ),
    "usd": (
        "from casa_assets.formats.usd import document; from tests.support.asset.assets import EVERY",
        "[document.layer_text(build()) for build in EVERY]",
    ),
    "scene mjcf": (KITCHEN, "write(in_form(corner(), Weight.FULL)).sums()"),
    "light scene mjcf": (KITCHEN, "write(in_form(corner(), Weight.LIGHT)).sums()"),
    "scene usd": (
        "from casa_assets.formats.usd.kitchen import write; from tests.support.kitchen.scenes import corner",
        "write(corner()).sums()",
    ),
}


@pytest.mark.parametrize("writer", WRITERS)
def test_bytes_do_not_depend_on_the_hash_seed(writer: str) -> None:
    imports, written = WRITERS[writer]
    program = f"{imports}\nfirst, second = {written}, {written}\nassert first == second\nprint(first)"
    command, outputs = [sys.executable, "-c", program], set()
    for seed in ("0", "4711"):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)}
        done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
        outputs.add(done.stdout)
    assert len(outputs) == 1
    assert outputs != {""}
