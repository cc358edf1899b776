"""What stands by itself has its middle of mass over what its collision shapes stand on."""

from __future__ import annotations

from casa_assets.mesh.planar import stands_by_itself
from casa_assets.model.asset.asset import Asset, Collider
from casa_assets.model.asset.parts import Box
from casa_assets.model.pose import Pose
from tests.support.asset.articulated_assets import microwave
from tests.support.asset.box_assets import plain_box, touched


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


def test_a_box_and_a_fixture_stand() -> None:
    assert stands_by_itself(plain_box())
    assert stands_by_itself(microwave())


def test_four_feet_carry_and_one_or_two_at_a_side_do_not() -> None:
    assert stands_by_itself(on_feet((-0.09, -0.02), (0.09, -0.02), (-0.09, 0.02), (0.09, 0.02)))
    assert not stands_by_itself(on_feet((-0.09, 0.02)))
    assert not stands_by_itself(on_feet((-0.09, -0.02), (-0.09, 0.02)))
