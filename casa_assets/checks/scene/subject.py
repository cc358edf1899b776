"""A written scene as MuJoCo has it: compiled once, with what every check asks of it, its contents and its speed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import mujoco
import numpy as np
from lxml import etree

from casa_assets.checks.motion.simulation import altered, open_before, reset_to_start, subtree
from casa_assets.checks.readers.facts import ROOT_BODY
from casa_assets.checks.readers.mujoco_facts import Loaded, load_asset_file, native_warnings
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.model.asset.asset import Asset, Base, Joint
from casa_assets.model.kitchen.scene import FREE_JOINT, Placement, Scene

T = TypeVar("T")
STEPS = 200  # that are timed
FILE = "scene.xml"


class Contents:
    """Objects of a scene by name, each with the body that holds it, and how it lies there in the state `qpos`."""

    def __init__(self, model: mujoco.MjModel, held: Iterable[tuple[str, str]], qpos: Floats) -> None:
        self.model = model
        # Of each object: its body, that of what holds it, and where its free joint is in qpos.
        self.rows: list[tuple[int, int, int]] = []
        for name, holder_name in held:
            holder = int(model.body(holder_name).id)
            if model.body_weldid[holder] != 0:
                address = int(model.joint(f"{name}__{FREE_JOINT}").qposadr[0])
                self.rows.append((int(model.body(name).id), holder, address))
        data = mujoco.MjData(model)
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        # Position and quaternion of each in the frame of what holds it.
        self._relative: list[tuple[Floats, Floats]] = []
        for body, holder, _ in self.rows:
            back, unturned, position, turn = np.empty(3), np.empty(4), np.empty(3), np.empty(4)
            mujoco.mju_negPose(back, unturned, data.xpos[holder], data.xquat[holder])
            mujoco.mju_mulPose(position, turn, back, unturned, data.xpos[body], data.xquat[body])
            self._relative.append((position, turn))

    def moved_with(self, moved: Mask) -> Mask:
        """(nbody,) the bodies that move, and the objects that rest on one of them."""
        found = moved.copy()
        for body, holder, _ in self.rows:
            if moved[holder]:
                found[body] = True
        return found

    def pose(self, data: mujoco.MjData) -> None:
        """Compute the poses of all bodies of the present joint positions, objects laid where what holds them is."""
        mujoco.mj_kinematics(self.model, data)
        if not self.rows:
            return
        position, turn = np.empty(3), np.empty(4)
        for (_, holder, address), (at, turned) in zip(self.rows, self._relative, strict=True):
            mujoco.mju_mulPose(position, turn, data.xpos[holder], data.xquat[holder], at, turned)
            data.qpos[address : address + 3], data.qpos[address + 3 : address + 7] = position, turn
        mujoco.mj_kinematics(self.model, data)


def timed_load(scene_xml: Path) -> tuple[Loaded, float]:
    """A file compiled where nothing of it was compiled before, and the seconds that this took."""
    # MuJoCo keeps what it has made of meshes and pictures for as long as a process lives, so that a second
    # load is faster than the first.
    mujoco.mj_clearCache(mujoco.mj_getCache())
    return timed(lambda: load_asset_file(scene_xml))


def steps_per_second(model: mujoco.MjModel) -> float:
    """Steps from the key `start`; the first one allocates and is not timed."""
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_step(model, data)
    return STEPS / max(timed(lambda: mujoco.mj_step(model, data, nstep=STEPS))[1], 1e-9)


def timed(call: Callable[[], T]) -> tuple[T, float]:
    """The result of a call, and the fewer of its seconds of the clock and of the processor in all threads.

    On a busy machine the clock goes on while this process waits for its turn, and a scene is no slower for it.
    """
    begin = time.perf_counter(), time.process_time()
    result = call()
    return result, min(time.perf_counter() - begin[0], time.process_time() - begin[1])


@dataclass(frozen=True)
class SceneJoint:
    """A joint of a placement by its name and numbers in the model.

    `moved`: (nbody,) bodies that it moves, including objects in a drawer. `geoms`: colliders of those bodies.
    `before`: joints of the same placement that have to be open, by name in the model: rad or m.
    """

    placement: Placement
    asset: Asset
    joint: Joint
    name: str
    id: int
    address: int
    dof: int
    moved: Mask
    geoms: Ints
    before: dict[str, float]


@dataclass(frozen=True, eq=False)
class SceneSubject:
    """A scene and the folder that holds its `scene.xml`; a subject is equal to itself alone.

    Values computed from the file are computed once, when a check first needs them.
    """

    scene: Scene
    root: Path

    @property
    def mjcf(self) -> Path:
        """The file."""
        return self.root / FILE

    @property
    def loaded(self) -> Loaded:
        """The whole file compiled, with pictures, and MuJoCo's warnings."""
        return self._timed_load[0]

    @property
    def load_s(self) -> float:
        """Seconds that this took."""
        return self._timed_load[1]

    @cached_property
    def _timed_load(self) -> tuple[Loaded, float]:
        return timed_load(self.mjcf)

    @cached_property
    def model(self) -> mujoco.MjModel:
        """Collision model, without visuals, images and materials. Whoever changes it restores it.

        Pairs that the file excludes do not collide in it, unless `all_pairs` is entered. Raises ValueError where the
        file does not compile.
        """
        return collision_model(self.mjcf)

    @cached_property
    def data(self) -> mujoco.MjData:
        """The scene as it begins, with the contacts of all pairs; shared, so nobody steps it."""
        data = mujoco.MjData(self.model)
        reset_to_start(self.model, data)
        with all_pairs(self.model):
            mujoco.mj_forward(self.model, data)
        return data

    @cached_property
    def contents(self) -> Contents:
        """The objects that lie in drawers, on racks and in doors."""
        rests = {place.name: place.resting for place in self.scene.objects}
        held = [(name, body_name(rest.placement, rest.link)) for name, rest in rests.items() if rest is not None]
        return Contents(self.model, held, self.model.qpos0)

    @cached_property
    def assets(self) -> dict[str, Asset]:
        """Name of a placement -> its asset."""
        return self.scene.asset_of

    @cached_property
    def placement_of(self) -> list[str]:
        """Name of the placement of each geom."""
        roots = [str(self.model.body(i).name) for i in range(self.model.nbody)]
        return [roots[self.model.body_rootid[body]] for body in self.model.geom_bodyid]

    @cached_property
    def geoms_of(self) -> dict[str, Ints]:
        """Name of a placement -> its geoms."""
        names = np.array(self.placement_of)
        return {place.name: np.flatnonzero(names == place.name) for place in self.scene.placements}

    @cached_property
    def is_fixed(self) -> Mask:
        """(ngeom,) whether a geom never moves."""
        return np.asarray(self.model.body_weldid[self.model.geom_bodyid] == 0)

    @cached_property
    def joints(self) -> dict[str, SceneJoint]:
        """All joints of all placements by their names in the model, in the order of the scene."""
        return {joint.name: joint for joint in self._joints()}

    @cached_property
    def operated(self) -> dict[str, SceneJoint]:
        """Joints of what has its place in the kitchen: a jar in a cupboard is not opened there."""
        return {name: joint for name, joint in self.joints.items() if joint.placement.resting is None}

    def _joints(self) -> Iterator[SceneJoint]:
        model = self.model
        for placement in self.scene.placements:
            asset = self.assets[placement.name]
            for joint in asset.joints:
                name = f"{placement.name}__{joint.name}"
                joint_id = int(model.joint(name).id)
                moved = self.contents.moved_with(subtree(model, int(model.jnt_bodyid[joint_id])))
                yield SceneJoint(
                    placement,
                    asset,
                    joint,
                    name,
                    id=joint_id,
                    address=int(model.jnt_qposadr[joint_id]),
                    dof=int(model.jnt_dofadr[joint_id]),
                    moved=moved,
                    geoms=np.flatnonzero(moved[model.geom_bodyid]),
                    before={f"{placement.name}__{k}": v for k, v in open_before(asset, joint).items()},
                )

    @cached_property
    def free(self) -> tuple[Placement, ...]:
        """Placements that rest by their weight."""
        return tuple(p for p in self.scene.placements if self.assets[p.name].base is Base.FREE)

    @cached_property
    def fixed(self) -> tuple[Placement, ...]:
        """Placements that are held where they are."""
        return tuple(p for p in self.scene.placements if self.assets[p.name].base is Base.FIXED)

    def geom_name(self, geom: int) -> str:
        """Name of a geom, `<placement>__<collider>`."""
        return str(self.model.geom(geom).name)

    def category(self, placement: str) -> str:
        """Category of a placement: `counter`, `sink`, `base_cabinet` ..."""
        return self.assets[placement].labels.classes[0]


def body_name(placement: str, link: str) -> str:
    """Name of the body of a link in the MJCF of a scene: that of the root link is called like the placement."""
    return placement if link == ROOT_BODY else f"{placement}__{link}"


def collision_model(path: Path, *added: etree._Element) -> mujoco.MjModel:
    """A scene file compiled without visuals, with bodies `added` to its world. ValueError: it does not compile.

    They are removed from the XML before MuJoCo reads it: deleting a thousand geoms from an MjSpec, as
    `simulation.collision_spec` does for single assets, takes ten times as long as all else.
    """
    root = etree.parse(str(path)).getroot()
    for geom in [g for g in root.iter("geom") if g.get("contype") == "0" and g.get("conaffinity") == "0"]:
        parent = geom.getparent()
        assert parent is not None, "a geom lies in a body"
        parent.remove(geom)
    for geom in root.iter("geom"):
        geom.attrib.pop("material", "")
    used = {g.get("mesh") for g in root.iter("geom")}
    for asset in root.iter("asset"):
        for child in list(asset):
            if child.tag != "mesh" or child.get("name") not in used:
                asset.remove(child)
    world = root.find("worldbody")
    if world is not None:
        world.extend(added)
    compiler = root.find("compiler")
    if compiler is None:
        compiler = etree.SubElement(root, "compiler")
    compiler.set("meshdir", str(path.parent.resolve()))
    # SCN001 reports the warnings of the whole file.
    with native_warnings():
        return mujoco.MjModel.from_xml_string(etree.tostring(root, encoding="unicode"))


def all_pairs(model: mujoco.MjModel) -> AbstractContextManager[None]:
    """While it is entered, pairs that the file excludes collide as well.

    A scene excludes a door and the frame that it hangs in for the sake of speed, but checks look whether they overlap.
    """
    # Ref: mjModel.exclude_signature is (body1 << 16) + body2, sorted. 0 excludes the world from itself: nothing.
    return altered(model, exclude_signature=0)


def boxes_meet(first: Floats, second: Floats, gap: float = 0.0) -> Mask:
    """True where boxes (..., 2, 3) come within `gap` metres of each other."""
    apart = (first[..., 0, :] > second[..., 1, :] + gap) | (second[..., 0, :] > first[..., 1, :] + gap)
    return np.asarray(np.logical_not(np.any(apart, axis=-1)))
