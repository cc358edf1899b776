"""Parts of a thing whose kind is known get the names, axes and signs that runtimes look for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from casa_assets.articulate.part_names import rename_for_runtime
from casa_assets.articulate.run.build import ArticulateRequest, build
from tests.unit.articulate.blocks import box, carcass, drawers, microwave, together
from tests.unit.articulate.test_assemble import obj

AXES = {"up": (0.0, 0.0, 1.0), "front": (0.0, -1.0, 0.0)}


def test_a_microwave_has_its_microjoint(tmp_path: Path) -> None:
    built = build(ArticulateRequest(obj(tmp_path / "m.obj", *microwave()[:2]), tmp_path, category="microwave", **AXES))
    asset, joints = rename_for_runtime(built.asset, built.articulation, "microwave")
    joint = asset.joint_of("door")
    assert joint is not None
    assert joint.name == joints["door_0"] == "microjoint"
    assert joint.axis == pytest.approx((0.0, 0.0, 1.0))
    assert joint.range == pytest.approx((-np.pi / 2, 0.0), abs=1e-5)
    assert joint.grip == "door_handle_main"
    assert {s.name for s in asset.states} == {"microjoint_closed", "microjoint_open"}
    main = next(r for r in asset.regions if r.name == "main")
    # The handle, the knob and the buttons stand out of the region by which it is placed.
    assert main.size == pytest.approx((0.5, 0.4, 0.3), abs=1e-3)
    assert joints["knob_0"] == "knob_0_joint"


def test_two_doors_are_those_of_a_fridge_and_its_freezer(tmp_path: Path) -> None:
    parts = [
        *carcass(0.6, 0.6, 1.8),
        box((0.002, -0.05, 0.002), (0.598, 0.0, 1.2)),
        box((0.54, -0.09, 0.4), (0.555, -0.05, 0.9)),
        box((0.002, -0.05, 1.21), (0.598, 0.0, 1.798)),
        box((0.54, -0.09, 1.3), (0.555, -0.05, 1.7)),
    ]
    built = build(
        ArticulateRequest(obj(tmp_path / "f.obj", *together(*parts)[:2]), tmp_path, category="refrigerator", **AXES)
    )
    asset, joints = rename_for_runtime(built.asset, built.articulation, "refrigerator")
    assert sorted(joints.values()) == ["freezer_door_joint", "fridge_door_joint"]
    assert asset.asset_from_link("freezer_door").position[2] > asset.asset_from_link("fridge_door").position[2]


def test_a_thing_of_no_known_kind_keeps_its_names(tmp_path: Path) -> None:
    built = build(ArticulateRequest(obj(tmp_path / "x.obj", *drawers()[:2]), tmp_path, **AXES))
    asset, joints = rename_for_runtime(built.asset, built.articulation, "object")
    assert sorted(joints.values()) == ["drawer_0_joint", "drawer_1_joint"]
    assert asset.joints == built.asset.joints
