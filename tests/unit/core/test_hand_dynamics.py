"""One model of the force of a hand: a door that a family builds and the same door found in a mesh feel the same."""

from __future__ import annotations

import math

import numpy as np
import pytest

from casa_assets.articulate.joints import build_joint
from casa_assets.articulate.plan import JointPlan, PartKind, PartPlan
from casa_assets.asset.family import Params
from casa_assets.asset.kit.assemble import assemble
from casa_assets.asset.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.asset.kit.solids.blocks import box
from casa_assets.core import hand_dynamics
from casa_assets.model.asset.asset import Asset, Joint, JointKind
from tests.unit.families.test_kit import SUPPLIES

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
    """The joint that articulation gives the same link."""
    (joint,) = asset.joints
    kind = PartKind.DOOR if joint.kind is JointKind.HINGE else PartKind.DRAWER
    plan = JointPlan(kind=joint.kind, axis=joint.axis, anchor=joint.anchor, range=joint.range)
    faces = np.zeros(0, dtype=np.int32)
    part = PartPlan(name="front", kind=kind, faces=faces, grip=faces, joint=plan)
    return build_joint(part, 1.0, asset.link("front"), None, ("object", "front"))


@pytest.mark.parametrize("kind", [JointKind.HINGE, JointKind.SLIDE])
def test_the_same_front_built_and_found_feels_the_same(kind: JointKind) -> None:
    asset = built(kind)
    (ours,), theirs = asset.joints, found(asset)
    assert theirs.frictionloss == pytest.approx(ours.frictionloss, rel=1e-2)
    assert theirs.damping == pytest.approx(ours.damping, rel=1e-2)
    assert theirs.armature == pytest.approx(ours.armature, rel=1e-2)
    assert (ours.drive, theirs.drive) == (None, None)


def opened_in(joint: Joint, inertia: float, lever: float) -> float:
    """Seconds in which 20 N at the hand take a joint over its way."""
    speed, place, seconds, dt = 0.0, 0.0, 0.0, 1e-3
    while place < joint.range[1]:
        drive = 20.0 * lever - joint.frictionloss - joint.damping * speed
        speed += drive / (inertia + joint.armature) * dt
        place, seconds = place + speed * dt, seconds + dt
        assert seconds < 5.0
    return seconds


def test_a_found_drawer_opens_in_the_time_of_the_model() -> None:
    asset = built(JointKind.SLIDE)
    seconds = opened_in(found(asset), asset.link("front").inertial.mass, 1.0)
    assert seconds == pytest.approx(hand_dynamics.OPENS_IN_S, rel=0.05)


def test_a_spring_carries_what_falls_open_and_holds_it_shut(subtests: pytest.Subtests) -> None:
    for way in [QUARTER, -QUARTER]:
        with subtests.test(way=way):
            spring = hand_dynamics.carry(8.0, way)
            end = spring.stiffness * (way - spring.rest) * math.copysign(1.0, way)
            assert 0.94 * 8.0 <= end <= 8.1
            assert spring.stiffness * -spring.rest * math.copysign(1.0, way) == pytest.approx(0.06 * 8.0, rel=0.02)


def test_a_spring_takes_its_share_of_the_push() -> None:
    free = hand_dynamics.feel_against(None, 0.3, 0.4, QUARTER)
    held = hand_dynamics.feel_against(hand_dynamics.Spring(4.0, -0.2), 0.3, 0.4, QUARTER)
    assert held.damping < free.damping
    assert held.frictionloss == free.frictionloss
