"""State machines put together line by line."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from casa_assets.families.kit.asset_builder import BehaviorBuilder, negated
from casa_assets.model.asset.behavior import Condition, Effect, EffectKind, Rule, Variable

DOWN = Condition(joint="lever", interval=(-1.0, -0.5))


def test_a_builder_without_variables_makes_no_state_machine() -> None:
    assert BehaviorBuilder().build() is None


def test_variables_rules_and_effects_keep_their_order() -> None:
    builder = BehaviorBuilder()
    builder.variable("power")
    builder.rule("power", "on", DOWN, before="off", after_s=2.0)
    builder.rule("power", "off", negated(DOWN))
    builder.follow_joint("speed", "knob", {"low": (0.0, 1.0), "high": (1.0, 2.0)})
    builder.effect(EffectKind.SPIN, "speed", "blade", value="high", strength=0.5)
    builder.light("power", "lamp", (1.0, 0.0, 0.0, 1.0))
    made = builder.build()
    assert made is not None
    assert made.variables == (
        Variable(name="power", values=("off", "on"), initial="off"),
        Variable(name="speed", values=("low", "high"), initial="low"),
    )
    assert made.rules == (
        Rule(variable="power", from_values=("off",), to="on", when=(DOWN,), after_s=2.0),
        Rule(variable="power", to="off", when=(DOWN.replace(negated=True),)),
        Rule(variable="speed", to="low", when=(Condition(joint="knob", interval=(0.0, 1.0)),)),
        Rule(variable="speed", to="high", when=(Condition(joint="knob", interval=(1.0, 2.0)),)),
    )
    assert made.effects == (
        Effect(variable="speed", value="high", kind=EffectKind.SPIN, target="blade", strength=0.5),
        Effect(variable="power", value="on", kind=EffectKind.LIGHT, target="lamp", color=(1.0, 0.0, 0.0, 1.0)),
    )


def test_the_negation_of_a_negation_is_the_condition() -> None:
    assert negated(negated(DOWN)) == DOWN


def test_a_rule_of_no_variable_is_refused() -> None:
    builder = BehaviorBuilder()
    builder.variable("power")
    builder.rule("powr", "on", DOWN)
    with pytest.raises(ValidationError, match="no variable 'powr'"):
        builder.build()
