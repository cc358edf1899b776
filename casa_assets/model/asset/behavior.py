"""State machine of a fixture as data: joint or contact -> state -> effect.

A simulation can run it without this package. Once per control step it goes through `rules` in order. For each variable,
the first rule whose `from_values` include the current value and whose conditions have all held for `after_s` without
interruption sets the variable to `to`; the variable's other rules wait for the next step. All conditions of a step see
the values at the end of the previous step. Then each effect acts on its target if its variable has its value.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated, Self

from pydantic import Field, model_validator

from casa_assets.model.record import Id, MixedCaseId, Record, Vec2, Vec4

# Sums of steps of time: a rule that waits a second has waited it after fifty steps of 0.02 s.
TIME_SLACK_S = 1e-9


class Condition(Record):
    """One condition that a runtime can measure; exactly one of joint, contact and variable is given.

    Attributes:
        joint: its position is within `interval`, rad or m, both ends included.
        contact: something that is not part of the asset touches this collider. variable: it has the value `equals`.
        begins: holds only in the step in which it becomes true (a press, not a hold).
        negated: holds if the rest does not.
    """

    joint: Id | None = None
    interval: Vec2 | None = None
    contact: MixedCaseId | None = None
    variable: Id | None = None
    equals: Id | None = None
    begins: bool = False
    negated: bool = False

    @model_validator(mode="after")
    def _one(self) -> Self:
        if sum(x is not None for x in (self.joint, self.contact, self.variable)) != 1:
            raise ValueError("a condition names one joint, contact or variable")
        if (self.joint is None) != (self.interval is None) or (self.variable is None) != (self.equals is None):
            raise ValueError("a joint comes with an interval, a variable with a value")
        if self.interval is not None and self.interval[0] > self.interval[1]:
            raise ValueError(f"interval {self.interval} must rise")
        return self


class Variable(Record):
    """A variable with a small set of values; `initial` is the value at the start."""

    name: Id
    values: Annotated[tuple[Id, ...], Field(min_length=2)]
    initial: Id

    @model_validator(mode="after")
    def _initial(self) -> Self:
        if self.initial not in self.values or len(set(self.values)) != len(self.values):
            raise ValueError(f"variable {self.name!r}: {self.initial!r} must be one of {self.values}, each once")
        return self


class Rule(Record):
    """One transition of a variable: its source values, its conditions and its new value.

    Attributes:
        from_values: values that it may have before; empty: any value. to: the new value.
        when: one or more conditions, all of which have to hold.
        after_s: time for which they have to hold before the transition, seconds.
    """

    variable: Id
    from_values: tuple[Id, ...] = ()
    to: Id
    when: tuple[Condition, ...]
    after_s: Annotated[float, Field(ge=0)] = 0.0


class EffectKind(StrEnum):
    """Kind of change that a runtime makes to the target while an effect acts."""

    SHOW = "show"  # a site (flame, water, coffee) or visual gets the effect's colour
    LIGHT = "light"  # a visual glows, and a lamp at it shines, in the effect's colour
    HEAT = "heat"  # a region or site gets hot
    COOL = "cool"
    FLOW = "flow"  # liquid falls from a site
    SPIN = "spin"  # a visual turns by itself (a turntable, a whisk)


class Effect(Record):
    """Visible consequence of a value: `target` is a site, visual or region; `strength` 0..1."""

    variable: Id
    value: Id
    kind: EffectKind
    target: MixedCaseId
    color: Vec4 = (1.0, 1.0, 1.0, 1.0)
    strength: Annotated[float, Field(gt=0, le=1)] = 1.0


class Behavior(Record):
    """A state machine.

    Attributes:
        variables: such as `power`: `off`, `on`. rules: in the order in which they are tried.
        effects: visible consequences of values.
    """

    variables: tuple[Variable, ...]
    rules: tuple[Rule, ...]
    effects: tuple[Effect, ...] = ()

    @model_validator(mode="after")
    def _whole(self) -> Self:
        values = {v.name: v.values for v in self.variables}
        asked = [(r.variable, v) for r in self.rules for v in (*r.from_values, r.to)]
        asked += [(c.variable, c.equals or "") for r in self.rules for c in r.when if c.variable]
        asked += [(e.variable, e.value) for e in self.effects]
        for variable, value in asked:
            if value not in values.get(variable, ()):
                raise ValueError(f"no variable {variable!r} with a value {value!r}")
        return self

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints that conditions depend on."""
        return tuple(c.joint for r in self.rules for c in r.when if c.joint)

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the colliders that conditions depend on."""
        return tuple(c.contact for r in self.rules for c in r.when if c.contact)

    @property
    def targets(self) -> tuple[str, ...]:
        """Names of the targets of effects."""
        return tuple(e.target for e in self.effects)


@dataclass(frozen=True)
class Stimulus:
    """Measurements of a runtime in one step: positions of joints, rad or m, and colliders that something touches."""

    joints: Mapping[str, float]
    touched: frozenset[str] = frozenset()


@dataclass(frozen=True)
class BehaviorState:
    """State of a behaviour; `step_behavior` gives the next one.

    Attributes:
        behavior: its rules. values: variable -> value.
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


def start_behavior(behavior: Behavior) -> BehaviorState:
    """The state with every variable at its initial value."""
    return BehaviorState(behavior, {v.name: v.initial for v in behavior.variables}, None, (0.0,) * len(behavior.rules))


def step_behavior(state: BehaviorState, stimulus: Stimulus, dt: float) -> BehaviorState:
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
