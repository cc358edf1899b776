"""registry/family_sizes.yaml says of families what their code says."""

from __future__ import annotations

from typing import Any

from casa_assets.kitchenware.catalog import MODELS
from casa_assets.layouts.check_plan.edit import flow_text
from casa_assets.projects import data_root

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
