"""Check a plan without building anything: every fault, each with a correction if one is near, and the corrected plan.

Faults are found in rounds: what is no YAML, then values, names, the walls, and what is in the way of what. The
corrections of a round are made in a copy of the text before the next round looks at it, so that one call tells all.
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

from casa_assets.errors import CasaError, RegistryError
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.model.kitchen.style import Style
from casa_assets.model.registry.document import Document, KeyPath
from casa_assets.pipeline.plans.conflicts import resolve
from casa_assets.pipeline.plans.draft import Draft
from casa_assets.pipeline.plans.edits import (
    Edit,
    EditKind,
    Fault,
    Mend,
    block_text,
    edited,
    edited_value,
    put,
    removed,
    spelt,
    value_at,
)
from casa_assets.pipeline.plans.mends import problem_faults
from casa_assets.pipeline.plans.values import name_faults, record_faults, wall_faults
from casa_assets.registry.kitchens import LIKE, laid_over_like
from casa_assets.registry.read import parse_document

MAX_ROUNDS = 60


@dataclass(frozen=True)
class ToldFault:
    """A fault and where it is: of what a mend has added, where that was added.

    Attributes:
        file: the one that was given, or that of the plan which it is like. line: of it, counted from 1.
        old: what stands where the edits of its mend are made.
    """

    fault: Fault
    file: str
    line: int
    old: tuple[Any, ...] = ()

    @property
    def facts(self) -> dict[str, Any]:
        """As JSON has it."""
        mend = self.fault.mend
        return {
            "file": self.file,
            "line": self.line,
            "pointer": list(self.fault.pointer),
            "expected": self.fault.expected,
            "got": self.fault.got,
            "mend": None
            if mend is None
            else {
                "sentence": mend.sentence,
                "edits": [
                    {"op": e.kind.value, "pointer": list(e.pointer), "old": old, "new": e.value}
                    for e, old in zip(mend.edits, self.old, strict=True)
                ],
            },
        }


@dataclass(frozen=True)
class PlanCheck:
    """What a check found.

    Attributes:
        faults: in the order in which their mends are to be made.
        text: of the file with all mends made.
        kitchen: of that text; None where a fault is left that has no mend.
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
            if stage in TRIED or left[0] > stage or (left[0] == stage and len(left[1]) < len(faults)):
                break
        else:
            told += [_told(replace(fault, mend=None), text, now, file) for fault in faults]
            return PlanCheck(tuple(told), now, None)
        told += [_told(fault, text, now, file) for fault in made]
        seen.add(after)
        now, (stage, faults, kitchen) = after, left
    return PlanCheck(tuple(told), now, kitchen)


class Stage(IntEnum):
    """What is looked at, one after the other."""

    TEXT = 0
    VALUES = 1
    NAMES = 2
    WALLS = 3
    CONFLICTS = 4
    PROBLEMS = 5
    FITS = 6


TRIED = (Stage.CONFLICTS, Stage.PROBLEMS)  # whose mends were tried before they are offered


def find_faults(
    text: str, file: str, style: Style, fixed_walls: bool = False
) -> tuple[Stage, list[Fault], KitchenRequest | None]:
    """The first stage that has faults, these, and the kitchen of a text that has none."""
    try:
        document, wrong = plan_document(text, file)
    except RegistryError as error:
        return Stage.TEXT, [Fault((), error.expected, error.got, None, error.line)], None
    if wrong is not None:
        return Stage.TEXT, [wrong], None
    raw, stem = document.value, plan_id(file)
    if found := record_faults(raw, stem):
        return Stage.VALUES, found, None
    draft = Draft.of(raw, stem, style)
    if found := name_faults(raw, draft.plan, style):
        return Stage.NAMES, found, None
    if found := wall_faults(raw, draft.plan):
        return Stage.WALLS, found, None
    _, conflict = resolve(draft)
    if conflict is not None:
        return Stage.CONFLICTS, [conflict], None
    if found := problem_faults(draft, fixed_walls):
        return Stage.PROBLEMS, found, None
    return Stage.FITS, [], draft.kitchen


def plan_id(file: str) -> str:
    """Id of a plan, after the name of its file."""
    stem = spelt(file.replace("\\", "/").rsplit("/", 1)[-1].rsplit(".", 1)[0])
    return stem if stem[:1].isalpha() else f"plan_{stem}".rstrip("_")


def plan_document(text: str, file: str) -> tuple[Document, Fault | None]:
    """The document of a text, laid over the plan that it is like; with a fault where there is none of that name."""
    document = parse_document(text, file)
    if not isinstance(document.value, dict) or LIKE not in document.value:
        return document, None
    try:
        return laid_over_like(document, plan_id(file)), None
    except CasaError as error:
        names = getattr(error, "expected", str(error))
        near = names.split("'")[1] if names.startswith("'") else None
        if near:
            mend = Mend(f"Write `{LIKE}: {near}`.", (put((LIKE,), near),))
        elif "walls" in document.value:
            mend = Mend(f"Take out '{LIKE}'.", (removed((LIKE,)),))
        else:
            return document, Fault((LIKE,), names, repr(document.value[LIKE]), None)
        return document, Fault((LIKE,), names, repr(document.value[LIKE]), mend)


def _mended(text: str, file: str, faults: list[Fault]) -> tuple[str, list[Fault]]:
    """The text after the mends of faults, and those whose mend was made: one waits where another changed its place."""
    made: list[Fault] = []
    touched: list[tuple[KeyPath, bool]] = []
    for fault in faults:
        mend = fault.mend
        if mend is None:
            continue
        if any(_waits(edit.pointer, touched) for edit in mend.edits):
            continue
        after = text
        for edit in mend.edits:
            after = edited_text(after, file, edit)
        if after != text:
            text = after
            made.append(fault)
            touched += [(e.pointer, e.kind in (EditKind.REMOVE, EditKind.INSERT, EditKind.RENAME)) for e in mend.edits]
    return text, made


def _waits(pointer: KeyPath, touched: list[tuple[KeyPath, bool]]) -> bool:
    """True if an edit that was made may have changed what a pointer leads to."""
    for at, moves in touched:
        if pointer[: len(at)] == at or at[: len(pointer)] == pointer:
            return True
        if moves and isinstance(at[-1], int) and pointer[: len(at) - 1] == at[:-1]:
            return True
    return False


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


def _told(fault: Fault, first: str, now: str, file: str) -> ToldFault:
    """A fault with its line in the text that was given, which earlier mends have changed."""
    line = fault.line
    old: tuple[Any, ...] = ()
    try:
        document, _ = plan_document(now, file)
    except CasaError:
        document = None
    if document is not None:
        at = fault.pointer
        while at and at not in document.lines:
            at = at[:-1]
        line = line or document.lines.get(at, 1)
        old = tuple(value_at(document.value, e.pointer) for e in fault.mend.edits) if fault.mend else ()
        if document.files.get(at, file) != file:
            return ToldFault(fault, document.files[at], line, old)
    if fault.mend and len(old) != len(fault.mend.edits):
        old = (None,) * len(fault.mend.edits)
    line = line if first == now else _first_line(first, now, line)
    return ToldFault(fault, file, min(line, max(len(first.splitlines()), 1)), old)


def _first_line(first: str, now: str, line: int) -> int:
    matcher = difflib.SequenceMatcher(None, now.splitlines(), first.splitlines(), autojunk=False)
    for op, a0, a1, b0, b1 in matcher.get_opcodes():
        if a0 <= line - 1 < a1:
            return (b0 + line - 1 - a0 if op == "equal" else min(b0 + (line - 1 - a0), max(b1 - 1, b0))) + 1
    return max(1, min(line, len(first.splitlines())))
