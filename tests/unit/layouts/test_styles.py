"""The styles of registry/styles: whole, of things that exist, and no two alike."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from casa_assets.errors import CasaError, PlanConflict, UnknownId
from casa_assets.kitchenware.catalog import MODELS
from casa_assets.kitchenware.fixtures.worktops import CORBEL_REACH, CORBEL_WIDTH
from casa_assets.layouts.check_plan.edit import flow_text
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.order.request import request_kitchen
from casa_assets.layouts.run.resolve import params_of, preset_params
from casa_assets.model.kitchen.style import PresetChoice, Style
from casa_assets.projects import data_root
from casa_assets.registry import kitchens
from casa_assets.registry.families import family
from casa_assets.textures.run.recipes import plain, recipes
from tests.support.asset.family_members import preset

TWELVE = kitchens.style_names()


def style_of(name: str) -> Style:
    return kitchens.load_style(name)[0]


def kitchen_of(plan: str, style: Style) -> KitchenRequest:
    return request_kitchen(kitchens.load_plan(plan)[0], style, preset_params())


def test_members_exist_and_their_numbers_go_together() -> None:
    assert len(TWELVE) == 12
    for style in map(style_of, TWELVE):
        for role, choice in [*style.models.items(), *(("prop", c) for c in style.props)]:
            plain_one = family(choice.family).presets[choice.name]
            # An override that changes nothing is a slip of the pen.
            assert not choice.params or params_of(choice) != plain_one, (style.id, role, choice)


@pytest.mark.content("style", "{style_id}")
@pytest.mark.content("plan", "{plan}")
@pytest.mark.parametrize("style_id", TWELVE)
@pytest.mark.parametrize("plan", ["l_small", "one_wall_large"])
def test_every_style_dresses_a_plan(style_id: str, plan: str) -> None:
    style = style_of(style_id)
    kitchen = kitchen_of(plan, style)
    made = {w.name: params_of(w.choice) for w in kitchen.items}
    known = set(plain()).union(*recipes().values())
    assert [name for name, params in made.items() if not known.issuperset(params.finishes)] == []
    of_role = {w.role: made[w.name] for w in kitchen.items}
    assert of_role["floor"].model_dump()["face"] == style.room.floor
    assert of_role["wall"].model_dump()["inside"] == style.room.wall
    groups = {True: style.cabinets.base, False: style.cabinets.island.filled_from(style.cabinets.base)}
    cabinets = [w for w in kitchen.items if w.choice.family in ("base_cabinet", "drawer_stack", "sink_base")]
    assert cabinets
    for wanted in cabinets:
        face = groups[kitchen.lines[wanted.run].at_wall].face
        assert made[wanted.name].model_dump()["look"]["face"] == face, wanted.name
        assert face in made[wanted.name].finishes
    assert of_role["counter"].model_dump()["top"] == style.counter.face
    assert ("curtain" in of_role) is any(h.is_window for h in kitchen.holes)


def test_cornices_of_one_run_do_not_meet() -> None:
    """Two returns need 8 cm: over a narrower gap between cabinets of one depth the cornice runs on."""
    plan = kitchens.load_plan("u_dining")[0]
    # Without its last cabinet the row leaves a gap before the corner, wider the wider the room is.
    runs = tuple(r.replace(upper=r.upper[:-1]) if r.id == "main" else r for r in plan.runs)
    gapped = plan.replace(runs=runs)
    for width in range(283, 321, 4):
        kitchen = request_kitchen(gapped, style_of("traditional_1"), preset_params(), {"width": width / 100})
        for run in kitchen.lines:
            ends = []
            for item in (w for w in kitchen.items if w.role == "cornice" and w.run == run):
                p = item.choice.params
                half = (p["width"] + p["out"] * (p["left_return"] + p["right_return"])) / 2
                ends.append((item.spot.u - half, item.spot.u + half))
            ends.sort()
            assert all(before[1] <= after[0] for before, after in pairwise(ends)), (width, run, ends)


@pytest.mark.parametrize("plan", ["double_island", "l_large", "one_wall_large", "pantry_island", "wraparound"])
def test_a_stool_turns_between_corbels(plan: str) -> None:
    kitchen = kitchen_of(plan, style_of("coastal"))
    stool = preset("stool", "pedestal")
    turning = next(link for link in stool.links if link is not stool.root)
    radius = max(np.hypot(v.mesh.vertices[:, 0], v.mesh.vertices[:, 1]).max() for v in turning.visuals)
    tops = [w for w in kitchen.items if w.role == "island" and w.choice.params.get("corbels")]
    assert tops
    for top in tops:
        left = top.spot.u - top.choice.params["width"] / 2
        reach = CORBEL_REACH
        for seat in (w for w in kitchen.items if w.role == "stool" and w.run == top.run):
            for corbel in top.choice.params["corbels"]:
                beside = abs(left + corbel - seat.spot.u) - CORBEL_WIDTH / 2
                assert np.hypot(beside, -seat.spot.v - reach) > radius, (seat.name, corbel)


def test_what_a_style_lacks_is_named() -> None:
    style = style_of("coastal")
    less = style.replace(models={k: v for k, v in style.models.items() if k != "range"})
    with pytest.raises((UnknownId, PlanConflict), match="range"):
        kitchen_of("l_small", less)
    worse = style.replace(models={**style.models, "range": PresetChoice(preset="range/unheard_of")})
    with pytest.raises(UnknownId, match="unheard_of"):
        kitchen_of("l_small", worse)
    with pytest.raises(CasaError, match="width"):
        params_of(PresetChoice(preset="range/pro_six", params={"width": 9.0}))


SIZE_NAMES = ("width", "depth", "height", "size", "form", "casing", "jar", "jar_top", "mount", "corner")


def bounds(metadata: list[Any]) -> list[float | None] | None:
    found = [next((getattr(m, e) for m in metadata if getattr(m, e, None) is not None), None) for e in ("ge", "le")]
    return None if None in found else found


def test_family_sizes_of_the_registry_are_those_of_the_code() -> None:
    rows = {}
    for name, model in sorted(MODELS.items()):
        fields = model.params.model_fields
        stated = {k: fields[k].default for k in fields if k in SIZE_NAMES and not fields[k].is_required()}
        plain = {k: getattr(v, "value", v) for k, v in stated.items() if isinstance(v, int | float | str)}
        spans = {side: bounds(fields[side].metadata) if side in fields else None for side in ("width", "height")}
        rows[name] = flow_text({"defaults": plain, **spans})
    text = (data_root() / "family_sizes.yaml").read_text(encoding="utf-8")
    head = "".join(line for line in text.splitlines(keepends=True) if line.startswith("#"))
    assert text == head + "".join(f"{name}: {row}\n" for name, row in rows.items())
