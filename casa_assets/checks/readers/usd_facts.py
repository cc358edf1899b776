"""USD of an asset or scene -> table of facts, by two readers that share no code: MuJoCo and UsdPhysics."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Collection, Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path, PurePosixPath

import mujoco
import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdSemantics, UsdShade

from casa_assets.checks.readers.facts import (
    ROOT_BODY,
    Cells,
    asset_table,
    body_cells,
    four,
    frame,
    joint_cells,
    look_cells,
    place_cells,
    rows,
    scene_table,
    seen_from,
    short_name,
    state_cells,
    tensor_entries,
    three,
    words_cells,
)
from casa_assets.checks.readers.mujoco_facts import Loaded, all_warnings, facts_of_model, free_bodies
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.asset import Base, JointKind
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3, Vec4

SITE = "MjcSiteAPI"
VARIANTS = "pose"
LAYER = "casa:layer"
AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
# Axis of a cylinder or capsule -> columns of its matrix, the axis last.
COLUMNS = {"X": (1, 2, 0), "Y": (2, 0, 1), "Z": (0, 1, 2)}
FRICTIONS = ("physics:dynamicFriction", "newton:torsionalFriction", "newton:rollingFriction")


def missing_importer() -> str:
    """Why MuJoCo cannot read USD here, a part of a sentence; empty where it can."""
    if find_spec("mujoco._usd") is not None:
        return ""
    return "MuJoCo's reader of USD, the package mujoco-usd, is not installed; it has no release for Python 3.14"


def imported(path: Path) -> Loaded:
    """The file compiled by way of MuJoCo's USD reader, which its XML loader does not call, with its warnings."""
    with all_warnings() as heard:
        try:
            spec = mujoco.MjSpec.from_file(str(path))
            _share_pictures(spec)
            model, error = spec.compile(), ""
        except ValueError as refusal:
            model, error = None, str(refusal)
    return Loaded(model, error, tuple(dict.fromkeys(heard)))


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


# Asset ----------------------------------------------------------------------------------------------------------------


def mujoco_facts(path: Path) -> Cells:
    """Fact table of a USD file as MuJoCo imports it. Raises ValueError where it does not."""
    loaded = imported(path)
    if loaded.model is None:
        raise ValueError(loaded.error)
    base = Base.FREE if free_bodies(loaded.model) else Base.FIXED
    read = StageReading(Usd.Stage.Open(str(path)))
    return facts_of_import(loaded.model, read) | {"base": base} | read.rest


def pxr_facts(path: Path) -> Cells:
    """Fact table of a USD file as UsdPhysics parses it; the poses of bodies follow from their joint frames.

    Raises:
        ValueError: the file has no default prim, or holds a joint that no asset has.
    """
    read = StageReading(Usd.Stage.Open(str(path)))
    return facts_of_stage(read)[0] | read.rest


class StageReading:
    """The part of the tables of both readers that OpenUSD alone reads of a stage, which nobody changes meanwhile.

    `scene`: it holds many placements. Raises ValueError where it has no default prim, or holds what no asset has.
    """

    def __init__(self, stage: Usd.Stage, scene: bool = False) -> None:
        root = stage.GetDefaultPrim()
        if not root:
            raise ValueError("there is no default prim")
        self.stage, self.places, self.looks = stage, rows(_places(stage)), rows(_looks(stage))
        self.rest = {"poses": poses(stage, scene)} | ({} if scene else words(root))
        self.placements = {
            prim.GetName(): {
                "asset": Usd.ModelAPI(prim).GetAssetName(),
                "layer": str(prim.GetAttribute(LAYER).Get() or ""),
                **words(prim),
            }
            for prim in (root.GetChildren() if scene else ())
            if prim.GetPrimAtPath(ROOT_BODY)
        }

    def scene(self, things: Cells, gravity: Vec3, roots: Mapping[str, Cells], welded: Collection[str]) -> Cells:
        """Table of the scene.

        Args:
            things: of all placements, as one of the readers has them, like `gravity`.
            roots: names of placements, and of other bodies -> world_from_root.
            welded: placements that are fixed to the world.
        Raises:
            ValueError: physics knows nothing of a placement.
        """
        if lost := [name for name in self.placements if name not in roots]:
            raise ValueError(f"placement {lost[0]!r} has no body {ROOT_BODY!r}")
        placements = [
            (name, {**cells, "base": Base.FIXED if name in welded else Base.FREE, **roots[name]})
            for name, cells in self.placements.items()
        ]
        # Distant lights and balls: the dome belongs to all of the scene.
        cache, prims = UsdGeom.XformCache(), list(self.stage.Traverse())
        lamps = [prim for prim in prims if prim.IsA(UsdLux.DistantLight) or prim.IsA(UsdLux.SphereLight)]
        lights = [(prim.GetName(), _light(prim, cache)) for prim in lamps]
        cameras = [(prim.GetName(), _camera(prim, cache)) for prim in prims if prim.IsA(UsdGeom.Camera)]
        return scene_table(gravity, placements, cameras, lights, things | self.rest)


def facts_of_import(model: mujoco.MjModel, read: StageReading) -> Cells:
    """Fact table of a stage as MuJoCo imported it, without poses and words."""
    table = facts_of_model(model)
    # MuJoCo leaves the colours of sites, most of what a surface is, and the variants of USD out; OpenUSD reads them.
    places = {
        name: place | {"color": read.places.get(name, {}).get("color")} for name, place in table["places"].items()
    }
    return table | {"places": places, "looks": read.looks}


def facts_of_stage(read: StageReading) -> tuple[Cells, dict[str, Pose]]:
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
    table = asset_table(
        base=Base.FIXED if welded else Base.FREE,
        words={},
        exclusions=filtered,
        bodies=[
            (short_name(str(p)), _body(stage.GetPrimAtPath(p), below[p], joints, movers.get(p), cache, frictions))
            for p in links
        ],
        places=read.places.items(),
        looks=read.looks.items(),
        poses=(),
    )
    return table, welded


def _body(
    prim: Usd.Prim,
    shapes: list[Usd.Prim],
    joints: dict[Sdf.Path, UsdPhysics.JointDesc],
    mover: UsdPhysics.JointDesc | None,
    cache: UsdGeom.XformCache,
    frictions: dict[Usd.Prim, Vec3],
) -> Cells:
    """Row of a body.

    Args:
        shapes: its colliders. joints: path of a body -> the joint that ties it to its parent or the world. mover: the
            joint that moves it. frictions: of each collider.
    """
    path, mass = prim.GetPath(), UsdPhysics.MassAPI(prim)
    axes = _pose(Gf.Vec3f(0), mass.GetPrincipalAxesAttr().Get()).rotation
    body_from_world = cache.GetLocalToWorldTransform(prim).GetInverse()
    up = joints.get(path)
    return body_cells(
        parent=short_name(str(up.body0)) if up is not None and not up.body0.isEmpty else "",
        place=_world_from(joints, path),
        mass=float(mass.GetMassAttr().Get()),
        center_of_mass=three(mass.GetCenterOfMassAttr().Get()),
        inertia=tensor_entries(axes @ np.diag(three(mass.GetDiagonalInertiaAttr().Get())) @ axes.T),
        colliders=len(shapes),
        boxes=[_bounds(s, cache.GetLocalToWorldTransform(s) * body_from_world) for s in shapes],
        frictions=[frictions[shape] for shape in shapes],
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


def _joint(joint: UsdPhysics.JointDesc, prim: Usd.Prim) -> Cells:
    """Row of a joint; its resistance as PhysX and Newton read it."""
    at = _pose(joint.localPose1Position, joint.localPose1Orientation)
    axis = at.rotation @ np.array(AXES[str(joint.axis)[-1]])
    is_hinge = joint.type == UsdPhysics.ObjectType.RevoluteJoint
    low, high = (joint.limit.lower, joint.limit.upper) if joint.limit.enabled else (-math.inf, math.inf)
    # Angles are degrees in USD.
    unit, drive = math.pi / 180 if is_hinge else 1.0, joint.drive
    stiffness, rest = (drive.stiffness / unit, drive.targetPosition * unit) if drive.enabled else (0.0, 0.0)
    damping, friction, armature = _numbers(prim, ("newton:damping", "newton:friction", "newton:armature"))
    return joint_cells(
        short_name(str(joint.primPath)),
        JointKind.HINGE if is_hinge else JointKind.SLIDE,
        three(axis),
        at.position,
        (math.radians(low), math.radians(high)) if is_hinge else (low, high),
        (stiffness, rest, damping / unit, friction, armature),
    )


def _numbers(prim: Usd.Prim, names: tuple[str, ...]) -> Vec3:
    """Values of three attributes, zero where one is not set."""
    return three([float(prim.GetAttribute(name).Get() or 0.0) for name in names])


def _frictions(shapes: list[Usd.Prim]) -> dict[Usd.Prim, Vec3]:
    """(sliding, torsional, rolling) friction of each shape, by its material for physics; found at once, as `_looks`."""
    bound = [material.GetPrim() for material in UsdShade.MaterialBindingAPI.ComputeBoundMaterials(shapes, "physics")[0]]
    # Of a shape without a material USD's own zeros.
    of = {material: _numbers(material, FRICTIONS) if material else (0.0, 0.0, 0.0) for material in set(bound)}
    return {shape: of[material] for shape, material in zip(shapes, bound, strict=True)}


def _bounds(shape: Usd.Prim, body_from_shape: Gf.Matrix4d) -> Floats:
    """(2, 3) corners of a collider, body frame, metres; exact for every shape; `body_from_shape`: of row vectors."""
    matrix = np.array(body_from_shape).T  # USD multiplies row vectors
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
    return Pose(position=three(position), quaternion=four((orientation.GetReal(), *orientation.GetImaginary())))


def rigid(matrix: Gf.Matrix4d) -> Cells:
    """Position and quaternion of a matrix of row vectors, without its scale. Raises ValueError: it is no rotation."""
    axes = Gf.Matrix3d(*(number for i in range(3) for number in matrix.GetRow3(i).GetNormalized()))
    if not Gf.IsClose(axes * axes.GetTranspose(), Gf.Matrix3d(1), 1e-6) or axes.GetDeterminant() < 0:
        raise ValueError("matrix is not a proper rotation")
    turn = Gf.Matrix4d(axes, Gf.Vec3d(0)).ExtractRotationQuat()
    position = three(number + 0.0 for number in matrix.ExtractTranslation())
    return {"position": position, "quaternion": four((turn.GetReal(), *turn.GetImaginary()))}


# Words, poses, places and looks ---------------------------------------------------------------------------------------


def words(root: Usd.Prim) -> Cells:
    """Classes and labels, states, grips, contract and behaviour of the asset at a prim."""
    prims = list(Usd.PrimRange(root))
    joints = [prim for prim in prims if prim.IsA(UsdPhysics.Joint)]
    names = {prim.GetName() for prim in prims}
    behavior = _text(root, "casa:behavior")
    grips, behind = (
        [(joint.GetName(), _text(joint, name)) for joint in joints] for name in ("casa:grip", "casa:behind")
    )
    states = [(joint, joint.GetCustomDataByKey("states") or {}) for joint in joints]
    return words_cells(
        classes=_labels(root, "class"),
        portion=" ".join(_labels(root, "portion")),
        labels=[(p.GetName(), label) for p in prims if p.IsA(UsdGeom.Gprim) for label in _labels(p, "part")],
        # Names of prims that there are.
        grips=[(joint, target) for joint, target in grips if target in names],
        behind=[(joint, target) for joint, target in behind if target in names],
        contract=_text(root, "casa:contract"),
        behavior=hashlib.sha256(behavior.encode()).hexdigest() if behavior else "",
        states=[
            (name, state_cells(joint.GetName(), state["value"], state["from"], state["to"]))
            for joint, named in states
            for name, state in named.items()
        ],
    )


def _labels(prim: Usd.Prim, taxonomy: str) -> tuple[str, ...]:
    if not prim.HasAPI(UsdSemantics.LabelsAPI, taxonomy):
        return ()
    return tuple(UsdSemantics.LabelsAPI(prim, taxonomy).GetLabelsAttr().Get() or ())


def _text(prim: Usd.Prim, name: str) -> str:
    return str(prim.GetAttribute(name).Get() or "")


def poses(stage: Usd.Stage, scene: bool = False) -> Cells:
    """Poses of the bodies in each variant of `pose`. The stage is left as it was.

    Args:
        stage: with the variants on its default prim.
        scene: whether it holds many placements; then poses are world_from_body, else root_from_body.
    """
    variants, found = stage.GetDefaultPrim().GetVariantSet(VARIANTS), {}
    bodies = sorted(p.GetPath() for p in stage.Traverse() if p.HasAPI(UsdPhysics.RigidBodyAPI))
    # In the session layer, which is no part of the file.
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        for name in sorted(variants.GetVariantNames()):
            # A variant that is selected already is left: each selection composes the whole stage again.
            if variants.GetVariantSelection() != name:
                variants.SetVariantSelection(name)
            cache = UsdGeom.XformCache()
            frames = rows(
                (short_name(str(path)), rigid(cache.GetLocalToWorldTransform(stage.GetPrimAtPath(path))))
                for path in bodies
            )
            found[name] = frames if scene else seen_from(ROOT_BODY, frames)
        variants.ClearVariantSelection()
    return found


def _places(stage: Usd.Stage) -> Iterator[tuple[str, Cells]]:
    """Prims that are sites; those without their own colour are regions.

    Raises:
        ValueError: one is neither sphere, cube nor cylinder about z.
    """
    cache = UsdGeom.XformCache()
    for prim in stage.Traverse():
        # As written: GetAppliedSchemas knows the schemas of MuJoCo only where its reader of USD is installed.
        if SITE not in prim.GetPrimTypeInfo().GetAppliedAPISchemas():
            continue
        # Places lie two levels below their body.
        body = prim.GetParent().GetParent()
        # body_from_place with its scale
        matrix = cache.GetLocalToWorldTransform(prim) * cache.GetLocalToWorldTransform(body).GetInverse()
        (kind, own), gprim = _volume(prim), UsdGeom.Gprim(prim)
        size = [float(matrix.GetRow3(i).GetLength() * own[i]) for i in range(3)]
        # A region defines no colour itself.
        colors, alphas = gprim.GetDisplayColorAttr().Get(), gprim.GetDisplayOpacityAttr().Get()
        color = (*three(colors[0]), float(alphas[0])) if colors and alphas else None
        name, link = short_name(str(prim.GetPath())), short_name(str(body.GetPath()))
        yield name, place_cells(link, kind, rigid(matrix), size, color)


def _volume(prim: Usd.Prim) -> tuple[str, Vec3]:
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


def _looks(stage: Usd.Stage) -> Iterator[tuple[str, Cells]]:
    """Meshes that physics does not touch, in the material that they are bound to.

    Raises:
        ValueError: one has no surface to be seen.
    """
    meshes = [p for p in stage.Traverse() if p.IsA(UsdGeom.Mesh) and not p.HasAPI(UsdPhysics.CollisionAPI)]
    # A site is no mesh, so what is left is seen. Materials of all of them are found at once, which shares what they
    # inherit.
    materials = UsdShade.MaterialBindingAPI.ComputeBoundMaterials(meshes)[0]
    surfaces: dict[Usd.Prim, Cells] = {}
    for prim, material in zip(meshes, materials, strict=True):
        bound = material.GetPrim()
        if bound not in surfaces:
            surfaces[bound] = _surface(prim, material)
        yield short_name(str(prim.GetPath())), surfaces[bound]


def _surface(prim: Usd.Prim, material: UsdShade.Material) -> Cells:
    """Colour, light that it gives off and picture of a material; `prim` is bound to it."""
    shader = material.ComputeSurfaceSource()[0] if material else None
    if not shader:
        raise ValueError(f"{prim.GetName()!r} has no surface")
    node = _node(shader, "diffuseColor")
    picture = PurePosixPath(node.GetInput("file").Get().path).name if node is not None else ""
    color = (*_value(shader, "diffuseColor")[:3], _value(shader, "opacity")[3])
    return look_cells(color, _value(shader, "emissiveColor")[:3], picture)


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


# Scene ----------------------------------------------------------------------------------------------------------------


def facts_of_scene_import(model: mujoco.MjModel, read: StageReading) -> Cells:
    """The table of the stage of a scene and of what MuJoCo imported from it."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    names = {short_name(model.body(i).name): i for i in range(1, model.nbody)}
    roots = {n: {"position": three(data.xpos[b]), "quaternion": four(data.xquat[b])} for n, b in names.items()}
    welded = names.keys() - {short_name(model.body(body).name) for body in free_bodies(model)}
    return read.scene(facts_of_import(model, read), three(model.opt.gravity), roots, welded)


def facts_of_scene_stage(read: StageReading) -> Cells:
    """The table of the stage of a scene as UsdPhysics parses it. Raises ValueError where it holds what no scene has."""
    things, welded = facts_of_stage(read)
    cache, prims = UsdGeom.XformCache(), list(read.stage.Traverse())
    bodies = [prim for prim in prims if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    roots = {short_name(str(prim.GetPath())): rigid(cache.GetLocalToWorldTransform(prim)) for prim in bodies}
    scenes = [UsdPhysics.Scene(prim) for prim in prims if prim.IsA(UsdPhysics.Scene)]
    if len(scenes) != 1:
        raise ValueError(f"there are {len(scenes)} physics scenes, not one")
    strength = float(scenes[0].GetGravityMagnitudeAttr().Get())
    gravity = np.array(scenes[0].GetGravityDirectionAttr().Get(), dtype=np.float64) * strength
    held = {name: frame(pose) for name, pose in welded.items()}
    return read.scene(things, three(gravity), roots | held, welded)


def _camera(prim: Usd.Prim, cache: UsdGeom.XformCache) -> Cells:
    lens = UsdGeom.Camera(prim)
    high, focal = lens.GetVerticalApertureAttr().Get(), lens.GetFocalLengthAttr().Get()
    fov = math.degrees(2 * math.atan(high / 2 / focal))
    return {**rigid(cache.GetLocalToWorldTransform(prim)), "fov_y_deg": fov}


def _light(prim: Usd.Prim, cache: UsdGeom.XformCache) -> Cells:
    shaping = UsdLux.ShapingAPI(prim) if prim.HasAPI(UsdLux.ShapingAPI) else None
    kind = "directional" if prim.IsA(UsdLux.DistantLight) else "point" if shaping is None else "spot"
    pose = Pose(**rigid(cache.GetLocalToWorldTransform(prim)))
    color = np.array(UsdLux.LightAPI(prim).GetColorAttr().Get(), dtype=np.float64)
    return {
        "kind": kind,
        "castshadow": bool(UsdLux.ShadowAPI(prim).GetShadowEnableAttr().Get()),
        "position": pose.position,
        # Lights of USD shine along their -z.
        "direction": three(np.zeros(3) if kind == "point" else -pose.rotation[:, 2]),
        "tint": three(color / max(float(color.max()), 1e-12)),
        "cone_deg": float(shaping.GetShapingConeAngleAttr().Get()) if shaping is not None else 0.0,
    }
