"""Mend the form of a plan: parts that are written in another way or in other words than the plan language has.

Each function adds to a list of faults; edits of one list are of different places, or wait for the next round.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

from casa_assets.model.kitchen.furnishing import CeilingLamps, DiningTable, FloorItem, SeatRow, WallItem, WorktopItem
from casa_assets.model.kitchen.plan import (
    IslandPosition,
    Parameter,
    PeninsulaPosition,
    Plan,
    PlanOpening,
    Run,
    RunCorner,
    Wall,
)
from casa_assets.model.kitchen.room_parts import Closet, Column, Slope
from casa_assets.model.kitchen.units import BaseKind, BaseUnit, UpperKind, UpperUnit
from casa_assets.model.record import Record
from casa_assets.model.registry.document import KeyPath
from casa_assets.model.registry.fields import expected_one_of
from casa_assets.pipeline.plans.fault import Fault, Mend, added, removed, renamed, replaced
from casa_assets.pipeline.plans.unit_form import unit_as_written
from casa_assets.pipeline.plans.words import METRES, key_and_unit, length_of, meant, plan_words, spelt
from casa_assets.registry.edit import Edit, flow_text, item_text
from casa_assets.registry.kitchens import LIKE

HEADINGS = {"back": "right", "right": "front", "front": "left", "left": "back"}
ROWS: Mapping[str, tuple[type[Record], str]] = {
    "walls": (Wall, "wall"),
    "openings": (PlanOpening, "opening"),
    "columns": (Column, "column"),
    "slopes": (Slope, "slope"),
    "runs": (Run, "run"),
    "corners": (RunCorner, "corner"),
    "worktop_items": (WorktopItem, "worktop_item"),
    "tables": (DiningTable, "table"),
    "wall_items": (WallItem, "wall_item"),
    "floor_items": (FloorItem, "floor_item"),
    "seats": (SeatRow, "seat"),
    "lamps": (CeilingLamps, "lamp"),
}
HAVE_IDS = ("walls", "openings", "columns", "runs", "worktop_items", "tables", "wall_items", "floor_items")
# Tables that are lists, and the keys that the name and the value of a row stand for where one is a mapping.
LISTS = {"seats": ("run", "count"), "lamps": ("item", "count"), "corners": ("", ""), "slopes": ("wall", "knee")}
OPENINGS = ("windows", "doors", "window", "door", "passages", "niches", "niche")  # on the top level
USUAL_NICHE_DEPTH = 0.3
USUAL_ROOM = {"width": 4.2, "depth": 3.6}


class Form:
    """The faults of a plan's form, as they are found."""

    def __init__(self, plan: dict[str, Any]) -> None:
        self.plan = plan
        self.faults: list[Fault] = []

    def say(self, pointer: KeyPath, expected: str, got: Any, sentence: str, *edits: Edit) -> None:
        """Add a fault with its mend."""
        written = got if isinstance(got, str) else flow_text(got)
        self.faults.append(Fault(pointer, expected, written[:80], Mend(sentence, edits)))

    def keys(self, pointer: KeyPath, row: Mapping[str, Any], known: Iterable[str], table: str) -> None:
        """Say of each key that is none what it should be called, or that it goes."""
        fields, given = tuple(known), set(row)
        for key in row:
            if key in fields:
                continue
            at, measured = (*pointer, key), key_and_unit(key)
            # A word of the plan language is no misspelling of another.
            name = meant(key, fields, table, 1.0 if key in _words() else 0.75 if table == "plan" else 0.6)
            number = row[key] if isinstance(row[key], int | float) else length_of(str(row[key]))
            if (
                measured
                and number is not None
                and (stem := meant(measured[0], fields, table, 0.75))
                and stem not in given
            ):
                metres = round(number * METRES[measured[1]], 4)
                edits = (renamed(at, stem), replaced((*pointer, stem), metres))
                self.say(at, f"{stem!r}, in metres", key, f"Write `{stem}: {metres:g}` in place of `{key}`.", *edits)
            elif name is not None and name not in given:
                given.add(name)
                self.say(at, expected_one_of(fields, key), key, f"Call {key!r} {name!r}.", renamed(at, name))
            else:
                self.say(at, expected_one_of(fields, key), key, f"Take out {key!r}.", removed(at))


@cache
def _words() -> frozenset[str]:
    """All keys of the plan language."""
    records: tuple[type[Record], ...] = (
        *(record for record, _ in ROWS.values()),
        Plan,
        BaseUnit,
        UpperUnit,
        IslandPosition,
        PeninsulaPosition,
        Closet,
    )
    return frozenset(field for record in records for field in record.model_fields)


def form_faults(plan: Any, stem: str) -> list[Fault]:
    """What is wrong with the form of a plan, from the outside in; the first that has any says all of its kind."""
    if (outer := _outer(plan)) is not None:
        return [outer]
    form = Form(plan)
    for step in (_top, _room, _tables, _rows, _row_keys, _runs, _units):
        step(form)
        if form.faults:
            return form.faults
    if not plan.get("title") and LIKE not in plan:
        title = stem.replace("_", " ").capitalize()
        edit = replaced(("title",), title) if "title" in plan else added(("title",), title)
        form.say(("title",), "a title", "nothing", f"Add `title: {title}`.", edit)
    return form.faults


def _outer(plan: Any) -> Fault | None:
    """The fault of a file that holds its plan inside something else."""
    inner = plan
    if isinstance(plan, list):
        inner = next((row for row in plan if isinstance(row, dict)), None)
    elif isinstance(plan, dict) and not {"walls", "runs", LIKE} & plan.keys():
        inner = next((v for v in plan.values() if isinstance(v, dict) and len(_known(v)) >= 2), plan)
    if inner is plan and isinstance(plan, dict):
        return None
    expected, got = "the keys of a plan, such as title, walls and runs", type(plan).__name__
    if not isinstance(inner, dict):
        return Fault((), expected, got, None)
    return Fault((), expected, got, Mend("Put the keys of the plan on the top level.", (replaced((), inner),)))


def _known(value: Mapping[str, Any]) -> set[str]:
    return {key for key in value if meant(key, Plan.model_fields, "plan")}


def _top(form: Form) -> None:
    """Keys of the top level: those of the plan language, or what stands for several of them."""
    plan, fields = form.plan, tuple(k for k in (*Plan.model_fields, LIKE) if k != "id")
    plain: dict[str, Any] = {}
    for key, value in plan.items():
        word = spelt(key)
        if word in OPENINGS and isinstance(value, list | dict):
            _more_openings(form, key, word.removesuffix("s"), value)
        elif word in ("island", "peninsula") and isinstance(value, dict):
            _more_runs(form, key, word, value)
        elif word == "id":
            form.say((key,), "no id: a plan is called as its file is", value, "Take out 'id'.", removed((key,)))
        elif word != "room" and not (key not in fields and plan_words()["plan"].get(word) == "room"):
            plain[key] = value
    form.keys((), plain, fields, "plan")


def _more_openings(form: Form, key: str, kind: str, value: Any) -> None:
    rows = dict(_named(form.plan.get("openings") or {}, "opening"))
    for name, row in _named(value, kind).items():
        if isinstance(row, dict):
            name = name if name not in rows else f"{name}_{len(rows) + 1}"
            has_depth = kind != "niche" or any(meant(k, ["depth"], "opening") for k in row)
            rows[name] = {"kind": kind, **({} if has_depth else {"depth": USUAL_NICHE_DEPTH}), **row}
    edits = (removed((key,)), _put(form.plan, ("openings",), rows))
    form.say((key,), "openings, each with its kind", key, f"Write {key!r} as rows of 'openings'.", *edits)


def _more_runs(form: Form, key: str, word: str, value: dict[str, Any]) -> None:
    runs = dict(_named(form.plan.get("runs") or {}, "run"))
    first = next(iter(runs), None)
    if first is None or word in runs:
        form.say((key,), "a row of 'runs'", key, f"Take out {key!r}.", removed((key,)))
        return
    place = {"faces": {"run": first}} if word == "island" else {"joins": {"run": first, "end": "right"}}
    rest = {k: v for k, v in value.items() if meant(k, Run.model_fields, "run")}
    units = (
        {} if any(meant(k, ["base"], "run") for k in rest) else {"base": ["island" if word == "island" else "doors"]}
    )
    runs[word] = {**place, **rest, **units}
    edits = (removed((key,)), _put(form.plan, ("runs",), runs))
    form.say((key,), "a row of 'runs'", key, f"Write {key!r} as a row of 'runs'.", *edits)


def _named(rows: Any, stem: str) -> dict[str, Any]:
    """Rows by name, of a mapping or a list."""
    if isinstance(rows, dict):
        return dict(rows)
    if isinstance(rows, list) and (joined := _joined(rows, "walls")):
        return joined
    out: dict[str, Any] = {}
    for row in rows if isinstance(rows, list) else []:
        said = next((row[k] for k in ("id", "name") if isinstance(row, dict) and isinstance(row.get(k), str)), stem)
        name = base = spelt(said) or stem
        while name in out:
            name = f"{base}_{len(out) + 1}"
        out[name] = {k: v for k, v in row.items() if k not in ("id", "name")} if isinstance(row, dict) else row
    return out


def _put(plan: Mapping[str, Any], pointer: KeyPath, value: Any) -> Edit:
    here: Any = plan
    for step in pointer[:-1]:
        here = here[step]
    return replaced(pointer, value) if pointer[-1] in here else added(pointer, value)


def _room(form: Form) -> None:
    """A size of the room in place of walls, and walls that are written in another way."""
    plan = form.plan
    for key in [k for k in plan if spelt(k) == "room" or plan_words()["plan"].get(spelt(k)) == "room"]:
        value = plan[key]
        edits = [removed((key,))]
        if not plan.get("walls") and LIKE not in plan:
            edits.append(_put(plan, ("walls",), _walls_of(value)))
        form.say((key,), "walls with their lengths", {key: value}, f"Write {key!r} as walls.", *edits)
        return
    walls = plan.get("walls")
    if LIKE in plan:
        return
    rows = _named(walls, "wall") if isinstance(walls, dict | list) else {}
    made = {name: _wall(name, row, n) for n, (name, row) in enumerate(rows.items())}
    if isinstance(walls, list) and all(isinstance(row, dict) and "id" in row for row in walls):
        made = made if _reshaped(made, rows) else rows
    if not rows:
        form.say(
            ("walls",), "at least four walls", walls, "Write four walls.", _put(plan, ("walls",), _walls_of(USUAL_ROOM))
        )
    elif (
        _reshaped(made, rows)
        or len(rows) < 4
        or (isinstance(walls, list) and _joined(walls, "walls"))
        or (isinstance(walls, list) and made != rows)
    ):
        full = _closed(made) if len(made) < 4 else made
        form.say(
            ("walls",),
            "at least four walls, clockwise from the back, each with its heading",
            walls,
            f"Write the walls as {flow_text(full)}.",
            replaced(("walls",), full),
        )


def _reshaped(made: Mapping[str, Any], rows: Mapping[str, Any]) -> bool:
    return any(made[name] != row for name, row in rows.items())


def _wall(name: str, row: Any, n: int) -> dict[str, Any]:
    """A wall with its heading; its length may be all that is written."""
    fields = dict(row) if isinstance(row, dict) else {"length": row} if row is not None else {}
    if not any(meant(key, ["heading"], "wall") for key in fields):
        if isinstance(fields.get("start"), list) and isinstance(fields.get("end"), list):
            return _wall_between(fields)
        side = meant(name, HEADINGS, "walls", 0.8) or list(HEADINGS)[n % 4]
        return {"heading": HEADINGS[side], **fields}
    return fields


def _wall_between(fields: dict[str, Any]) -> dict[str, Any]:
    (ax, ay), (bx, by) = fields.pop("start")[:2], fields.pop("end")[:2]
    dx, dy = float(bx) - float(ax), float(by) - float(ay)
    heading = ("right" if dx > 0 else "left") if abs(dx) >= abs(dy) else ("back" if dy > 0 else "front")
    return {"heading": heading, "length": round(max(abs(dx), abs(dy)), 3), **fields}


def _closed(made: Mapping[str, Any]) -> dict[str, Any]:
    """Four walls of the one to three that are there; those that were missing are open."""
    by_heading = {row.get("heading"): (name, row) for name, row in made.items()}
    full: dict[str, Any] = {}
    for side, heading in HEADINGS.items():
        opposite = {"right": "left", "left": "right", "front": "back", "back": "front"}[heading]
        if heading in by_heading:
            name, row = by_heading[heading]
            full[name] = row
        else:
            length = by_heading.get(opposite, ("", {}))[1].get("length")
            usual = USUAL_ROOM["width" if heading in ("right", "left") else "depth"]
            full[side] = {"heading": heading, "length": usual if length is None else length, "open": True}
    return full


def _walls_of(size: Any) -> dict[str, Any]:
    """Four walls of a room's size: a mapping, a list of two numbers, or `4.2 x 3.1 m`."""
    width: Any = None
    depth: Any = None
    if isinstance(size, str):
        parts = [length_of(part) for part in re.split(r"\s*[x×*]\s*", size.lower())]
        if len(parts) > 1:
            width, depth = parts[0], parts[1]
    elif isinstance(size, list) and len(size) > 1:
        width, depth = size[0], size[1]
    elif isinstance(size, dict):
        found: dict[str, Any] = {}
        for key, value in size.items():
            measured = key_and_unit(key)
            name = meant(measured[0] if measured else key, ("width", "depth", "length"))
            number = value if isinstance(value, int | float) else length_of(str(value))
            if name and number is not None:
                found[name] = round(number * METRES[measured[1]], 3) if measured else number
        width, depth = found.get("width"), found.get("depth", found.get("length"))
        if width is None and "depth" in found:
            width = found.get("length")
    width, depth = width or USUAL_ROOM["width"], depth or USUAL_ROOM["depth"]
    return {
        "back": {"heading": "right", "length": width},
        "right": {"heading": "front", "length": depth},
        "front": {"heading": "left", "length": width, "open": True},
        "left": {"heading": "back", "length": depth},
    }


def _tables(form: Form) -> None:
    """Tables that are a list, a mapping or a value where the plan language has the other."""
    plan = form.plan
    for name in (*ROWS, "parameters"):
        if name not in plan or name == "walls":
            continue
        value, at = plan[name], (name,)
        if name in HAVE_IDS and isinstance(value, list) and (joined := _joined(value, name)):
            form.say(at, "a mapping of ids to rows", value, f"Write '{name}' without hyphens.", replaced(at, joined))
        elif value is None or value == "" or (not value and isinstance(value, list | dict) and name != "runs"):
            if value is None or not isinstance(value, list | dict):
                form.say(at, "rows", "nothing", f"Take out '{name}'.", removed(at))
        elif name in LISTS and isinstance(value, dict):
            rows = _listed(name, value)
            form.say(at, "a list", value, f"Write '{name}' as {flow_text(rows)}.", replaced(at, rows))
        elif name == "seats" and isinstance(value, int):
            run = next(
                (k for k, r in _named(plan.get("runs"), "run").items() if isinstance(r, dict) and "faces" in r), ""
            )
            edit = replaced(at, [{"run": run, "count": value}]) if run else removed(at)
            form.say(at, "a list of runs with a count", value, "Say at which run the seats are.", edit)
        elif not isinstance(value, dict | list):
            form.say(at, "rows", value, f"Take out '{name}'.", removed(at))
        elif name == "parameters":
            _parameters(form, value)


def _joined(rows: list[Any], table: str) -> dict[str, Any]:
    """One mapping of a list of mappings, each of one id and its row; empty where it is another list."""
    fields = ROWS[table][0].model_fields
    is_each = all(isinstance(row, dict) and len(row) == 1 and not row.keys() & fields.keys() for row in rows)
    found = {key: value for row in rows for key, value in row.items()} if is_each else {}
    return found if all(isinstance(value, dict | list) for value in found.values()) else {}


def _listed(name: str, value: Mapping[str, Any]) -> list[Any]:
    fields = ROWS[name][0].model_fields
    if any(key in fields for key in value):
        return [dict(value)]
    key, number = LISTS[name]
    rows: list[Any] = []
    for said, row in value.items():
        inner = row if isinstance(row, dict) else {number: row} if number else {"runs": row}
        rows.append({key: said, **inner} if key and key not in inner else inner)
    return rows


def _parameters(form: Form, value: Any) -> None:
    if isinstance(value, list):
        form.say(
            ("parameters",), "a mapping of names to lengths", value, "Take out 'parameters'.", removed(("parameters",))
        )
        return
    for name, row in value.items():
        at = ("parameters", name)
        numbers: list[Any] = [
            length_of(str(x)) if isinstance(x, str) else x for x in (row if isinstance(row, list) else [row])
        ]
        if isinstance(row, dict):
            form.keys(at, row, Parameter.model_fields, "parameter")
            missing = [k for k in Parameter.model_fields if k not in row]
            if missing and not form.faults:
                known = [row[k] for k in Parameter.model_fields if k in row]
                made = {k: row.get(k, known[0] if known else 3.0) for k in Parameter.model_fields}
                form.say(at, "default, low and high", row, f"Write it as {flow_text(made)}.", replaced(at, made))
        elif all(isinstance(x, int | float) for x in numbers) and (len(numbers) != 3 or numbers != row):
            low, high = min(numbers), max(numbers)
            middle = numbers[0] if len(numbers) != 2 else round((low + high) / 2, 2)
            made_list = [middle, low, high]
            form.say(at, "[default, low, high]", row, f"Write it as {flow_text(made_list)}.", replaced(at, made_list))
        elif len(numbers) == 3 and not numbers[1] <= numbers[0] <= numbers[2]:
            low, middle, high = sorted(numbers)
            if low > 0:
                made_list = [middle, low, high]
                form.say(
                    at, "[default, low, high]", row, f"Write it as {flow_text(made_list)}.", replaced(at, made_list)
                )


def _rows(form: Form) -> None:
    """Rows that are no mappings, or lack the id that a list has to give."""
    for name in ROWS:
        value = form.plan.get(name)
        if not isinstance(value, dict | list):
            continue
        pairs = list(value.items()) if isinstance(value, dict) else list(enumerate(value))
        for key, row in pairs:
            at: KeyPath = (name, key)
            if not isinstance(row, dict):
                _row_as_value(form, name, at, row)
            elif isinstance(value, list) and name in HAVE_IDS and "id" not in row:
                said = next((k for k in ("name", "item", "type", "kind", "on") if isinstance(row.get(k), str)), None)
                new = spelt(str(row[said])) if said else f"{ROWS[name][1]}_{int(key) + 1}"
                taken = {r.get("id") for r in value if isinstance(r, dict)}
                new = new if new not in taken else f"{new}_{int(key) + 1}"
                moved = said == "name" or (name == "worktop_items" and said == "item")
                edits = (
                    (renamed((*at, said), "id"), replaced((*at, "id"), new))
                    if moved and said
                    else (added((*at, "id"), new),)
                )
                form.say(at, "an id", row, f"Add `id: {new}`.", *edits)
            elif isinstance(value, dict) and row.get("id") == key:
                form.say(
                    (*at, "id"), "no id: the key of the row is its id", key, "Take out 'id'.", removed((*at, "id"))
                )


def _row_as_value(form: Form, name: str, at: KeyPath, row: Any) -> None:
    """A row that is a word, a number or a list."""
    made: dict[str, Any] | None = None
    if name == "runs" and isinstance(row, list):
        made = {"base": row}
    elif name == "corners" and isinstance(row, list) and len(row) == 2:
        made = {"runs": row}
    elif name == "lamps" and isinstance(row, str):
        made = {"item": spelt(row)}
    elif name == "seats" and isinstance(row, str):
        made = {"run": spelt(row), "count": 2}
    elif name == "slopes" and isinstance(row, str):
        made = {"wall": spelt(row)}
    elif name == "worktop_items" and isinstance(row, str) and isinstance(at[-1], str):
        made = {"on": row}
    if made is None:
        form.say(at, "a mapping", row, f"Take out {flow_text(row)}.", removed(at))
    else:
        form.say(at, "a mapping", row, f"Write it as {flow_text(made)}.", replaced(at, made))


def _row_keys(form: Form) -> None:
    """Keys of rows, and of what stands in them."""
    for name, (record, table) in ROWS.items():
        value = form.plan.get(name)
        if not isinstance(value, dict | list):
            continue
        for key, row in value.items() if isinstance(value, dict) else enumerate(value):
            if not isinstance(row, dict):
                continue
            fields = [f for f in record.model_fields if f != "id" or isinstance(value, list)]
            form.keys((name, key), row, fields, table)
            for inner, kind in (("faces", IslandPosition), ("joins", PeninsulaPosition)):
                if name == "runs" and isinstance(row.get(inner), dict):
                    form.keys((name, key, inner), row[inner], kind.model_fields, "position")
            if name == "openings" and isinstance(row.get("closet"), dict):
                form.keys((name, key, "closet"), row["closet"], Closet.model_fields, "closet")


def _runs(form: Form) -> None:
    """How runs are placed."""
    runs = form.plan.get("runs")
    pairs = list(runs.items()) if isinstance(runs, dict) else list(enumerate(runs)) if isinstance(runs, list) else []
    names = [str(row.get("id", key)) for key, row in pairs if isinstance(row, dict)]
    walls = list(_named(form.plan.get("walls"), "wall"))
    for n, (key, row) in enumerate(pairs):
        if not isinstance(row, dict):
            continue
        at, stated = ("runs", key), [k for k in ("on", "faces", "joins") if row.get(k) is not None]
        others = [name for name in names[:n] if name != names[n]] or names[:1]
        for inner in ("faces", "joins"):
            if isinstance(row.get(inner), str):
                made = {"run": row[inner], **({"end": "right"} if inner == "joins" else {})}
                form.say(
                    (*at, inner),
                    "a mapping",
                    row[inner],
                    f"Write it as {flow_text(made)}.",
                    replaced((*at, inner), made),
                )
        if len(stated) > 1:
            extra = "on" if "on" in stated else stated[1]
            form.say(at, "one of on, faces and joins", ", ".join(stated), f"Take out '{extra}'.", removed((*at, extra)))
        elif not stated and LIKE not in form.plan:
            name = names[n] if n < len(names) else ""
            wall = meant(name, walls, "walls") or (walls[n] if n < len(walls) else None)
            if name in ("island", "center", "middle") and others:
                edit, said = added((*at, "faces"), {"run": others[0]}), f"faces: {{run: {others[0]}}}"
            elif wall:
                edit, said = added((*at, "on"), wall), f"on: {wall}"
            else:
                continue
            form.say(at, "one of on, faces and joins", "none", f"Add `{said}`.", edit)


def _units(form: Form) -> None:
    """Units in other forms and other words."""
    runs = form.plan.get("runs")
    for key, run in runs.items() if isinstance(runs, dict) else enumerate(runs or ()):
        for row, kinds, record in (("base", BaseKind, BaseUnit), ("upper", UpperKind, UpperUnit)):
            units, at = run.get(row) if isinstance(run, dict) else None, ("runs", key, row)
            if units is None and isinstance(run, dict) and row in run:
                form.say(at, "a list of units", "nothing", f"Take out '{row}'.", removed(at))
            elif isinstance(units, dict):
                made: list[Any] = [{k: v} if v not in (None, {}) else k for k, v in units.items()]
                form.say(
                    at, "a list of units", units, f"Write a hyphen before each unit of '{row}'.", replaced(at, made)
                )
            elif isinstance(units, str):
                split = [part.strip() for part in units.split(",") if part.strip()]
                form.say(
                    at, "a list of units", units, f"Write each unit of '{row}' behind a hyphen.", replaced(at, split)
                )
            elif isinstance(units, list):
                for n, unit in enumerate(units):
                    _unit(form, (*at, n), unit, [k.value for k in kinds], tuple(record.model_fields), row)


def _unit(form: Form, at: KeyPath, unit: Any, kinds: list[str], fields: tuple[str, ...], row: str) -> None:
    made = unit_as_written(unit, kinds, fields, row)
    if made is None:
        form.say(at, expected_one_of(kinds, str(unit)), unit, f"Take out {flow_text(unit)}.", removed(at))
    elif made != unit:
        form.say(at, _expected(kinds, made), unit, f"Write `{item_text(made)}`.", replaced(at, made))
    elif isinstance(unit, dict) and isinstance(inner := next(iter(unit.values())), dict):
        form.keys((*at, next(iter(unit))), inner, [f for f in fields if f != "kind"], "unit")


def _expected(kinds: list[str], made: Any) -> str:
    """The kind of a unit, and the others that there are."""
    kind = next(iter(made)) if isinstance(made, dict) else made
    return f"{kind!r}, or another one of {', '.join(kinds)}"
