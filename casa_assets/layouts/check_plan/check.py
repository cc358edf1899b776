"""Check a plan without building anything: every fault, each with a correction if one is near, and the corrected plan.

Faults are found in rounds: YAML syntax, then values, names, the walls, and conflicts of space. The corrections of a
round are made in a copy of the text before the next round looks at it, so that one call reports all faults. A plan is
fitted to a room of another size by giving its walls that size and making the corrections of what no longer fits.
"""

from __future__ import annotations

import difflib
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from casa_assets.errors import CasaError, RegistryError
from casa_assets.layouts.check_plan.draft import Draft
from casa_assets.layouts.check_plan.edit import (
    Edit,
    EditKind,
    Fault,
    Mend,
    block_text,
    edited,
    edited_value,
    flow_text,
    put,
    spelt,
    value_at,
)
from casa_assets.layouts.check_plan.mends import problem_faults, resolve
from casa_assets.layouts.check_plan.values import name_faults, record_faults, wall_faults
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.plan.room import AXES
from casa_assets.model.kitchen.plan import COOKERS, BaseKind, Plan
from casa_assets.model.kitchen.style import Style
from casa_assets.model.registry.document import Document
from casa_assets.registry.kitchens import LIKE, laid_over_like
from casa_assets.registry.read import parse_document

MAX_ROUNDS = 60
# Stages: what is looked at, one after the other. Mends of the last two were tried before they are offered.
TEXT, VALUES, NAMES, WALLS, CONFLICTS, PROBLEMS, FITS = range(7)
KEPT_KINDS = (BaseKind.SINK, BaseKind.FRIDGE)
TOLERANCE_M = 0.005
Size = tuple[float, float]  # of a room along x and y, metres
SEARCH_STEPS = 6  # of the least room, each of which halves what is not known of it


@dataclass(frozen=True)
class PlanCheck:
    """Result of a check: faults, in the order in which their mends are to be made, and the text with all these made.

    `kitchen`: of that text; None if a fault without a mend is left.
    """

    faults: tuple[Fault, ...]
    text: str
    kitchen: KitchenRequest | None

    @property
    def fits(self) -> bool:
        """True if the plan is right as it is."""
        return not self.faults

    @property
    def mended(self) -> bool:
        """True if all mends together make a plan that fits."""
        return self.kitchen is not None


def check_plan(text: str, file: str, style: Style, fixed_walls: bool = False) -> PlanCheck:
    """Check the text of a plan. Raises RegistryError or UnknownId where a file that it needs is wrong, not for its own.

    `file`: its name, whose stem is the plan's id. `style`: that it is tried with. `fixed_walls`: where doors clash or
    an aisle is narrow, the room is not made larger.
    """
    reported: list[Fault] = []
    now, seen = text, {text}
    stage, faults, kitchen = find_faults(now, file, style, fixed_walls)
    while faults:
        # All mends at once, or the first one that leaves fewer faults.
        for batch in (faults, *([fault] for fault in faults)):
            after, made = _mended(now, file, batch)
            if after in seen or len(seen) > MAX_ROUNDS:
                continue
            left = find_faults(after, file, style, fixed_walls)
            if stage >= CONFLICTS or left[0] > stage or (left[0] == stage and len(left[1]) < len(faults)):
                break
        else:
            reported += [_located(replace(fault, mend=None), text, now, file) for fault in faults]
            return PlanCheck(tuple(reported), now, None)
        reported += [_located(fault, text, now, file) for fault in made]
        seen.add(after)
        now, (stage, faults, kitchen) = after, left
    return PlanCheck(tuple(reported), now, kitchen)


def find_faults(
    text: str, file: str, style: Style, fixed_walls: bool = False
) -> tuple[int, list[Fault], KitchenRequest | None]:
    """The first stage that has faults, these, and the kitchen of a text that has none."""
    try:
        document, wrong = plan_document(text, file)
    except RegistryError as error:
        return TEXT, [Fault((), error.expected, error.got, None, error.line)], None
    if wrong is not None:
        return TEXT, [wrong], None
    raw, stem = document.value, plan_id(file)
    if found := record_faults(raw, stem):
        return VALUES, found, None
    draft = Draft.of(raw, stem, style)
    if found := name_faults(draft):
        return NAMES, found, None
    if found := wall_faults(draft):
        return WALLS, found, None
    _, conflict = resolve(draft)
    if conflict is not None:
        return CONFLICTS, [conflict], None
    if found := problem_faults(draft, fixed_walls):
        return PROBLEMS, found, None
    return FITS, [], draft.kitchen


def plan_id(file: str) -> str:
    """Id of a plan, after the name of its file."""
    stem = spelt(file.replace("\\", "/").rsplit("/", 1)[-1].rsplit(".", 1)[0])
    return stem if stem[:1].isalpha() else f"plan_{stem}".rstrip("_")


def plan_document(text: str, file: str) -> tuple[Document, Fault | None]:
    """Parse a text and lay it over the plan named by `like`; with a fault if there is no plan of that name."""
    document = parse_document(text, file)
    if not isinstance(document.value, dict) or LIKE not in document.value:
        return document, None
    try:
        return laid_over_like(document, plan_id(file)), None
    except CasaError as error:
        names, mend = getattr(error, "expected", str(error)), None
        if names.startswith("'"):
            near = names.split("'")[1]
            mend = Mend.write((), **{LIKE: near})
        elif "walls" in document.value:
            mend = Mend.take_out((LIKE,), repr(LIKE))
        return document, Fault((LIKE,), names, repr(document.value[LIKE]), mend)


def _mended(text: str, file: str, faults: Sequence[Fault]) -> tuple[str, list[Fault]]:
    """The text after the mends of faults, and those whose mend was made: one waits where another changed its place."""
    made: list[Fault] = []
    first = now = plan_document(text, file)[0].value if any(fault.mend for fault in faults) else None
    for fault in (fault for fault in faults if fault.mend):
        edits = fault.mend.edits if fault.mend else ()
        # What is before an item of a list decides its number.
        places = [e.pointer[:-1] if e.pointer and isinstance(e.pointer[-1], int) else e.pointer for e in edits]
        if any(value_at(now, at) != value_at(first, at) for at in places):
            continue
        for edit in edits:
            text = edited_text(text, file, edit)
        now = plan_document(text, file)[0].value
        made += [fault] if edits else []
    return text, made


def edited_text(text: str, file: str, edit: Edit) -> str:
    """The text with an edit; of a plan that is like another, what that one states is copied to where it changes.

    Where the other states what the edit takes out, the whole plan is written, without `like`.
    """
    own: Any = parse_document(text, file).value if edit.pointer else None
    if not isinstance(own, dict) or LIKE not in own or edit.pointer == (LIKE,):
        return edited(text, edit)
    document, wrong = plan_document(text, file)
    if wrong is not None:
        return edited(text, edit)
    whole, top = edited_value(document.value, edit), edit.pointer[0]
    is_own = edit.kind is EditKind.INSERT or value_at(own, edit.pointer[:-1]) is not None
    steps = [edit] if is_own else []
    if isinstance(top, str) and top in whole:
        steps.append(put((top,), whole[top]))
    for step in steps:
        try:
            after = edited(text, step)
            if plan_document(after, file)[0].value == whole:
                return after
        except (KeyError, IndexError, TypeError):
            continue
    return block_text(whole)


def _located(fault: Fault, first: str, now: str, file: str) -> Fault:
    """A fault with its line in the text that was given, which earlier mends have changed."""
    edits, line = fault.mend.edits if fault.mend else (), fault.line
    old: tuple[Any, ...] = (None,) * len(edits)
    try:
        document, _ = plan_document(now, file)
    except CasaError:
        document = None
    if document is not None:
        at = fault.pointer
        while at and at not in document.lines:
            at = at[:-1]
        line = line or document.lines.get(at, 1)
        old = tuple(value_at(document.value, e.pointer) for e in edits)
        if document.files.get(at, file) != file:
            return replace(fault, file=document.files[at], line=line, old=old)
    matcher = difflib.SequenceMatcher(None, now.splitlines(), first.splitlines(), autojunk=False)
    for _, a0, a1, b0, b1 in matcher.get_opcodes():
        if a0 <= line - 1 < a1:
            line = min(b0 + line - 1 - a0, max(b1 - 1, b0)) + 1
            break
    return replace(fault, file=file, line=max(1, min(line, len(first.splitlines()))), old=old)


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

    `file`: name of the file; the plan may be like another. `style`: that it is tried with. `width`, `depth`: of the
    room, along x and y, metres. Raises DoesNotFit: nothing that keeps its sink, cooker and refrigerator fits.
    CasaError: the plan has faults.
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
    fitted, reason = _fitted(text, file, style, size, (width, depth))
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
        if _fitted(text, file, style, size, (w, d))[0] is not None:
            high, found = share, (w, d)
        else:
            low = share
    return found


def _fitted(text: str, file: str, style: Style, size: Size, wanted: Size) -> tuple[FittedPlan | None, str]:
    """The plan in a room, or None with the reason."""
    draft = Draft.of(plan_document(text, file)[0].value, plan_id(file), style)
    resized, said = text, []
    for edit, sentence in _resized(draft, size, wanted):
        resized = edited_text(resized, file, edit)
        said.append(sentence)
    found = check_plan(resized, file, style, fixed_walls=True)
    if found.kitchen is None:
        last = found.faults[-1]
        return None, f"expected {last.expected}, got {last.got}"
    (x0, y0), (x1, y1) = found.kitchen.room.bounds()
    if abs(x1 - x0 - wanted[0]) > TOLERANCE_M or abs(y1 - y0 - wanted[1]) > TOLERANCE_M:
        first = next((t for t in found.faults if t.mend and "length" in t.mend.sentence), None)
        return None, "needs longer walls" if first is None else f"expected {first.expected}, got {first.got}"
    lost = sorted(_essential(draft.plan) - _essential(found.kitchen.plan))
    if lost:
        return None, f"there is no place for the {' and the '.join(lost)}"
    said += [fault.mend.sentence for fault in found.faults if fault.mend]
    return FittedPlan(found.text, tuple(said)), ""


def _essential(plan: Plan) -> set[str]:
    """Kinds of units that a kitchen keeps: sink, refrigerator, and a cooker of either kind."""
    kinds = {unit.kind for unit in plan.units.values()}
    return {kind.value for kind in KEPT_KINDS if kind in kinds} | ({"cooker"} if kinds & set(COOKERS) else set())


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
                edit = put(("parameters", name), three)
                out.setdefault(f"parameter {name}", (edit, f"Write {name}: {flow_text(three)}."))
            else:
                edit = put((*draft.row("walls", wall.id), "length"), value)
                out[wall.id] = (edit, f"Write `length: {value:g}` for {wall.id}.")
    return list(out.values())
