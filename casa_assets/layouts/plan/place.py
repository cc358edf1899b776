"""Place the runs of a plan: at walls, in front of other runs, or across their ends."""

from __future__ import annotations

from collections.abc import Mapping

from casa_assets.errors import PlanConflict
from casa_assets.layouts.plan import standard_sizes
from casa_assets.layouts.plan.room import Room, WallLine, resolve_length, wall_of
from casa_assets.layouts.plan.runs import TOUCH_M, LineEnd, RunLine, base_slots
from casa_assets.layouts.plan.style_models import StyleModels
from casa_assets.model.kitchen.floor import RunEnd
from casa_assets.model.kitchen.plan import BaseKind, CornerKind, IslandSide, Plan, Run, RunCorner, RunSide

MIN_LENGTH_M = 0.3  # of a run at a wall


def place_runs(plan: Plan, room: Room, parameters: Mapping[str, float], models: StyleModels) -> dict[str, RunLine]:
    """Place all runs, by id. Raises PlanConflict."""
    _check_names(plan)
    lines: dict[str, RunLine] = {}
    ends = {}
    for corner in plan.corners:
        for name in corner.runs:
            if name not in {r.id for r in plan.runs}:
                raise PlanConflict(plan.id, ("corners",), "runs of the plan", repr(name))
        ends[(corner.runs[0], RunSide.RIGHT)] = _corner_end(corner, 0)
        ends[(corner.runs[1], RunSide.LEFT)] = _corner_end(corner, 1)
    for run in plan.runs:
        left = ends.get((run.id, RunSide.LEFT), LineEnd(RunEnd.FREE))
        right = ends.get((run.id, RunSide.RIGHT), LineEnd(RunEnd.FREE))
        if run.on is not None:
            wall = wall_of(plan, room, run.on, "runs", run.id, "on")
            lines[run.id] = _place_at_wall(plan, run, wall, parameters, left, right)
        else:
            lines[run.id] = _place_free(plan, run, parameters, models, lines, left, right)
    for k, corner in enumerate(plan.corners):
        first, second = (lines[name].frame for name in corner.runs)
        if first.more_deg != second.more_deg:
            got = f"{(first.turn_deg - second.turn_deg) % 360.0:g} degrees between {' and '.join(corner.runs)}"
            raise PlanConflict(plan.id, ("corners", k), "runs that meet at a right angle", got)
        if (first.turn_deg - second.turn_deg) % 360.0 != 90.0:
            expected = "two runs of which the second begins, on its left, where the first ends"
            raise PlanConflict(plan.id, ("corners", k, "runs"), expected, f"{' and '.join(corner.runs)}")
    return lines


def _corner_end(corner: RunCorner, index: int) -> LineEnd:
    """The end of the first (0) or second (1) run of a corner, with the lengths that the corner takes."""
    owner = corner.owner or corner.runs[0]
    is_owner = corner.runs[index] == owner
    door, upper_door = (standard_sizes.CORNER_DOOR, standard_sizes.UPPER_CORNER_DOOR) if is_owner else (0.0, 0.0)
    base = {
        CornerKind.BLIND: standard_sizes.CORNER_CLEARANCE + door,
        CornerKind.DIAGONAL: standard_sizes.DIAGONAL,
        CornerKind.DEAD: standard_sizes.CORNER_CLEARANCE,
    }[corner.base]
    upper = {
        None: 0.0,
        CornerKind.BLIND: standard_sizes.UPPER_CORNER_CLEARANCE + upper_door,
        CornerKind.DIAGONAL: standard_sizes.UPPER_DIAGONAL,
        CornerKind.DEAD: standard_sizes.UPPER_CORNER_CLEARANCE,
    }[corner.upper]
    return LineEnd(RunEnd.CORNER, corner, base, upper)


def _place_at_wall(
    plan: Plan, run: Run, wall: WallLine, parameters: Mapping[str, float], left: LineEnd, right: LineEnd
) -> RunLine:
    at = ("runs", run.id)
    start, end = (resolve_length(plan, x, parameters, *at, n) for x, n in ((run.start, "start"), (run.end, "end")))
    length = round(wall.length - start - end, 4)
    if run.length is not None:
        surplus = round(length - resolve_length(plan, run.length, parameters, *at, "length"), 4)
        if surplus < 0:
            raise PlanConflict(plan.id, (*at, "length"), f"at most {length:.2f} m", f"{length - surplus:.2f} m")
        keeps_right = right.kind is RunEnd.CORNER and left.kind is RunEnd.FREE
        start, end = (start + surplus, end) if keeps_right else (start, end + surplus)
        length = round(length - surplus, 4)
    if length <= MIN_LENGTH_M:
        expected = f"a start and an end that leave some of {wall.length:.2f} m"
        raise PlanConflict(plan.id, at, expected, f"{length:.2f} m")
    if left.kind is RunEnd.FREE and start < TOUCH_M and not wall.left_bare:
        left = LineEnd(RunEnd.WALL)
    if right.kind is RunEnd.FREE and end < TOUCH_M and not wall.right_bare:
        right = LineEnd(RunEnd.WALL)
    return RunLine(run, wall.frame.offset(start), length, standard_sizes.BASE_DEPTH, left, right)


def _place_free(
    plan: Plan,
    run: Run,
    parameters: Mapping[str, float],
    models: StyleModels,
    lines: Mapping[str, RunLine],
    left: LineEnd,
    right: LineEnd,
) -> RunLine:
    """Place a peninsula across the end of another run, or an island in front of one."""
    at = ("runs", run.id)
    length = _own_length(plan, run, parameters, models, left, right)
    other_id = run.faces.run if run.faces else run.joins.run if run.joins else ""
    if other_id not in lines:
        raise PlanConflict(plan.id, at, "a run that stands before it in the plan", repr(other_id))
    other = lines[other_id]
    if run.joins is not None:
        if run.joins.end is RunSide.RIGHT:
            frame = other.frame.offset(other.length, 0.0, -1)
        else:
            frame = other.frame.offset(0.0, 0.0, 1).offset(-length)
        return RunLine(run, frame, length, standard_sizes.BASE_DEPTH, left, right)
    assert run.faces is not None, "the record has one of `on`, `faces` and `joins`"
    is_island = bool(run.base) and run.base[0].kind is BaseKind.ISLAND
    depth = standard_sizes.ISLAND_DEPTH if is_island else standard_sizes.BASE_DEPTH
    unit, middle = run.faces.in_front_of, other.length / 2
    if unit is not None:
        slots = {s.name: s for s in base_slots(plan, other, models)}
        if unit not in slots:
            raise PlanConflict(plan.id, (*at, "faces", "in_front_of"), f"a unit of {other.id}", repr(unit))
        middle = slots[unit].middle
    middle += run.faces.shift
    away = run.faces.aisle + standard_sizes.WORKTOP_OVERHANG + depth
    if run.faces.side is IslandSide.BACK:
        if other.at_wall:
            raise PlanConflict(plan.id, (*at, "faces", "side"), "front, since that run stands at a wall", "'back'")
        frame = other.frame.offset(middle - length / 2, -other.depth_behind - away)
        return RunLine(run, frame, length, depth, left, right)
    back = standard_sizes.WORKTOP_DEPTH + away
    return RunLine(run, other.frame.offset(middle + length / 2, back, 2), length, depth, left, right)


def _own_length(
    plan: Plan, run: Run, parameters: Mapping[str, float], models: StyleModels, left: LineEnd, right: LineEnd
) -> float:
    """Length of a run that no wall bounds."""
    if run.length is not None:
        return resolve_length(plan, run.length, parameters, "runs", run.id, "length")
    units = sum(standard_sizes.base_span(u, models).usual for u in run.base)
    return round(left.base_length + right.base_length + units, 3)


def _check_names(plan: Plan) -> None:
    """Raise PlanConflict where two things of a plan have one name, since placements are named after the plan."""
    seen: set[str] = set()
    names: list[tuple[tuple[str | int, ...], str]] = []
    for run in plan.runs:
        for row, units in (("base", run.base), ("upper", run.upper)):
            names += [(("runs", run.id, row, k), unit.id) for k, unit in enumerate(units)]
    for field in ("openings", "columns", "worktop_items", "tables", "wall_items", "floor_items"):
        names += [((field, item.id), item.id) for item in getattr(plan, field)]
    for pointer, name in names:
        if name in seen:
            raise PlanConflict(plan.id, pointer, "a name of its own", f"a second {name!r}")
        seen.add(name)
