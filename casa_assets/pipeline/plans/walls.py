"""Mend walls that do not go round a room: lengths that do not close, wrong turns, the wrong way round."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from casa_assets.layouts.plan.room import AXES, corner_turns, is_corner, lengths_along
from casa_assets.model.kitchen.plan import Heading, Plan, Wall
from casa_assets.pipeline.plans.fault import Fault, Mend, removed, replaced
from casa_assets.pipeline.plans.written import key_edit, row_at
from casa_assets.registry.edit import flow_text

OPPOSITE = {
    Heading.RIGHT: Heading.LEFT,
    Heading.LEFT: Heading.RIGHT,
    Heading.BACK: Heading.FRONT,
    Heading.FRONT: Heading.BACK,
}
MIN_WALL_M = 0.3
# Of the usual names of four walls, clockwise from the back left corner.
HEADINGS = {"back": "right", "right": "front", "front": "left", "left": "back"}
Turned = tuple[Wall, Heading | float]  # a wall and the heading that it would have


def wall_faults(raw: Any, plan: Plan, lengths: Mapping[str, float]) -> list[Fault]:
    """What is wrong with the outline of a room; turns first, since lengths follow them."""
    turned = _turns(raw, plan)
    return [turned] if turned else _lengths(raw, plan, lengths)


def _turns(raw: Any, plan: Plan) -> Fault | None:
    walls = plan.walls
    if _goes_round([(w, w.heading) for w in walls]):
        return None
    got = ", ".join(f"{w.id}: {_said(w.heading)}" for w in walls)
    expected = "walls that go round clockwise once, seen from above, such as right, front, left, back"
    if any(w.is_aslant for w in walls):
        expected += ", by a right angle at each corner or by less to the right"
    for order in _orders(walls):
        if order is not None:
            rows = _rows(raw, order)
            named = ", ".join(f"{wall.id}: {_said(heading)}" for wall, heading in order)
            return Fault(("walls",), expected, got, Mend(f"Write them as {named}.", (replaced(("walls",), rows),)))
    return Fault(("walls",), expected, got, None)


def _said(heading: Heading | float) -> str:
    return heading.value if isinstance(heading, Heading) else f"{heading:g}"


def _opposite(heading: Heading | float) -> Heading | float:
    return OPPOSITE[heading] if isinstance(heading, Heading) else (heading + 180.0) % 360.0


def _mirrored(heading: Heading | float) -> Heading | float:
    """Degrees that were counted the other way round."""
    return heading if isinstance(heading, Heading) else -heading % 360.0


def _orders(walls: Sequence[Wall]) -> list[list[Turned] | None]:
    """Orders with headings that might be meant, and go round; the likeliest first."""
    turned_round: list[Turned] = [(w, _opposite(w.heading)) for w in reversed(walls)]
    other_way: list[Turned] = [(w, _mirrored(w.heading)) for w in walls]
    found = [_begun_at_right(turned_round), other_way]
    if len(walls) == 4:
        sides = {w.id: w for w in walls}
        if sides.keys() == HEADINGS.keys():
            found.insert(0, [(sides[side], Heading(heading)) for side, heading in HEADINGS.items()])
        found.append([(w, Heading(h)) for w, h in zip(walls, HEADINGS.values(), strict=True)])
    return [order if order and _goes_round(order) else None for order in found]


def _begun_at_right(order: list[Turned]) -> list[Turned]:
    first = next((k for k, (_, heading) in enumerate(order) if heading is Heading.RIGHT), 0)
    return [*order[first:], *order[:first]]


def _goes_round(order: Sequence[Turned]) -> bool:
    turns = corner_turns([wall.replace(heading=heading) for wall, heading in order])
    return all(is_corner(turn) for turn in turns) and round(sum(turns), 6) == 360.0


def _rows(raw: Any, order: Sequence[Turned]) -> Any:
    rows = raw["walls"]
    if isinstance(rows, dict):
        return {w.id: {**rows[w.id], "heading": _written(h)} for w, h in order}
    by_id = {row["id"]: row for row in rows}
    return [{**by_id[w.id], "heading": _written(h)} for w, h in order]


def _written(heading: Heading | float) -> str | float:
    return heading.value if isinstance(heading, Heading) else heading


def _lengths(raw: Any, plan: Plan, lengths: Mapping[str, float]) -> list[Fault]:
    """Lengths of walls along and across the room that do not lead back to where they begin."""
    faults = []
    for wall in plan.walls:
        if wall.is_aslant and wall.length is None:
            at = row_at(raw, "walls", wall.id)
            mend = Mend("Write `length: 1.0`.", (key_edit(raw, at, "length", 1.0),))
            return [Fault((*at, "length"), "a length, since it stands aslant", "none", mend)]
    for headings in AXES:
        own = [w for w in plan.walls if w.heading in headings]
        unknown = [w for w in own if w.length is None]
        known = {w.id: plan.length(w.length, lengths) for w in plan.walls if w.length is not None}
        ahead, back = (lengths_along(plan.walls, known, h) for h in headings)
        if not unknown and abs(ahead - back) < 1e-3:
            continue
        if len(unknown) == 1:
            rest = back - ahead if unknown[0].heading is headings[0] else ahead - back
            if rest >= MIN_WALL_M:
                continue
        faults.append(_unclosed(raw, plan, own, unknown, (ahead, back), headings, lengths))
    return faults


def _unclosed(
    raw: Any,
    plan: Plan,
    own: Sequence[Wall],
    unknown: Sequence[Wall],
    sums: tuple[float, float],
    headings: tuple[Heading, Heading],
    lengths: Mapping[str, float],
) -> Fault:
    """The fault of lengths that do not close; the last wall gives way, or the one whose length is not stated."""
    expected = f"walls to the {headings[0].value} and to the {headings[1].value} that are as long together"
    got = f"{sums[0]:g} and {sums[1]:g} m"
    wall = (unknown or own)[-1]
    others = [w for w in own if w is not wall]
    same = [w for w in others if w.heading is not wall.heading]
    at = (*row_at(raw, "walls", wall.id), "length")
    by_aslant = _aslant(plan, lengths, headings)
    if len(others) == len(same) == 1 and same[0].length is not None and not by_aslant:
        value: Any = same[0].length
    else:
        known = [w for w in others if w.length is not None]
        signed = sum(plan.length(w.length or 0.0, lengths) * (1 if w in same else -1) for w in known)
        signed += by_aslant if wall.heading is headings[1] else -by_aslant
        if signed < MIN_WALL_M or len(known) < len(others):
            if len(unknown) > 1:
                value = sums[0] or sums[1] or 3.0
                return Fault(
                    at, expected, got, Mend(f"Write `length: {value:g}`.", (key_edit(raw, at[:-1], "length", value),))
                )
            return _longer_opposite(raw, plan, wall, same, expected, got, lengths)
        value = round(signed, 4)
    sentence = f"Write `length: {flow_text(value)}` for {wall.id}."
    return Fault(at, expected, got, Mend(sentence, (key_edit(raw, at[:-1], "length", value),)))


def _aslant(plan: Plan, lengths: Mapping[str, float], headings: tuple[Heading, Heading]) -> float:
    """Metres that walls aslant lead to the first of two opposite headings, less those to the second."""
    aslant = [w for w in plan.walls if w.is_aslant and w.length is not None]
    known = {w.id: plan.length(w.length or 0.0, lengths) for w in aslant}
    return lengths_along(aslant, known, headings[0]) - lengths_along(aslant, known, headings[1])


def _longer_opposite(
    raw: Any, plan: Plan, wall: Wall, same: Sequence[Wall], expected: str, got: str, lengths: Mapping[str, float]
) -> Fault:
    """Where the last wall would have no length, the longest opposite one is made longer."""
    at = (*row_at(raw, "walls", wall.id), "length")
    if not same:
        return Fault(at, expected, got, None)
    longest = max(same, key=lambda w: plan.length(w.length or 0.0, lengths))
    ahead = sum(
        plan.length(w.length or 0.0, lengths) for w in plan.walls if w.heading is wall.heading and w is not wall
    )
    rest = sum(plan.length(w.length or 0.0, lengths) for w in same if w is not longest)
    value = round(max(ahead - rest + 1.0, MIN_WALL_M), 3)
    edits = [key_edit(raw, row_at(raw, "walls", longest.id), "length", value)]
    if wall.length is not None:
        edits.append(removed(at))
    return Fault(at, expected, got, Mend(f"Write `length: {value:g}` for {longest.id}.", tuple(edits)))
