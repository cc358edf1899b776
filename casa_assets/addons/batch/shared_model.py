"""Batch forms of several kitchens -> models of one structure, so that an engine steps them side by side."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

import mujoco
import numpy as np
from lxml import etree
from scipy.optimize import linear_sum_assignment

from casa_assets import CasaError
from casa_assets.addons.batch.structure import (
    BodyKind,
    GeomKind,
    JointKind,
    PaintedMaterial,
    SiteKind,
    Structure,
    Unit,
    UnitKind,
    add_materials,
    materials_of,
    plain_colors,
    structure_of,
)
from casa_assets.ext.arrays import Floats
from casa_assets.ext.kitchens import FREE_WIDTH

Kind = TypeVar("Kind", bound=Hashable)
# Metres: how deep below the kitchen bodies are parked, how far apart, and half the size of a parked geom.
PARK_DEPTH_M, PARK_SPACING_M, PARKED_M = 5.0, 0.2, 1e-3
PARKED_KG, PARKED_BALL_M = 0.1, 0.05  # a parked body is a ball of this mass and radius, kg and metres
# MuJoCo stores less for a body whose frame is exactly that of its inertia. All are moved off it, metres.
OFF_FRAME_M = 1e-6
# A parked joint has dry friction where the joints that take its place have some, N or N*m.
PARKED_FRICTION = 0.1
ROBOT_MOUNT, ROBOT_PREFIX = "robot_mount", "robot_"
_WORDS = {
    int(mujoco.mjtJoint.mjJNT_FREE): "free",
    int(mujoco.mjtJoint.mjJNT_HINGE): "hinge",
    int(mujoco.mjtJoint.mjJNT_SLIDE): "slide",
}
# Elements of MJCF that hold what stands in a kitchen, and how many there are of each sort.
_CONTENT = ("size", "worldbody", "contact", "custom", "keyframe")
_SKY = "skybox"
_LIGHT_FIELDS = (
    *("pos", "dir", "ambient", "diffuse", "specular", "attenuation"),
    *("cutoff", "exponent", "bulbradius"),
)
_GEOM_FIELDS = ("size", "pos", "quat", "friction", "solref", "solimp", "solmix", "margin", "gap")
# Engines on a graphics card want the same bodies, joints and geoms in every world and let numbers differ: poses,
# sizes, masses, ranges, colours. The shared structure has as many places of each kind as the kitchen that has most of
# it. A kitchen fills them with what it has, and a place that it does not fill is parked: a geom inside another one of
# its body, a body in a row below the floor, where nothing pulls at it.
# Whole numbers that may differ: names, trees of bounding boxes, which only MuJoCo itself uses, how many bodies are
# parked and so without weight, lights that are off, and which material a geom has. Shortcuts are switched off.
_MAY_DIFFER = ("bvh_", "oct_", "name", "nname", "nbuffer", "ngravcomp", "flg_gravcomp", "light_", "geom_matid")
START = "start"
_SHORTCUTS = ("geom_sameframe", "body_sameframe", "site_sameframe")


@dataclass(frozen=True)
class Robot:
    """A robot that is in every world of a batch; `make` returns a new MjSpec of it.

    `qpos`, `ctrl`: of its first keyframe, else as built and zeros. `freedoms`: of all its joints. `floats`: its base
    has a free joint, so that it is placed in the world and not on a body that a reset moves.
    """

    make: Callable[[], mujoco.MjSpec]
    qpos: Floats
    ctrl: Floats
    freedoms: int
    floats: bool


def robot_of(robot: str | Path | mujoco.MjSpec) -> Robot:
    """A robot from its MJCF file or a copy of its MjSpec. Raises CasaError for one that does not load."""

    def loaded() -> mujoco.MjSpec:
        return robot.copy() if isinstance(robot, mujoco.MjSpec) else mujoco.MjSpec.from_file(str(robot))

    def make() -> mujoco.MjSpec:
        spec = loaded()
        # A keyframe of the robot alone would not fit a kitchen.
        for key in list(spec.keys):
            spec.delete(key)
        return spec

    try:
        model = loaded().compile()
    except (ValueError, OSError) as error:
        name = robot.modelname if isinstance(robot, mujoco.MjSpec) else robot
        raise CasaError(f"{name}: MuJoCo cannot load this robot: {error}") from error
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    if len(free) and free[0] != 0:
        raise CasaError(f"{model.joint(int(free[0])).name}: a free joint of a robot has to be its first joint")
    qpos, ctrl = (model.key_qpos[0], model.key_ctrl[0]) if model.nkey else (model.qpos0, np.zeros(model.nu))
    return Robot(make, np.array(qpos), np.array(ctrl), int(model.nv), bool(len(free)))


class Slot(NamedTuple):
    """A place that a unit of a kitchen can take, or the world itself.

    `geoms`, `sites`: of each of its bodies, kind -> for how many there is room.
    """

    kind: UnitKind | None  # of the units that fit; None for the world
    geoms: tuple[Mapping[GeomKind, int], ...]
    sites: tuple[Mapping[SiteKind, int], ...]


class Slots(NamedTuple):
    """Places of a shared structure, and who takes them."""

    world: Slot  # the place of what does not move
    moving: tuple[Slot, ...]
    tenants: tuple[tuple[Unit | None, ...], ...]  # for each kitchen, for each of `moving`, its unit there, or None


def slots_for(structures: Sequence[Structure]) -> Slots:
    """Places in which each of some structures fits: of each kind of unit as many as one of them has at most.

    Units with like geoms share a place, so that little room stays empty.
    """
    by_kind: dict[UnitKind, list[list[Unit]]] = defaultdict(lambda: [[] for _ in structures])
    for number, structure in enumerate(structures):
        for unit in structure.units:
            by_kind[unit.kind][number].append(unit)
    moving: list[Slot] = []
    tenants: list[list[Unit | None]] = [[] for _ in structures]
    for kind in sorted(by_kind):
        for here in zip(*_seated(structures, by_kind[kind]), strict=True):
            moving.append(_slot(kind, [(s, t.bodies) for s, t in zip(structures, here, strict=True) if t is not None]))
            for row, tenant in zip(tenants, here, strict=True):
                row.append(tenant)
    world = _slot(None, [(structure, (0,)) for structure in structures])
    return Slots(world, tuple(moving), tuple(map(tuple, tenants)))


def _seated(structures: Sequence[Structure], found: Sequence[Sequence[Unit]]) -> list[list[Unit | None]]:
    """Return, for each structure, its units of one kind in the order of places, None for places it does not fill.

    Structures are assigned one after the other, the largest first, so that places grow by as few geoms as possible.
    """
    places: list[Counter[tuple[int, GeomKind]]] = [Counter() for _ in range(max(map(len, found)))]
    seated: list[list[Unit | None]] = [[None] * len(places) for _ in structures]
    for number in sorted(range(len(structures)), key=lambda one: -len(found[one])):
        needs = [_needs(structures[number], unit) for unit in found[number]]
        growth = np.array([[(need - place).total() for place in places] for need in needs]).reshape(-1, len(places))
        for unit, place in zip(*linear_sum_assignment(growth), strict=True):
            seated[number][place] = found[number][unit]
            places[place] |= needs[unit]
    return seated


def _needs(structure: Structure, unit: Unit) -> Counter[tuple[int, GeomKind]]:
    """(body of a unit, kind) -> how many geoms it has."""
    bodies = [(place, structure.geoms.get(body, {})) for place, body in enumerate(unit.bodies)]
    return Counter({(place, kind): len(ids) for place, geoms in bodies for kind, ids in geoms.items()})


def _slot(kind: UnitKind | None, tenants: Sequence[tuple[Structure, tuple[int, ...]]]) -> Slot:
    """A place for units of several structures, each with its bodies in the same order."""
    places = range(len(tenants[0][1]))
    geoms = tuple(_most(s.geoms.get(bodies[place], {}) for s, bodies in tenants) for place in places)
    sites = tuple(_most(s.sites.get(bodies[place], {}) for s, bodies in tenants) for place in places)
    return Slot(kind, geoms, sites)


def _most(found: Iterable[Mapping[Kind, Sequence[int]]]) -> dict[Kind, int]:
    """For each kind the most that one of several has, in a fixed order."""
    most: Counter[Kind] = Counter()
    for one in found:
        most |= Counter({kind: len(ids) for kind, ids in one.items()})
    return dict(sorted(most.items(), key=lambda item: repr(item[0])))


def _values(model: mujoco.MjModel, sort: str, number: int, fields: Sequence[str]) -> dict[str, Any]:
    """Real numbers of one element of a model, by what MjSpec calls them."""
    found = {field: getattr(model, f"{sort}_{field}")[number] for field in fields}
    return {field: value if np.ndim(value) else float(value) for field, value in found.items()}


class Kitchen(NamedTuple):
    """A batch form: its spec, compiled, and its structure."""

    spec: mujoco.MjSpec
    model: mujoco.MjModel
    structure: Structure

    @property
    def cameras(self) -> dict[str, int]:
        """Name of a camera -> its id."""
        return {str(self.model.camera(number).name): number for number in range(self.model.ncam)}


class SharedSpec:
    """Writes a kitchen into the shared structure; `added`: element type -> name in the kitchen -> its element."""

    def __init__(self, kitchen: Kitchen, materials: Mapping[str, PaintedMaterial] | None = None) -> None:
        """Begins with an empty spec. `materials`: of all kitchens, by name; None: pictures become their mean colour."""
        self.spec = _emptied(kitchen.spec)
        self._colors = plain_colors(kitchen.model) if materials is None else None
        add_materials(self.spec, (materials or {}).values())
        self.added: dict[str, dict[str, Any]] = {sort: {} for sort in ("body", "joint", "geom", "site", "camera")}
        self._kitchen, self._model, self._structure = kitchen, kitchen.model, kitchen.structure
        self._names: Counter[str] = Counter()
        self._parked = 0

    def fill(self, slots: Slots, tenants: Sequence[Unit | None]) -> None:
        """Add what does not move, and each place with its tenant or parked."""
        world = self.spec.worldbody
        self._add_shapes(world, slots.world, 0, 0)
        for slot, tenant in zip(slots.moving, tenants, strict=True):
            bodies: list[Any] = []
            for tree in slot.kind.trees if slot.kind else ():
                self._add_tree(world, slot, tree, tenant, bodies)
            for pair in slot.kind.exclusions if slot.kind else ():
                first, second = (bodies[number].name if number >= 0 else world.name for number in pair)
                self.spec.add_exclude(bodyname1=first, bodyname2=second)

    def film(self, cameras: Sequence[str], lights: int) -> None:
        """Add cameras and lights; a camera that the kitchen lacks looks as its first, a light that it lacks is off."""
        model, world = self._model, self.spec.worldbody
        for name in cameras:
            number = self._kitchen.cameras.get(name, 0)
            camera = world.add_camera(name=name, **_values(model, "cam", number, ("pos", "quat", "fovy")))
            if name in self._kitchen.cameras:
                self.added["camera"][name] = camera
        for number in range(lights):
            known = min(number, model.nlight - 1)
            world.add_light(
                name=f"light_{number}",
                type=mujoco.mjtLightType(int(model.light_type[known])),
                castshadow=bool(model.light_castshadow[known]),
                active=number < model.nlight,
                **_values(model, "light", known, _LIGHT_FIELDS),
            )

    def mount(self, robot: Robot) -> None:
        """Add a robot: on a body that a reset moves, or in the world if it has a free joint."""
        world = self.spec.worldbody
        below = world if robot.floats else world.add_body(name=ROBOT_MOUNT, mocap=True)
        self.spec.attach(robot.make(), prefix=ROBOT_PREFIX, frame=below.add_frame())

    def _add_tree(self, parent: Any, slot: Slot, kind: BodyKind, tenant: Unit | None, bodies: list[Any]) -> None:
        """Add a body and those that hang on it to the `bodies` of the unit."""
        place = len(bodies)
        source = None if tenant is None else tenant.bodies[place]
        word = "_".join(_WORDS[joint.shape] for joint in kind.joints)
        name = f"{word}_{self._names[word]}"
        self._names[word] += 1
        values = self._parked_frame(parent) if source is None else self._frame(source)
        body = parent.add_body(name=name, explicitinertial=True, **values)
        bodies.append(body)
        if source is not None:
            self.added["body"][str(self._model.body(source).name)] = body
        for number, joint in enumerate(kind.joints):
            self._add_joint(body, joint, None if source is None else int(self._model.body_jntadr[source]) + number)
        self._add_shapes(body, slot, place, source)
        for child in kind.children:
            self._add_tree(body, slot, child, tenant, bodies)

    def _frame(self, source: int) -> dict[str, Any]:
        model = self._model
        ipos = np.array(model.body_ipos[source])
        values = _values(model, "body", source, ("pos", "quat", "mass", "iquat", "inertia", "gravcomp"))
        return {**values, "ipos": ipos if ipos.any() else ipos + OFF_FRAME_M}

    def _parked_frame(self, parent: Any) -> dict[str, Any]:
        """Pose and mass of a body that is not there: without weight, below the kitchen or above its parent."""
        pos = [0.0, 0.0, PARKED_BALL_M]
        if parent.id == 0:
            pos = [PARK_SPACING_M * self._parked, 0.0, -PARK_DEPTH_M]
            self._parked += 1
        inertia = [0.4 * PARKED_KG * PARKED_BALL_M**2] * 3
        return {"pos": pos, "mass": PARKED_KG, "ipos": [OFF_FRAME_M] * 3, "inertia": inertia, "gravcomp": 1.0}

    def _add_joint(self, body: Any, kind: JointKind, source: int | None) -> None:
        values: dict[str, Any] = {"type": mujoco.mjtJoint(kind.shape), "name": body.name}
        is_free = kind.shape == mujoco.mjtJoint.mjJNT_FREE
        if not is_free:
            values["limited"] = mujoco.mjtLimited.mjLIMITED_TRUE if kind.limited else mujoco.mjtLimited.mjLIMITED_FALSE
        if source is None:
            body.add_joint(
                **values,
                axis=[0.0, 0.0, 1.0] if kind.shape == mujoco.mjtJoint.mjJNT_HINGE else [1.0, 0.0, 0.0],
                range=[-1.0, 1.0],
                damping=[PARKED_FRICTION, 0.0, 0.0],
                frictionloss=PARKED_FRICTION if kind.has_friction else 0.0,
            )
            return
        model, dof, address = self._model, int(self._model.jnt_dofadr[source]), int(self._model.jnt_qposadr[source])
        if not is_free:
            values |= {"ref": float(model.qpos0[address]), "springref": float(model.qpos_spring[address])}
        self.added["joint"][str(model.joint(source).name)] = body.add_joint(
            **values,
            **_values(model, "jnt", source, ("axis", "pos", "range", "margin")),
            **_values(model, "dof", dof, ("frictionloss", "armature")),
            stiffness=[float(model.jnt_stiffness[source]), *map(float, model.jnt_stiffnesspoly[source])],
            damping=[float(model.dof_damping[dof]), *map(float, model.dof_dampingpoly[dof])],
            solref_limit=model.jnt_solref[source],
            solimp_limit=model.jnt_solimp[source],
            solref_friction=model.dof_solref[dof],
            solimp_friction=model.dof_solimp[dof],
        )

    def _add_shapes(self, body: Any, slot: Slot, place: int, source: int | None) -> None:
        """Add the geoms and sites of a body; those that the kitchen lacks go to the centre of its largest geom."""
        geoms = {} if source is None else self._structure.geoms.get(source, {})
        sites = {} if source is None else self._structure.sites.get(source, {})
        middle: Floats = np.zeros(3)
        if geoms:
            largest = max((ids[0] for ids in geoms.values()), key=lambda geom: float(self._model.geom_rbound[geom]))
            middle = self._model.geom_pos[largest]
        for kind, many in slot.geoms[place].items():
            for geom in _padded(geoms.get(kind, ()), many):
                self._add_geom(body, kind, geom, middle)
        for site_kind, many in slot.sites[place].items():
            for site in _padded(sites.get(site_kind, ()), many):
                self._add_site(body, site_kind, site, middle)

    def _add_geom(self, body: Any, kind: GeomKind, source: int | None, middle: Floats) -> None:
        values = kind._asdict()
        values |= {"type": mujoco.mjtGeom(values.pop("shape")), "mass": 0.0}
        if source is None:
            body.add_geom(**values, size=[PARKED_M] * 3, pos=middle)
            return
        model = self._model
        self.added["geom"][str(model.geom(source).name)] = body.add_geom(
            **values, **_values(model, "geom", source, _GEOM_FIELDS), **self._look(source)
        )

    def _look(self, source: int) -> dict[str, Any]:
        """Material of a geom, or its colour: MuJoCo would take the colour where both are given."""
        material = int(self._model.geom_matid[source])
        if self._colors is None and material >= 0:
            return {"material": str(self._model.material(material).name)}
        return {"rgba": (self._model.geom_rgba if self._colors is None else self._colors)[source]}

    def _add_site(self, body: Any, kind: SiteKind, source: int | None, middle: Floats) -> None:
        values: dict[str, Any] = {"type": mujoco.mjtGeom(kind.shape), "size": kind.size, "group": kind.group}
        if source is None:
            body.add_site(**values, pos=middle, rgba=[0.0] * 4)
            return
        model = self._model
        self.added["site"][str(model.site(source).name)] = body.add_site(
            **values, **_values(model, "site", source, ("pos", "quat", "rgba"))
        )


def _emptied(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """Return a kitchen without its contents and materials; options, sky and views are kept."""
    # MjSpec takes milliseconds to delete one element, and there are more than a thousand.
    root = etree.fromstring(spec.to_xml())
    for element in [found for tag in _CONTENT for found in root.iterchildren(tag)]:
        root.remove(element)
    for block in root.iterchildren("asset"):
        for element in [found for found in block if found.get("type") != _SKY]:
            block.remove(element)
    return mujoco.MjSpec.from_string(etree.tostring(root, encoding="unicode"))


def _padded(found: Sequence[int], many: int) -> list[int | None]:
    """So many numbers: those that were found, and None for the rest."""
    return [*found, *[None] * (many - len(found))]


@dataclass(frozen=True)
class SharedModel:
    """A kitchen in a shared structure, compiled, with its MJCF (empty where it has pictures).

    `start`: (nq,) positions as it begins. `bodies` ... `cameras`: name in the kitchen -> id in the model.
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
    """Return batch forms in one shared structure.

    Args:
        specs: of batch forms.
        cylinders: False: replace each cylinder by a box of the same height and cross-section area, for engines without
            contacts between cylinders and boxes.
        robot: placed on the body `robot_mount`, or in the world if its base is free; its names begin with `robot_`.
        numerics: name of a custom number in the models -> its value.
        textures: each has the materials and pictures of all, so that its geoms can show any; else they are plain.
    Raises:
        CasaError: a model has an element that batch forms do not have, or the structures still differ.
    """
    kitchens = [_read(spec, cylinders) for spec in specs]
    slots = slots_for([kitchen.structure for kitchen in kitchens])
    cameras = list(dict.fromkeys(name for kitchen in kitchens for name in kitchen.cameras))
    lights = max(kitchen.model.nlight for kitchen in kitchens)
    painted: dict[str, PaintedMaterial] = {}
    for kitchen in kitchens if textures else ():
        painted |= materials_of(kitchen.model)
    made = []
    for kitchen, tenants in zip(kitchens, slots.tenants, strict=True):
        shared = SharedSpec(kitchen, painted if textures else None)
        shared.fill(slots, tenants)
        shared.film(cameras, lights)
        for name, value in numerics.items():
            shared.spec.add_numeric(name=name, data=[value], size=1)
        if robot is not None:
            shared.mount(robot)
        made.append(_compiled(shared, kitchen.model, is_plain=not textures))
    for other in made[1:]:
        _hold_same(made[0].model, other.model)
    # Lengths by which MuJoCo turns speeds of hinges into metres a second, to find what is slow enough to fall asleep:
    # engines have them once for all worlds. With the longest none falls asleep sooner than in its own kitchen.
    longest = np.max([one.model.dof_length for one in made], axis=0)
    for one in made:
        one.model.dof_length[:] = longest
    return made


def _read(spec: mujoco.MjSpec, cylinders: bool) -> Kitchen:
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
    """Compile the spec written for a kitchen; `is_plain`: without pictures, so that MuJoCo can write its MJCF."""
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
    """Return the slice of qpos with the positions of a joint."""
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
