"""Find values of a behaviour that no sequence of moves, touches and waits can reach."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from casa_assets.core.behavior_interpreter import BehaviorState, Stimulus, step
from casa_assets.model.asset.behavior import Behavior
from casa_assets.model.record import Vec2

TICK_S = 0.05
# States of one group of variables that are looked at; sound behaviours have dozens.
MOST = 4096
State = tuple[tuple[str, ...], tuple[float, ...], tuple[bool, ...]]


@dataclass(frozen=True)
class VariableGroup:
    """Variables whose rules depend on each other, with all inputs of these rules.

    Attributes:
        behavior: these variables and their rules.
        joints, stands: names, and the positions worth trying of each.
        contacts: names.
        longest_s: longest time that a rule waits.
    """

    behavior: Behavior
    joints: tuple[str, ...]
    stands: tuple[tuple[float, ...], ...]
    contacts: tuple[str, ...]
    longest_s: float


def unreached(behavior: Behavior, ranges: Mapping[str, Vec2]) -> list[tuple[str, str]]:
    """(variable, value) of every value that no sequence of moves, touches and waits brings about.

    Args:
        ranges: joint -> (low, high), rad or m.
    """
    missing: list[tuple[str, str]] = []
    for group in _groups(behavior, ranges):
        missing += _search(group)
    return missing


def _groups(behavior: Behavior, ranges: Mapping[str, Vec2]) -> Iterator[VariableGroup]:
    left = [v.name for v in behavior.variables]
    while left:
        names = _connected(behavior, left[0])
        left = [n for n in left if n not in names]
        rules = tuple(r for r in behavior.rules if r.variable in names)
        part = Behavior(variables=tuple(v for v in behavior.variables if v.name in names), rules=rules)
        joints = tuple(dict.fromkeys(part.joints))
        yield VariableGroup(
            part,
            joints,
            tuple(_stands(part, joint, ranges[joint]) for joint in joints),
            tuple(dict.fromkeys(part.contacts)),
            max((r.after_s for r in rules), default=0.0),
        )


def _connected(behavior: Behavior, name: str) -> list[str]:
    found = [name]
    for at in found:
        for rule in behavior.rules:
            looks = [c.variable for c in rule.when if c.variable]
            if rule.variable == at or at in looks:
                found += [n for n in dict.fromkeys([rule.variable, *looks]) if n not in found]
    return found


def _stands(behavior: Behavior, joint: str, span: Vec2) -> tuple[float, ...]:
    """Positions that differ in which intervals hold them, the one nearest to zero first."""
    intervals = [c.interval for r in behavior.rules for c in r.when if c.joint == joint and c.interval]
    low, high = span
    cuts = sorted({low, high, *(min(max(end, low), high) for i in intervals for end in i)})
    tried = sorted([*cuts, *((a + b) / 2 for a, b in pairwise(cuts))])
    home = min(max(0.0, low), high)
    found: dict[tuple[bool, ...], float] = {}
    for at in [home, *sorted(tried, key=lambda v: (abs(v), v))]:
        found.setdefault(tuple(a <= at <= b for a, b in intervals), at)
    return tuple(found.values())


def _search(group: VariableGroup) -> list[tuple[str, str]]:
    variables = group.behavior.variables
    missing = [(v.name, value) for v in variables for value in v.values]
    first: State = (
        tuple(v.initial for v in variables),
        tuple(s[0] for s in group.stands),
        (False,) * len(group.contacts),
    )
    seen, queue = {first}, deque([first])
    while queue and missing:
        state = queue.popleft()
        missing = [m for m in missing if m not in list(zip([v.name for v in variables], state[0], strict=True))]
        for after in _moves(group, state):
            if after not in seen and len(seen) < MOST:
                seen.add(after)
                queue.append(after)
    return missing


def _moves(group: VariableGroup, state: State) -> Iterator[State]:
    """States one act away: one joint elsewhere, one thing touched or let go, or time gone by."""
    values, at, touched = state
    stood = step(_machine(group, values), _stimulus(group, at, touched), 0.0)
    for i, options in enumerate(group.stands):
        for there in options:
            if there != at[i]:
                yield _after(group, stood, (*at[:i], there, *at[i + 1 :]), touched, TICK_S)
    for i, held in enumerate(touched):
        yield _after(group, stood, at, (*touched[:i], not held, *touched[i + 1 :]), TICK_S)
    yield _after(group, stood, at, touched, TICK_S)
    if group.longest_s:
        yield _after(group, stood, at, touched, group.longest_s)


def _after(
    group: VariableGroup, machine: BehaviorState, at: tuple[float, ...], touched: tuple[bool, ...], seconds: float
) -> State:
    done = step(machine, _stimulus(group, at, touched), seconds)
    return tuple(done.values[v.name] for v in group.behavior.variables), at, touched


def _machine(group: VariableGroup, values: tuple[str, ...]) -> BehaviorState:
    names = (v.name for v in group.behavior.variables)
    return BehaviorState(
        group.behavior, dict(zip(names, values, strict=True)), None, (0.0,) * len(group.behavior.rules)
    )


def _stimulus(group: VariableGroup, at: tuple[float, ...], touched: tuple[bool, ...]) -> Stimulus:
    held = frozenset(name for name, on in zip(group.contacts, touched, strict=True) if on)
    return Stimulus(dict(zip(group.joints, at, strict=True)), held)
