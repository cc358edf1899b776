"""The faults of what a kitchen would fail its checks by: each mend was tried before it is offered."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import ValidationError

from casa_assets.errors import CasaError, PlanConflict
from casa_assets.layouts.order.request import KitchenRequest, request_kitchen
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.plan import Plan
from casa_assets.model.kitchen.units import BaseKind
from casa_assets.model.registry.document import KeyPath
from casa_assets.pipeline.plans.conflicts import mend_of
from casa_assets.pipeline.plans.fault import Fault, Mend
from casa_assets.pipeline.plans.foresight.candidates import candidates
from casa_assets.pipeline.plans.foresight.problems import Problem, problems_of
from casa_assets.pipeline.plans.sizes import PresetSizes
from casa_assets.pipeline.plans.written import place_of, row_at, unit_at
from casa_assets.registry.edit import Edit, edited_value
from casa_assets.registry.roles import load_roles

MOST_CONFLICTS = 5  # one after the other, that a mend may leave behind for the next rounds
KEPT = (BaseKind.SINK, BaseKind.RANGE, BaseKind.HOB, BaseKind.FRIDGE, BaseKind.DISHWASHER)


def foreseen_faults(raw: Any, kitchen: KitchenRequest) -> list[Fault]:
    """The first problem of a kitchen, since its mend may be that of others; none where it would pass."""
    problems = problems_of(kitchen)
    if not problems:
        return []
    first = problems[0]
    mend = next((m for m in candidates(raw, kitchen, first) if _helps(raw, kitchen, problems, m)), None)
    return [Fault(_pointer(raw, kitchen, first.about), first.expected, first.got, mend)]


def _pointer(raw: Any, kitchen: KitchenRequest, name: str) -> KeyPath:
    """Where a unit, an opening or a run of that name is written; its run for a unit that the layout adds."""
    if name == "all_tasks":
        return (name,)
    if any(o.id == name for o in kitchen.plan.openings):
        return row_at(raw, "openings", name)
    if any(i.id == name for i in kitchen.plan.worktop_items):
        return (*row_at(raw, "worktop_items", name), "on")
    if name in kitchen.lines:
        return row_at(raw, "runs", name)
    found = place_of(kitchen.plan, name)
    return unit_at(raw, *found) if found else row_at(raw, "runs", kitchen.slot(name).line.id)


def _helps(raw: Any, kitchen: KitchenRequest, before: list[Problem], mend: Mend) -> bool:
    """True if a mend takes the first problem away, leaves fewer or smaller ones, and all that a kitchen needs."""
    after = _after(raw, kitchen, mend.edits)
    if after is None or _kept(after.plan) < _kept(kitchen.plan):
        return False
    found = problems_of(after)
    return (len(found), _weight(found)) < (len(before), _weight(before)) and not _is_in(before[0], found)


def _is_in(problem: Problem, found: Iterable[Problem]) -> bool:
    return any((p.kind, p.owners) == (problem.kind, problem.owners) for p in found)


def _weight(problems: Iterable[Problem]) -> float:
    return sum(p.excess for p in problems)


def _kept(plan: Plan) -> int:
    """How many of its units a kitchen has to keep."""
    return sum(unit.kind in KEPT for unit in plan.units.values())


def _after(raw: Any, kitchen: KitchenRequest, edits: Iterable[Edit]) -> KitchenRequest | None:
    """The kitchen after edits, and after the mends of what then does not fit; None where nothing comes of it."""
    value, sizes, roles = raw, PresetSizes(), load_roles()
    try:
        for _ in range(MOST_CONFLICTS):
            for edit in edits:
                value = edited_value(value, edit)
            plan = Plan.model_validate({**value, "id": kitchen.plan.id})
            try:
                return request_kitchen(plan, kitchen.style, sizes, roles=roles)
            except PlanConflict as error:
                models = StyleModels(kitchen.style, sizes, roles, plan.height)
                mend = mend_of(error, value, plan, models, plan.defaults)
                if mend is None:
                    return None
                edits = mend.edits
    except (ValidationError, CasaError, KeyError, IndexError, TypeError):
        return None  # what is named is no longer there
    return None
