"""Faults in the statements of a plan: values that its records reject, unknown names, walls that do not close.

A correction is offered if a known name is similar, if a number is a little beyond a bound, and if another order or
length of walls closes the room. All other faults are reported with what was expected.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from casa_assets.layouts.check_plan.draft import Draft
from casa_assets.layouts.check_plan.edit import (
    NEAR,
    Fault,
    Mend,
    flow_text,
    nearest,
    put,
    remove,
    rename,
    spelt,
    value_at,
)
from casa_assets.layouts.plan.room import AXES, corner_turns, is_corner, lengths_along
from casa_assets.model.kitchen.plan import BaseKind, Heading, OpeningKind, Plan, Wall
from casa_assets.model.registry.document import KeyPath, expected_one_of, fields_at
from casa_assets.registry.kitchens import LIKE

# A number that is further beyond a bound than this share of it was meant in another way, such as in centimetres.
BEYOND_BOUND, MOST_BEYOND = 0.01, 0.25
NEAR_KEY, NEAR_KIND, NEAR_ROLE = 0.8, 0.7, 0.75  # least similarity of misspelt ones: `over` is no `oven`
# What is expected, by the type of an error of pydantic or its first word, where its own words name Python's types.
EXPECTED = {
    "bool": "true or false", "int": "a whole number", "float": "a number without a unit (lengths in metres)",
    "list": "a list", "tuple": "a list", "dict": "a mapping of keys to values", "model": "a mapping of keys to values",
    "too_long": "at most {max_length} of them", "too_short": "at least {min_length} of them",
    "string_pattern_mismatch": "a name of small letters, digits and single underscores that begins with a letter",
}  # fmt: skip
# Bounds by the type of an error: their name, and what is added to one that is itself not allowed.
BOUNDS = {
    "greater_than_equal": ("ge", 0.0), "greater_than": ("gt", BEYOND_BOUND),
    "less_than_equal": ("le", 0.0), "less_than": ("lt", -BEYOND_BOUND),
}  # fmt: skip
CLEAREST = ("extra_forbidden", "enum", "literal_error", *BOUNDS)
# Keys that are lengths or names of parameters, by table.
LENGTH_KEYS = {
    "walls": ("length",), "openings": ("at",), "runs": ("start", "end", "length"), "wall_items": ("at",),
    "columns": ("at", "from_wall"), "tables": ("at", "from_wall"), "floor_items": ("at", "from_wall"),
}  # fmt: skip
AT_WALLS = ("openings", "columns", "tables", "wall_items", "floor_items")  # tables whose rows have a wall
CORNERS = ("left_corner", "right_corner", "left_filler", "right_filler")
# Of the usual names of four walls, clockwise from the back left corner.
HEADINGS = {"back": Heading.RIGHT, "right": Heading.FRONT, "front": Heading.LEFT, "left": Heading.BACK}
OPPOSITE = {a: b for pair in AXES for a, b in (pair, pair[::-1])}
MIN_WALL_M, MAX_WALL_M, USUAL_WALL_M = 0.3, 20.0, 1.0


def record_faults(plan: Any, stem: str) -> list[Fault]:
    """Return the values that the records of plans reject, each value once, in the order of the file.

    `plan`: value of the file. `stem`: the plan's id.
    """
    if not isinstance(plan, dict):
        return [Fault((), "the keys of a plan: title, walls, runs and others", type(plan).__name__)]
    if "id" in plan:
        return [
            Fault(("id",), "no id: a plan is called as its file is", repr(plan["id"]), Mend.take_out(("id",), "id"))
        ]
    try:
        Plan.model_validate({**plan, "id": stem})
    except ValidationError as error:
        groups: dict[KeyPath, list[Any]] = {}
        for one in error.errors():
            groups.setdefault(written_at(plan, one["loc"]), []).append(one)
        own = {at: errors for at, errors in groups.items() if not _follows(at, errors, groups)} or groups
        return [_fault(plan, at, errors) for at, errors in own.items()]
    return []


def _follows(at: KeyPath, errors: list[Any], groups: Mapping[KeyPath, Any]) -> bool:
    """True if only other faults are the reason: too few rows since some are wrong, ids of units made of a wrong one."""
    types = {one["type"] for one in errors}
    if types == {"too_short"}:
        return any(other[: len(at)] == at != other for other in groups)
    return types == {"string_pattern_mismatch"} and at[-1] != "id" and all(one["loc"][-1] == "id" for one in errors)


def written_at(plan: Mapping[str, Any], loc: Sequence[str | int]) -> KeyPath:
    """Pointer into the file of a place in the record: rows may be written by id, units in short forms."""
    at: list[str | int] = []
    here: Any = plan
    for n, step in enumerate(loc):
        if isinstance(here, dict) and isinstance(step, int) and step < len(here):
            step = list(here)[step]
        elif n > 3 and loc[0] == "runs" and loc[2] in ("base", "upper") and len(at) == 4:
            # A field of a unit: `- doors`, `- doors: 0.6`, `- doors: {width: 0.6}`.
            if not isinstance(here, dict) or len(here) != 1:
                return (*at, step) if isinstance(here, dict) and step in here else tuple(at)
            kind, inner = next(iter(here.items()))
            return (*at, kind, step) if isinstance(inner, dict) and step in inner else (*at, kind)
        in_list = isinstance(here, list) and isinstance(step, int) and step < len(here)
        if in_list or (isinstance(here, dict) and step in here):
            here = here[step]
        elif isinstance(here, dict) and isinstance(step, str) and re.fullmatch(r"[a-z_]+", step):
            return (*at, step)  # what is missing
        else:
            break
        at.append(step)
    return tuple(at)


def _fault(plan: dict[str, Any], at: KeyPath, errors: list[Any]) -> Fault:
    got = value_at(plan, at)
    # Of the branches of a union, the one that says more than a type counts.
    errors = sorted(errors, key=lambda e: (e["type"] not in CLEAREST, e["type"].endswith("_type")))
    kind, ctx, said = errors[0]["type"], errors[0].get("ctx", {}), str(errors[0]["msg"])
    if kind == "extra_forbidden":
        return _unknown_key(plan, at, errors[0]["loc"])
    if kind in ("enum", "literal_error"):
        return _unknown_word(at, got, str(errors[0]["input"]), re.findall(r"'([^']+)'", ctx["expected"]))
    said = said.removeprefix("Input should be ").removeprefix("Value error, ")
    if kind in BOUNDS and isinstance(got, int | float):
        value = ctx[BOUNDS[kind][0]] + BOUNDS[kind][1]
        is_near = abs(got - value) <= MOST_BEYOND * max(abs(value), 1.0)
        return Fault(at, said, f"{got:g}", Mend(f"Write {value:g}.", (put(at, value),)) if is_near else None)
    if kind == "missing":
        return Fault(at, f"{at[-1]!r}, which is missing", "nothing")
    mend = None
    if kind == "string_pattern_mismatch":
        is_key = got is None and at[-1] == "id"  # the id is the key of the row
        at, got = (at[:-1], at[-2]) if is_key else (at, got)
        name = spelt(str(got))
        edit = rename(at, name) if is_key else put(at, name)
        mend = Mend(f"Write {name}.", (edit,)) if name[:1].isalpha() else None
    known = EXPECTED.get(kind) or EXPECTED.get(kind.split("_")[0])
    return Fault(at, said if known is None else known.format(**ctx), flow_text(got)[:80], mend)


def _unknown_key(plan: dict[str, Any], at: KeyPath, loc: Sequence[str | int]) -> Fault:
    known = [name for name in fields_at(Plan, loc[:-1]) if name != "id" or len(at) > 1]
    key, beside = str(loc[-1]), value_at(plan, at[:-1])
    # A plan that is like another has all keys of that one beside its own.
    given = beside if isinstance(beside, dict) and len(at) > 1 else {}
    near = nearest(key, [name for name in known if name not in given], NEAR_KEY)
    mend = None if near is None else Mend(f"Call {key!r} {near!r}.", (rename(at, near),))
    return Fault(at, expected_one_of([*known, LIKE] if len(at) == 1 else known, key), repr(key), mend)


def _unknown_word(at: KeyPath, got: Any, word: str, known: list[str]) -> Fault:
    near = nearest(word, known)
    is_key = at[-1] == word and got != word  # the kind of a unit that is written `- doors: 0.6`
    edit = None if near is None else rename(at, near) if is_key else put(at, near)
    return Fault(at, expected_one_of(known, word), repr(word), Mend(f"Write {near}.", (edit,)) if edit else None)


def name_faults(draft: Draft) -> list[Fault]:
    """Return names of walls, runs, units, parameters and roles that do not exist, and names that are used twice.

    An item over or on a missing unit, such as one that was removed for lack of room, is removed too.
    """
    found = [*_orders_of_runs(draft), *_same_names(draft), *_no_roles(draft)]
    for at, got, known, least in _references(draft):
        if got is not None and got not in known:
            near = nearest(got, known, least)
            mend = Mend(_written(at, near), (put(at, near),)) if near else None
            found.append(Fault(at, expected_one_of(known, got), repr(got), mend))
    for at, name, got, units in _references_to_units(draft):
        if got is not None and got not in units:
            near, key = _unit_like(got, units), "on" if at[0] == "worktop_items" else "over"
            there = (*at, key)
            if near is None:
                mend = Mend.take_out(at, repr(name))
            else:
                edit = draft.in_unit(at, key, near) if at[0] == "runs" else put(there, near)
                mend = Mend(_written(there, near), (edit,))
            known = [name for name, kind in units.items() if kind]
            found.append(Fault(there, expected_one_of(known, got), repr(got), mend))
    return found


def _written(at: KeyPath, value: str) -> str:
    """The sentence that has a value written at a key, or in the place of an item of a list."""
    return f"Write `{at[-1]}: {value}`." if isinstance(at[-1], str) else f"Write {value!r}."


def _references(draft: Draft) -> Iterator[tuple[KeyPath, str | None, Sequence[str], float]]:
    """Yield the place of each name, the name, the names known there, and how similar a name has to be to be meant."""
    walls, runs, roles = [w.id for w in draft.plan.walls], [r.id for r in draft.plan.runs], sorted(draft.style.models)
    for table, keys in LENGTH_KEYS.items():
        for row in getattr(draft.plan, table):
            for key in keys:
                if isinstance(value := getattr(row, key), str):
                    yield (*draft.row(table, row.id), key), value, sorted(draft.plan.parameters), NEAR
    for run in draft.plan.runs:
        at, others = draft.row("runs", run.id), [r for r in runs if r != run.id]
        yield (*at, "on"), run.on, walls, NEAR
        if placed := run.faces or run.joins:
            yield (*at, "faces" if run.faces else "joins", "run"), placed.run, others, NEAR
        if run.faces:
            units = [u.id for r in draft.plan.runs if r.id == run.faces.run for u in r.base]
            yield (*at, "faces", "in_front_of"), run.faces.in_front_of, units, NEAR
    for k, corner in enumerate(draft.plan.corners):
        for i, name in enumerate(corner.runs):
            yield ("corners", k, "runs", i), name, [r for r in runs if r not in corner.runs or r == name], NEAR
        yield ("corners", k, "owner"), corner.owner, corner.runs, NEAR
    niches = [o.id for o in draft.plan.openings if o.kind is OpeningKind.NICHE]
    for table in AT_WALLS:
        for row in getattr(draft.plan, table):
            known = [*walls, *niches] if getattr(row, "kind", None) is OpeningKind.WINDOW else walls
            yield (*draft.row(table, row.id), "wall"), row.wall, known, NEAR
            if table in ("wall_items", "floor_items"):
                yield (*draft.row(table, row.id), "item"), row.item, roles, NEAR_ROLE
    for k, slope in enumerate(draft.plan.slopes):
        yield ("slopes", k, "wall"), slope.wall, walls, NEAR
    for k, seats in enumerate(draft.plan.seats):
        yield ("seats", k, "run"), seats.run, runs, NEAR
    for k, lamps in enumerate(draft.plan.lamps):
        yield ("lamps", k, "item"), lamps.item, roles, NEAR_ROLE
        yield ("lamps", k, "over"), lamps.over, [*runs, *(t.id for t in draft.plan.tables)], NEAR


def _references_to_units(draft: Draft) -> Iterator[tuple[KeyPath, str, str | None, Mapping[str, str]]]:
    """Yield the place of each row or unit, its id, the unit that it names, and the known units with their kinds."""
    for run in draft.plan.runs:
        for k, unit in enumerate(run.upper):
            yield draft.unit(run.id, "upper", k), unit.id, unit.over, {u.id: u.kind.value for u in run.base}
    corners = {f"{r}_{end}": "" for c in draft.plan.corners for r in c.runs for end in CORNERS}
    uppers = {u.id: "" for r in draft.plan.runs for u in r.upper}
    for table in ("openings", "wall_items", "worktop_items"):
        for row in getattr(draft.plan, table):
            wall = None if table == "worktop_items" else row.wall
            order = sorted(draft.plan.runs, key=lambda r: wall is not None and r.on != wall)
            known = {u.id: u.kind.value for r in order for u in r.base} | corners | ({} if wall is None else uppers)
            yield draft.row(table, row.id), row.id, row.on if wall is None else row.over, known


def _unit_like(got: str, units: Mapping[str, str]) -> str | None:
    """The unit that is meant by a name: one of that kind, or the one that is spelt most like it."""
    kind = nearest(got, [k.value for k in BaseKind], NEAR_KIND)
    return next((name for name, its in units.items() if its == kind), None) or nearest(got, units, NEAR_KIND)


def _orders_of_runs(draft: Draft) -> Iterator[Fault]:
    """Yield runs that precede the run they depend on, and wall units over a run that is not at a wall."""
    names = [r.id for r in draft.plan.runs]
    for n, run in enumerate(draft.plan.runs):
        placed, at, rows = run.faces or run.joins, draft.row("runs", run.id), draft.raw["runs"]
        if placed is None:
            continue
        if placed.run in names[n + 1 :]:
            if isinstance(rows, dict):
                order: Any = {**{k: v for k, v in rows.items() if k != run.id}, run.id: rows[run.id]}
            else:
                order = [*rows[:n], *rows[n + 1 :], rows[n]]
            mend = Mend(f"Write {run.id!r} behind {placed.run!r}.", (put(("runs",), order),))
            yield Fault(at, "a run that stands before it in the file", repr(placed.run), mend)
        if run.upper:
            expected = f"no wall units over {run.id}, which stands at no wall"
            mend = Mend.take_out((*at, "upper"), f"'upper' of {run.id}")
            yield Fault((*at, "upper"), expected, f"{len(run.upper)} of them", mend)


def _no_roles(draft: Draft) -> Iterator[Fault]:
    """Things on worktops that no model of the style is named after: the role is the name of the row."""
    taken = {item.id for item in draft.plan.worktop_items}
    for k, item in enumerate(draft.plan.worktop_items):
        if item.model is None and item.id not in draft.style.models:
            near = nearest(item.id, sorted(set(draft.style.models) - taken), NEAR_ROLE)
            at, mend = _called(draft, "worktop_items", k, near or "")
            yield Fault(at, expected_one_of(sorted(draft.style.models), item.id), repr(item.id), mend if near else None)


def _called(draft: Draft, table: str, k: int, name: str) -> tuple[KeyPath, Mend]:
    """Where a row of a table is, and the mend that gives it another id."""
    rows = draft.raw[table]
    at: KeyPath = (table, k if isinstance(rows, list) else list(rows)[k])
    edit = put((*at, "id"), name) if isinstance(rows, list) else rename(at, name)
    return at, Mend(f"Call it {name!r}.", (edit,))


def _same_names(draft: Draft) -> Iterator[Fault]:
    """Two things of one name."""
    seen: set[str] = set()
    for run in draft.plan.runs:
        for row, units in (("base", run.base), ("upper", run.upper)):
            for k, unit in enumerate(units):
                if unit.id in seen:
                    at, new = draft.unit(run.id, row, k), _free(unit.id, seen)
                    mend = Mend(f"Call it {new!r}.", (draft.in_unit(at, "id", new),))
                    yield Fault(at, "a name of its own", repr(unit.id), mend)
                seen.add(unit.id)
    for table in (*AT_WALLS, "worktop_items"):
        for k, name in enumerate(row.id for row in getattr(draft.plan, table)):
            if name in seen:
                at, mend = _called(draft, table, k, _free(name, seen))
                # The name of a thing on a worktop is its role, which there is once.
                mend = Mend("Take it out.", (remove(at),)) if table == "worktop_items" else mend
                yield Fault(at, "a name of its own", repr(name), mend)
            seen.add(name)


def _free(name: str, taken: set[str]) -> str:
    return next(new for n in range(2, len(taken) + 3) if (new := f"{name}_{n}") not in taken)


def wall_faults(draft: Draft) -> list[Fault]:
    """Return the faults in the outline of a room; turns first, since lengths depend on them."""
    walls = draft.plan.walls
    if _goes_round(walls):
        return [*_lengths(draft)]
    expected = "walls that go round clockwise once, seen from above, such as right, front, left, back"
    if any(w.is_aslant for w in walls):
        expected += ", by a right angle at each corner or by less to the right"
    order, mend = next((o for o in _orders(walls) if _goes_round(o)), None), None
    if order is not None:
        mend = Mend(f"Write them as {_said(order)}.", (put(("walls",), _rows(draft.raw["walls"], order)),))
    return [Fault(("walls",), expected, _said(walls), mend)]


def _said(walls: Sequence[Wall]) -> str:
    return ", ".join(f"{w.id}: {flow_text(w.heading)}" for w in walls)


def _goes_round(walls: Sequence[Wall]) -> bool:
    turns = corner_turns(walls)
    return all(is_corner(turn) for turn in turns) and round(sum(turns), 6) == 360.0


def _orders(walls: Sequence[Wall]) -> Iterator[list[Wall]]:
    """The walls in orders and with headings that might be meant, the likeliest first."""
    sides = {w.id: w for w in walls}
    if sides.keys() == HEADINGS.keys():
        yield [sides[side].replace(heading=heading) for side, heading in HEADINGS.items()]
    headings = [OPPOSITE[h] if isinstance(h := w.heading, Heading) else (h + 180.0) % 360.0 for w in walls]
    back = [w.replace(heading=heading) for w, heading in zip(walls, headings, strict=True)][::-1]
    first = next((k for k, w in enumerate(back) if w.heading is Heading.RIGHT), 0)
    yield [*back[first:], *back[:first]]
    if len(walls) == len(HEADINGS):
        yield [w.replace(heading=heading) for w, heading in zip(walls, HEADINGS.values(), strict=True)]


def _rows(rows: Any, order: Sequence[Wall]) -> Any:
    """The rows of walls in another order, with other headings, in the form that they are written in."""
    headings = {w.id: w.heading.value if isinstance(w.heading, Heading) else w.heading for w in order}
    by_id = rows if isinstance(rows, dict) else {row["id"]: row for row in rows}
    new = {name: {**by_id[name], "heading": heading} for name, heading in headings.items()}
    return new if isinstance(rows, dict) else [*new.values()]


def _lengths(draft: Draft) -> Iterator[Fault]:
    """Lengths of walls along and across the room that do not lead back to where they begin."""
    aslant = next((w for w in draft.plan.walls if w.is_aslant and w.length is None), None)
    if aslant is not None:
        at = (*draft.row("walls", aslant.id), "length")
        mend = Mend(f"Write `length: {USUAL_WALL_M}`.", (put(at, USUAL_WALL_M),))
        yield Fault(at, "a length, since it stands aslant", "none", mend)
        return
    known = {w.id: draft.plan.length(w.length, draft.plan.defaults) for w in draft.plan.walls if w.length is not None}
    for headings in AXES:
        own = [w for w in draft.plan.walls if w.heading in headings]
        unknown = [w for w in own if w.length is None]
        there, back = (lengths_along(draft.plan.walls, known, h) for h in headings)
        is_closed = abs(there - back) < 1e-3 if not unknown else len(unknown) == 1
        if is_closed and all(_closing(draft, known, w, headings) >= MIN_WALL_M for w in unknown):
            continue
        expected = f"walls to the {headings[0].value} and to the {headings[1].value} that are as long together"
        last = (unknown or own)[-1:]
        at = (*draft.row("walls", last[0].id), "length") if last else ("walls",)
        yield Fault(at, expected, f"{there:g} and {back:g} m", _closed(draft, known, headings))


def _closing(draft: Draft, known: Mapping[str, float], wall: Wall, headings: tuple[Heading, Heading]) -> float:
    """Return the length of a wall that closes the outline, in metres; 0 or less if no length does."""
    others = {name: length for name, length in known.items() if name != wall.id}
    there, back = (lengths_along(draft.plan.walls, others, h) for h in headings)
    return round(back - there if wall.heading is headings[0] else there - back, 4)


def _closed(draft: Draft, known: Mapping[str, float], headings: tuple[Heading, Heading]) -> Mend | None:
    """One wall that gives way: one whose length is not stated, or the last of those that can."""
    own = [w for w in draft.plan.walls if w.heading in headings]
    for wall in [*(w for w in own if w.length is None), *(w for w in own[::-1] if w.length is not None)]:
        value: Any = _closing(draft, known, wall, headings)
        others = [w for w in own if w is not wall]
        if any(w.length is None for w in others) or not MIN_WALL_M <= value <= MAX_WALL_M:
            continue
        if len(others) == 1 and known[others[0].id] == value:
            value = others[0].length  # which may be a parameter
        at = draft.row("walls", wall.id)
        return Mend.write(at, wall.id, length=value)
    return None
