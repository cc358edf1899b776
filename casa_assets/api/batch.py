"""Many kitchens at once, in one engine: worlds of different plans and styles side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Literal, TypedDict, TypeVar, Unpack, overload

import mujoco
import numpy as np

from casa_assets.addons.batch.batch_form import read_batch
from casa_assets.addons.batch.engines import COMMON_SIZES, TRIAL_ROBOT_FREEDOMS, Engine, Parts, engine_named
from casa_assets.addons.batch.shared_model import Robot, SharedModel, robot_of, share
from casa_assets.addons.batch.start_positions import StartPositions, awake_sizes, near_pairs, start_positions
from casa_assets.api.kitchen import Kitchen, kitchen
from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import CasaError
from casa_assets.layouts.run.load_scene import FILES
from casa_assets.layouts.run.state_file import read_current_states
from casa_assets.model.kitchen.files import SCENE_JSON, START_STATES

if TYPE_CHECKING:
    from casa_assets.addons.batch.engines import MujocoEngine
    from casa_assets.addons.batch.mjx_engine import MjxEngine
    from casa_assets.addons.batch.mujoco_warp_engine import MujocoWarpEngine
    from casa_assets.addons.batch.newton_engine import NewtonEngine

E = TypeVar("E", bound=Engine)
EngineName = Literal["mujoco", "mujoco_warp", "mjx", "newton"]
# These do not know what sleeps when they begin, so that all contacts at rest count.
BEGIN_AWAKE = ("mjx", "newton")
# The one whole number that differs between kitchens: which material a geom has.
_MATERIAL = "geom_matid"
Kitchens = Sequence[str | Path | Kitchen]


@dataclass(frozen=True)
class BatchKitchen:
    """A kitchen of a batch.

    Attributes:
        model: compiled model, in the structure that all kitchens of the batch share.
        bodies, joints, geoms, sites, cameras: name in the kitchen -> id in `model` and in the engine.
        rows: states at rest, one of which a reset takes.
    """

    id: str
    model: mujoco.MjModel
    bodies: Mapping[str, int]
    joints: Mapping[str, int]
    geoms: Mapping[str, int]
    sites: Mapping[str, int]
    cameras: Mapping[str, int]
    rows: StartPositions

    def address(self, joint: str) -> int:
        """Index in qpos of the first number of a joint. Raises CasaError if the joint does not exist."""
        if joint not in self.joints:
            raise CasaError(f"{self.id}: its batch form has no joint {joint!r}; batch.json lists those that are locked")
        return int(self.model.jnt_qposadr[self.joints[joint]])


class Batch(Generic[E]):
    """Worlds in one engine, made by `batch(...)`; world w is a copy of kitchen `w % len(kitchens)`.

    Attributes:
        engine: it has the `model` and `data` of all worlds, as objects of the engine itself.
        kitchens: the kitchens in their order; kitchen_of_world: (worlds,) ints.
        sizes: sizes of the engine's buffers for a world.
        states: (worlds,) number of the start state of the last reset of each world; -1: the kitchen as it is built.
        base: (worlds, 3) parking pose of the middle of a robot's base in each world: x, y (m), yaw (rad).
    """

    def __init__(self, engine: E, kitchens: Sequence[BatchKitchen], parts: Parts, robot: Robot | None) -> None:
        self.engine, self.kitchens, self.sizes = engine, tuple(kitchens), dict(parts.sizes)
        self.kitchen_of_world = parts.kitchen_of_world
        self.states: Ints = np.full(len(parts.kitchen_of_world), -1)
        self.base: Floats = np.zeros((len(parts.kitchen_of_world), 3))
        self._robot = robot
        self.reset(seed=None)

    def __len__(self) -> int:
        """Number of worlds."""
        return len(self.kitchen_of_world)

    @cached_property
    def fields(self) -> dict[str, Floats]:
        """Name of a MuJoCo model array that differs between the kitchens -> its values, (kitchens, ...)."""
        models = [kitchen.model for kitchen in self.kitchens]
        found = {}
        for name in dir(models[0]):
            value = getattr(models[0], name)
            is_number = isinstance(value, np.ndarray) and (value.dtype.kind == "f" or name == _MATERIAL)
            if is_number and not name.startswith(("_", "bvh_")):
                rows = np.stack([getattr(model, name) for model in models])
                if (rows != rows[0]).any():
                    found[name] = rows
        return found

    @property
    def qpos(self) -> Floats:
        """(worlds, nq) copy of the positions, in MuJoCo's order."""
        return self.engine.qpos

    @property
    def qvel(self) -> Floats:
        """(worlds, nv) copy of the velocities, in the engine's order."""
        return self.engine.qvel

    def step(self, count: int = 1) -> None:
        """Run `count` steps of 2 ms in all worlds."""
        self.engine.step(count)

    def reset(self, worlds: Sequence[int] | Ints | None = None, seed: int | None = None) -> None:
        """Put worlds into start states, at rest, with the robot at its parking place.

        Args:
            worlds: their numbers; None: all.
            seed: seed that draws the state of each world; None: the first state of each kitchen.
        """
        chosen = np.arange(len(self)) if worlds is None else np.asarray(worlds, dtype=np.int64)
        random = None if seed is None else np.random.default_rng(seed)
        rows = [self.kitchens[kitchen].rows for kitchen in self.kitchen_of_world[chosen]]
        drawn = [0 if random is None else int(random.integers(len(row))) for row in rows]
        self.states[chosen] = [row.states[number] for row, number in zip(rows, drawn, strict=True)]
        self.base[chosen] = base = np.stack([row.base[number] for row, number in zip(rows, drawn, strict=True)])
        qpos = np.stack([row.qpos[number] for row, number in zip(rows, drawn, strict=True)])
        asleep = np.stack([row.asleep[number] for row, number in zip(rows, drawn, strict=True)])
        half = base[:, 2] / 2
        level = np.zeros(len(chosen))
        mounts = np.stack([base[:, 0], base[:, 1], level, np.cos(half), level, level, np.sin(half)], axis=1)
        if self._robot is not None:
            qpos = np.concatenate([qpos, _placed(self._robot, mounts)], axis=1)
        self.engine.reset(chosen, qpos, asleep, mounts)


class BatchOptions(TypedDict, total=False):
    """The options of `batch`, which explains them."""

    worlds: int | None
    robot: str | Path | mujoco.MjSpec | None
    states: int
    sizes: Mapping[str, int] | None
    device: str | None
    textures: bool


@overload
def batch(
    kitchens: Kitchens, engine: Literal["mujoco_warp"] = ..., **options: Unpack[BatchOptions]
) -> Batch[MujocoWarpEngine]: ...
@overload
def batch(kitchens: Kitchens, engine: Literal["mujoco"], **options: Unpack[BatchOptions]) -> Batch[MujocoEngine]: ...
@overload
def batch(kitchens: Kitchens, engine: Literal["mjx"], **options: Unpack[BatchOptions]) -> Batch[MjxEngine]: ...
@overload
def batch(kitchens: Kitchens, engine: Literal["newton"], **options: Unpack[BatchOptions]) -> Batch[NewtonEngine]: ...
def batch(
    kitchens: Kitchens,
    engine: EngineName = "mujoco_warp",
    *,
    worlds: int | None = None,
    robot: str | Path | mujoco.MjSpec | None = None,
    states: int = 16,
    sizes: Mapping[str, int] | None = None,
    device: str | None = None,
    textures: bool = False,
) -> Batch[Any]:
    """Run several kitchens in one engine: their batch forms in one structure, at rest in their start states.

    Engines require the same bodies, joints and shapes in each world but allow different numbers. So all kitchens get as
    many of each as the kitchen with the most; surplus ones are parked out of the way.

    Args:
        kitchens: ids, folders of scenes, or results of `kitchen()` and `load()`; plans and styles may differ.
        engine: `mujoco` steps with threads on the processor; `mujoco_warp`, `mjx` and `newton` have to be installed.
        worlds: number of worlds; None: one for each kitchen.
        robot: MJCF file or MjSpec of a robot; in each world it is placed as the start state says, and its names begin
            with `robot_`. Not with `newton`.
        states: maximum number of start states of each kitchen to keep for resets, if `casa-assets scenes states` drew
            some in its folder; otherwise there is one, the kitchen as it is built.
        sizes: nconmax, njmax, nccdmax and nvmax of a world that replace those in `batch.json`; a robot may need more.
        device: such as `cuda:0` or `cpu`; None: the engine's own choice.
        textures: for rendering: the model holds the materials of all kitchens, and `geom_matid` differs from world to
            world. Otherwise geoms have plain colours, which differ too. Not with `newton`.
    Raises:
        UnknownId: no such engine or kitchen. CasaError: no kitchen or fewer worlds than kitchens, the engine is not
            installed, a kitchen cannot be built, or a robot does not load.
    """
    count = len(kitchens) if worlds is None else worlds
    if not kitchens or count < len(kitchens):
        raise CasaError(f"{count} worlds of {len(kitchens)} kitchens: there has to be a kitchen, and a world of each")
    made = engine_named(engine)
    if engine == "newton" and robot is not None:
        raise CasaError("newton: a robot is added with newton.ModelBuilder; leave robot out")
    if engine == "newton" and textures:
        raise CasaError("newton: takes the shapes of a kitchen in plain colours; leave textures out")
    sources = [_Source.of(kitchen) for kitchen in kitchens]
    mounted = None if robot is None else _mounted(robot, sources)
    shared, rows, found = _put_together(sources, engine, states, mounted, sizes or {}, textures)
    parts = Parts(
        models=[one.model for one in shared],
        texts=[one.text for one in shared],
        kitchen_of_world=np.arange(count) % len(kitchens),
        sizes=found,
        mounted=mounted is not None and not mounted.floats,
        ctrl=np.zeros(shared[0].model.nu) if mounted is None else mounted.ctrl,
        device=device,
    )
    inside = [
        BatchKitchen(source.kitchen.id, one.model, one.bodies, one.joints, one.geoms, one.sites, one.cameras, row)
        for source, one, row in zip(sources, shared, rows, strict=True)
    ]
    return Batch(made(parts), inside, parts, mounted)


def _mounted(robot: str | Path | mujoco.MjSpec, sources: Sequence[_Source]) -> Robot:
    lost = next((source.kitchen for source in sources if source.parks is None), None)
    if lost is not None:
        where = lost.id if lost.folder is None else lost.folder / SCENE_JSON
        raise CasaError(f"{where}: is missing or names no parking place, where a robot would stand")
    return robot_of(robot)


def _put_together(
    sources: Sequence[_Source],
    engine: EngineName,
    states: int,
    robot: Robot | None,
    sizes: Mapping[str, int],
    textures: bool,
) -> tuple[list[SharedModel], list[StartPositions], dict[str, int]]:
    """Return the kitchens in one structure, with a robot; their states at rest; sizes of the buffers of a world."""
    specs = [source.spec for source in sources]
    # States are settled without a robot, which would move; its bodies and joints come after the kitchen's.
    shared = share(specs, cylinders=engine != "mjx", textures=textures)
    rows = [source.rows(one, states) for source, one in zip(sources, shared, strict=True)]
    found = [source.sizes or COMMON_SIZES for source in sources]
    if engine in BEGIN_AWAKE:
        found += [awake_sizes(one, row) for one, row in zip(shared, rows, strict=True)]
    most = {name: max(one.get(name, 0) for one in found) for name in COMMON_SIZES}
    # The trials that the sizes are from had a robot.
    most["nvmax"] += max(0, robot.freedoms - TRIAL_ROBOT_FREEDOMS) if robot is not None else 0
    most |= sizes
    if engine == "mjx":
        pairs = max(near_pairs(one, row) for one, row in zip(shared, rows, strict=True))
        numbers = {"max_contact_points": most["nconmax"], "max_geom_pairs": pairs}
        shared = share(specs, False, robot, numbers, textures)
    elif robot is not None:
        shared = share(specs, robot=robot, textures=textures)
    return shared, rows, most


@dataclass(frozen=True)
class _Source:
    """Input for one kitchen of a batch: the kitchen, and its batch form."""

    kitchen: Kitchen
    spec: mujoco.MjSpec

    @staticmethod
    def of(source: str | Path | Kitchen) -> _Source:
        if isinstance(source, Kitchen):
            found = source.with_detail("batch")
        elif isinstance(source, Path) or Path(source).is_dir():
            found = Kitchen(Path(source), "batch")
        else:
            found = kitchen(source, detail="batch")
        return _Source(found, found.to_mjspec())

    @property
    def sizes(self) -> dict[str, int]:
        """Sizes of buffers from `batch.json`; empty if the file does not exist."""
        found = None if self.kitchen.folder is None else read_batch(self.kitchen.folder)
        return {} if found is None else {name: getattr(found.engine, name) for name in COMMON_SIZES}

    def rows(self, shared: SharedModel, most: int) -> StartPositions:
        """States at rest, from the start states that were drawn for exactly this scene."""
        drawn, folder = None, self.kitchen.folder
        if folder is not None and (folder / START_STATES).is_file() and (folder / FILES["full"]).is_file():
            drawn = read_current_states(folder, folder / FILES["full"])
        return start_positions(shared, drawn, most, self.parks or (0.0, 0.0, 0.0))

    @cached_property
    def parks(self) -> tuple[float, float, float] | None:
        """Parking pose of a robot in the kitchen as built, in front of the first fixture, or None if not stated."""
        folder = self.kitchen.folder
        if folder is not None and not (folder / SCENE_JSON).is_file():
            return None
        places = self.kitchen.facts["parking"].values()
        shut = next((spot["shut"] for spot in places if spot.get("shut")), None)
        return None if shut is None else (shut["x"], shut["y"], shut["yaw"])


def _placed(robot: Robot, mounts: Floats) -> Floats:
    """(worlds, nq of the robot) positions; a free robot is at its parking place and looks ahead."""
    rows = np.tile(robot.qpos, (len(mounts), 1))
    if robot.floats:
        rows[:, :2] = mounts[:, :2]
        for row, mount in zip(rows, mounts, strict=True):
            turned = np.empty(4)
            mujoco.mju_mulQuat(turned, mount[3:], robot.qpos[3:7])
            row[3:7] = turned
    return rows
