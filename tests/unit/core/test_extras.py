"""What is optional says how it is installed, in a command that works here."""

from __future__ import annotations

import importlib.metadata
import shlex
import sys
from pathlib import Path

import pytest

from casa_assets.cli import doctor
from casa_assets.core import optional_packages
from casa_assets.errors import CasaError

ROOT = Path(__file__).parents[3]


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As it is where a wheel was installed: no checkout, only metadata."""
    lines = ["numpy>=2.1", 'pyarrow>=17; extra == "parquet"', 'ruff ; extra == "dev"', "torch>=2; extra == 'clip'"]
    monkeypatch.setattr(optional_packages, "_CHECKOUT", tmp_path)
    monkeypatch.setattr(importlib.metadata, "requires", lambda name: lines)


def test_extras_of_a_checkout() -> None:
    assert set(optional_packages.extras()) == {
        "clip",
        "gymnasium",
        "meshopt",
        "objaverse",
        "parquet",
        "ray",
        "robots",
        "simready",
        "stores",
    }
    assert [line.split(">")[0] for line in optional_packages.extras()["parquet"]] == ["pyarrow"]


@pytest.mark.usefixtures("installed")
def test_extras_of_an_installed_package() -> None:
    assert optional_packages.requirements() == ("numpy>=2.1",)
    assert optional_packages.extras() == {"clip": ("torch>=2",), "parquet": ("pyarrow>=17",)}


def test_command_in_a_checkout_installs_the_checkout() -> None:
    python, *words = shlex.split(optional_packages.install_command("parquet"))
    assert python == sys.executable
    assert words == ["-m", "pip", "install", "-c", str(ROOT / "constraints.txt"), "-e", f"{ROOT}[parquet]"]


@pytest.mark.usefixtures("installed")
def test_command_elsewhere_names_the_packages() -> None:
    assert shlex.split(optional_packages.install_command("parquet"))[1:] == ["-m", "pip", "install", "pyarrow>=17"]


def test_what_is_not_installed_is_an_error_that_names_the_extra() -> None:
    optional_packages.require("numpy", "parquet", "A table")
    with pytest.raises(CasaError, match=r"A table needs no_such_module.*extra 'parquet'.*pip install"):
        optional_packages.require("no_such_module", "parquet", "A table")


def test_doctor_looks_at_every_extra_and_needs_none(monkeypatch: pytest.MonkeyPatch) -> None:
    def version(name: str) -> str:
        if name == "pyarrow":
            raise importlib.metadata.PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(importlib.metadata, "version", version)
    found = {finding.subject: finding for finding in doctor._packages()}
    assert {"package pyarrow", "package objaverse", "package open-clip-torch"} <= set(found)
    missing = found["package pyarrow"]
    assert (missing.ok, missing.needed) == (False, False)
    assert missing.fix == optional_packages.install_command("parquet")
