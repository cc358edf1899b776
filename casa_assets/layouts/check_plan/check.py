"""Check a plan without building anything: every fault, each with a correction if one is near, and the corrected plan.

Faults are found in rounds: YAML syntax, then values, names, the walls, and conflicts of space. The corrections of a
round are made in a copy of the text before the next round looks at it, so that one call reports all faults.
"""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from casa_assets.errors import CasaError, RegistryError
from casa_assets.layouts.check_plan.conflicts import resolve
from casa_assets.layouts.check_plan.draft import Draft
from casa_assets.layouts.check_plan.mends import problem_faults
from casa_assets.layouts.check_plan.values import name_faults, record_faults, wall_faults
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.model.kitchen.style import Style
from casa_assets.model.registry.document import Document
from casa_assets.registry.edit import (
    Edit,
    EditKind,
    Fault,
    Mend,
    block_text,
    edited,
    edited_value,
    spelt,
    value_at,
)
from casa_assets.registry.kitchens import LIKE, laid_over_like
from casa_assets.registry.read import parse_document

MAX_ROUNDS = 60
# Stages: what is looked at, one after the other. Mends of the last two were tried before they are offered.
TEXT, VALUES, NAMES, WALLS, CONFLICTS, PROBLEMS, FITS = range(7)


@dataclass(frozen=True)
class ToldFault:
    """A fault with its location: the file, which may be that of the plan named by `like`, and the line, counted from 1.

    For a part that an earlier mend has added, the location is where it was added. `old`: the values that the edits of
    the fault's mend replace.
    """

    fault: Fault
    file: str
    line: int
    old: tuple[Any, ...] = ()

    @property
    def facts(self) -> dict[str, Any]:
        """As JSON has it."""
        fault, mend = self.fault, None
        if fault.mend is not None:
            pairs = zip(fault.mend.edits, self.old, strict=True)
            edits = [{"op": e.kind, "pointer": [*e.pointer], "old": old, "new": e.value} for e, old in pairs]
            mend = {"sentence": fault.mend.sentence, "edits": edits}
        told = {"pointer": [*fault.pointer], "expected": fault.expected, "got": fault.got, "mend": mend}
        return {"file": self.file, "line": self.line, **told}


@dataclass(frozen=True)
class PlanCheck:
    """Result of a check: faults, in the order in which their mends are to be made, and the text with all these made.

    `kitchen`: of that text; None if a fault without a mend is left.
    """

    faults: tuple[ToldFault, ...]
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

    Args:
        file: its name, whose stem is the plan's id.
        style: that it is tried with. fixed_walls: where doors clash or an aisle is narrow, the room is not made larger.
    """
    told: list[ToldFault] = []
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
            told += [_told(replace(fault, mend=None), text, now, file) for fault in faults]
            return PlanCheck(tuple(told), now, None)
        told += [_told(fault, text, now, file) for fault in made]
        seen.add(after)
        now, (stage, faults, kitchen) = after, left
    return PlanCheck(tuple(told), now, kitchen)


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
            mend = Mend(f"Write `{LIKE}: {near}`.", (Edit.put((LIKE,), near),))
        elif "walls" in document.value:
            mend = Mend(f"Take out '{LIKE}'.", (Edit.remove((LIKE,)),))
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
        steps.append(Edit.put((top,), whole[top]))
    for step in steps:
        try:
            after = edited(text, step)
            if plan_document(after, file)[0].value == whole:
                return after
        except (KeyError, IndexError, TypeError):
            continue
    return block_text(whole)


def _told(fault: Fault, first: str, now: str, file: str) -> ToldFault:
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
            return ToldFault(fault, document.files[at], line, old)
    matcher = difflib.SequenceMatcher(None, now.splitlines(), first.splitlines(), autojunk=False)
    for _, a0, a1, b0, b1 in matcher.get_opcodes():
        if a0 <= line - 1 < a1:
            line = min(b0 + line - 1 - a0, max(b1 - 1, b0)) + 1
            break
    return ToldFault(fault, file, max(1, min(line, len(first.splitlines()))), old)
