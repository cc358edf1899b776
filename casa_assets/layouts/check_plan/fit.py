"""Fit a plan to a room of another size: walls first, then what no longer fits, as a designer would give it up.

Rows are made narrower, then lose shelves, fillers and open cabinets, then doors, then drawers (`conflicts.GIVEN_UP`).
Openings move into their walls. Sink, cooker and refrigerator stay, or the plan is refused.
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass

from casa_assets.errors import CasaError
from casa_assets.layouts.check_plan.check import check_plan, edited_text, plan_document, plan_id
from casa_assets.layouts.check_plan.draft import Draft
from casa_assets.layouts.plan.room import AXES
from casa_assets.model.kitchen.plan import COOKERS, BaseKind, Plan
from casa_assets.model.kitchen.style import Style
from casa_assets.registry.edit import Edit, flow_text

KEPT = (BaseKind.SINK, BaseKind.FRIDGE)
TOLERANCE_M = 0.005
Size = tuple[float, float]  # of a room along x and y, metres
SEARCH_STEPS = 6  # of the least room, each of which halves what is not known of it


@dataclass(frozen=True)
class FittedPlan:
    """A plan in another room: the text of its file, and its changes, one sentence each, in their order."""

    text: str
    changes: tuple[str, ...]


class DoesNotFit(CasaError):
    """A room that a plan cannot be fitted to: why not, and the least room of that shape that it can."""

    def __init__(self, reason: str, least: Size) -> None:
        self.reason, self.least = reason, least
        super().__init__(f"{reason}; the least room for it is about {least[0]:.2f} x {least[1]:.2f} m")


def fit_plan(text: str, file: str, style: Style, width: float, depth: float) -> FittedPlan:
    """The plan with walls of another size and with what fits between them.

    Args:
        file: name of the file; the plan may be like another. style: that it is tried with.
        width, depth: of the room, along x and y, metres.
    Raises:
        DoesNotFit: nothing that keeps its sink, cooker and refrigerator fits. CasaError: the plan has faults.
    """
    look = f"look at it with `casa-assets scenes check-plan {shlex.quote(str(file))}`"
    before = check_plan(text, file, style)
    if not before.fits or before.kitchen is None:
        raise CasaError(f"{file}: has faults of its own; {look}")
    aslant = next((w.id for w in before.kitchen.plan.walls if w.is_aslant), None)
    if aslant is not None:
        raise CasaError(
            f"{file}: its wall {aslant} stands aslant; only rooms whose walls meet at right angles are fitted. "
            f"Change the lengths of its walls by hand, and {look}"
        )
    (x0, y0), (x1, y1) = before.kitchen.room.bounds()
    size = (round(x1 - x0, 4), round(y1 - y0, 4))
    fitted, reason = _tried(text, file, style, size, (width, depth))
    if fitted is not None:
        return fitted
    raise DoesNotFit(f"{file}: {reason}", _least(text, file, style, size, (width, depth)))


def _least(text: str, file: str, style: Style, size: Size, wanted: Size) -> Size:
    """The least room between the one that is wanted and the plan's own."""
    low, high = 0.0, 1.0
    found = (max(wanted[0], size[0]), max(wanted[1], size[1]))
    for _ in range(SEARCH_STEPS):
        share = (low + high) / 2
        w, d = (round(a + share * (max(a, b) - a), 2) for a, b in zip(wanted, size, strict=True))
        if _tried(text, file, style, size, (w, d))[0] is not None:
            high, found = share, (w, d)
        else:
            low = share
    return found


def _tried(text: str, file: str, style: Style, size: Size, wanted: Size) -> tuple[FittedPlan | None, str]:
    """The plan in a room, or None with the reason."""
    draft = Draft.of(plan_document(text, file)[0].value, plan_id(file), style)
    resized, said = text, []
    for edit, sentence in _resized(draft, size, wanted):
        resized = edited_text(resized, file, edit)
        said.append(sentence)
    found = check_plan(resized, file, style, fixed_walls=True)
    if found.kitchen is None:
        last = found.faults[-1].fault
        return None, f"expected {last.expected}, got {last.got}"
    (x0, y0), (x1, y1) = found.kitchen.room.bounds()
    if abs(x1 - x0 - wanted[0]) > TOLERANCE_M or abs(y1 - y0 - wanted[1]) > TOLERANCE_M:
        first = next((t.fault for t in found.faults if t.fault.mend and "length" in t.fault.mend.sentence), None)
        return None, "needs longer walls" if first is None else f"expected {first.expected}, got {first.got}"
    lost = sorted(_essential(draft.plan) - _essential(found.kitchen.plan))
    if lost:
        return None, f"there is no place for the {' and the '.join(lost)}"
    said += [told.fault.mend.sentence for told in found.faults if told.fault.mend]
    return FittedPlan(found.text, tuple(said)), ""


def _essential(plan: Plan) -> set[str]:
    """Kinds of units that a kitchen keeps: sink, refrigerator, and a cooker of either kind."""
    kinds = {unit.kind for unit in plan.units.values()}
    return {kind.value for kind in KEPT if kind in kinds} | ({"cooker"} if kinds & set(COOKERS) else set())


def _resized(draft: Draft, size: Size, wanted: Size) -> list[tuple[Edit, str]]:
    """Edits that make the walls of a room as long as is wanted; parts of a side keep their share of it."""
    out: dict[str, tuple[Edit, str]] = {}
    for headings, old, new in zip(AXES, size, wanted, strict=True):
        for wall in draft.plan.walls:
            if wall.heading not in headings or wall.length is None or abs(old - new) < 1e-9:
                continue
            now = draft.plan.length(wall.length, draft.plan.defaults)
            value = round(new if abs(now - old) < 1e-3 else now * new / old, 3)
            if isinstance(wall.length, str):
                three, name = [value, value, value], wall.length
                edit = Edit.put(("parameters", name), three)
                out.setdefault(f"parameter {name}", (edit, f"Write {name}: {flow_text(three)}."))
            else:
                edit = Edit.put((*draft.row("walls", wall.id), "length"), value)
                out[wall.id] = (edit, f"Write `length: {value:g}` for {wall.id}.")
    return list(out.values())
