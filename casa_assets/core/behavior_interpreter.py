"""Interpreter of behaviours: updates their variables as joints move and colliders are touched."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from casa_assets.model.asset.behavior import Behavior, Condition, Effect

# Sums of steps of time: a rule that waits a second has waited it after fifty steps of 0.02 s.
TIME_SLACK_S = 1e-9


@dataclass(frozen=True)
class Stimulus:
    """Measurements of a runtime in one step: positions of joints, rad or m, and colliders that something touches."""

    joints: Mapping[str, float]
    touched: frozenset[str] = frozenset()


@dataclass(frozen=True)
class BehaviorState:
    """State of a behaviour; `step` gives the next one.

    Attributes:
        behavior: its rules.
        values: variable -> value.
        before: which conditions of which rules held in the last step, or None before the first step.
        held_s: for each rule, how long its conditions have held, seconds.
    """

    behavior: Behavior
    values: Mapping[str, str]
    before: tuple[tuple[bool, ...], ...] | None = None
    held_s: tuple[float, ...] = field(default=())

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Effects that act now."""
        return tuple(e for e in self.behavior.effects if self.values[e.variable] == e.value)


def start(behavior: Behavior) -> BehaviorState:
    """The state with every variable at its initial value."""
    return BehaviorState(behavior, {v.name: v.initial for v in behavior.variables}, None, (0.0,) * len(behavior.rules))


def step(state: BehaviorState, stimulus: Stimulus, dt: float) -> BehaviorState:
    """Run one control step of `dt` seconds: for each variable, the first rule that applies sets the new value.

    All rules see the values from before the step. A condition that holds in the very first step does not count as just
    begun, since the runtime has not seen it false.
    """
    values, decided = dict(state.values), set[str]()
    now: list[tuple[bool, ...]] = []
    held: list[float] = []
    for i, rule in enumerate(state.behavior.rules):
        raw = tuple(_holds(c, stimulus, state.values) for c in rule.when)
        was = raw if state.before is None else state.before[i]
        now.append(raw)
        true = [r and not w if c.begins else r for c, r, w in zip(rule.when, raw, was, strict=True)]
        is_asked = not rule.from_values or state.values[rule.variable] in rule.from_values
        if not is_asked or any(t == c.negated for t, c in zip(true, rule.when, strict=True)):
            held.append(0.0)
            continue
        held.append(state.held_s[i] + dt)
        due = rule.after_s == 0.0 or held[i] >= rule.after_s - TIME_SLACK_S
        if due and rule.variable not in decided:
            decided.add(rule.variable)
            values[rule.variable] = rule.to
            held[i] = 0.0 if rule.after_s else held[i]
    return BehaviorState(state.behavior, values, tuple(now), tuple(held))


def _holds(condition: Condition, stimulus: Stimulus, values: Mapping[str, str]) -> bool:
    """Whether a condition holds, without regard to `begins` and `negated`."""
    if condition.joint is not None:
        assert condition.interval is not None, "the record has looked"
        low, high = condition.interval
        return low <= stimulus.joints[condition.joint] <= high
    if condition.contact is not None:
        return condition.contact in stimulus.touched
    return condition.variable is not None and values[condition.variable] == condition.equals
