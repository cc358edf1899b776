"""Run the state machines of fixtures beside a simulation, and begin episodes from start states at rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import mujoco
import numpy as np

from casa_assets.checks.readers import mujoco_facts
from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import CasaError
from casa_assets.model.asset.behavior import Behavior, BehaviorState, Effect, Stimulus, start_behavior, step_behavior
from casa_assets.model.kitchen import scene
from casa_assets.model.kitchen.scene import LightScene

FixtureStates = Mapping[str, Mapping[str, str | None]]
# Name of a thing by itself in a file, as the name of its body.
_ALONE = "object"
_BEHAVIOR, _STATE, _JOINER = "behavior", "state__", "__"


class StartStates:
    """Start states that fit a model: the kitchen in its full or light form, alone or with a robot and more in it.

    They are certified for the full kitchen alone: no contact deeper than 1 mm, nothing moves by more than 5 mm in 2 s,
    and the space of a robot with its arm at rest is free at its parking place.

    Attributes:
        qpos: (states, numbers) positions of the kitchen's joints, in the order of `addresses`; read-only.
        addresses: (numbers,) index in `data.qpos` of the model for each number of a row.
        base: (states, 3) parking pose of the middle of the robot's base: x, y (m), yaw (rad); read-only.
        envelope: boxes that are free there, lower and upper corner (m) in the frame of the base, x ahead.
        depth, motion: (states,) deepest contact and greatest motion of each, m; read-only.
        notes: for each state, which objects are `placed` where, in front of which fixture the robot is `parked`, and
            which joints are `opened`.
    """

    def __init__(self, states: scene.StartStates, model: mujoco.MjModel, source: Path) -> None:
        """Made by `Kitchen.start_states`. Raises CasaError if the model lacks a joint of the states."""
        self.qpos: Floats = states.qpos.astype(np.float64)
        self.addresses = _addresses(states, model, source)
        self.base, self.depth, self.motion = (a.astype(np.float64) for a in (states.base, states.depth, states.motion))
        for array in (self.qpos, self.base, self.depth, self.motion):
            array.setflags(write=False)
        self.envelope, self.notes = states.envelope, states.notes

    def __len__(self) -> int:
        """Number of states."""
        return len(self.qpos)

    def reset(self, data: mujoco.MjData, number: int) -> None:
        """Put the joints of the kitchen into one state, with everything at rest.

        It takes microseconds: poses and contacts are computed by the next `mj_forward` or `mj_step`. Joints of a robot
        are not changed; `base[number]` is its parking pose.
        """
        data.qpos[self.addresses] = self.qpos[number]
        data.qvel[:] = 0.0
        data.qacc_warmstart[:] = 0.0
        data.time = 0.0


def _addresses(states: scene.StartStates, model: mujoco.MjModel, source: Path) -> Ints:
    """(numbers,) index in qpos of a model for each number of a row."""
    found = np.empty(states.qpos.shape[1], dtype=np.int64)
    for joint in states.joints:
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint.name)
        is_free = number >= 0 and model.jnt_type[number] == mujoco.mjtJoint.mjJNT_FREE
        if number < 0 or is_free != (joint.width == scene.FREE_WIDTH):
            raise CasaError(
                f"{source}: the model has no joint {joint.name!r} as the start states know it; they are of the kitchen "
                f"{states.scene}, whose model Kitchen.to_mjmodel gives"
            )
        first = int(model.jnt_qposadr[number])
        found[joint.address : joint.address + joint.width] = range(first, first + joint.width)
    return found


@dataclass(frozen=True)
class _JointStates:
    """Named states of a joint: index in `qpos`, position when fully open, and value -> shares of the way there."""

    address: int
    end: float
    intervals: Mapping[str, tuple[float, float]]

    def value(self, qpos: Floats) -> str | None:
        """Return its current state, or None between two states."""
        # The stops of a joint are soft: a closed drawer may be a little below zero.
        share = min(max(float(qpos[self.address]) / self.end, 0.0), 1.0)
        return next((value for value, (low, high) in self.intervals.items() if low <= share <= high), None)


class Behaviors:
    """State machines and joint states of every fixture in a compiled model, whose texts hold all data of them.

    Works on whole kitchens and on single assets, full or light, alone or with a robot attached.

    Attributes:
        values: fixture -> name -> possible values. A name is that of a variable of the fixture's state machine (such as
            `power`: off, on) or of one of its joints (such as `door_joint`: closed, open). The fixture of an asset that
            was loaded by itself is called `object`.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        """Read the texts of a compiled model. Raises CasaError if a text names a joint that the model lacks."""
        self._model = model
        self._root = model.body_rootid[model.geom_bodyid]
        self._machines: dict[str, BehaviorState] = {}
        self._addresses: dict[str, dict[str, int]] = {}
        self._joints: dict[str, dict[str, _JointStates]] = {}
        self._keys: dict[int, tuple[str, str]] = {}  # geom -> fixture, collider that it is or replaces
        self._time: float | None = None
        geoms = [model.geom(i).name for i in range(model.ngeom)]
        self._prefix = [name[: name.rfind(_JOINER) + len(_JOINER)] if _JOINER in name else "" for name in geoms]
        for name, text in sorted(mujoco_facts.texts(model).items()):
            if name.endswith(_BEHAVIOR):
                self._add_machine(name.removesuffix(_BEHAVIOR), Behavior.model_validate_json(text), geoms)
            elif _STATE in name:
                self._add_state(name.rpartition(_STATE)[0], text)
        self._is_key = np.zeros(model.ngeom, dtype=bool)
        self._is_key[list(self._keys)] = True
        self.values = self._possible()

    def _add_machine(self, prefix: str, behavior: Behavior, geoms: list[str]) -> None:
        fixture = _fixture(prefix)
        self._machines[fixture] = start_behavior(behavior)
        self._addresses[fixture] = {joint: self._address(prefix + joint) for joint in behavior.joints}
        watched = set(behavior.contacts)
        for geom, name in enumerate(geoms):
            collider = LightScene.collider_of(name.removeprefix(prefix))
            if name.startswith(prefix) and collider in watched:
                self._keys[geom] = fixture, collider

    def _add_state(self, prefix: str, text: str) -> None:
        """Add a state; its text has the joint name of the file, to which a merged model may have added a prefix."""
        written, value, low, high = text.split()
        joint = written.rpartition(_JOINER)[2]
        address = self._address(prefix + joint)
        end = max(self._model.joint(prefix + joint).range, key=abs)
        known = self._joints.setdefault(_fixture(prefix), {}).get(joint)
        intervals = {**(known.intervals if known else {}), value: (float(low), float(high))}
        self._joints[_fixture(prefix)][joint] = _JointStates(address, float(end), intervals)

    def _address(self, joint: str) -> int:
        if mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_JOINT, joint) < 0:
            raise CasaError(f"the texts of the model name the joint {joint!r}, which it does not have; load it again")
        return int(self._model.joint(joint).qposadr[0])

    def _possible(self) -> Mapping[str, Mapping[str, tuple[str, ...]]]:
        found: dict[str, dict[str, tuple[str, ...]]] = {}
        for fixture, machine in self._machines.items():
            found[fixture] = {v.name: v.values for v in machine.behavior.variables}
        for fixture, joints in self._joints.items():
            mine = found.setdefault(fixture, {})
            for joint, states in joints.items():
                if joint in mine:
                    raise CasaError(f"{fixture} has a variable and a joint that are both called {joint!r}; rename one")
                mine[joint] = tuple(states.intervals)
        return MappingProxyType({fixture: MappingProxyType(found[fixture]) for fixture in sorted(found)})

    def reset(self, data: mujoco.MjData) -> FixtureStates:
        """Set every variable to its initial value and read `data` for the first time.

        Call it after every reset of `data`. Anything that is already touched at this time does not count as just
        pressed.
        """
        for fixture, machine in self._machines.items():
            self._machines[fixture] = start_behavior(machine.behavior)
        self._time = None
        return self.update(data)

    def update(self, data: mujoco.MjData) -> FixtureStates:
        """Advance to the time of `data` and return fixture -> variable or joint -> value.

        Call it once per control step (0.05 s or less): a touch that begins and ends between two calls is not seen. A
        joint between two of its named states has the value None.

        Raises:
            CasaError: the time of `data` is before that of the last call; `reset` was forgotten.
        """
        elapsed = 0.0 if self._time is None else data.time - self._time
        if elapsed < 0:
            raise CasaError(
                f"time went back from {self._time} s to {data.time} s; call reset(data) where data is reset"
            )
        self._time = data.time
        touched = self._touched(data)
        for fixture, machine in self._machines.items():
            joints = {joint: float(data.qpos[at]) for joint, at in self._addresses[fixture].items()}
            stimulus = Stimulus(joints, frozenset(touched.get(fixture, ())))
            self._machines[fixture] = step_behavior(machine, stimulus, elapsed)
        return self.states(data)

    def states(self, data: mujoco.MjData) -> FixtureStates:
        """Return the values from the last `update`, with current states of joints; state machines do not advance."""
        found: dict[str, dict[str, str | None]] = {name: dict(m.values) for name, m in self._machines.items()}
        for fixture, joints in self._joints.items():
            found.setdefault(fixture, {}).update((name, joint.value(data.qpos)) for name, joint in joints.items())
        return found

    @property
    def effects(self) -> Mapping[str, tuple[Effect, ...]]:
        """Fixture -> effects that act now; in a kitchen `<fixture>__<target>` names the site, geom or region."""
        return {fixture: machine.effects for fixture, machine in self._machines.items() if machine.effects}

    def _touched(self, data: mujoco.MjData) -> dict[str, set[str]]:
        """Fixture -> its watched colliders that are touched by something outside the fixture."""
        found: dict[str, set[str]] = {}
        pairs = data.contact.geom
        for first, second in pairs[self._is_key[pairs].any(axis=1)].tolist():
            for geom, other in ((first, second), (second, first)):
                if geom in self._keys and not self._is_same_thing(geom, other):
                    fixture, collider = self._keys[geom]
                    found.setdefault(fixture, set()).add(collider)
        return found

    def _is_same_thing(self, geom: int, other: int) -> bool:
        """Whether two geoms belong to one asset: by name, or by body if names have no prefix.

        In a light kitchen all fixed objects belong to the world body.
        """
        if other < 0:
            return False
        if self._prefix[geom] and self._prefix[geom] == self._prefix[other]:
            return True
        return bool(self._root[geom] == self._root[other] != 0)


def _fixture(prefix: str) -> str:
    return prefix.rstrip("_") or _ALONE
