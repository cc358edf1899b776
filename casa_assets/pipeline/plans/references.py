"""Names in a plan that nothing answers to: walls, runs, units, parameters and roles, each with the nearest.

What is over or on a unit that is not there, such as one that was taken out for want of room, is taken out too.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from typing import Any

from casa_assets.model.kitchen.plan import OpeningKind, Plan, Run
from casa_assets.model.kitchen.style import Style
from casa_assets.model.kitchen.units import COOKERS, BaseKind, UpperKind
from casa_assets.model.registry.document import KeyPath
from casa_assets.model.registry.fields import expected_one_of
from casa_assets.pipeline.plans.fault import Fault, Mend, removed, replaced
from casa_assets.pipeline.plans.names import NEAR, nearest, spelt
from casa_assets.pipeline.plans.written import row_at, unit_at, unit_edit
from casa_assets.registry.edit import Edit, EditKind

# Keys that are lengths or names of parameters, by table.
LENGTH_KEYS = {
    "walls": ("length",),
    "openings": ("at",),
    "runs": ("start", "end", "length"),
    "wall_items": ("at",),
    "columns": ("at", "from_wall"),
    "tables": ("at", "from_wall"),
    "floor_items": ("at", "from_wall"),
}
CORNERS = ("left_corner", "right_corner", "left_filler", "right_filler")


def written(at: KeyPath, value: str) -> str:
    """The sentence that has a value written at a key, or in the place of an item of a list."""
    return f"Write `{at[-1]}: {value}`." if isinstance(at[-1], str) else f"Write {value!r}."


class References:
    """All names of a plan, and the faults of those that are wrong.

    Attributes:
        raw: the plan as its file has it. plan: the record of it.
    """

    def __init__(self, raw: Any, plan: Plan, style: Style) -> None:
        self.raw, self.plan = raw, plan
        self.walls = [w.id for w in plan.walls]
        self.runs = [r.id for r in plan.runs]
        self.units = {u.id: (r.id, u.kind.value) for r in plan.runs for u in r.base}
        self.uppers = {u.id: (r.id, u.kind.value) for r in plan.runs for u in r.upper}
        self.corners = {f"{r}_{end}": (r, "") for c in plan.corners for r in c.runs for end in CORNERS}
        self.roles = sorted(style.models)
        self.of_style = style
        self.faults: list[Fault] = []

    def wrong(self, at: KeyPath, known: Sequence[str], got: str, sentence: str = "", *edits: Edit) -> None:
        """Add a fault, with a correction if edits are given."""
        mend = Mend(sentence, edits) if edits else None
        self.faults.append(Fault(at, expected_one_of(known, got), repr(got), mend))

    def name(self, at: KeyPath, got: str | None, known: Sequence[str], least: float = NEAR) -> None:
        """Check a name; `least` is how similar a known one has to be to be meant."""
        if got is None or got in known:
            return
        near = nearest(got, known, least)
        if near:
            self.wrong(at, known, got, written(at, near), replaced(at, near))
        else:
            self.wrong(at, known, got)

    def unit(
        self, at: KeyPath, got: str | None, run: str = "", wall: str = "", with_corners: bool = True
    ) -> str | None:
        """The unit that is meant by a name: the name itself where it is right, None where nothing is near.

        Args:
            run: that it should be of. wall: that its run should stand at.
        """
        units = {**self.units, **(self.corners if with_corners else {}), **(self.uppers if with_corners else {})}
        known = {k: v for k, v in units.items() if not run or v[0] == run}
        if got is None or got in known:
            return got
        on = {r.id for r in self.plan.runs if not wall or r.on == wall}
        kind = nearest(spelt(got).removeprefix(f"{run}_"), [k.value for k in BaseKind], 0.7)
        of_kind = [k for k, (r, its) in known.items() if its == kind]
        same = [k for k in of_kind if spelt(got).startswith(f"{known[k][0]}_")]
        near = same or [k for k in of_kind if known[k][0] in on] or of_kind
        return (
            near[0] if near else next(iter(difflib.get_close_matches(spelt(got), list(known), n=1, cutoff=0.72)), None)
        )


def reference_faults(raw: Any, plan: Plan, style: Style) -> list[Fault]:
    """All names that nothing answers to."""
    names = References(raw, plan, style)
    _lengths(names)
    _runs(names)
    _same_names(names)
    if not names.faults:
        _openings(names)
        _items(names)
    return names.faults


def _lengths(names: References) -> None:
    """Lengths that name no parameter."""
    known = sorted(names.plan.parameters)
    for table, keys in LENGTH_KEYS.items():
        for row in getattr(names.plan, table):
            for key in keys:
                value = getattr(row, key)
                if isinstance(value, str):
                    names.name((*row_at(names.raw, table, row.id), key), value, known)


def _runs(names: References) -> None:
    """Walls and runs that runs and corners name."""
    for n, run in enumerate(names.plan.runs):
        at = row_at(names.raw, "runs", run.id)
        names.name((*at, "on"), run.on, names.walls)
        others = [r for r in names.runs if r != run.id]
        placed = run.faces or run.joins
        if placed is None:
            continue
        key, before = ("faces" if run.faces else "joins"), names.runs[:n]
        if placed.run not in others:
            names.name((*at, key, "run"), placed.run, others)
        elif placed.run not in before:
            _moved_behind(names, run.id, placed.run)
        elif run.faces and run.faces.in_front_of is not None:
            inner = (*at, "faces", "in_front_of")
            found = names.unit(inner, run.faces.in_front_of, placed.run, with_corners=False)
            if found != run.faces.in_front_of:
                known = [k for k, (r, _) in names.units.items() if r == placed.run]
                edits = (replaced(inner, found),) if found else ()
                names.wrong(inner, known, run.faces.in_front_of, written(inner, str(found)), *edits)
        if run.upper:
            expected = f"no wall units over {run.id}, which stands at no wall"
            mend = Mend(f"Take out 'upper' of {run.id}.", (removed((*at, "upper")),))
            names.faults.append(Fault((*at, "upper"), expected, f"{len(run.upper)} of them", mend))
    for k, corner in enumerate(names.plan.corners):
        at = ("corners", k)
        for i, name in enumerate(corner.runs):
            if name not in names.runs:
                names.name((*at, "runs", i), name, [r for r in names.runs if r not in corner.runs])
                break
        else:
            names.name((*at, "owner"), corner.owner, corner.runs)


def _moved_behind(names: References, run: str, other: str) -> None:
    """A run that stands before the one that it needs."""
    runs, at = names.raw["runs"], row_at(names.raw, "runs", run)
    if isinstance(runs, dict):
        order: Any = {**{k: v for k, v in runs.items() if k != run}, run: runs[run]}
    else:
        order = [*(r for r in runs if r.get("id") != run), next(r for r in runs if r.get("id") == run)]
    names.wrong(
        at, [r for r in names.runs if r != run], other, f"Write {run!r} behind {other!r}.", replaced(("runs",), order)
    )


def _same_names(names: References) -> None:
    """Two things of one name."""
    seen: set[str] = set()
    raw, plan = names.raw, names.plan
    for run in plan.runs:
        for row, units in (("base", run.base), ("upper", run.upper)):
            for k, unit in enumerate(units):
                if unit.id in seen:
                    new = _free(unit.id if row == "base" else f"{unit.id}_upper", seen)
                    at = unit_at(raw, run.id, row, k)
                    names.wrong(at, ["a name of its own"], unit.id, f"Call it {new!r}.", unit_edit(raw, at, "id", new))
                seen.add(unit.id)
    others: tuple[tuple[str, Iterable[str]], ...] = (
        ("openings", [o.id for o in plan.openings]),
        ("columns", [c.id for c in plan.columns]),
        ("tables", [t.id for t in plan.tables]),
        ("worktop_items", [i.id for i in plan.worktop_items]),
        ("wall_items", [i.id for i in plan.wall_items]),
        ("floor_items", [i.id for i in plan.floor_items]),
    )
    for table, ids in others:
        for k, name in enumerate(ids):
            if name in seen:
                _other_name(names, table, k, name, _free(f"{name}_{table.split('_')[0].removesuffix('s')}", seen))
            seen.add(name)


def _other_name(names: References, table: str, k: int, name: str, new: str) -> None:
    rows = names.raw[table]
    at: KeyPath = (table, k) if isinstance(rows, list) else (table, list(rows)[k])
    if table == "worktop_items":  # the name is the role, which there is once
        names.wrong(at, ["each role once"], name, "Take it out.", removed(at))
    elif isinstance(rows, list):
        names.wrong(at, ["a name of its own"], name, f"Call it {new!r}.", replaced((*at, "id"), new))
    else:
        names.wrong(at, ["a name of its own"], name, f"Call it {new!r}.", Edit(EditKind.RENAME, at, new))


def _free(name: str, taken: set[str]) -> str:
    n = 2
    while f"{name}_{n}" in taken:
        n += 1
    return name if name not in taken else f"{name}_{n}"


def _openings(names: References) -> None:
    niches: list[str] = []
    for opening in names.plan.openings:
        at = row_at(names.raw, "openings", opening.id)
        known = [*names.walls, *niches] if opening.kind is OpeningKind.WINDOW else names.walls
        names.name((*at, "wall"), opening.wall, known)
        if opening.kind is OpeningKind.NICHE:
            niches.append(opening.id)
        if opening.wall in names.walls:
            _over(names, at, opening.over, opening.wall)
    for run in names.plan.runs:
        for k, unit in enumerate(run.upper):
            if unit.kind is UpperKind.HOOD and unit.over is None:
                _over_cooker(names, run, k)
                continue
            found = names.unit((), unit.over, run.id, with_corners=False)
            if found == unit.over or unit.over is None:
                continue
            at = unit_at(names.raw, run.id, "upper", k)
            known = [u.id for u in run.base]
            edit = unit_edit(names.raw, at, "over", found) if found else removed(at)
            sentence = written(("over",), found) if found else f"Take out the {unit.kind.value}."
            names.wrong(at, known, unit.over, sentence, edit)


def _over_cooker(names: References, run: Run, k: int) -> None:
    """A hood that is over nothing: it belongs over the cooker of its run that has none yet."""
    taken = {unit.over for unit in run.upper}
    cooker = next((u.id for u in run.base if u.kind in COOKERS and u.id not in taken), None)
    if cooker is not None:
        at = unit_at(names.raw, run.id, "upper", k)
        mend = Mend(written(("over",), cooker), (unit_edit(names.raw, at, "over", cooker),))
        names.faults.append(Fault(at, "a cooker that the hood is over", "none", mend))


def _over(names: References, at: KeyPath, over: str | None, wall: str) -> None:
    """The unit that an opening or a wall item is over."""
    found = names.unit((*at, "over"), over, wall=wall)
    if found == over or over is None:
        return
    edit = replaced((*at, "over"), found) if found else removed(at)
    sentence = written(("over",), found) if found else f"Take out {at[-1]!r}."
    names.wrong((*at, "over"), list(names.units), over, sentence, edit)


def _items(names: References) -> None:
    raw, plan = names.raw, names.plan
    for item in plan.worktop_items:
        at = row_at(raw, "worktop_items", item.id)
        is_named = item.model is not None or item.id in names.of_style.models
        role = item.id if is_named else nearest(item.id, names.of_style.models, 0.75)
        if role is None or (role != item.id and role in {i.id for i in plan.worktop_items}):
            names.wrong(at, names.roles, item.id)
            continue
        if role != item.id:
            edit = replaced((*at, "id"), role) if isinstance(at[-1], int) else Edit(EditKind.RENAME, at, role)
            names.wrong(at, names.roles, item.id, f"Call it {role!r}.", edit)
            continue
        found = names.unit((*at, "on"), item.on)
        if found != item.on:
            edit = replaced((*at, "on"), found) if found else removed(at)
            sentence = written(("on",), found) if found else f"Take out {item.id!r}."
            names.wrong((*at, "on"), list(names.units), item.on, sentence, edit)
    for wall_item in plan.wall_items:
        at = row_at(raw, "wall_items", wall_item.id)
        names.name((*at, "wall"), wall_item.wall, names.walls)
        _over(names, at, wall_item.over, wall_item.wall)
        _role(names, at, wall_item.item)
    for floor_item in plan.floor_items:
        at = row_at(raw, "floor_items", floor_item.id)
        names.name((*at, "wall"), floor_item.wall, names.walls)
        _role(names, at, floor_item.item)
    for table, things in (("columns", plan.columns), ("tables", plan.tables)):
        for thing in things:
            at = row_at(raw, table, thing.id)
            names.name((*at, "wall"), thing.wall, names.walls)
    for k, slope in enumerate(plan.slopes):
        names.name(("slopes", k, "wall"), slope.wall, names.walls)
    for k, seats in enumerate(plan.seats):
        names.name(("seats", k, "run"), seats.run, names.runs)
    for k, lamps in enumerate(plan.lamps):
        _role(names, ("lamps", k), lamps.item)
        names.name(("lamps", k, "over"), lamps.over, [*names.runs, *(t.id for t in plan.tables)])


def _role(names: References, at: KeyPath, item: str) -> None:
    names.name((*at, "item"), item, names.roles, 0.7)
