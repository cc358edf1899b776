"""Things on worktops: a blender comes with the lid that fits it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from casa_assets.layouts.compose.compose import compose
from casa_assets.layouts.order.request import KitchenRequest, request_kitchen
from casa_assets.model.kitchen.furnishing import WorktopItem
from casa_assets.pipeline.kitchens.resolve import params_of, preset_params
from casa_assets.registry.kitchens import load_plan, load_style, style_names
from tests.family_members import made


def kitchen(style: str) -> KitchenRequest:
    """A plan with a blender alone on its worktops."""
    plan, _ = load_plan("one_wall_small")
    item = WorktopItem(id="blender", on=plan.worktop_items[0].on, at=0.5)
    return request_kitchen(plan.replace(worktop_items=(item,)), load_style(style)[0], preset_params())


@pytest.mark.parametrize("style", style_names())
def test_a_blender_has_the_lid_of_its_jar(style: str) -> None:
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
