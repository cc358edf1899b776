"""Checks of the USD package: silent on good packages, and each code is tripped by a fault of its own."""

from __future__ import annotations

import io
import multiprocessing
from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

from casa_assets.checks.check import Package
from casa_assets.checks.simready import warm
from casa_assets.model.asset.asset import Asset
from tests.support.asset.articulated_assets import grill
from tests.support.asset.assets import EVERY, textured_box
from tests.support.asset.packages import Tampering, not_run_here, tamper, tripped, written

FILES = ("USD", "PAR")


def cut_in_half(package: Package) -> None:
    text = package.usd.read_text()
    package.usd.write_text(text[: len(text) // 2])


def corrupt_normal_map(package: Package) -> None:
    (picture,) = package.usd.parent.glob("textures/print_normal_*.png")
    out = io.BytesIO()
    Image.open(picture).convert("RGB").save(out, "JPEG")
    picture.write_bytes(out.getvalue())


def changed(old: str, new: str) -> Tampering:
    return lambda package: tamper(package.usd, (old, new))


FRICTION = "float physics:staticFriction"
# Code -> what it is silent on, and what is done to the package of it.
EXAMPLES: dict[str, tuple[Callable[[], Asset], Tampering]] = {
    "USD001": (textured_box, cut_in_half),
    "USD002": (textured_box, changed('string author = "Casa"', 'string author = ""')),
    "USD003": (textured_box, changed("inputs:bias = (-1, -1, -1, 0)", "inputs:bias = (0, 0, 0, 0)")),
    "USD004": (textured_box, changed(FRICTION, f"float physics:restitution = 0.5\n            {FRICTION}")),
    "USD005": (textured_box, corrupt_normal_map),
}


@pytest.mark.parametrize("make", [*EVERY, grill])
def test_good_packages_trip_nothing(make: Callable[[], Asset], tmp_path: Path) -> None:
    assert tripped(written(make(), tmp_path), FILES) == set()


@pytest.mark.parametrize("code", EXAMPLES)
def test_bad_example_trips_its_code_alone(code: str, tmp_path: Path) -> None:
    package = written(textured_box(), tmp_path)
    EXAMPLES[code][1](package)
    assert tripped(package, FILES) == {code} - not_run_here()


def test_checks_say_nothing_in_the_terminal(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    good, bad = written(textured_box(), tmp_path / "good"), written(textured_box(), tmp_path / "bad")
    cut_in_half(bad)
    for package in (good, bad):
        tripped(package, FILES)
    assert capfd.readouterr() == ("", "")


def test_checks_run_in_a_forked_child(tmp_path: Path) -> None:
    """Twenty children of one warm parent: a lock or thread lost in the fork would hang some of them."""
    package = written(textured_box(), tmp_path)
    warm()
    tripped(package, FILES)
    context = multiprocessing.get_context("fork")
    children = [context.Process(target=_child, args=(package,)) for _ in range(20)]
    for child in children:
        child.start()
    for child in children:
        child.join(timeout=60)
    assert [child.exitcode for child in children] == [0] * len(children)


def _child(package: Package) -> None:
    raise SystemExit(len(tripped(package, FILES)))
