"""One kitchen -> the MjSpec of it in a structure that it shares with others; what it lacks is parked."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
from lxml import etree

from casa_assets.core.typing import Floats
from casa_assets.pipeline.batches.pictures import PaintedMaterial, add_materials, plain_colors
from casa_assets.pipeline.batches.robot import Robot
from casa_assets.pipeline.batches.slots import Slot, Slots
from casa_assets.pipeline.batches.structure import BodyKind, GeomKind, JointKind, SiteKind, Structure, Unit

# Metres: how deep below the kitchen bodies are parked, how far apart, and half the size of a parked geom.
PARK_DEPTH_M, PARK_SPACING_M, PARKED_M = 5.0, 0.2, 1e-3
# A parked body is a ball of this mass and radius, kg and metres.
PARKED_KG, PARKED_BALL_M = 0.1, 0.05
# MuJoCo stores less for a body whose frame is exactly that of its inertia. All are moved off it by so much, metres.
OFF_FRAME_M = 1e-6
# A parked joint has dry friction where the joints that take its place have some, N or N*m.
PARKED_FRICTION = 0.1
ROBOT_MOUNT, ROBOT_PREFIX = "robot_mount", "robot_"
_UPRIGHT = (1.0, 0.0, 0.0, 0.0)
_WORDS = {
    int(mujoco.mjtJoint.mjJNT_FREE): "free",
    int(mujoco.mjtJoint.mjJNT_HINGE): "hinge",
    int(mujoco.mjtJoint.mjJNT_SLIDE): "slide",
}
# Elements of MJCF that hold what stands in a kitchen, and how many there are of each sort.
_CONTENT = ("size", "worldbody", "contact", "custom", "keyframe")
_SKY = "skybox"


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
    """Writes a kitchen into the shared structure.

    Attributes:
        spec: what is written. added: sort of thing -> name in the kitchen -> what stands for it.
    """

    def __init__(self, kitchen: Kitchen, materials: Mapping[str, PaintedMaterial] | None = None) -> None:
        """Begins with a spec that holds nothing.

        Args:
            materials: of all kitchens, by name; None: what has a picture gets the mean colour of it.
        """
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
            camera = world.add_camera(
                name=name, pos=model.cam_pos[number], quat=model.cam_quat[number], fovy=model.cam_fovy[number]
            )
            if name in self._kitchen.cameras:
                self.added["camera"][name] = camera
        for number in range(lights):
            known = min(number, model.nlight - 1)
            world.add_light(
                name=f"light_{number}",
                type=mujoco.mjtLightType(int(model.light_type[known])),
                pos=model.light_pos[known],
                dir=model.light_dir[known],
                ambient=model.light_ambient[known],
                diffuse=model.light_diffuse[known],
                specular=model.light_specular[known],
                attenuation=model.light_attenuation[known],
                cutoff=float(model.light_cutoff[known]),
                exponent=float(model.light_exponent[known]),
                bulbradius=float(model.light_bulbradius[known]),
                castshadow=bool(model.light_castshadow[known]),
                active=number < model.nlight,
            )

    def mount(self, robot: Robot) -> None:
        """Add a robot: on a body that a reset moves, or in the world if it has a free joint."""
        world = self.spec.worldbody
        below = world if robot.floats else world.add_body(name=ROBOT_MOUNT, mocap=True)
        self.spec.attach(robot.make(), prefix=ROBOT_PREFIX, frame=below.add_frame())

    def _add_tree(self, parent: Any, slot: Slot, kind: BodyKind, tenant: Unit | None, bodies: list[Any]) -> None:
        """Add a body and those that hang on it.

        Args:
            bodies: of the unit so far; those that are added come after them.
        """
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
        """Pose and mass of a body as the kitchen has them."""
        model = self._model
        ipos = np.array(model.body_ipos[source])
        return {
            "pos": model.body_pos[source],
            "quat": model.body_quat[source],
            "mass": float(model.body_mass[source]),
            "ipos": ipos if ipos.any() else ipos + OFF_FRAME_M,
            "iquat": model.body_iquat[source],
            "inertia": model.body_inertia[source],
            "gravcomp": float(model.body_gravcomp[source]),
        }

    def _parked_frame(self, parent: Any) -> dict[str, Any]:
        """Pose and mass of a body that is not there: without weight, below the kitchen or above its parent."""
        pos = [0.0, 0.0, PARKED_BALL_M]
        if parent.id == 0:
            pos = [PARK_SPACING_M * self._parked, 0.0, -PARK_DEPTH_M]
            self._parked += 1
        inertia = [0.4 * PARKED_KG * PARKED_BALL_M**2] * 3
        return {"pos": pos, "mass": PARKED_KG, "ipos": [OFF_FRAME_M] * 3, "inertia": inertia, "gravcomp": 1.0}

    def _add_joint(self, body: Any, kind: JointKind, source: int | None) -> None:
        """Add a joint of a body, as the kitchen has it or parked."""
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
            axis=model.jnt_axis[source],
            pos=model.jnt_pos[source],
            range=model.jnt_range[source],
            margin=float(model.jnt_margin[source]),
            stiffness=[float(model.jnt_stiffness[source]), *map(float, model.jnt_stiffnesspoly[source])],
            damping=[float(model.dof_damping[dof]), *map(float, model.dof_dampingpoly[dof])],
            frictionloss=float(model.dof_frictionloss[dof]),
            armature=float(model.dof_armature[dof]),
            solref_limit=model.jnt_solref[source],
            solimp_limit=model.jnt_solimp[source],
            solref_friction=model.dof_solref[dof],
            solimp_friction=model.dof_solimp[dof],
        )

    def _add_shapes(self, body: Any, slot: Slot, place: int, source: int | None) -> None:
        """Add the geoms and sites of a body; those that the kitchen lacks stand in the middle of its largest geom."""
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
        values: dict[str, Any] = {
            "type": mujoco.mjtGeom(kind.shape),
            "contype": kind.contype,
            "conaffinity": kind.conaffinity,
            "condim": kind.condim,
            "priority": kind.priority,
            "group": kind.group,
            "mass": 0.0,
        }
        if source is None:
            body.add_geom(**values, size=[PARKED_M] * 3, pos=middle)
            return
        model = self._model
        self.added["geom"][str(model.geom(source).name)] = body.add_geom(
            **values,
            size=model.geom_size[source],
            pos=model.geom_pos[source],
            quat=model.geom_quat[source],
            friction=model.geom_friction[source],
            solref=model.geom_solref[source],
            solimp=model.geom_solimp[source],
            solmix=float(model.geom_solmix[source]),
            margin=float(model.geom_margin[source]),
            gap=float(model.geom_gap[source]),
            **self._look(source),
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
            **values, pos=model.site_pos[source], quat=model.site_quat[source], rgba=model.site_rgba[source]
        )


def _emptied(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """A kitchen without all that stands in it, and without its materials; options, sky and views stay."""
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
