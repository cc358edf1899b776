"""registry/family_sizes.yaml says of families what their code says."""

from __future__ import annotations

from typing import Any

from casa_assets.kitchenware.catalog import MODELS
from casa_assets.layouts.check_plan.draft import PresetSizes, family_sizes
from casa_assets.layouts.check_plan.edit import flow_text
from casa_assets.layouts.order.request import request_kitchen
from casa_assets.layouts.run.resolve import preset_params
from casa_assets.projects import data_root
from casa_assets.registry.kitchens import load_plan, load_style, plan_names, style_names

NAMES = ("width", "depth", "height", "size", "form", "casing", "jar", "jar_top", "mount", "corner")


def bounds(metadata: list[Any]) -> list[float | None] | None:
    found = [next((getattr(m, e) for m in metadata if getattr(m, e, None) is not None), None) for e in ("ge", "le")]
    return None if None in found else found


def test_sizes_are_those_of_the_code() -> None:
    rows = {}
    for name, model in sorted(MODELS.items()):
        fields = model.params.model_fields
        stated = {k: fields[k].default for k in fields if k in NAMES and not fields[k].is_required()}
        plain = {k: getattr(v, "value", v) for k, v in stated.items() if isinstance(v, int | float | str)}
        spans = {side: bounds(fields[side].metadata) if side in fields else None for side in ("width", "height")}
        rows[name] = flow_text({"defaults": plain, **spans})
    text = (data_root() / "family_sizes.yaml").read_text(encoding="utf-8")
    head = "".join(line for line in text.splitlines(keepends=True) if line.startswith("#"))
    assert text == head + "".join(f"{name}: {row}\n" for name, row in rows.items())


def test_kitchens_are_the_same_with_them() -> None:
    """What is asked of the code of families when a kitchen is made is all there."""
    sizes = PresetSizes()
    for k, name in enumerate(style_names()):
        style, plan = load_style(name)[0], load_plan(plan_names()[k % len(plan_names())])[0]
        light, whole = (request_kitchen(plan, style, presets) for presets in (sizes, preset_params()))
        assert light.slots == whole.slots
        assert [(i.name, i.choice.preset, i.spot) for i in light.items] == [
            (i.name, i.choice.preset, i.spot) for i in whole.items
        ]
    assert set(family_sizes()) == set(MODELS)
