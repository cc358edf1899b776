"""Keys that are pressed and come back, and the toggle that one key makes."""

from __future__ import annotations

from casa_assets.core import hand_dynamics
from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.behavior_builder import BehaviorBuilder
from casa_assets.families.kit.solids.blocks import box, rod
from casa_assets.families.kit.solids.solid import Solid
from casa_assets.model.asset.behavior import Condition
from casa_assets.model.record import Vec3

KEY_TRAVEL = 0.0025  # metres
KEY_CLEARANCE = 0.0004  # metres that are left under a pressed key


def round_key(radius: float, height: float = 0.005) -> Solid:
    """A round cap whose foot is at z = 0."""
    return rod(radius, height, min(0.0015, 0.3 * height)).translated(z=height / 2)


def flat_key(width: float, tall: float, height: float = 0.005) -> Solid:
    """A rectangular cap whose foot is at z = 0; wide along x, tall along y."""
    return box((width, tall, height), (0.0, 0.0, height / 2), 0.0015, 2)


def add_key(
    builder: AssetBuilder,
    name: str,
    joint: str,
    at: Vec3,
    cap: Solid,
    finish: str,
    *,
    face: str = "front",
    parent: str = ROOT,
    stroke: float = KEY_TRAVEL,
) -> None:
    """A sprung key; its collider is called `name`, its link `<name>_key`.

    Args:
        at: middle of its foot on the surface that it is set in, parent's frame, metres.
        cap: standing on z = 0. face: where it looks: `front` (-y), `up`, `left` (-x), `right` or `back`.
    """
    turn, direction = _FACES[face]
    lift = stroke + KEY_CLEARANCE
    place = (at[0] - direction[0] * lift, at[1] - direction[1] * lift, at[2] - direction[2] * lift)
    link = builder.link(f"{name}_key", at=place, parent=parent)
    builder.add(link, _turned(cap, turn), finish, label="button", name=name)
    lower, upper = cap.bounds
    width, height = float(upper[0] - lower[0]) - 0.003, float(upper[1] - lower[1]) - 0.003
    stem = box((width, height, lift + 0.0015), (0.0, 0.0, -(lift + 0.0015) / 2 + 0.001), 0.0)
    # The stem goes into its hole when the key is pressed.
    builder.add(link, _turned(stem, turn), "plastic_black", label="button", collider=False, density=0.0)
    spring = hand_dynamics.press(stroke, hand_dynamics.KEY_FULL_N, hand_dynamics.KEY_PRELOAD_N)
    builder.slide(joint, link, direction, (0.0, stroke), name, spring=spring, feel=hand_dynamics.KEY)


_FACES: dict[str, tuple[tuple[str, float] | None, Vec3]] = {
    "front": (("x", 1.5707963267948966), (0.0, 1.0, 0.0)),
    "back": (("x", -1.5707963267948966), (0.0, -1.0, 0.0)),
    "left": (("y", -1.5707963267948966), (1.0, 0.0, 0.0)),
    "right": (("y", 1.5707963267948966), (-1.0, 0.0, 0.0)),
    "up": (None, (0.0, 0.0, -1.0)),
}


def _turned(solid: Solid, turn: tuple[str, float] | None) -> Solid:
    return solid if turn is None else solid.rotated(*turn)


def add_toggle(behavior: BehaviorBuilder, variable: str, collider: str) -> None:
    """Add a variable that one key switches on and off: on a press, once for each press.

    A second variable, `<variable>_latch`, follows when the key is let go, so that one press counts once.
    """
    latch = f"{variable}_latch"
    press = Condition(contact=collider, begins=True)
    free = Condition(contact=collider, negated=True)
    behavior.variable(variable)
    behavior.variable(latch)
    behavior.rule(variable, "off", press, Condition(variable=latch, equals="on"), before="on")
    behavior.rule(variable, "on", press, Condition(variable=latch, equals="off"), before="off")
    behavior.rule(latch, "on", free, Condition(variable=variable, equals="on"), before="off")
    behavior.rule(latch, "off", free, Condition(variable=variable, equals="off"), before="on")
