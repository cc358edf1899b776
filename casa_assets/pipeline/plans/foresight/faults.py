"""The faults of what a kitchen would fail its checks by: each mend was tried before it is offered."""

from __future__ import annotations

import itertools
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
from casa_assets.pipeline.plans.foresight.candidates import candidates, last_resorts
from casa_assets.pipeline.plans.foresight.problems import Problem, ProblemKind, problems_of
from casa_assets.pipeline.plans.sizes import PresetSizes
from casa_assets.pipeline.plans.written import place_of, row_at, unit_at
from casa_assets.registry.edit import Edit, edited_value
from casa_assets.registry.roles import load_roles

SMALLER = 0.7  # share of the excess of a problem that a mend may leave, where none takes it away
ITEM_WEIGHT = 0.01
OF_WALLS = ("walls", "parameters")  # keys of a plan
MOST_CONFLICTS = 5  # one after the other, that a mend may leave behind for the next rounds
KEPT = (BaseKind.SINK, BaseKind.RANGE, BaseKind.HOB, BaseKind.FRIDGE, BaseKind.DISHWASHER)


def foreseen_faults(raw: Any, kitchen: KitchenRequest, fixed_walls: bool = False) -> list[Fault]:
    """The first problem of a kitchen, since its mend may be that of others; none where it would pass.

    Args:
        fixed_walls: no mend changes lengths of walls.
    """
    problems = problems_of(kitchen)
    if not problems:
        return []
    first = problems[0]
    tried: list[tuple[Mend, list[Problem]]] = []
    mend = None
    for one in itertools.chain(candidates(raw, kitchen, first), last_resorts(raw, kitchen, first)):
        if fixed_walls and any(edit.pointer[0] in OF_WALLS for edit in one.edits):
            continue
        found = _left(raw, kitchen, one)
        if found is None or not _is_less(found, problems):
            continue
        if not _is_in(first, found):
            mend = one
            break
        tried.append((one, found))
    if mend is None:  # what makes it smaller, until the next round
        mend = next((m for m, found in tried if not _is_in(first, found, SMALLER)), None)
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


def _left(raw: Any, kitchen: KitchenRequest, mend: Mend) -> list[Problem] | None:
    """The problems after a mend; None where it makes no kitchen, or takes away what a kitchen needs."""
    after = _after(raw, kitchen, mend.edits)
    return None if after is None or _kept(after.plan) < _kept(kitchen.plan) else problems_of(after)


def _is_less(found: list[Problem], before: list[Problem]) -> bool:
    """True if problems are fewer, or as many and smaller."""
    return (len(found), _weight(found)) < (len(before), _weight(before))


def _is_in(problem: Problem, found: Iterable[Problem], share: float = 0.0) -> bool:
    """True if a problem is there again, with at least a share of its excess."""
    again = (p for p in found if (p.kind, p.owners) == (problem.kind, problem.owners))
    return any(not share or p.excess >= share * problem.excess for p in again)


def _weight(problems: Iterable[Problem]) -> float:
    """How much is missing in all, metres; things on worktops count little, for they are moved most easily."""
    return sum(p.excess * (ITEM_WEIGHT if p.kind is ProblemKind.ITEM else 1.0) for p in problems)


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
