"""Assets that are scaled, and whether things stand by themselves."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from casa_assets.asset.scale_asset import scaled
from casa_assets.formats.mjcf.document import write
from casa_assets.mesh.planar import stands_by_itself
from casa_assets.model.asset.asset import Asset, Collider, JointKind
from casa_assets.model.asset.parts import Box
from casa_assets.model.pose import Pose
from tests.support.asset.articulated_assets import drawer_unit, microwave
from tests.support.asset.box_assets import plain_box, touched

FACTOR = 1.25


@pytest.fixture(params=["microwave", "drawers"])
def asset(request: pytest.FixtureRequest) -> Asset:
    return microwave() if request.param == "microwave" else drawer_unit()


def test_all_lengths_are_scaled(asset: Asset) -> None:
    made = scaled(asset, FACTOR, 2 * asset.mass)
    assert made.bounds == pytest.approx(FACTOR * asset.bounds, abs=1e-6)
    assert made.mass == pytest.approx(2 * asset.mass, rel=1e-5)
    for before, after in zip(asset.regions, made.regions, strict=True):
        assert after.size == pytest.approx(FACTOR * np.array(before.size), rel=1e-6)
        assert after.pose.position == pytest.approx(FACTOR * np.array(before.pose.position), abs=1e-6)
    for before, after in zip(asset.joints, made.joints, strict=True):
        factor = FACTOR if before.kind is JointKind.SLIDE else 1.0
        assert after.range == pytest.approx(factor * np.array(before.range), abs=1e-6)
        # A hand needs as much force, at an arm that is longer.
        arm = 1.0 if before.kind is JointKind.SLIDE else FACTOR
        assert after.frictionloss == pytest.approx(arm * before.frictionloss, rel=0.01)


def test_mujoco_has_the_masses_and_inertias_of_a_scaled_body(asset: Asset) -> None:
    small, large = (_model(one) for one in (asset, scaled(asset, FACTOR, 2 * asset.mass)))
    assert large.body_mass == pytest.approx(2 * small.body_mass, rel=1e-5)
    assert large.body_inertia == pytest.approx(2 * FACTOR**2 * small.body_inertia, rel=1e-4, abs=1e-9)
    assert large.body_pos == pytest.approx(FACTOR * small.body_pos, abs=1e-6)


def _model(asset: Asset) -> mujoco.MjModel:
    files = dict(write(asset).entries)
    return mujoco.MjModel.from_xml_string(files["model.xml"].decode(), files)


def on_feet(*corners: tuple[float, float]) -> Asset:
    """A box of 0.2 x 0.06 x 0.12 m over feet at some of its corners."""
    feet = (
        Collider(
            name=f"foot_{i}",
            shape=Box(size=(0.02, 0.02, 0.01)),
            substance="cardboard",
            pose=Pose(position=(x, y, 0.005)),
        )
        for i, (x, y) in enumerate(corners)
    )
    body = Collider(
        name="body", shape=Box(size=(0.2, 0.06, 0.11)), substance="cardboard", pose=Pose(position=(0.0, 0.0, 0.065))
    )
    return touched(body, *feet)


def test_a_box_a_fixture_and_four_feet_stand_and_one_or_two_at_a_side_do_not() -> None:
    assert stands_by_itself(plain_box())
    assert stands_by_itself(microwave())
    assert stands_by_itself(on_feet((-0.09, -0.02), (0.09, -0.02), (-0.09, 0.02), (0.09, 0.02)))
    assert not stands_by_itself(on_feet((-0.09, 0.02)))
    assert not stands_by_itself(on_feet((-0.09, -0.02), (-0.09, 0.02)))
