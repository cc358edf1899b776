"""State machines of what is shown: what the page has to know of them, and one step of one.

Nothing is kept between two steps: the page sends the state that it got and gets the next one, so that several pages may
show one kitchen, each with its own doors and burners.
"""

from __future__ import annotations

from typing import Any

from pydantic import ConfigDict, Field, ValidationError

from casa_assets.core.numeric import decimals
from casa_assets.errors import CasaError
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.behavior import Behavior, BehaviorState, Stimulus, start_behavior, step_behavior
from casa_assets.model.asset.parts import Region, Site
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record

DIGITS = 5  # of metres: a hundredth of a millimetre
# A page that was asleep comes back after minutes; a rule of 25 s is then over, and no longer step says more.
MAX_STEP_S = 60.0


class Step(Record):
    """State of one fixture, as a page sends it for a step of its state machine.

    Attributes:
        placement: name of the fixture; empty for an asset by itself.
        values: variable -> value, as in the last answer; empty at the start.
        before, held_s: of BehaviorState, as in the last answer.
        joints: name -> position, rad or m; names without that of the placement. Joints not listed are at zero.
        touched: names of colliders that are being pressed. dt_s: seconds since the last step.
    """

    model_config = ConfigDict(extra="forbid")

    placement: str = ""
    values: dict[str, str] = Field(default_factory=dict)
    before: tuple[tuple[bool, ...], ...] | None = None
    held_s: tuple[float, ...] = ()
    joints: dict[str, float] = Field(default_factory=dict)
    touched: tuple[str, ...] = ()
    dt_s: float = 0.0


def parse(data: bytes) -> Step:
    """Parse a step from JSON. Raises CasaError if it is not a valid step."""
    try:
        return Step.model_validate_json(data)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "the whole"
        raise CasaError(f"this is no step of a state machine: {where}: {first['msg']}") from error


def step(behavior: Behavior, said: Step) -> dict[str, Any]:
    """The next state of a machine, and the effects that act in it, as JSON has them.

    Returns:
        values, before, held_s: for the next step. effects: rows of `kind`, `target`, `color`, `strength`.
        waits: whether a rule is counting seconds, so that time alone changes something.
    Raises:
        CasaError: a state that this machine cannot be in, or a joint that is no number.
    """
    state = start_behavior(behavior)
    if said.values:
        known = {variable.name: variable.values for variable in behavior.variables}
        if set(said.values) != set(known) or any(value not in known[name] for name, value in said.values.items()):
            raise CasaError(f"{said.values} is no state of this machine; it has {known}")
        state = BehaviorState(behavior, said.values, said.before, said.held_s)
        if len(said.held_s) != len(behavior.rules) or (
            said.before is not None
            and [len(held) for held in said.before] != [len(rule.when) for rule in behavior.rules]
        ):
            raise CasaError(f"{said.placement or 'the asset'}: the state has not the rules of this machine")
    joints = {name: said.joints.get(name, 0.0) for name in behavior.joints}
    seconds = min(max(said.dt_s, 0.0), MAX_STEP_S)
    after = step_behavior(state, Stimulus(joints, frozenset(said.touched)), seconds)
    waits = any(rule.after_s and held for rule, held in zip(behavior.rules, after.held_s, strict=True))
    return {
        "values": dict(after.values),
        "before": after.before,
        "held_s": after.held_s,
        "effects": [
            {"kind": one.kind.value, "target": one.target, "color": list(one.color), "strength": one.strength}
            for one in after.effects
        ],
        "waits": waits,
    }


def describe(asset: Asset, placement: str = "") -> dict[str, Any] | None:
    """Return the data with which a page shows an asset's state machine, or None if the asset has no state machine.

    Returns:
        variables: name -> values. joints: names of those that it depends on.
        contacts: rows of `name` and `joint` of colliders that are pressed; the joint is that of the key, null if it
            does not move.
        targets: name of a site, visual or region that effects act on -> `link`, and its `points` and `faces` or its
            `position`, `quaternion` and `size`.
    """
    behavior = asset.behavior
    if behavior is None:
        return None
    moved_by = {c.name: asset.joint_of(link.name) for link in asset.links for c in link.colliders}
    contacts = [(name, moved_by[name]) for name in dict.fromkeys(behavior.contacts)]
    return {
        "placement": placement,
        "variables": {variable.name: list(variable.values) for variable in behavior.variables},
        "joints": list(dict.fromkeys(behavior.joints)),
        "contacts": [{"name": name, "joint": joint.name if joint else None} for name, joint in contacts],
        "targets": {name: _target(asset, name) for name in dict.fromkeys(behavior.targets)},
    }


def _target(asset: Asset, name: str) -> dict[str, Any]:
    for link in asset.links:
        for visual in link.visuals:
            if visual.name == name:
                points = [_rounded(point) for point in visual.mesh.vertices.tolist()]
                return {"is": "visual", "link": link.name, "points": points, "faces": visual.mesh.faces.tolist()}
    places: tuple[Site | Region, ...] = (*asset.sites, *asset.regions)
    place = next(place for place in places if place.name == name)
    size = [2 * place.radius] * 3 if isinstance(place, Site) and place.size is None else list(place.size or ())
    kind = "site" if isinstance(place, Site) else "region"
    return {"is": kind, "link": place.link, "shape": place.kind, "size": size, **_pose(place.pose)}


def _pose(pose: Pose) -> dict[str, Any]:
    """`quaternion` is (w, x, y, z)."""
    return {"position": _rounded(pose.position), "quaternion": _rounded(pose.quaternion)}


def _rounded(numbers: Any) -> list[float]:
    return [decimals(float(number), DIGITS) for number in numbers]
