"""Builder of an asset's state machine (`model/asset/behavior.py`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from casa_assets.model.asset.behavior import Behavior, Condition, Effect, EffectKind, Rule, Variable
from casa_assets.model.record import Vec2, Vec4


@dataclass
class BehaviorBuilder:
    """Variables, rules and effects in the order in which they were added."""

    variables: list[Variable] = field(default_factory=list)
    rules: list[Rule] = field(default_factory=list)
    effects: list[Effect] = field(default_factory=list)

    def variable(self, name: str, *values: str) -> None:
        """Add a variable; its first value is the one at the start. Without values it is `off` and `on`."""
        values = values or ("off", "on")
        self.variables.append(Variable(name=name, values=values, initial=values[0]))

    def rule(self, variable: str, to: str, *when: Condition, before: str = "", after_s: float = 0.0) -> None:
        """Set a variable to a value where all conditions hold; `before`: only where it has that value, else any."""
        from_values = (before,) if before else ()
        self.rules.append(Rule(variable=variable, from_values=from_values, to=to, when=when, after_s=after_s))

    def follow_joint(self, name: str, joint: str, intervals: Mapping[str, Vec2]) -> None:
        """Add a variable that takes the value whose interval contains the joint's position.

        Args:
            intervals: value -> interval, rad or m; the first value is the initial one.
        """
        self.variable(name, *intervals)
        for value, interval in intervals.items():
            self.rule(name, value, Condition(joint=joint, interval=interval))

    def effect(
        self,
        kind: EffectKind,
        variable: str,
        target: str,
        *,
        value: str = "on",
        color: Vec4 = (1.0, 1.0, 1.0, 1.0),
        strength: float = 1.0,
    ) -> None:
        """Add what happens to a target while a variable has a value."""
        self.effects.append(
            Effect(variable=variable, value=value, kind=kind, target=target, color=color, strength=strength)
        )

    def light(self, variable: str, target: str, color: Vec4) -> None:
        """Let a target glow in a colour while a variable is `on`."""
        self.effect(EffectKind.LIGHT, variable, target, color=color)

    def build(self) -> Behavior | None:
        """The state machine, or None if there are no variables."""
        if not self.variables:
            return None
        return Behavior(variables=tuple(self.variables), rules=tuple(self.rules), effects=tuple(self.effects))


def negated(condition: Condition) -> Condition:
    """A condition that holds where the given one does not."""
    return condition.replace(negated=not condition.negated)
