"""Batch forms of several kitchens -> models of one structure, so that an engine steps them side by side.

Engines on a graphics card want the same bodies, joints and geoms in every world and let numbers differ: poses, sizes,
masses, ranges, colours. The shared structure has as many places of each kind as the kitchen that has most of it. A
kitchen fills them with what it has, and a place that it does not fill is parked: a geom inside another one of its
body, a body in a row below the floor, where nothing pulls at it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import mujoco
import numpy as np

from casa_assets.core.typing import Floats
from casa_assets.errors import CasaError
from casa_assets.model.kitchen.start_states import FREE_WIDTH
from casa_assets.pipeline.batches.pictures import materials_of
from casa_assets.pipeline.batches.robot import Robot
from casa_assets.pipeline.batches.shared_spec import Kitchen, SharedSpec
from casa_assets.pipeline.batches.slots import slots_for
from casa_assets.pipeline.batches.structure import structure_of

# Whole numbers that may differ: names, trees of bounding boxes, which only MuJoCo itself uses, how many bodies are
# parked and so without weight, lights that are off, and which material a geom has. Shortcuts are switched off.
_MAY_DIFFER = ("bvh_", "oct_", "name", "nname", "nbuffer", "ngravcomp", "flg_gravcomp", "light_", "geom_matid")
START = "start"
_SHORTCUTS = ("geom_sameframe", "body_sameframe", "site_sameframe")


@dataclass(frozen=True)
class SharedModel:
    """A kitchen in a shared structure.

    Attributes:
        name: of the kitchen. model: compiled; its arrays have the shapes that they have for the other kitchens.
        text: MJCF of it, empty where it has pictures. start: (nq,) positions of its joints as it begins.
        bodies, joints, geoms, sites, cameras: name in the kitchen -> id in the model.
    """

    name: str
    model: mujoco.MjModel
    text: str
    start: Floats
    bodies: Mapping[str, int]
    joints: Mapping[str, int]
    geoms: Mapping[str, int]
    sites: Mapping[str, int]
    cameras: Mapping[str, int]


def share(
    specs: Sequence[mujoco.MjSpec],
    cylinders: bool = True,
    robot: Robot | None = None,
    numerics: Mapping[str, float] = MappingProxyType({}),
    textures: bool = False,
) -> list[SharedModel]:
    """Batch forms in one structure.

    Args:
        specs: of batch forms.
        cylinders: False: each becomes a box as high with as large a section, for engines without contacts between
            cylinders and boxes.
        robot: stands on the body `robot_mount`, or in the world if its base is free; its names begin with `robot_`.
        numerics: name of a custom number in the models -> its value.
        textures: each has the materials and pictures of all, so that its geoms can show any; else they are plain.
    Raises:
        CasaError: a model has something that batch forms do not have, or the structures still differ.
    """
    kitchens = [_read(spec, cylinders) for spec in specs]
    slots = slots_for([kitchen.structure for kitchen in kitchens])
    cameras = list(dict.fromkeys(name for kitchen in kitchens for name in kitchen.cameras))
    lights = max(kitchen.model.nlight for kitchen in kitchens)
    painted = (
        {name: found for kitchen in kitchens for name, found in materials_of(kitchen.model).items()}
        if textures
        else None
    )
    made = []
    for kitchen, tenants in zip(kitchens, slots.tenants, strict=True):
        shared = SharedSpec(kitchen, painted)
        shared.fill(slots, tenants)
        shared.film(cameras, lights)
        for name, value in numerics.items():
            shared.spec.add_numeric(name=name, data=[value], size=1)
        if robot is not None:
            shared.mount(robot)
        made.append(_compiled(shared, kitchen.model, is_plain=not textures))
    for other in made[1:]:
        _hold_same(made[0].model, other.model)
    # Lengths by which MuJoCo turns speeds of hinges into metres a second, to tell what is slow enough to fall asleep:
    # engines have them once for all worlds. With the longest none falls asleep sooner than in its own kitchen.
    longest = np.max([one.model.dof_length for one in made], axis=0)
    for one in made:
        one.model.dof_length[:] = longest
    return made


def _read(spec: mujoco.MjSpec, cylinders: bool) -> Kitchen:
    """A batch form, compiled."""
    for geom in () if cylinders else spec.geoms:
        if geom.type == mujoco.mjtGeom.mjGEOM_CYLINDER:
            radius, half = float(geom.size[0]), float(geom.size[1])
            side = radius * np.sqrt(np.pi) / 2
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_BOX, [side, side, half]
    model = spec.compile()
    try:
        return Kitchen(spec, model, structure_of(model))
    except ValueError as error:
        raise CasaError(f"{spec.modelname}: {error}") from error


def _compiled(shared: SharedSpec, kitchen: mujoco.MjModel, is_plain: bool) -> SharedModel:
    """What was written for a kitchen, compiled; `is_plain`: without pictures, so that MuJoCo can write its MJCF."""
    model = shared.spec.compile()
    for name in _SHORTCUTS:
        getattr(model, name)[:] = 0
    ids = {sort: {name: int(found.id) for name, found in added.items()} for sort, added in shared.added.items()}
    start, begun = np.array(model.qpos0), kitchen.key(START).qpos
    for name, joint in ids["joint"].items():
        into, out = addresses(model, joint), addresses(kitchen, kitchen.joint(name).id)
        start[into] = begun[out]
    named = (ids[sort] for sort in ("body", "joint", "geom", "site", "camera"))
    return SharedModel(shared.spec.modelname, model, shared.spec.to_xml() if is_plain else "", start, *named)


def addresses(model: mujoco.MjModel, joint: int) -> slice:
    """Where the positions of a joint stand in qpos."""
    first = int(model.jnt_qposadr[joint])
    return slice(first, first + (FREE_WIDTH if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE else 1))


def _hold_same(first: mujoco.MjModel, second: mujoco.MjModel) -> None:
    """Raises CasaError where two models differ in anything but real numbers."""
    for name in dir(first):
        value = getattr(first, name)
        if name.startswith(("_", *_MAY_DIFFER)) or not isinstance(value, np.ndarray | int):
            continue
        other = np.asarray(getattr(second, name))
        mine = np.asarray(value)
        if mine.shape != other.shape or (mine.dtype.kind in "iub" and not np.array_equal(mine, other)):
            raise CasaError(f"kitchens of a batch differ in {name} of their models, which an engine cannot change")
