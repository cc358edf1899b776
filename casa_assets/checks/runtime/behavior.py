"""Find behaviour that a runtime does not get: values out of reach, keys that no finger presses, rooms without room."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks import check
from casa_assets.checks.check import Package
from casa_assets.checks.motion.simulation import STEP_S, collision_spec, find_contacts
from casa_assets.checks.readers import mujoco_facts
from casa_assets.checks.runtime import contract as contract_names
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.asset import Asset, Region
from casa_assets.model.asset.behavior import (
    Behavior,
    BehaviorState,
    Effect,
    EffectKind,
    Stimulus,
    start_behavior,
    step_behavior,
)
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2
from casa_assets.model.registry.contract import Contract, KeyRule, Trial

TICK_S = 0.05
# States of one group of variables that are looked at; sound behaviours have dozens.
MOST = 4096
State = tuple[tuple[str, ...], tuple[float, ...], tuple[bool, ...]]
NO_BEHAVIOR = "it has no behaviour: nothing about it changes"
SETTLE_STEPS, HOLD_STEPS = 3, 2  # steps that a chain of rules is given to come to an end, and for which a key is held
# How far the end of an interval may be from the threshold that it stands for, rad or m.
THRESHOLD_TOLERANCE = 1e-3
MIN_VISIBLE_M = 0.004  # sites that are smaller are not seen. Our choice.
# What each kind of effect can act on.
TARGET_KINDS = {
    EffectKind.SHOW: ("site", "visual"),
    EffectKind.LIGHT: ("visual",),
    EffectKind.HEAT: ("region", "site"),
    EffectKind.COOL: ("region", "site"),
    EffectKind.FLOW: ("site",),
    EffectKind.SPIN: ("visual",),
}
BALL_DIAMETER_M = 0.06
BALL_SHARE = 0.8  # of the least side of a region that is narrower
DROP_HEIGHT_M = 0.008
SIMULATED_S = 1.5
OUTER_REGIONS = frozenset({"main", "bbox"})
MAX_SPEED_M_S = 0.05
MAX_PENETRATION_M = 1e-3
# Radius of the fingertip, a sphere; how deep it is pressed into what it touches; height at which it waits; metres.
TIP_RADIUS_M, PRESS_DEPTH_M, WAITING_HEIGHT_M = 0.004, 0.0003, 50.0
# Steps of the approach to a surface; each at worst halves the distance that is left.
APPROACH_STEPS = 12
CACHED_TIPS = 4
TIP = "casa_fingertip"


@dataclass(frozen=True)
class VariableGroup:
    """Variables whose rules depend on each other, with all inputs of these rules.

    `stands`: positions worth trying of each joint. `longest_s`: longest time that a rule waits.
    """

    behavior: Behavior
    joints: tuple[str, ...]
    stands: tuple[tuple[float, ...], ...]
    contacts: tuple[str, ...]
    longest_s: float


def unreached(behavior: Behavior, ranges: Mapping[str, Vec2]) -> list[tuple[str, str]]:
    """(variable, value) of all that no moves, touches and waits bring about; `ranges`: of joints, rad or m."""
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
    named = dict(zip((v.name for v in group.behavior.variables), values, strict=True))
    machine = BehaviorState(group.behavior, named, None, (0.0,) * len(group.behavior.rules))
    stood = step_behavior(machine, _stimulus(group, at, touched), 0.0)
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
    done = step_behavior(machine, _stimulus(group, at, touched), seconds)
    return tuple(done.values[v.name] for v in group.behavior.variables), at, touched


def _stimulus(group: VariableGroup, at: tuple[float, ...], touched: tuple[bool, ...]) -> Stimulus:
    held = frozenset(name for name, on in zip(group.contacts, touched, strict=True) if on)
    return Stimulus(dict(zip(group.joints, at, strict=True)), held)


def values_are_reachable(asset: Asset) -> check.Measurement:
    """BEH001: number of values that moving joints and touching colliders cannot bring about."""
    if asset.behavior is None:
        return check.not_applicable(NO_BEHAVIOR)
    missing = unreached(asset.behavior, {j.name: j.range for j in asset.joints})
    message = "nothing that a robot can do makes it"
    return check.count((f"behavior/{name}", f"{message} {value!r}") for name, value in missing)


def effects_are_visible(asset: Asset) -> check.Measurement:
    """BEH002: number of effects without a target that can show them."""
    if asset.behavior is None:
        return check.not_applicable(NO_BEHAVIOR)
    effects = enumerate(asset.behavior.effects)
    return check.count((f"behavior/effects/{i}", message) for i, e in effects for message in _effect_faults(asset, e))


def behavior_meets_contract(package: Package) -> check.Measurement:
    """BEH003: number of contract values and thresholds that the asset misses when operated in MuJoCo."""
    asset, contract = package.asset, package.contract
    if asset.contract is None:
        return check.not_applicable("it names no contract that says how it behaves")
    if contract is None or contract.id != asset.contract:
        return check.not_run(f"registry/contracts has no {asset.contract!r}")
    faults = contract_names.missing_requirements(asset, contract, contract_names.variables)
    if asset.behavior is not None:
        faults += _thresholds(asset, asset.behavior, contract)
        wanted = any(key.values for key in contract.keyframes) or bool(contract.trials)
        model = fingertip_model(package) if wanted else None
        if wanted and model is None:
            return check.count(faults) if faults else check.not_run(check.NO_COMPILE)
        if model is not None:
            for key in contract.keyframes:
                faults += _pose(model, asset, asset.behavior, key)
            for trial in contract.trials:
                faults += _trial(model, asset, asset.behavior, trial)
    return check.count(faults)


def _effect_faults(asset: Asset, effect: Effect) -> Iterator[str]:
    sites = {s.name: s for s in asset.sites}
    visuals = {v.name for k in asset.links for v in k.visuals}
    kinds = [k for k, there in (("site", effect.target in sites), ("visual", effect.target in visuals)) if there]
    kinds += ["region"] if any(r.name == effect.target for r in asset.regions) else []
    allowed = TARGET_KINDS[effect.kind]
    if not any(kind in allowed for kind in kinds):
        wanted = " or a ".join(allowed)
        yield f"{effect.kind.value}s {effect.target!r}, which is a {' and a '.join(kinds)}, not a {wanted}"
        return
    if effect.kind in (EffectKind.SHOW, EffectKind.LIGHT):
        if effect.color[3] <= 0.0:
            yield f"shows {effect.target!r} in a colour that is wholly see-through"
        if effect.kind is EffectKind.LIGHT and max(effect.color[:3]) <= 0.0:
            yield f"lights {effect.target!r} in black"
    if effect.kind is EffectKind.SHOW and effect.target in sites:
        site = sites[effect.target]
        extent = 2 * site.radius if site.size is None else max(site.size)
        if extent < MIN_VISIBLE_M:
            yield f"shows {effect.target!r}, which is {extent:.4f} m large; nobody sees that"


def _thresholds(asset: Asset, behavior: Behavior, contract: Contract) -> Iterator[check.Problem]:
    """Ends of intervals that are neither a threshold of the contract nor an end of the joint's range."""
    ranges = {j.name: j.range for j in asset.joints}
    for i, rule in enumerate(behavior.rules):
        for condition in rule.when:
            if condition.joint is None or condition.interval is None:
                continue
            low, high = ranges[condition.joint]
            thresholds = [t for t in contract.thresholds if re.fullmatch(t.joint, condition.joint)]
            named = {t.name: t.position((low, high)) for t in thresholds}
            for end in condition.interval if named else ():
                is_inside = low + THRESHOLD_TOLERANCE < end < high - THRESHOLD_TOLERANCE
                if is_inside and all(abs(end - at) > THRESHOLD_TOLERANCE for at in named.values()):
                    there = ", ".join(f"{name} {at:.4g}" for name, at in named.items())
                    changes = f"{condition.joint} changes {rule.variable} at {end:.4g}"
                    yield f"behavior/rules/{i}", f"{changes}; RoboCasa's thresholds are {there}"


def _pose(model: FingertipModel, asset: Asset, behavior: Behavior, rule: KeyRule) -> Iterator[check.Problem]:
    key = next((k for k in asset.keyframes if k.name == rule.name), None)
    if key is None or not rule.values:
        return
    state = _settle(start_behavior(behavior), model.measure({}))
    state = _settle(state, model.measure({at.joint: at.value for at in key.joints}))
    for message in _differences(state, rule.values):
        yield f"keyframes/{rule.name}", f"in this pose {message}"


def _trial(model: FingertipModel, asset: Asset, behavior: Behavior, trial: Trial) -> Iterator[check.Problem]:
    """Differences from the trial; it ends with the first step that has some."""
    stands: dict[str, float] = {}
    state = _settle(start_behavior(behavior), model.measure(stands))
    for number, act in enumerate(trial.steps):
        pointer = f"trials/{trial.name}/{number}"
        for pattern, way in act.move.items():
            for joint in asset.joints:
                if re.fullmatch(pattern, joint.name):
                    stands[joint.name] = position(joint.range, way)
        state = _settle(state, model.measure(stands))
        if act.press is not None:
            names = [c.name for k in asset.links for c in k.colliders if re.fullmatch(act.press, c.name)]
            if not names:  # CON003 says so
                return
            pressed = model.press(stands, names[0])
            if pressed is None:
                yield pointer, f"{names[0]!r} cannot be touched by a fingertip without touching something else"
                return
            state = _settle(state, pressed, HOLD_STEPS)
            state = _settle(state, model.measure(stands), HOLD_STEPS)
        state = _settle(state, model.measure(stands), round(act.wait_s / TICK_S))
        differences = list(_differences(state, act.expect))
        if differences:
            done = ", ".join([*(f"{p} to {w:g}" for p, w in act.move.items()), act.press or ""]).strip(", ")
            yield pointer, f"after {done or 'waiting'} {differences[0]}"
            return


def position(span: tuple[float, float], way: float) -> float:
    """Joint position at a share of the range from zero, rad or m; negative: towards the nearer end."""
    near, far = sorted(span, key=abs)
    return way * far if way >= 0 else -way * near


def _settle(state: BehaviorState, stimulus: Stimulus, steps: int = SETTLE_STEPS) -> BehaviorState:
    for _ in range(steps):
        state = step_behavior(state, stimulus, TICK_S)
    return state


def _differences(state: BehaviorState, wanted: Mapping[str, str]) -> Iterator[str]:
    for pattern, value in wanted.items():
        for name, found in state.values.items():
            if re.fullmatch(pattern, name) and not re.fullmatch(value, found):
                yield f"{name} is {found!r}, not {value!r}"


def interiors_hold_a_ball(package: Package, limit: float) -> check.Measurement:
    """HOL001: farthest that a ball laid into a region comes to rest outside of it, metres."""
    asset = package.asset
    regions = [r for r in asset.regions if r.name not in OUTER_REGIONS]
    if not check.is_fixture_like(asset):
        return check.not_applicable(check.NOT_BUILT)
    if not regions:
        return check.not_applicable("it has no region to put things into")
    if mujoco_facts.load_mjcf(package.mjcf).error:
        return check.not_run(check.NO_COMPILE)
    model = _model_with_balls(package, regions)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    at_start = {r.name: _penetration(model, data, r) for r in regions}
    blocked = _blocked_heights(package, model, regions)
    mujoco.mj_step(model, data, nstep=int(SIMULATED_S / STEP_S))
    problems, worst = [], 0.0
    for region in regions:
        pointer = f"regions/{region.name}"
        if at_start[region.name] > MAX_PENETRATION_M:
            problems.append((pointer, f"is not hollow: a ball of {2 * _radius(region):.3f} m does not fit in"))
            continue
        if region.name in blocked:
            height = f"{blocked[region.name]:.3f} m above its floor"
            problems.append((pointer, f"is filled {height}: a ball let down from its top does not pass"))
            continue
        distance = _distance_outside(data, region)
        worst = max(worst, distance)
        speed = float(np.linalg.norm(data.body(f"ball__{region.name}").cvel[3:]))
        if distance > limit:
            problems.append((pointer, f"a ball laid into it comes to lie {distance:.3f} m off its floor or sides"))
        elif speed > MAX_SPEED_M_S:
            problems.append((pointer, f"a ball laid into it still moves at {speed:.2f} m/s"))
    return check.Measurement(worst, tuple(problems))


def _radius(region: Region) -> float:
    return min(BALL_DIAMETER_M, BALL_SHARE * min(region.size[:2])) / 2


def _world_from_region(package: Package, region: Region) -> Pose:
    return package.asset.asset_from_link(region.link) @ region.pose


def _model_with_balls(package: Package, regions: list[Region]) -> mujoco.MjModel:
    """The asset with a ball just above the floor of each region; balls do not touch each other."""
    spec = collision_spec(package.mjcf)
    for key in list(spec.keys):
        spec.delete(key)
    spec.option.timestep = STEP_S
    for region in regions:
        radius = _radius(region)
        center = np.array([[0.0, 0.0, -region.size[2] / 2 + radius + DROP_HEIGHT_M]])
        at = _world_from_region(package, region).apply(center)[0]
        body = spec.worldbody.add_body(name=f"ball__{region.name}", pos=at)
        body.add_freejoint()
        touch = {"contype": 0, "conaffinity": 1, "condim": 6, "friction": [0.6, 0.02, 0.01]}
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, radius, radius], mass=0.05, **touch)
    return spec.compile()


def _blocked_heights(package: Package, model: mujoco.MjModel, regions: list[Region]) -> dict[str, float]:
    """Region name -> height above its floor at which a ball in its middle runs into something, metres."""
    data = mujoco.MjData(model)
    blocked: dict[str, float] = {}
    heights = {r.name: _heights(r) for r in regions}
    for k in range(max(len(column) for column in heights.values())):
        present = {name: column[min(k, len(column) - 1)] for name, column in heights.items()}
        for region in regions:
            center = np.array([[0.0, 0.0, present[region.name] - region.size[2] / 2]])
            start = model.jnt_qposadr[model.body_jntadr[model.body(f"ball__{region.name}").id]]
            data.qpos[start : start + 3] = _world_from_region(package, region).apply(center)[0]
        find_contacts(model, data)
        for region in regions:
            if _penetration(model, data, region) > MAX_PENETRATION_M:
                blocked.setdefault(region.name, present[region.name])
    return blocked


def _heights(region: Region) -> list[float]:
    """Heights above its floor of a ball on its way from the top of a region down, a radius apart at most, metres."""
    radius = _radius(region)
    low, high = radius + DROP_HEIGHT_M, region.size[2] - radius
    if high <= low:
        return [low]
    return [float(height) for height in np.linspace(high, low, int(np.ceil((high - low) / radius)) + 1)]


def _penetration(model: mujoco.MjModel, data: mujoco.MjData, region: Region) -> float:
    """Depth at which the ball of a region is in something, metres."""
    body = model.body(f"ball__{region.name}").id
    return max([0.0, *(float(-c.dist) for c in data.contact[: data.ncon] if body in model.geom_bodyid[c.geom])])


def _distance_outside(data: mujoco.MjData, region: Region) -> float:
    """Distance of the ball at rest from the region: below or above its floor, or beyond its sides, metres."""
    link = data.body(region.link)
    local = link.xmat.reshape(3, 3).T @ (data.body(f"ball__{region.name}").xpos - link.xpos)
    point = region.pose.rotation.T @ (local - np.array(region.pose.position))
    half, radius = np.array(region.size) / 2, _radius(region)
    floor = abs(float(point[2]) - radius + float(half[2]))
    if region.kind == "cylinder":
        sides = float(np.linalg.norm(point[:2])) - half[0]
    else:
        sides = float((np.abs(point[:2]) - half[:2]).max())
    return float(max(floor, sides))


@dataclass(frozen=True)
class FingertipModel:
    """An asset without what is only seen, with a fingertip, and the ranges of its joints, rad or m."""

    model: mujoco.MjModel
    ranges: Mapping[str, Vec2]

    def measure(self, positions: Mapping[str, float]) -> Stimulus:
        """Stimulus of the asset with joints at these positions (rad or m, others at zero) and nothing touched."""
        return self._stimulus(self._set_joints(positions), frozenset())

    def press(self, positions: Mapping[str, float], collider: str) -> Stimulus | None:
        """Stimulus while a fingertip touches this collider and no other; None if it cannot reach it."""
        data = self._set_joints(positions)
        # From the front, above, the sides, behind and below, then along the collider's own axes.
        directions = [*np.array([[0, -1, 0], [0, 0, 1], [-1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, -1]], dtype=float)]
        for axis in data.geom_xmat[self.model.geom(collider).id].reshape(3, 3).T.copy():
            directions += [axis, -axis]
        for direction in directions:
            if self._touched_from(data, collider, direction) == {collider}:
                return self._stimulus(data, frozenset({collider}))
        return None

    def _set_joints(self, positions: Mapping[str, float]) -> mujoco.MjData:
        data = mujoco.MjData(self.model)
        data.mocap_pos[0] = (0.0, 0.0, WAITING_HEIGHT_M)
        for name, value in positions.items():
            low, high = self.ranges[name]
            data.joint(name).qpos[0] = min(max(value, low), high)
        mujoco.mj_forward(self.model, data)
        return data

    def _stimulus(self, data: mujoco.MjData, touched: frozenset[str]) -> Stimulus:
        return Stimulus({name: float(data.joint(name).qpos[0]) for name in self.ranges}, touched)

    def _touched_from(self, data: mujoco.MjData, collider: str, direction: Floats) -> set[str]:
        """Names of what the tip touches once it has come to the collider's middle from a direction."""
        target, tip = self.model.geom(collider).id, self.model.geom(TIP).id
        center = data.geom_xpos[target].copy()
        distance = float(self.model.geom_rbound[target]) + 2 * TIP_RADIUS_M
        for _ in range(APPROACH_STEPS):
            data.mocap_pos[0] = center + distance * direction
            mujoco.mj_kinematics(self.model, data)
            gap = mujoco.mj_geomDistance(self.model, data, target, tip, 1.0, None)
            distance -= gap + PRESS_DEPTH_M
            if distance < 0:
                return set()
        # By distance: MuJoCo makes no contacts with still bodies.
        reach = self.model.geom_rbound + TIP_RADIUS_M
        near = np.linalg.norm(data.geom_xpos - data.geom_xpos[tip], axis=1) <= reach
        others = [int(g) for g in np.flatnonzero(near) if g != tip]
        return {
            self.model.geom(g).name
            for g in others
            if mujoco.mj_geomDistance(self.model, data, g, tip, TIP_RADIUS_M, None) <= 0.0
        }


def fingertip_model(package: Package) -> FingertipModel | None:
    """The model of a package; None if it does not compile, which MJC001 reports."""
    if mujoco_facts.load_mjcf(package.mjcf).error:
        return None
    return _with_fingertip(package.mjcf, package.asset.digest)


@lru_cache(maxsize=CACHED_TIPS)
def _with_fingertip(path: Path, digest: str) -> FingertipModel:
    assert digest, "names the content of the file in the cache"
    spec = collision_spec(path)
    for key in list(spec.keys):
        spec.delete(key)
    tip = spec.worldbody.add_body(name=TIP, mocap=True)
    tip.add_geom(name=TIP, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[TIP_RADIUS_M, 0, 0])
    model = spec.compile()
    joints = [model.joint(i) for i in range(model.njnt)]
    return FingertipModel(model, {j.name: (float(j.range[0]), float(j.range[1])) for j in joints})
