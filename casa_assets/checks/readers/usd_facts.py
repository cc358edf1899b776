"""Reduce the USD of an asset to the table of facts that formats are compared by."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path, PurePosixPath
from typing import Literal

import mujoco
import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade

from casa_assets.checks.readers.facts import (
    OUTER,
    ROOT_BODY,
    AssetFacts,
    BodyFacts,
    JointFacts,
    PlaceFacts,
    PoseFacts,
    ProgramTexts,
    StateFacts,
    VisualFacts,
    bounds_around,
    four,
    own_name,
    pose_facts,
    quaternions_of,
    short_name,
    tensor_entries,
    three,
)
from casa_assets.checks.readers.mujoco_facts import Loaded, all_warnings, facts_of_model, free_bodies
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.asset import Base, JointKind
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3, Vec4

# Usd words ------------------------------------------------------------------------------------------------------------
# USD stage -> what programs read by name: words, places, named poses. Read with OpenUSD alone.

SITE = "MjcSiteAPI"
VARIANTS = "pose"


def words(root: Usd.Prim) -> ProgramTexts:
    """Classes and labels, states, grips, contract and behaviour of the asset at a prim."""
    prims = list(Usd.PrimRange(root))
    joints = [prim for prim in prims if prim.IsA(UsdPhysics.Joint)]
    names = {prim.GetName() for prim in prims}
    behavior = _text(root, "casa:behavior")
    grips, behind = (
        [(joint.GetName(), _text(joint, name)) for joint in joints] for name in ("casa:grip", "casa:behind")
    )
    states = [(joint, joint.GetCustomDataByKey("states") or {}) for joint in joints]
    return ProgramTexts(
        classes=_labels(root, "class"),
        portion=" ".join(_labels(root, "portion")),
        labels=[(p.GetName(), label) for p in prims if p.IsA(UsdGeom.Gprim) for label in _labels(p, "part")],
        # Names of prims that there are.
        grips=[(joint, target) for joint, target in grips if target in names],
        behind=[(joint, target) for joint, target in behind if target in names],
        contract=_text(root, "casa:contract"),
        behavior=hashlib.sha256(behavior.encode()).hexdigest() if behavior else "",
        states=[
            StateFacts(name=name, joint=joint.GetName(), value=said["value"], interval=(said["from"], said["to"]))
            for joint, named in states
            for name, said in named.items()
        ],
    )


def _labels(prim: Usd.Prim, taxonomy: str) -> tuple[str, ...]:
    if not prim.HasAPI(UsdSemantics.LabelsAPI, taxonomy):
        return ()
    return tuple(UsdSemantics.LabelsAPI(prim, taxonomy).GetLabelsAttr().Get() or ())


def _text(prim: Usd.Prim, name: str) -> str:
    return str(prim.GetAttribute(name).Get() or "")


def poses(stage: Usd.Stage, scene: bool = False) -> list[PoseFacts]:
    """Poses of the bodies in each variant of `pose`. The stage is left as it was.

    Args:
        stage: with the variants on its default prim.
        scene: whether it holds many placements; then poses are world_from_body, else root_from_body.
    """
    variants = stage.GetDefaultPrim().GetVariantSet(VARIANTS)
    bodies = sorted(p.GetPath() for p in stage.Traverse() if p.HasAPI(UsdPhysics.RigidBodyAPI))
    names, found = [short_name(str(path)) for path in bodies], []
    # In the session layer, which is no part of the file.
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        for name in sorted(variants.GetVariantNames()):
            # What is selected already is not selected again: each selection composes the whole stage anew.
            if variants.GetVariantSelection() != name:
                variants.SetVariantSelection(name)
            cache = UsdGeom.XformCache()
            matrices = [cache.GetLocalToWorldTransform(stage.GetPrimAtPath(path)) for path in bodies]
            world_from = dict(zip(names, zip(*rigid_all(matrices), strict=True), strict=True))
            found.append(pose_facts(name, world_from, None if scene else ROOT_BODY))
        variants.ClearVariantSelection()
    return found


def _places(stage: Usd.Stage) -> list[PlaceFacts]:
    """Prims that are sites; those without their own colour are regions.

    Raises:
        ValueError: one is neither sphere, cube nor cylinder about z.
    """
    cache = UsdGeom.XformCache()
    # As written: GetAppliedSchemas knows the schemas of MuJoCo only where its reader of USD is installed.
    sites = [prim for prim in stage.Traverse() if SITE in prim.GetPrimTypeInfo().GetAppliedAPISchemas()]
    # Places lie two levels below their body.
    bodies = [prim.GetParent().GetParent() for prim in sites]
    # body_from_place with its scale
    matrices = [
        cache.GetLocalToWorldTransform(prim) * cache.GetLocalToWorldTransform(body).GetInverse()
        for prim, body in zip(sites, bodies, strict=True)
    ]
    found = []
    for prim, body, matrix, at, turn in zip(sites, bodies, matrices, *rigid_all(matrices), strict=True):
        kind, own = _volume(prim)
        # A region defines no colour itself.
        gprim = UsdGeom.Gprim(prim)
        colors, alphas = gprim.GetDisplayColorAttr().Get(), gprim.GetDisplayOpacityAttr().Get()
        found.append(
            PlaceFacts(
                name=short_name(str(prim.GetPath())),
                body=short_name(str(body.GetPath())),
                kind=kind,
                position=at,
                quaternion=turn,
                size=[float(matrix.GetRow3(i).GetLength() * own[i]) for i in range(3)],
                color=(*three(colors[0]), float(alphas[0])) if colors and alphas else None,
            )
        )
    return [place for place in found if own_name(place.name) != OUTER]


def _volume(prim: Usd.Prim) -> tuple[Literal["sphere", "box", "cylinder"], Vec3]:
    """Kind and full size of a gprim before any scale."""
    if prim.IsA(UsdGeom.Cube):
        size = float(UsdGeom.Cube(prim).GetSizeAttr().Get())
        return "box", (size, size, size)
    if prim.IsA(UsdGeom.Sphere):
        size = 2 * float(UsdGeom.Sphere(prim).GetRadiusAttr().Get())
        return "sphere", (size, size, size)
    rod = UsdGeom.Cylinder(prim)
    if rod and rod.GetAxisAttr().Get() == UsdGeom.Tokens.z:
        across = 2 * float(rod.GetRadiusAttr().Get())
        return "cylinder", (across, across, float(rod.GetHeightAttr().Get()))
    raise ValueError(f"place {prim.GetName()!r} is neither sphere, cube nor cylinder about z")


def rigid(matrix: Gf.Matrix4d) -> Pose:
    """Pose of a matrix of row vectors, without its scale."""
    (position,), (quaternion,) = rigid_all([matrix])
    return Pose(position=position, quaternion=quaternion)


def rigid_all(matrices: Sequence[Gf.Matrix4d]) -> tuple[list[Vec3], list[Vec4]]:
    """Positions and quaternions of matrices of row vectors, without their scale."""
    rows = np.array([np.array(matrix) for matrix in matrices]).reshape(-1, 4, 4)
    axes = rows[:, :3, :3] / np.linalg.norm(rows[:, :3, :3], axis=2, keepdims=True)
    positions, quaternions = rows[:, 3, :3] + 0.0, quaternions_of(axes.transpose(0, 2, 1))
    return [three(row) for row in positions.tolist()], [four(row) for row in quaternions.tolist()]


# Usd looks ------------------------------------------------------------------------------------------------------------
# USD stage -> what its visuals look like. Read with OpenUSD alone.


def looks(stage: Usd.Stage) -> list[VisualFacts]:
    """Meshes that physics does not touch, in the material that they are bound to.

    Raises:
        ValueError: one has no surface to be seen.
    """
    meshes = [p for p in stage.Traverse() if p.IsA(UsdGeom.Mesh) and not p.HasAPI(UsdPhysics.CollisionAPI)]
    # A site is no mesh, so what is left is seen. Materials of all of them are found at once, which shares what they
    # inherit.
    materials = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(meshes)[0]
    surfaces: dict[Usd.Prim, tuple[Vec4, Vec3, str]] = {}
    found = []
    for prim, material in zip(meshes, materials, strict=True):
        bound = material.GetPrim()
        if bound not in surfaces:
            surfaces[bound] = _surface(prim, material)
        color, light, picture = surfaces[bound]
        found.append(VisualFacts(name=short_name(str(prim.GetPath())), color=color, light=light, picture=picture))
    return found


def _surface(prim: Usd.Prim, material: UsdShade.Material) -> tuple[Vec4, Vec3, str]:
    """Colour, light that it gives off and picture of a material, as `VisualFacts` has them; `prim` is bound to it."""
    shader = material.ComputeSurfaceSource()[0] if material else None
    if not shader:
        raise ValueError(f"{prim.GetName()!r} has no surface")
    red, green, blue, _ = _value(shader, "diffuseColor")
    node = _node(shader, "diffuseColor")
    picture = PurePosixPath(node.GetInput("file").Get().path).name if node is not None else ""
    return (red, green, blue, _value(shader, "opacity")[3]), three(_value(shader, "emissiveColor")[:3]), picture


def _node(shader: UsdShade.Shader, name: str) -> UsdShade.Shader | None:
    port = shader.GetInput(name)
    if not port or not port.HasConnectedSource():
        return None
    return UsdShade.Shader(port.GetConnectedSources()[0][0].source.GetPrim())


def _value(shader: UsdShade.Shader, name: str) -> Vec4:
    """Colour or number of an input, or the factor on its picture; a number is the alpha of white."""
    node = _node(shader, name)
    if node is not None:
        scale = node.GetInput("scale")
        return four(scale.Get() if scale else (1, 1, 1, 1))
    port = shader.GetInput(name)
    value = port.Get() if port else (0.0, 0.0, 0.0)
    return (1.0, 1.0, 1.0, value) if isinstance(value, float) else (*three(value), 1.0)


# Usd facts ------------------------------------------------------------------------------------------------------------
# USD file -> fact table, by two readers that share no code: MuJoCo and UsdPhysics.

AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
# Axis of a cylinder or capsule -> columns of its matrix, the axis last.
COLUMNS = {"X": (1, 2, 0), "Y": (2, 0, 1), "Z": (0, 1, 2)}


def missing_importer() -> str:
    """Why MuJoCo cannot read USD here, a part of a sentence; empty where it can."""
    if find_spec("mujoco._usd") is not None:
        return ""
    return "MuJoCo's reader of USD, the package mujoco-usd, is not installed; it has no release for Python 3.14"


def imported(path: Path) -> Loaded:
    """The file compiled by way of MuJoCo's USD reader, which its XML loader does not call, with its warnings."""
    with all_warnings() as said:
        try:
            spec = mujoco.MjSpec.from_file(str(path))
            _share_pictures(spec)
            model, error = spec.compile(), ""
        except ValueError as refusal:
            model, error = None, str(refusal)
    return Loaded(model, error, tuple(dict.fromkeys(said)))


def _share_pictures(spec: mujoco.MjSpec) -> None:
    """Make materials share one texture per picture file, so that each file is decoded once.

    The reader makes a texture for every material that names a file: 114 of 18 files in one kitchen. The others are
    replaced by one plain pixel, because deleting them would take as long as reading them.
    """
    first: dict[tuple[object, ...], str] = {}
    renamed: dict[str, str] = {}
    for texture in spec.textures:
        if not texture.file:
            continue
        name = first.setdefault((texture.file, texture.type, texture.nchannel, texture.colorspace), texture.name)
        if name != texture.name:
            renamed[texture.name] = name
            texture.file, texture.builtin = "", mujoco.mjtBuiltin.mjBUILTIN_FLAT
            texture.width = texture.height = 1
    for material in spec.materials:
        names = list(material.textures)
        if any(name in renamed for name in names):
            material.textures = [renamed.get(name, name) for name in names]


def mujoco_facts(path: Path) -> AssetFacts:
    """Fact table of a USD file as MuJoCo imports it. Raises ValueError where it does not."""
    loaded = imported(path)
    if loaded.model is None:
        raise ValueError(loaded.error)
    base = Base.FREE if free_bodies(loaded.model) else Base.FIXED
    stage = Usd.Stage.Open(str(path))
    return _whole(facts_of_import(loaded.model, StageReading(stage)).replace(base=base), stage)


def pxr_facts(path: Path) -> AssetFacts:
    """Fact table of a USD file as UsdPhysics parses it; the poses of bodies follow from their joint frames.

    Raises:
        ValueError: the file has no default prim, or holds a joint that no asset has.
    """
    stage = Usd.Stage.Open(str(path))
    return _whole(facts_of_stage(StageReading(stage))[0], stage)


def _whole(table: AssetFacts, stage: Usd.Stage) -> AssetFacts:
    return table.replace(poses=poses(stage), words=words(stage.GetDefaultPrim()))


class StageReading:
    """What OpenUSD alone reads of a stage, read once for the tables of both readers.

    Attributes:
        stage: nobody changes it meanwhile.
    """

    def __init__(self, stage: Usd.Stage) -> None:
        """Raise ValueError where the stage has no default prim."""
        if not stage.GetDefaultPrim():
            raise ValueError("there is no default prim")
        self.stage = stage

    @cached_property
    def places(self) -> list[PlaceFacts]:
        """Sites and regions. Raises as `_places` does."""
        return _places(self.stage)

    @cached_property
    def looks(self) -> list[VisualFacts]:
        """Appearance of the visuals."""
        return looks(self.stage)


def facts_of_import(model: mujoco.MjModel, read: StageReading) -> AssetFacts:
    """Fact table of a stage as MuJoCo imported it, without poses and words."""
    table = facts_of_model(model, base=Base.FIXED, words=ProgramTexts())
    # MuJoCo leaves the colours of sites, most of what a surface is, and the variants of USD out; OpenUSD reads them.
    colors = {place.name: place.color for place in read.places}
    places = [place.replace(color=colors.get(place.name)) for place in table.places]
    return table.replace(places=places, looks=read.looks)


def facts_of_stage(read: StageReading) -> tuple[AssetFacts, dict[str, Pose]]:
    """Fact table of a stage as UsdPhysics parses it, without poses and words.

    Returns:
        The table, and the bodies that are fixed to the world: name -> world_from_body as their joint demands.
    """
    stage = read.stage
    # Colliders are left out of what the parser reads, and traversed: it appends them to one list from many threads
    # without a lock, and with some twenty of them the list is damaged now and then, or the process dies (25.11).
    shapes = [p for p in stage.Traverse() if p.HasAPI(UsdPhysics.CollisionAPI)]
    parsed = UsdPhysics.LoadUsdPhysicsFromRange(stage, ["/"], sorted({p.GetParent().GetPath() for p in shapes}))
    kinds = UsdPhysics.ObjectType

    def found(*kinds: object) -> list[UsdPhysics.ObjectDesc]:
        return [described for kind in kinds if kind in parsed for described in parsed[kind][1]]

    links = {d.primPath: d for d in found(kinds.RigidBody)}
    mounts = {d.body1: d for d in found(kinds.FixedJoint)}
    movers = {d.body1: d for d in found(kinds.RevoluteJoint, kinds.PrismaticJoint)}
    if found(kinds.SphericalJoint, kinds.DistanceJoint, kinds.D6Joint, kinds.CustomJoint):
        raise ValueError("a joint is neither fixed, revolute nor prismatic")
    below: dict[Sdf.Path, list[Usd.Prim]] = {path: [] for path in links}
    for shape in shapes:
        # The nearest body has it: bodies may be below others.
        nearest = next((path for path in reversed(shape.GetPath().GetPrefixes()) if path in below), None)
        if nearest is not None:
            below[nearest].append(shape)
    joints, cache, frictions = {**mounts, **movers}, UsdGeom.XformCache(), _frictions(shapes)
    filtered = [(short_name(str(p)), short_name(str(o))) for p, d in links.items() for o in d.filteredCollisions]
    welded = {short_name(str(b)): _body1_in_body0(d) for b, d in mounts.items() if d.body0.isEmpty and b in links}
    table = AssetFacts(
        base=Base.FIXED if welded else Base.FREE,
        exclusions=filtered,
        words=ProgramTexts(),
        bodies=[
            _body(stage.GetPrimAtPath(path), below[path], joints, movers.get(path), cache, frictions) for path in links
        ],
        places=read.places,
        looks=read.looks,
    )
    return table, welded


def _body(
    prim: Usd.Prim,
    shapes: list[Usd.Prim],
    joints: dict[Sdf.Path, UsdPhysics.JointDesc],
    mover: UsdPhysics.JointDesc | None,
    cache: UsdGeom.XformCache,
    frictions: dict[Usd.Prim, Vec3],
) -> BodyFacts:
    """Row of a body.

    Args:
        shapes: its colliders. joints: path of a body -> the joint that ties it to its parent or the world. mover: the
            joint that moves it. frictions: of each collider.
    """
    path, mass = prim.GetPath(), UsdPhysics.MassAPI(prim)
    axes = _pose(Gf.Vec3f(0), mass.GetPrincipalAxesAttr().Get()).rotation
    body_from_world = cache.GetLocalToWorldTransform(prim).GetInverse()
    lower, upper = bounds_around([_bounds(s, cache.GetLocalToWorldTransform(s) * body_from_world) for s in shapes])
    pose, up = _world_from(joints, path), joints.get(path)
    return BodyFacts(
        name=short_name(str(path)),
        parent=short_name(str(up.body0)) if up is not None and not up.body0.isEmpty else "",
        colliders=len(shapes),
        position=pose.position,
        center_of_mass=three(mass.GetCenterOfMassAttr().Get()),
        lower=lower,
        upper=upper,
        quaternion=pose.quaternion,
        mass=float(mass.GetMassAttr().Get()),
        inertia=tensor_entries(axes @ np.diag(three(mass.GetDiagonalInertiaAttr().Get())) @ axes.T),
        frictions={frictions[shape] for shape in shapes},
        joint=None if mover is None else _joint(mover, prim.GetStage().GetPrimAtPath(mover.primPath)),
    )


def _world_from(joints: dict[Sdf.Path, UsdPhysics.JointDesc], path: Sdf.Path) -> Pose:
    """Pose that the joint frames demand, every joint at zero and the root at the origin."""
    joint = joints.get(path)
    if joint is None or joint.body0.isEmpty:
        return Pose()
    return _world_from(joints, joint.body0) @ _body1_in_body0(joint)


def _body1_in_body0(joint: UsdPhysics.JointDesc) -> Pose:
    """Pose of a joint's second body in the frame of its first, the joint at zero."""
    parent_from_joint = _pose(joint.localPose0Position, joint.localPose0Orientation)
    body_from_joint = _pose(joint.localPose1Position, joint.localPose1Orientation)
    return parent_from_joint @ body_from_joint.inverse()


def _joint(joint: UsdPhysics.JointDesc, prim: Usd.Prim) -> JointFacts:
    """Row of a joint; its resistance as PhysX and Newton read it."""
    frame = _pose(joint.localPose1Position, joint.localPose1Orientation)
    axis = frame.rotation @ np.array(AXES[str(joint.axis)[-1]])
    is_hinge = joint.type == UsdPhysics.ObjectType.RevoluteJoint
    low, high = (joint.limit.lower, joint.limit.upper) if joint.limit.enabled else (-math.inf, math.inf)
    # Angles are degrees in USD.
    unit, drive = math.pi / 180 if is_hinge else 1.0, joint.drive
    stiffness, rest = (drive.stiffness / unit, drive.targetPosition * unit) if drive.enabled else (0.0, 0.0)
    damping, friction, armature = _numbers(prim, "newton:damping", "newton:friction", "newton:armature")
    return JointFacts(
        name=short_name(str(joint.primPath)),
        kind=JointKind.HINGE if is_hinge else JointKind.SLIDE,
        axis=three(axis),
        anchor=frame.position,
        range=(math.radians(low), math.radians(high)) if is_hinge else (float(low), float(high)),
        resistance=(stiffness, rest, damping / unit, friction, armature),
    )


def _numbers(prim: Usd.Prim, *names: str) -> Vec3:
    """Values of three attributes, zero where one is not set."""
    return three([float(prim.GetAttribute(name).Get() or 0.0) for name in names])


def _frictions(shapes: list[Usd.Prim]) -> dict[Usd.Prim, Vec3]:
    """(sliding, torsional, rolling) friction of each shape, by its material for physics; found at once, as `looks`."""
    bound = [material.GetPrim() for material in UsdShade.MaterialBindingAPI.ComputeBoundMaterials(shapes, "physics")[0]]
    names = ("physics:dynamicFriction", "newton:torsionalFriction", "newton:rollingFriction")
    # Of a shape without a material USD's own zeros.
    of = {material: _numbers(material, *names) if material else (0.0, 0.0, 0.0) for material in set(bound)}
    return {shape: of[material] for shape, material in zip(shapes, bound, strict=True)}


def _bounds(shape: Usd.Prim, rows: Gf.Matrix4d) -> Floats:
    """(2, 3) corners of a collider, body frame, metres; exact for every shape.

    Args:
        rows: body_from_shape, of row vectors.
    """
    matrix = np.array(rows).T  # USD multiplies row vectors
    linear, centre = matrix[:3, :3], matrix[:3, 3]
    if shape.IsA(UsdGeom.Mesh):
        points = np.array(UsdGeom.Mesh(shape).GetPointsAttr().Get(), dtype=np.float64) @ linear.T + centre
        return np.array([points.min(axis=0), points.max(axis=0)])
    # Half extents of a shape under a linear map: its support function along the axes.
    if shape.IsA(UsdGeom.Cube):
        half = np.abs(linear).sum(axis=1) * UsdGeom.Cube(shape).GetSizeAttr().Get() / 2
    elif shape.IsA(UsdGeom.Sphere):
        half = shape.GetAttribute("radius").Get() * np.sqrt((linear**2).sum(axis=1))
    else:
        turned = linear[:, COLUMNS[shape.GetAttribute("axis").Get()]]
        rod = np.abs(turned[:, 2]) * shape.GetAttribute("height").Get() / 2
        span = turned if shape.IsA(UsdGeom.Capsule) else turned[:, :2]
        half = rod + shape.GetAttribute("radius").Get() * np.sqrt((span**2).sum(axis=1))
    return np.array([centre - half, centre + half])


def _pose(position: Gf.Vec3f, orientation: Gf.Quatf) -> Pose:
    x, y, z = orientation.GetImaginary()
    return Pose(position=three(position), quaternion=(float(orientation.GetReal()), float(x), float(y), float(z)))
