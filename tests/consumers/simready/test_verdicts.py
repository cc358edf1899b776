"""Verdicts of SimReady's validator: in this process, by another Python, wherever a file lies, as its command says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from casa_assets.checks import simready
from casa_assets.checks.package import Package, usd
from casa_assets.checks.simready import validate_simready
from casa_assets.checks.simready_python import VARIABLE, versions_elsewhere
from tests.support.asset.assets import microwave, rigid_mug
from tests.support.asset.packages import Tampering, tamper, written

pytestmark = pytest.mark.consumers
LONG = "a" * 120


def name_nobody(package: Package) -> None:
    tamper(package.usd, ('string author = "Casa"', 'string author = ""'))


@pytest.mark.parametrize("corrupt", [None, name_nobody], ids=["good", "bad"])
def test_verdict_is_that_of_the_command_line(corrupt: Tampering | None, tmp_path: Path) -> None:
    package = written(microwave(), tmp_path)
    if corrupt:
        corrupt(package)
    command = [str(Path(sys.executable).with_name("simready-validate")), "--profile", simready.PROFILE]
    command += ["--version", simready.PROFILE_VERSION, str(package.usd)]
    done = subprocess.run(command, capture_output=True, check=False, cwd=tmp_path)
    assert done.returncode in (0, 1)
    passes = usd.usd_meets_simready_profile(package).problems == ()
    assert passes == (done.returncode == 0) == (corrupt is None)


@pytest.mark.parametrize(
    "above", ["Küche 空 1", "-x", "CON", f"{LONG}/{LONG}"], ids=["words", "dash", "reserved", "long"]
)
def test_where_a_library_lies_does_not_matter(above: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = written(microwave(), tmp_path / above)
    assert validate_simready(package.usd, package.root) == (True, {})
    inside = package.usd.rename(package.usd.with_name("micro wave.usda"))
    assert "com.nvidia.simready.NP.002" in validate_simready(inside, package.root)[1]


def test_another_python_gives_the_same_verdict(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good, bad = written(rigid_mug(), tmp_path / "good"), written(rigid_mug(), tmp_path / "bad case")
    name_nobody(bad)
    codes = frozenset({"com.nvidia.simready.SR.004"})
    asked = [(good, frozenset[str]()), (bad, frozenset[str]()), (bad, codes)]
    here = [validate_simready(one.usd, one.root, without) for one, without in asked]
    assert [passes for passes, _ in here] == [True, False, True]
    assert versions_elsewhere() == {}
    monkeypatch.setenv(VARIABLE, sys.executable)
    assert [validate_simready(one.usd, one.root, without) for one, without in asked] == here
    assert {"simready-validate", "simready-foundation-tier-core"} <= versions_elsewhere().keys()
