"""Draw start states: loose things put somewhere else, doors opened where asked, a robot parked, all of it at rest."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field

import mujoco
import numpy as np

from casa_assets.checks.start_states.stage import ENVELOPE, Kind, LooseThing, Parking, Place, Stage, settle, watch
from casa_assets.core.numeric import Floats, rng_for
from casa_assets.errors import CasaError
from casa_assets.model.kitchen.scene import FREE_WIDTH, StartStates, StateNotes

RANDOM_LANE = "start_states"
# How often a thing is put into each kind of place, where there is one.
SHARES = {Kind.WORKTOP: 0.6, Kind.SHELF: 0.15, Kind.DRAWER: 0.1, Kind.FRIDGE: 0.15}
EDGE_M, OVER_M, ABOVE_M = 0.01, 0.001, 0.005  # gaps at the sides, below and above a thing that is put somewhere
TRIES = 40  # places that are tried for one thing, and draws of one state
OPENED_SHARES = (0.4, 1.0)  # of a door's way, where it is opened
SAFETY = 0.8  # share of the limits that a state is drawn within, so that it holds on other machines too
STAYED_M = 0.1  # farthest that something loose goes while a state settles; fruit rolls to the bottom of its bowl
# Why a draw is given up.
NO_ROOM, RESTLESS, LEFT, FELL, DEEP, MOVES, PARKED, WARNS = (
    "a thing found no room",
    "did not come to rest",
    "a thing left its place",
    "a thing fell over or off",
    "shapes are pressed into each other",
    "moves by itself",
    "something stands where the robot parks",
    "the simulator warned",
)


BACK_M = tuple(0.05 * k for k in range(13))  # from a parking place, which is for a base alone, to where an arm has room


@dataclass(frozen=True)
class StateRequest:
    """How many start states to draw for each kitchen, and in each: things to put elsewhere, doors to open."""

    count: int = 100
    things: int = 10
    opened: int = 0
    seed: int = 0


@dataclass(frozen=True)
class Wanted:
    """A request with the key of all that the states are made from, and limits of depth and motion, m."""

    key: str
    request: StateRequest
    depth: float
    motion: float


@dataclass
class _Draft:
    qpos: Floats
    placed: dict[str, Place] = field(default_factory=dict)
    opened: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Drawn:
    qpos: Floats
    parking: Parking
    notes: StateNotes
    depth: float
    motion: float


def draw_states(stage: Stage, wanted: Wanted) -> StartStates:
    """States of a kitchen, each by a separate generator: state 7 is the same however many are drawn.

    Raises CasaError: too few things, places, doors or parking places, or a state was given up too often.
    """
    asked = wanted.request
    name = stage.facts["id"]
    if len(stage.things) < asked.things:
        raise CasaError(
            f"{name}: {asked.things} things were to be put somewhere in each state, and it has {len(stage.things)} "
            "that a hand can move; ask for fewer, or make the kitchen with more"
        )
    if not stage.parking:
        raise CasaError(f"{name}: a robot finds no parking place in it; see NAV001 of its report")
    if asked.things and not stage.places:
        raise CasaError(f"{name}: it has no worktop, shelf or drawer that things could be put on")
    if len(stage.doors) < asked.opened:
        doors = f"{asked.opened} doors were to stand open, and it has {len(stage.doors)}"
        raise CasaError(f"{name}: {doors}; ask for fewer")
    refused: Counter[str] = Counter()
    drawn = [_draw(stage, wanted, number, refused) for number in range(asked.count)]
    return StartStates(
        key=wanted.key,
        scene=name,
        scene_xml=stage.digest,
        mujoco=mujoco.__version__,
        seed=asked.seed,
        limits=(wanted.depth, wanted.motion),
        envelope=ENVELOPE,
        joints=stage.joints,
        notes=tuple(one.notes for one in drawn),
        qpos=np.array([one.qpos for one in drawn]),
        base=np.array([one.parking.at for one in drawn]),
        depth=np.array([one.depth for one in drawn]),
        motion=np.array([one.motion for one in drawn]),
        refused=dict(sorted(refused.items())),
    )


def _draw(stage: Stage, wanted: Wanted, number: int, refused: Counter[str]) -> _Drawn:
    reasons: Counter[str] = Counter()
    for attempt in range(TRIES):
        rng = rng_for(wanted.request.seed, f"{RANDOM_LANE}/{stage.facts['id']}/{number}/{attempt}")
        found = _try(stage, wanted, rng)
        if isinstance(found, _Drawn):
            refused.update(reasons)
            return found
        reasons[found] += 1
    counts = ", ".join(f"{reason} ({count})" for reason, count in reasons.most_common())
    raise CasaError(f"{stage.facts['id']}: no start state was found in {TRIES} draws of number {number}: {counts}")


def _try(stage: Stage, wanted: Wanted, rng: np.random.Generator) -> _Drawn | str:
    """One draw: a state, or the reason why it was given up."""
    draft = _Draft(stage.at_rest.copy())
    doors = [stage.doors[int(k)] for k in rng.permutation(len(stage.doors))[: wanted.request.opened]]
    for _, address, closed, opened in doors:
        draft.qpos[address] = closed + float(rng.uniform(*OPENED_SHARES)) * (opened - closed)
    draft.qpos = stage.with_contents(draft.qpos)
    draft.opened = tuple(sorted(name for name, *_ in doors))
    chosen = _choose(stage, wanted.request.things, rng)
    # Out of the kitchen, each to a different place high above it, until they are put somewhere.
    for k, thing in enumerate(chosen):
        draft.qpos[thing.address : thing.address + 3] = (2.0 * k, 0.0, 50.0)
    for thing in chosen:
        if not _put(stage, draft, thing, rng):
            return NO_ROOM
    settled = settle(stage, draft.qpos)
    if settled is None:
        return RESTLESS
    stage.show(settled)
    by_name = {thing.name: thing for thing in chosen}
    if not all(_is_in(stage, by_name[name], place) for name, place in draft.placed.items()):
        return LEFT
    loose = [slice(j.address, j.address + 3) for j in stage.joints if j.width == FREE_WIDTH]
    if any(float(np.linalg.norm(settled[part] - draft.qpos[part])) > STAYED_M for part in loose):
        return FELL
    parking = _park(stage, rng)
    if parking is None:
        return PARKED
    seen = watch(stage, settled)
    if seen.depth > SAFETY * wanted.depth:
        return DEEP
    if seen.motion > SAFETY * wanted.motion:
        return MOVES
    if seen.warnings:
        return WARNS
    placed = {name: place.name for name, place in sorted(draft.placed.items())}
    notes = StateNotes(placed=placed, parked=parking.fixture, opened=draft.opened)
    return _Drawn(settled, parking, notes, seen.depth, seen.motion)


def _choose(stage: Stage, count: int, rng: np.random.Generator) -> list[LooseThing]:
    """Things that are put somewhere else; of a stack the upper ones are taken first."""
    waiting = [stage.things[int(k)] for k in rng.permutation(len(stage.things))]
    chosen: list[LooseThing] = []
    taken: set[str] = set()
    while len(chosen) < count:
        thing = next(one for one in waiting if stage.on_top.get(one.name, set()) <= taken)
        waiting.remove(thing)
        chosen.append(thing)
        taken.add(thing.name)
    return chosen


def _put(stage: Stage, draft: _Draft, thing: LooseThing, rng: np.random.Generator) -> bool:
    """Put a thing upright into a place where it touches nothing; False if no such place was found."""
    kinds = sorted({place.kind for place in stage.places if place.kind in thing.kinds})
    if not kinds:
        return False
    weights = np.array([SHARES[kind] for kind in kinds])
    part = slice(thing.address, thing.address + 7)
    for _ in range(TRIES):
        kind = kinds[int(rng.choice(len(kinds), p=weights / weights.sum()))]
        options = [place for place in stage.places if place.kind == kind]
        areas = np.array([place.size[0] * place.size[1] for place in options])
        place = options[int(rng.choice(len(options), p=areas / areas.sum()))]
        at, yaw = rng.uniform(-1.0, 1.0, 2), float(rng.uniform(-math.pi, math.pi))
        pose = _pose_in(stage, draft, thing, place, at, yaw)
        if pose is None:
            continue
        draft.qpos[part] = pose
        stage.data.qpos[:] = draft.qpos
        mujoco.mj_kinematics(stage.model, stage.data)
        mujoco.mj_collision(stage.model, stage.data)
        contact = stage.data.contact
        if not (np.isin(contact.geom, thing.geoms).any(axis=1) & (contact.dist < 0.0)).any():
            draft.placed[thing.name] = place
            return True
    return False


def _pose_in(stage: Stage, draft: _Draft, thing: LooseThing, place: Place, at: Floats, yaw: float) -> Floats | None:
    """(7,) pose of a thing upright on a place, `at` (2,) -1..1 of the room left there; None if it does not fit."""
    spin, quaternion = np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]), np.zeros(4)
    mujoco.mju_mulQuat(quaternion, spin, thing.turned)
    local = stage.box_of(thing, quaternion)
    # Fixtures are turned by quarters, so that the box around a place is the place.
    half = np.abs(place.pose.rotation) @ place.size / 2
    spare = half - (local[1] - local[0]) / 2 - np.array([EDGE_M, EDGE_M, 0.0])
    if min(spare[0], spare[1], 2 * spare[2] - OVER_M - ABOVE_M) < 0.0:
        return None
    centre = np.array(place.pose.position)
    middle = (local[0] + local[1]) / 2
    x, y = centre[:2] + at * spare[:2] - middle[:2]
    z = centre[2] - half[2] + OVER_M - local[0][2]
    shifted = stage.carried(draft.qpos, place, np.array([x, y, z]))
    return np.concatenate([shifted, quaternion])


def _is_in(stage: Stage, thing: LooseThing, place: Place) -> bool:
    """Whether the middle of a thing is still in its place, in the present state."""
    half = np.abs(place.pose.rotation) @ place.size / 2
    centre = stage.carried(stage.data.qpos, place, np.array(place.pose.position))
    return bool((np.abs(stage.low_and_high(thing).sum(axis=0) / 2 - centre) <= half).all())


def _park(stage: Stage, rng: np.random.Generator) -> Parking | None:
    """A base pose, at or behind a parking place, that is free of collisions in the present state; None if not found."""
    for k in rng.permutation(len(stage.parking)):
        place = stage.parking[int(k)]
        x, y, yaw = (float(number) for number in place.at)
        for back in BACK_M:
            exact = np.array([x - back * math.cos(yaw), y - back * math.sin(yaw), yaw])
            at = exact.astype(np.float32).astype(np.float64)  # as it is written
            if stage.in_the_way(at) is None:
                return Parking(place.fixture, at)
    return None
