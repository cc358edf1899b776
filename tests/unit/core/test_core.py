"""Extras and how they are installed; colours, rotations and rounding; one model of the force of a hand."""

from __future__ import annotations

import importlib.metadata
import math
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from casa_assets.articulate.assemble import build_joint
from casa_assets.articulate.plan import JointPlan, PartKind, PartPlan
from casa_assets.asset.assemble import assemble
from casa_assets.asset.asset_builder import ROOT, AssetBuilder
from casa_assets.asset.blocks import box
from casa_assets.asset.family import Params
from casa_assets.core import hand_dynamics, numeric, system
from casa_assets.core.numeric import about_axis, decimals, significant
from casa_assets.errors import CasaError
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from tests.unit.families.test_kit import SUPPLIES

CHECKOUT = Path(__file__).parents[3]


def test_extras_of_an_installed_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As it is where a wheel was installed: no checkout, only metadata."""
    lines = ["numpy>=2.1", 'pyarrow>=17; extra == "parquet"', 'ruff ; extra == "dev"', "torch>=2; extra == 'clip'"]
    monkeypatch.setattr(system, "_SOURCE", tmp_path)
    monkeypatch.setattr(importlib.metadata, "requires", lambda name: lines)
    assert system.requirements() == ("numpy>=2.1",)
    assert system.extras() == {"clip": ("torch>=2",), "parquet": ("pyarrow>=17",)}


def test_what_is_not_installed_is_an_error_with_the_command_that_installs_it_in_a_checkout() -> None:
    python, *words = shlex.split(system.install_command("parquet"))
    assert python == sys.executable
    assert words == ["-m", "pip", "install", "-c", str(CHECKOUT / "constraints.txt"), "-e", f"{CHECKOUT}[parquet]"]
    system.require("numpy", "parquet", "A table")
    with pytest.raises(CasaError, match=r"A table needs no_such_module.*extra 'parquet'.*pip install"):
        system.require("no_such_module", "parquet", "A table")


def test_there_and_back() -> None:
    shown = np.arange(256) / 255
    linear = numeric.linear_from_srgb_array(shown)
    np.testing.assert_allclose(numeric.srgb_from_linear_array(linear), shown, atol=1e-7)
    assert (linear[0], linear[-1]) == (0.0, 1.0)
    assert linear[128] == pytest.approx(0.21586, abs=1e-5)  # half of the way on a screen is a fifth of the light
    assert [numeric.linear_from_srgb(float(v)) for v in shown] == pytest.approx(linear.tolist(), abs=1e-15)
    assert [numeric.srgb_from_linear(float(v)) for v in linear] == pytest.approx(shown.tolist(), abs=1e-7)
    with np.errstate(all="raise"):
        assert numeric.srgb_from_linear_array(np.array([-0.1, 0.0, 1.0], dtype=np.float32)).dtype == np.float32
    assert numeric.linear_from_srgb_array(np.zeros((2, 3), dtype=np.float32)).dtype == np.float32
    assert significant(0.000123456, 3) == 0.000123
    assert (decimals(1.23456, 2), math.copysign(1.0, decimals(-1e-9, 4))) == (1.23, 1.0)


def test_rotation_agrees_with_scipy() -> None:
    for angle in [-7.0, -0.3, 0.0, 1e-9, math.pi / 2, math.pi, 5.0]:
        for axis in (np.array([1.0, 0.0, 0.0]), np.array([2.0, -3.0, 6.0]) / 7):
            wanted = Rotation.from_rotvec(axis * angle).as_matrix()
            assert np.abs(about_axis(axis, angle) - wanted).max() < 1e-15, angle


QUARTER = math.pi / 2


def built(kind: JointKind) -> Asset:
    """A cupboard with a door of 0.5 m, or a drawer, as a family builds it."""
    builder = AssetBuilder(SUPPLIES)
    builder.add(ROOT, box((0.5, 0.5, 0.7)), "plain")
    builder.link("front", at=(-0.25, -0.26, 0.0))
    builder.add("front", box((0.5, 0.018, 0.7), (0.25, 0.0, 0.0)), "plain")
    builder.add("front", box((0.012, 0.03, 0.2), (0.46, -0.024, 0.0)), "plain", label="handle", name="front_handle")
    if kind is JointKind.HINGE:
        builder.hinge("front_joint", "front", (0.0, 0.0, -1.0), (0.0, QUARTER), "front_handle")
    else:
        builder.slide("front_joint", "front", (0.0, -1.0, 0.0), (0.0, 0.4), "front_handle")
    return assemble(builder, "cupboard", Params())


def found(asset: Asset) -> Joint:
    (joint,) = asset.joints
    kind = PartKind.DOOR if joint.kind is JointKind.HINGE else PartKind.DRAWER
    plan = JointPlan(kind=joint.kind, axis=joint.axis, anchor=joint.anchor, range=joint.range)
    faces = np.zeros(0, dtype=np.int32)
    part = PartPlan(name="front", kind=kind, faces=faces, grip=faces, joint=plan)
    return build_joint(part, 1.0, asset.link("front"), None, ("object", "front"))


def test_the_same_front_built_and_found_feels_the_same() -> None:
    for kind in (JointKind.HINGE, JointKind.SLIDE):
        asset = built(kind)
        (ours,), theirs = asset.joints, found(asset)
        for name in ("frictionloss", "damping", "armature"):
            assert getattr(theirs, name) == pytest.approx(getattr(ours, name), rel=1e-2), kind
        assert (ours.drive, theirs.drive) == (None, None)


def test_a_found_drawer_opens_in_the_time_of_the_model() -> None:
    """20 N at the hand take it over its way."""
    asset = built(JointKind.SLIDE)
    joint, speed, place, seconds, dt = found(asset), 0.0, 0.0, 0.0, 1e-3
    while place < joint.range[1] and seconds < 5.0:
        force = 20.0 - joint.frictionloss - joint.damping * speed
        speed += force / (asset.link("front").inertial.mass + joint.armature) * dt
        place, seconds = place + speed * dt, seconds + dt
    assert seconds == pytest.approx(hand_dynamics.OPENS_IN_S, rel=0.05)


def test_a_spring_carries_what_falls_open_and_holds_it_shut() -> None:
    for way in [QUARTER, -QUARTER]:
        spring, sign = hand_dynamics.carry(8.0, way), math.copysign(1.0, way)
        assert 0.94 * 8.0 <= spring.stiffness * (way - spring.rest) * sign <= 8.1
        assert spring.stiffness * -spring.rest * sign == pytest.approx(0.06 * 8.0, rel=0.02)
    button = hand_dynamics.press(0.003, full_n=5.5, preload_n=2.2)
    forces = [button.stiffness * (button.rest - at) for at in (0.0, 0.003)]
    assert forces == pytest.approx([-2.2, -5.5], rel=0.01), "it is pushed out"
