"""MJCF and USD of one asset are one fact table, whoever reads them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from casa_assets.checks import parity
from casa_assets.checks.package import Package
from casa_assets.checks.readers import asset_facts, mjcf_facts, usd_facts
from casa_assets.model.asset import Asset, Base
from tests.assets import EVERY, drawer_unit, microwave, rigid_mug
from tests.packages import Tampering, tamper, tripped, written

RELATIVE, LENGTH = 1e-5, 1e-6


STEEL = "</cabinet_0123456789/physicsMaterials/steel>"
CARDBOARD = "</cabinet_0123456789/physicsMaterials/cardboard>"


def forget_friction(package: Package) -> None:
    """Only MuJoCo reads the binding for all purposes."""
    tamper(package.usd, (f"rel material:binding = {STEEL}", ""))


def change_substance(package: Package) -> None:
    """Only UsdPhysics reads the binding for physics."""
    tamper(package.usd, (f"rel material:binding:physics = {STEEL}", f"rel material:binding:physics = {CARDBOARD}"))


def slide_only(package: Package) -> None:
    tamper(package.usd, ("mjc:condim = 4", "mjc:condim = 3"))


def shift_carcass(package: Package) -> None:
    tamper(package.usd, ("xformOp:translate = (0, 0, 0.01)", "xformOp:translate = (0, 0, 0.0101)"))


BAD: dict[str, Tampering] = {
    "PAR001": forget_friction,
    "PAR002": change_substance,
    "PAR003": slide_only,
    "PAR004": shift_carcass,
}

# Code -> what it is silent on, and what is done to the package of it.
EXAMPLES = {code: (drawer_unit, spoil) for code, spoil in BAD.items()}


@pytest.mark.parametrize("code", BAD)
def test_bad_example_trips_its_code_alone(code: str, tmp_path: Path) -> None:
    package = written(drawer_unit(), tmp_path)
    assert tripped(package, ("USD", "PAR")) == set()
    other = written(drawer_unit(), tmp_path / "bad")
    BAD[code](other)
    assert tripped(other, ("USD", "PAR")) == {code}


def test_both_sides_of_a_joint_are_read(tmp_path: Path) -> None:
    """MuJoCo reads the child's side and where the bodies stand, UsdPhysics the parent's side."""
    package = written(microwave(), tmp_path)
    head, tail = package.usd.read_text().split('PhysicsRevoluteJoint "microjoint"')
    tail = tail.replace("localRot0 = (1, 0, 0, 0)", "localRot0 = (0.9999995, 0.001, 0, 0)")
    package.usd.write_text(f'{head}PhysicsRevoluteJoint "microjoint"{tail}')
    assert tripped(package, ("USD", "PAR")) == {"PAR002", "PAR004"}


@pytest.mark.parametrize("make", EVERY)
def test_every_reader_of_every_file_says_what_the_asset_says(make: Callable[[], Asset], tmp_path: Path) -> None:
    asset = make()
    package = written(asset, tmp_path)
    truth = asset_facts.facts(asset)
    for found in (
        mjcf_facts.facts(package.mjcf),
        usd_facts.mujoco_facts(package.usd),
        usd_facts.pxr_facts(package.usd),
    ):
        assert parity.compare(truth, found, RELATIVE, LENGTH) == []


def test_free_articulation(tmp_path: Path) -> None:
    package = written(microwave(Base.FREE), tmp_path)
    assert usd_facts.mujoco_facts(package.usd).base is Base.FREE
    assert usd_facts.pxr_facts(package.usd).base is Base.FREE
    assert tripped(package, ("USD", "PAR")) == set()


def test_compare_points_at_what_differs() -> None:
    facts = asset_facts.facts(drawer_unit())
    (knob,) = [b for b in facts.bodies if b.name == "knob"]
    others = tuple(b for b in facts.bodies if b.name != "knob")
    heavier = facts.replace(bodies=(*others, knob.replace(mass=knob.mass * 1.001)))
    assert [where for where, _ in parity.compare(facts, heavier, RELATIVE, LENGTH)] == ["bodies/knob/mass"]
    x, y, z = knob.position
    moved = facts.replace(bodies=(*others, knob.replace(position=(x + 2e-6, y, z))))
    assert [where for where, _ in parity.compare(facts, moved, RELATIVE, LENGTH)] == ["bodies/knob/position"]
    assert parity.compare(facts, moved, RELATIVE, 1e-5) == []


def test_travel_of_a_slide_is_a_length() -> None:
    facts = asset_facts.facts(drawer_unit())
    (drawer,) = [b for b in facts.bodies if b.name == "drawer"]
    assert drawer.joint is not None
    longer = drawer.replace(joint=drawer.joint.replace(range=(0.0, 0.280005)))
    changed = facts.replace(bodies=tuple(longer if b.name == "drawer" else b for b in facts.bodies))
    assert [where for where, _ in parity.compare(facts, changed, RELATIVE, LENGTH)] == ["bodies/drawer/joint/range"]


def test_a_missing_collider_is_a_difference() -> None:
    facts = asset_facts.facts(rigid_mug())
    fewer = facts.replace(bodies=(facts.bodies[0].replace(colliders=9),))
    assert [where for where, _ in parity.compare(facts, fewer, RELATIVE, LENGTH)] == ["bodies/object/colliders"]
