"""What a scene refuses, and what it knows of its placements."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from casa_assets.model.kitchen.scene import Camera, Layer, Light, Placement, Scene, Sky
from casa_assets.model.pose import Pose
from tests.articulated_assets import microwave
from tests.assets import rigid_mug

OVEN, MUG = microwave(), rigid_mug()
AT = Placement(name="cup", asset=MUG.id)
LAMP = Light(name="lamp", position=(0.0, 0.0, 2.0), direction=(0.0, 0.0, -1.0))


def test_a_placement_is_a_thing_unless_it_says_otherwise() -> None:
    assert AT.layer is Layer.THINGS
    assert Placement.from_json(AT.replace(layer=Layer.CEILING).to_json()).layer is Layer.CEILING


def test_it_knows_the_asset_of_each_placement() -> None:
    scene = Scene(id="two", assets=(OVEN, MUG), placements=(AT, Placement(name="box", asset=OVEN.id)))
    assert {name: asset.id for name, asset in scene.asset_of.items()} == {"cup": MUG.id, "box": OVEN.id}


def test_what_it_refuses(subtests: pytest.Subtests) -> None:
    for changes in [
        {"lights": (LAMP, LAMP)},
        {"cameras": (Camera(name="cup", pose=Pose()),)},
        {"placements": (AT.replace(name="world"),)},
        {"placements": (AT.replace(asset="plate_0123456789"),)},
        {"ambient": (-0.1, 0.0, 0.0)},
        {"assets": (MUG, MUG)},
    ]:
        with subtests.test(changes=changes):
            good = Scene(id="one", assets=(MUG,), placements=(AT,), lights=(LAMP,))
            with pytest.raises(ValidationError):
                good.replace(**changes)


def test_no_joint_is_called_like_that_of_a_free_base() -> None:
    freed = OVEN.replace(joints=(OVEN.joints[0].replace(name="free"),), states=())
    with pytest.raises(ValidationError, match="free"):
        Scene(id="one", assets=(freed,), placements=(Placement(name="oven", asset=freed.id),))


def test_what_a_light_refuses(subtests: pytest.Subtests) -> None:
    for changes in [
        {"direction": (0.0, 0.0, 0.0)},
        {"color": (-1.0, 0.0, 0.0)},
        {"attenuation": (0.0, 0.0, 0.0)},
        {"radius": 0.0},
        {"cone_deg": 91.0},
        {"softness": 1.1},
    ]:
        with subtests.test(changes=changes), pytest.raises(ValidationError):
            LAMP.replace(**changes)


def test_a_sky_has_colours() -> None:
    with pytest.raises(ValidationError):
        Sky(zenith=(0.0, 0.0, 1.5))
