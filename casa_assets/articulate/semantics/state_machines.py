"""Build the state machine of an appliance: what happens when its doors, knobs and keys are moved.

These are the state machines of the families of the same categories; thresholds are those of registry/contracts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.behavior import Behavior, Condition, Effect, EffectKind, Rule, Variable
from casa_assets.model.asset.parts import Joint
from casa_assets.model.record import Vec4

# Share of its range up to which a door counts as shut. Ref: RoboCasa v1.0, is_closed.
DOOR_SHUT_SHARE = 0.005
# Where a knob lights its burner, and where it burns high, rad. Ref: class Stove, STOVE_LOW_MIN, STOVE_HIGH_MIN.
BURNER_LOW_RAD, BURNER_HIGH_RAD = 0.35, math.radians(80)
# Shares of its range at which a toaster's lever is down, and up again. Ref: class Toaster.
LEVER_DOWN_SHARE, LEVER_UP_SHARE = 0.9, 0.7
# Shares of the range: a kettle's switch is on, its lid is shut, or open. Ref: class ElectricKettle.
SWITCH_ON_SHARE, LID_SHUT_SHARE, LID_OPEN_SHARE = 0.95, 0.01, 0.9
# Angle at which a faucet begins to run. Ref: class Sink.
FAUCET_ON_RAD = 0.4
# How long a coffee machine pours. A choice.
POURS_S = 25.0
# Joints give a little beyond their stops, rad or m.
STOP_SLACK = 0.01
FLAME: Vec4 = (0.06, 0.2, 0.75, 0.6)
BREW: Vec4 = (0.05, 0.025, 0.012, 1.0)
WATER: Vec4 = (0.45, 0.62, 0.75, 0.6)
WARM: Vec4 = (1.0, 0.88, 0.65, 1.0)
WHITE: Vec4 = (1.0, 1.0, 1.0, 1.0)
_Parts = tuple[list[Variable], list[Rule], list[Effect]]  # of a state machine
NOTHING: _Parts = ([], [], [])


def behavior_for(asset: Asset, category: str) -> Behavior | None:
    """Return the state machine of an asset of a category, as far as its parts exist; None if it has no states.

    Args:
        asset: under the names of its kind, with its regions and sites.
    """
    makers = {
        "microwave": _microwave,
        "hob": _burners,
        "range": _burners,
        "refrigerator": _fridge,
        "toaster_oven": _toaster_oven,
        "toaster": _toaster,
        "coffee_machine": _coffee_machine,
        "kettle": _kettle,
        "sink": _faucet,
    }
    if category not in makers:
        return None
    variables, rules, effects = makers[category](asset, {j.name: j for j in asset.joints})
    return Behavior(variables=tuple(variables), rules=tuple(rules), effects=tuple(effects)) if variables else None


def _has_shape(asset: Asset, name: str) -> bool:
    return any(c.name == name for k in asset.links for c in k.colliders)


def _microwave(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """Start heats while the door is shut; the stop key or opening the door ends it."""
    if not (_has_shape(asset, "start_button") and _has_shape(asset, "stop_button")):
        return NOTHING
    start, stop = (Condition(contact=c, begins=True) for c in ("start_button", "stop_button"))
    rules = [Rule(variable="power", from_values=("on",), to="off", when=(stop,))]
    shut: tuple[Condition, ...] = ()
    if "microjoint" in joints:
        shut = (_is_shut(joints["microjoint"]),)
        rules.insert(0, Rule(variable="power", from_values=("on",), to="off", when=(shut[0].replace(negated=True),)))
    rules.append(Rule(variable="power", from_values=("off",), to="on", when=(start, *shut)))
    spins = [v.name for k in asset.links if k.name == "tray" for v in k.visuals]
    effects = [*_effects(asset, "power", "on", EffectKind.HEAT, ("int",))]
    effects += [Effect(variable="power", value="on", kind=EffectKind.SPIN, target=name) for name in spins]
    return [_switch("power")], rules, effects


def _burners(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """Each knob sets its burner to off, low or high."""
    variables, rules, effects = [], [], []
    for site in (s.name for s in asset.sites if s.name.startswith("burner_on_")):
        loc = site.removeprefix("burner_on_")
        name, joint = f"burner_{loc}", joints.get(f"knob_{loc}_joint")
        if joint is None:
            continue
        variables.append(Variable(name=name, values=("off", "low", "high"), initial="off"))
        spans = (
            ("off", (-0.1, BURNER_LOW_RAD)),
            ("low", (BURNER_LOW_RAD, BURNER_HIGH_RAD)),
            ("high", (BURNER_HIGH_RAD, joint.range[1] + 0.1)),
        )
        rules += [Rule(variable=name, to=v, when=(Condition(joint=joint.name, interval=s),)) for v, s in spans]
        for value, strength in (("low", 0.5), ("high", 1.0)):
            for kind in (EffectKind.SHOW, EffectKind.HEAT):
                visible = Effect(variable=name, value=value, kind=kind, target=site, strength=strength)
                effects.append(visible.replace(color=FLAME) if kind is EffectKind.SHOW else visible)
    return variables, rules, effects


def _fridge(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """The lamp is on while a door of the fridge is open."""
    closed = [_is_shut(j) for n, j in joints.items() if n.startswith("fridge") and "door" in n]
    if not closed:
        return NOTHING
    rules = [Rule(variable="light", to="off", when=tuple(closed))]
    rules += [Rule(variable="light", to="on", when=(s.replace(negated=True),)) for s in closed]
    effects = _effects(asset, "light", "on", EffectKind.SHOW, ("lamp",), WARM)
    return [_switch("light")], rules, effects


def _toaster_oven(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """A toaster oven heats while its timer, and its other knobs where they exist, are away from zero."""
    knobs = [joints[n] for n in ("knob_time_joint", "knob_temp_joint", "knob_function_joint") if n in joints]
    if not knobs or knobs[0].name != "knob_time_joint":
        return NOTHING
    turned = [Condition(joint=j.name, interval=(0.1 * j.range[1], j.range[1] + STOP_SLACK)) for j in knobs]
    rules = [Rule(variable="power", from_values=("on",), to="off", when=(t.replace(negated=True),)) for t in turned]
    rules.append(Rule(variable="power", from_values=("off",), to="on", when=tuple(turned)))
    heats = [r.name for r in asset.regions if r.name.startswith(("rack", "tray", "int"))]
    effects = _effects(asset, "power", "on", EffectKind.HEAT, heats)
    return [_switch("power")], rules, effects


def _toaster(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """A lever that goes down switches its slots on; its cancel key, or the lever going up, switches them off."""
    variables, rules, effects = [], [], []
    for stem, power in (("", "power"), ("side_l_", "power_l"), ("side_r_", "power_r")):
        lever = joints.get(f"{stem}lever_joint")
        if lever is None:
            continue
        variables.append(_switch(power))
        down = _range_between(lever, LEVER_DOWN_SHARE, 1.0, begins=True)
        rules.append(Rule(variable=power, from_values=("off",), to="on", when=(down,)))
        if _has_shape(asset, f"{stem}button_cancel"):
            cancel = Condition(contact=f"{stem}button_cancel", begins=True)
            rules.append(Rule(variable=power, from_values=("on",), to="off", when=(cancel,)))
        rules.append(
            Rule(variable=power, from_values=("on",), to="off", when=(_range_between(lever, 0.0, LEVER_UP_SHARE),))
        )
        slots = [r.name for r in asset.regions if r.name.startswith(f"{stem}slot_")]
        effects += _effects(asset, power, "on", EffectKind.HEAT, slots)
    return variables, rules, effects


def _coffee_machine(asset: Asset, _: Mapping[str, Joint]) -> _Parts:
    """The start key starts a brew, which ends by itself."""
    if not _has_shape(asset, "start_button"):
        return NOTHING
    press, on = Condition(contact="start_button", begins=True), Condition(variable="power", equals="on")
    effects = _effects(asset, "power", "on", EffectKind.SHOW, ("coffee_liquid",), BREW)
    effects += _effects(asset, "power", "on", EffectKind.FLOW, ("coffee_liquid",), BREW)
    rules = [
        Rule(variable="power", from_values=("off",), to="on", when=(press,)),
        Rule(variable="power", from_values=("on",), to="off", when=(on,), after_s=POURS_S),
    ]
    return [_switch("power")], rules, effects


def _kettle(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """A kettle heats while its switch is down; its lid is open or closed at the ends of its range."""
    variables, rules = [], []
    if "switch_joint" in joints:
        down = _range_between(joints["switch_joint"], SWITCH_ON_SHARE, 1.0)
        variables.append(_switch("power"))
        rules.append(Rule(variable="power", from_values=("off",), to="on", when=(down,)))
        rules.append(Rule(variable="power", from_values=("on",), to="off", when=(down.replace(negated=True),)))
    if "lid_joint" in joints:
        lid = joints["lid_joint"]
        variables.append(Variable(name="lid", values=("closed", "open"), initial="closed"))
        wide, shut = _range_between(lid, LID_OPEN_SHARE, 1.0), _range_between(lid, 0.0, LID_SHUT_SHARE)
        rules.append(Rule(variable="lid", from_values=("closed",), to="open", when=(wide,)))
        rules.append(Rule(variable="lid", from_values=("open",), to="closed", when=(shut,)))
    effects = _effects(asset, "power", "on", EffectKind.HEAT, ("int",)) if "switch_joint" in joints else []
    return variables, rules, effects


def _faucet(asset: Asset, joints: Mapping[str, Joint]) -> _Parts:
    """The flow handle runs the water; the other handle, where there is one, sets hot or cold."""
    handle, other = joints.get("handle_joint"), joints.get("handle_temp_joint")
    if handle is None or handle.range[1] <= FAUCET_ON_RAD:
        return NOTHING
    end = handle.range[1]
    half = max(end / 2, FAUCET_ON_RAD)
    levels = {"off": (-STOP_SLACK, FAUCET_ON_RAD), "low": (FAUCET_ON_RAD, half), "high": (half, end + STOP_SLACK)}
    variables = [Variable(name="water", values=("off", "low", "high"), initial="off")]
    rules = [Rule(variable="water", to=v, when=(Condition(joint=handle.name, interval=i),)) for v, i in levels.items()]
    if other is not None:
        lower, upper = other.range
        middle = (lower + upper) / 2
        variables.append(Variable(name="temperature", values=("cold", "hot"), initial="cold"))
        for value, span in (("cold", (lower - STOP_SLACK, middle)), ("hot", (middle, upper + STOP_SLACK))):
            rules.append(Rule(variable="temperature", to=value, when=(Condition(joint=other.name, interval=span),)))
    effects = []
    for value, strength in (("low", 0.5), ("high", 1.0)):
        visible = _effects(asset, "water", value, EffectKind.SHOW, ("water",), WATER)
        visible += _effects(asset, "water", value, EffectKind.FLOW, ("water",), WATER)
        effects += [e.replace(strength=strength) for e in visible]
    return variables, rules, effects


def _switch(name: str) -> Variable:
    return Variable(name=name, values=("off", "on"), initial="off")


def _is_shut(joint: Joint) -> Condition:
    """Return the condition that a joint is no farther open than counts as shut."""
    return _range_between(joint, 0.0, DOOR_SHUT_SHARE)


def _range_between(joint: Joint, first: float, last: float, begins: bool = False) -> Condition:
    """Return the condition that a joint is between two shares of its range, from zero to its farther end."""
    end = max(joint.range, key=abs)
    ends = [first * end, last * end]
    if first <= 0.0:
        ends[0] = -math.copysign(STOP_SLACK, end)
    if last >= 1.0:
        ends[1] += math.copysign(STOP_SLACK, end)
    return Condition(joint=joint.name, interval=(min(ends), max(ends)), begins=begins)


def _effects(
    asset: Asset, variable: str, value: str, kind: EffectKind, targets: Sequence[str], color: Vec4 = WHITE
) -> list[Effect]:
    """Return the effects of a variable's value on those targets that exist."""
    there = {s.name for s in asset.sites} | {r.name for r in asset.regions}
    there |= {v.name for k in asset.links for v in k.visuals}
    return [Effect(variable=variable, value=value, kind=kind, target=t, color=color) for t in targets if t in there]
