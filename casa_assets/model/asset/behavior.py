"""State machine of a fixture as data: joint or contact -> state -> effect.

A simulation reads it without this package. Once per control step it goes through `rules` in order. The first rule of a
variable whose `from_values` hold its value and whose conditions all hold, for `after_s` on end, sets the variable to
`to`; its other rules wait for the next step. All conditions of a step see the values that the step before left. Then
every effect whose variable has its value acts on its target.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Self

from pydantic import Field, model_validator

from casa_assets.model.record import Id, MixedCaseId, Record, Vec2, Vec4


class Condition(Record):
    """One thing that a runtime can measure; exactly one of joint, contact and variable is named.

    Attributes:
        joint: its position lies within `interval`, rad or m, both ends included.
        contact: something that is no part of the asset touches this collider.
        variable: it has the value `equals`.
        begins: holds only in the step in which it becomes true (a press, not a hold).
        negated: holds where the rest does not.
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
    """Something that has one of a few values; `initial` is the one at the start."""

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
        from_values: values that it may have before; any where empty.
        to: the value that it gets.
        when: conditions that all hold; one or more.
        after_s: seconds for which they have held.
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
        variables: such as `power`: `off`, `on`.
        rules: in the order in which they are tried.
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
        """Names of the joints that conditions look at."""
        return tuple(c.joint for r in self.rules for c in r.when if c.joint)

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the colliders that conditions look at."""
        return tuple(c.contact for r in self.rules for c in r.when if c.contact)

    @property
    def targets(self) -> tuple[str, ...]:
        """Names of what effects act on."""
        return tuple(e.target for e in self.effects)
