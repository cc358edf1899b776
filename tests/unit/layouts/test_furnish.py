"""Things on worktops: a blender comes with the lid that fits it, props keep clear of what is operated."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from casa_assets.core.numeric import Floats
from casa_assets.layouts.compose import compose, pose_at_spot, scatter_props
from casa_assets.layouts.order.request import KitchenRequest, request_kitchen
from casa_assets.layouts.run.resolve import params_of, preset_params
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.plan import WorktopItem
from casa_assets.model.pose import Pose
from casa_assets.registry.kitchens import load_plan, load_style, style_names
from tests.support.asset.family_members import made


def kitchen(style: str) -> KitchenRequest:
    """A plan with a blender alone on its worktops."""
    plan, _ = load_plan("one_wall_small")
    item = WorktopItem(id="blender", on=plan.worktop_items[0].on, at=0.5)
    return request_kitchen(plan.replace(worktop_items=(item,)), load_style(style)[0], preset_params())


def test_a_blender_has_the_lid_of_its_jar(subtests: pytest.Subtests) -> None:
    for style in style_names():
        with subtests.test(style=style):
            items = {item.name: item for item in kitchen(style).items}
            blender, lid = (params_of(items[name].choice) for name in ("blender", "blender_lid"))
            assert (lid.jar, lid.jar_top) == (blender.jar, blender.jar_top)  # type: ignore[attr-defined]


def test_the_lid_lies_on_the_jar() -> None:
    wanted = kitchen("coastal")
    kept = tuple(item for item in wanted.items if item.name.startswith("blender"))
    assets = {item.name: made(item.choice.family, params_of(item.choice)) for item in kept}
    scene = compose(replace(wanted, items=kept), assets, "a")
    blender, lid = scene.placements
    site = next(site for site in assets["blender"].sites if site.name == "lid_site")
    above = (blender.pose @ site.pose).inverse() @ lid.pose
    assert above.position[:2] == pytest.approx((0.0, 0.0), abs=1e-5)
    assert 0.0 < above.position[2] < 2e-4
    # Its cover lies over the mouth, its plug reaches into the jar.
    top = lid.pose.position[2] + assets["blender_lid"].bounds[0][2]
    assert top < blender.pose.position[2] + assets["blender"].bounds[1][2]


def test_props_keep_away_from_what_is_operated_on_a_worktop() -> None:
    plan, _ = load_plan("l_large")
    toaster = next(item for item in plan.worktop_items if item.id == "toaster")
    style = load_style("mediterranean")[0]
    wanted = request_kitchen(plan.replace(worktop_items=(toaster,)), style, preset_params())
    kept = tuple(item for item in wanted.items if item.role == "counter" or item.name == "toaster")
    assets = {item.name: made(item.choice.family, params_of(item.choice)) for item in kept}
    (item,) = (i for i in kept if i.name == "toaster")
    props = [(choice, made(choice.family, params_of(choice))) for choice in style.props[:3]]
    box = _bounds(assets["toaster"], pose_at_spot(assets["toaster"], item.spot))[:, :2]
    found = 0
    for seed in range(12):
        for prop, asset in scatter_props(replace(wanted, items=kept), assets, props, seed):
            found += 1
            other = _bounds(asset, pose_at_spot(asset, prop.spot))[:, :2]
            assert np.maximum(other[0] - box[1], box[0] - other[1]).max() >= 0.36
    assert found > 12


def _bounds(asset: Asset, pose: Pose) -> Floats:
    low, high = asset.bounds
    points = pose.apply(np.array(list(product(*zip(low, high, strict=True)))))
    return np.array([points.min(axis=0), points.max(axis=0)])
