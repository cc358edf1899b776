"""behavior.json of an asset: its state machine, the named states of its joints, and its named poses."""

from __future__ import annotations

from casa_assets.model.asset.behavior import Behavior
from casa_assets.model.asset.joint import Keyframe, State
from casa_assets.model.record import Record


class BehaviorFile(Record):
    """behavior.json: how a fixture reacts to hands, as data. Radians, metres, seconds.

    Attributes:
        behavior: state machine.
        states: named intervals of joints.
        keyframes: named poses.
    """

    behavior: Behavior
    states: tuple[State, ...]
    keyframes: tuple[Keyframe, ...]
