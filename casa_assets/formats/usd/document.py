"""Asset -> USD package: links, joints, filtered pairs, poses as variants, and the nested layer."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdPhysics, Vt

from casa_assets.core.numeric import arc_from_z, principal_axes
from casa_assets.formats.usd import shapes
from casa_assets.formats.usd.shapes import attach_label, place, put, quatd, vec3d
from casa_assets.model.asset.asset import Asset, Base, Drive, Joint, JointKind, Link
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import CLOSED_POSE, Scene, key_positions
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3, Vec4

# <id>/
#   usd/<id>.usda
#   usd/nested/<id>.usda         the same with bodies below the bodies that carry them, if there are several
#   usd/textures/                the pictures; model.xml may refer to them here
#   usd/.thumbs/256x256/<id>.usda.png
#
# /<id>                          kind component, labels
#   /visualMaterials /physicsMaterials /physicsJoints
#   /object                      rigid body, base of the articulation if there are joints
#     /visual /collision /sites
#   /door                        rigid body, a sibling of `object`: bodies are connected by joints, not by paths

USD_FOLDER = "usd"
TEXTURES = "textures"  # inside the folder of the layer: SimReady refuses paths with `..`
# In the folder of the flat layer of an asset, where SimReady allows no second layer.
NESTED_FOLDER = "nested"
# The day on which this writer's output last changed, not the day of the run, which would make two runs over the same
# asset differ. Change it whenever the bytes that the writer makes change.
WRITER_DATE = "2026-11-22"
WRITER_VERSION = "1"
UNKNOWN = "unknown"  # SimReady refuses an empty string
# camelCase, which no joint or link id is.
JOINTS = "physicsJoints"
BASE_TO_WORLD = "baseToWorld"
# USD joints move along X, Y or Z of the joint frame. Directions that need no rounding: token, child_from_joint.
EXACT_AXES: dict[Vec3, tuple[str, Vec4]] = {
    (1.0, 0.0, 0.0): ("X", (1.0, 0.0, 0.0, 0.0)),
    (0.0, 1.0, 0.0): ("Y", (1.0, 0.0, 0.0, 0.0)),
    (0.0, 0.0, 1.0): ("Z", (1.0, 0.0, 0.0, 0.0)),
    (-1.0, 0.0, 0.0): ("X", (0.0, 0.0, 0.0, 1.0)),
    (0.0, -1.0, 0.0): ("Y", (0.0, 1.0, 0.0, 0.0)),
    (0.0, 0.0, -1.0): ("Z", (0.0, 1.0, 0.0, 0.0)),
}
VARIANT_SET = "pose"
XFORM_OPS = ("xformOp:translate", "xformOp:orient")
# Positions of the joints of an asset, by the name of a pose.
Poses = Mapping[str, Mapping[str, float]]


def write(asset: Asset, thumbnail: bytes) -> Files:
    """Return the USD package of an asset, paths relative to the asset's folder.

    Args:
        thumbnail: PNG, 256 x 256, of the asset.
    Returns:
        `usd/<id>.usda`, its thumbnail, `usd/textures/<file name>` for every picture that the layer refers to, and
        `usd/nested/<id>.usda` if there are several links.
    """
    name = f"{asset.id}.usda"
    entries = {
        f"{USD_FOLDER}/{name}": layer_text(asset).encode("utf-8"),
        f"{USD_FOLDER}/.thumbs/256x256/{name}.png": thumbnail,
    }
    if len(asset.links) > 1:
        root = Sdf.Path.absoluteRootPath.AppendChild(asset.id)
        nested = _nested_text(root, f"../{name}", [(root, asset, _named_poses(asset))])
        entries[f"{USD_FOLDER}/{NESTED_FOLDER}/{name}"] = nested.encode("utf-8")
    for look in asset.materials:
        entries |= {f"{USD_FOLDER}/{TEXTURES}/{t.file_name}": t.png for t in look.textures}
    return Files.of(entries)


def layer_text(asset: Asset, textures: str = f"./{TEXTURES}") -> str:
    """Return the root layer as usda text: the same asset gives the same text, whatever was written before.

    Args:
        textures: path from the layer to the folder of the pictures.
    """
    layer, path = Sdf.Layer.CreateAnonymous(".usda"), Sdf.Path.absoluteRootPath.AppendChild(asset.id)
    stage = Usd.Stage.Open(layer)
    root = UsdGeom.Xform.Define(stage, path).GetPrim()
    set_stage(stage, root)
    model = Usd.ModelAPI(root)
    model.SetKind(Kind.Tokens.component)
    model.SetAssetName(asset.id)
    model.SetAssetIdentifier(Sdf.AssetPath(f"./{asset.id}.usda"))
    model.SetAssetVersion(WRITER_VERSION)
    layer.customLayerData = {"SimReady_Metadata": _provenance(asset)}
    # Classes from the category upwards, the Wikidata item, and the portion of a cut object.
    attach_label(root, "class", asset.labels.classes)
    attach_label(root, "wikidata_qcode", [asset.labels.qcode.id])
    if asset.labels.portion is not None:
        attach_label(root, "portion", [asset.labels.portion.value])
    behavior = None if asset.behavior is None else asset.behavior.to_json()
    put(root, {"casa:contract": asset.contract, "casa:behavior": behavior})
    shapes.define_materials(stage, path, asset, textures)
    for link in asset.links:
        _define_body(stage, path, asset, link)
    _define_joints(stage, path, asset)
    shapes.define_sites(stage, path, asset)
    for pair in asset.exclusions:
        prim = put(stage.GetPrimAtPath(path.AppendChild(pair.first)), {}, "PhysicsFilteredPairsAPI")
        prim.GetRelationship("physics:filteredPairs").AddTarget(path.AppendChild(pair.second))
    # The layer itself has the joints at zero, but for poses of links that move: a variant is weaker than opinions of
    # the layer outside of it.
    poses = _named_poses(asset)
    if poses:
        add_variants(layer, path, VARIANT_SET, poses, CLOSED_POSE)
    for name, positions in poses.items():
        set_joints(layer, path.AppendVariantSelection(VARIANT_SET, name), asset, positions, prepared=True)
    return str(layer.ExportToString())


def set_stage(stage: Usd.Stage, root: Usd.Prim) -> None:
    """Set z up, metres, kilograms, and `root` as the default prim."""
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    stage.SetDefaultPrim(root)


def _provenance(asset: Asset) -> dict[str, object]:
    """The fields that SimReady asks for. Ref: SimReady Foundation requirement SR.004."""
    lower, upper = asset.bounds
    provenance = asset.provenance
    return {
        "asset_name": asset.id,
        "asset_type": "prop",
        "category": asset.labels.category,
        "author": provenance.author or UNKNOWN,
        "asset_license": provenance.licence or UNKNOWN,
        "source_file": provenance.path,
        "usd_date_generated": WRITER_DATE,
        "qcode": asset.labels.qcode.id,
        "rigid_body_count": len(asset.links),
        "asset_extents": Gf.Vec3f(*(float(n) for n in upper - lower)),
        "mass": asset.mass,
    }


def _define_body(stage: Usd.Stage, root: Sdf.Path, asset: Asset, link: Link) -> None:
    """Body prim with its visuals and colliders. Bodies are siblings, so the pose is asset_from_link."""
    prim = stage.DefinePrim(root.AppendChild(link.name), "Xform")
    if asset.keyframes and asset.is_moved(link.name):
        # Its poses are in the variants.
        UsdGeom.Xformable(prim).AddTranslateOp(UsdGeom.XformOp.PrecisionDouble)
        UsdGeom.Xformable(prim).AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
    else:
        place(prim, asset.asset_from_link(link.name))
    moments, axes = principal_axes(link.inertial.tensor)
    values = {
        "physics:mass": link.inertial.mass,
        "physics:centerOfMass": link.inertial.center_of_mass,
        "physics:diagonalInertia": float32_moments(moments),
        "physics:principalAxes": Gf.Quatf(*Pose.from_matrix(axes).quaternion),
    }
    put(prim, values, "PhysicsRigidBodyAPI", "PhysicsMassAPI")
    if link is asset.root and (len(asset.links) > 1 or asset.base is Base.FIXED):
        # Newton refuses joints, even fixed ones, outside an articulation. Only on the base body do SimReady, MuJoCo and
        # Newton all accept its root.
        put(prim, {}, "PhysicsArticulationRootAPI")
    shapes.define_visuals(stage, root, link)
    shapes.define_colliders(stage, root, link)


def float32_moments(moments: Vec3) -> Vec3:
    """Moments rounded to float32 that still belong to a body: none exceeds the sum of the other two.

    Rounding the moments of a flat plate, whose largest is that sum, may break this by one unit in the last place.
    """
    values = [np.float32(m) for m in moments]
    largest = max(range(3), key=lambda i: values[i])
    others = [float(values[i]) for i in range(3) if i != largest]
    while float(values[largest]) > sum(others):
        values[largest] = np.nextafter(values[largest], np.float32(0.0))
    x, y, z = (float(m) for m in values)
    return x, y, z


def _define_joints(stage: Usd.Stage, root: Sdf.Path, asset: Asset) -> None:
    """Joints of the asset below `<root>/physicsJoints`; links without a joint are fixed to their parent."""
    if len(asset.links) == 1 and asset.base is Base.FREE:
        return
    scope = UsdGeom.Scope.Define(stage, root.AppendChild(JOINTS)).GetPath()
    if asset.base is Base.FIXED:
        # To the asset's own root prim: an end without a target is at the origin of the stage, and PhysX would pull a
        # base that is placed elsewhere back to it.
        held = stage.DefinePrim(scope.AppendChild(BASE_TO_WORLD), "PhysicsFixedJoint")
        _attach(held, root, root.AppendChild(asset.root.name), asset.root.pose, Pose())
    for link in asset.links[1:]:
        assert link.parent is not None
        ends, joint = (root.AppendChild(link.parent), root.AppendChild(link.name)), asset.joint_of(link.name)
        if joint is None:
            mount = stage.DefinePrim(scope.AppendChild(f"{link.name}Mount"), "PhysicsFixedJoint")
            _attach(mount, *ends, link.pose, Pose())
            continue
        kind = "PhysicsRevoluteJoint" if joint.kind is JointKind.HINGE else "PhysicsPrismaticJoint"
        prim = stage.DefinePrim(scope.AppendChild(joint.name), kind)
        token, rotation = axis_and_rotation(joint.axis)
        _attach(prim, *ends, link.pose, Pose(position=joint.anchor, quaternion=rotation))
        put(prim, {"physics:axis": token, "casa:grip": joint.grip, "casa:behind": joint.behind})
        _set_dynamics(prim, joint)
        if asset.keyframes:
            put(prim, {}, joint_state(joint, 0.0)[0])
        # Named states: fractions of the way from closed (0) to open (1).
        states = [state for state in asset.states if state.joint == joint.name]
        if states:
            named = {s.name: {"value": s.value, "from": s.interval[0], "to": s.interval[1]} for s in states}
            prim.SetCustomDataByKey("states", named)


def axis_and_rotation(axis: Vec3) -> tuple[str, Vec4]:
    """Axis token and child_from_joint rotation that turns the token's axis onto a unit vector.

    For any direction other than the six exact ones, the token is Z and the rotation is the shortest arc.
    """
    return EXACT_AXES.get(axis) or ("Z", arc_from_z(axis))


def _attach(prim: Usd.Prim, parent: Sdf.Path, child: Sdf.Path, parent_from_child: Pose, child_from_joint: Pose) -> None:
    for number, (path, frame) in enumerate(((parent, parent_from_child @ child_from_joint), (child, child_from_joint))):
        prim.GetRelationship(f"physics:body{number}").SetTargets([path])
        rotation = Gf.Quatf(*frame.quaternion)
        put(prim, {f"physics:localPos{number}": frame.position, f"physics:localRot{number}": rotation})


def _set_dynamics(prim: Usd.Prim, joint: Joint) -> None:
    """Range, friction, damping, armature, and drive: a spring as PhysX and Newton read it, and another for MuJoCo."""
    is_hinge = joint.kind is JointKind.HINGE
    per_unit, axis = (math.pi / 180, "angular") if is_hinge else (1.0, "linear")
    drive = joint.drive or Drive(stiffness=0.0, damping=0.0)
    low, high = (math.degrees(n) if is_hinge else n for n in joint.range)
    put(prim, {"physics:lowerLimit": low, "physics:upperLimit": high})
    if joint.drive is not None:
        values = {
            "type": "force",
            "stiffness": drive.stiffness * per_unit,
            "damping": drive.damping * per_unit,
            "targetPosition": drive.target / per_unit,
        }
        put(prim, {f"drive:{axis}:physics:{name}": v for name, v in values.items()}, f"PhysicsDriveAPI:{axis}")
    springs = {
        "mjc:stiffness": drive.stiffness,
        "mjc:springref": drive.target / per_unit,
        "mjc:margin": joint.limit_margin,
    }
    values = {
        "newton:armature": joint.armature,
        "newton:damping": (joint.damping + drive.damping) * per_unit,
        "newton:friction": joint.frictionloss,
        "mjc:solimplimit": Vt.DoubleArray(joint.limit_impedance),
        "mjc:solimpfriction": Vt.DoubleArray(joint.friction_impedance) if joint.frictionloss else None,
        **(springs if joint.drive is not None else {}),
    }
    put(prim, values, "NewtonJointAPI", "MjcJointAPI")


# Poses ----------------------------------------------------------------------------------------------------------------


def _named_poses(asset: Asset) -> Poses:
    """Positions of joints in each named pose, `closed` among them if there are any."""
    if not asset.keyframes:
        return {}
    return {CLOSED_POSE: {}, **{key.name: joint_positions(key.joints) for key in asset.keyframes}}


def joint_state(joint: Joint, position: float) -> tuple[str, str, float]:
    """Applied schema of the joint state that PhysX reads, its attribute, and a position (rad or m) as it has it.

    Ref: PhysxSchema, PhysicsJointStateAPI: degrees or metres.
    """
    is_hinge = joint.kind is JointKind.HINGE
    axis = "angular" if is_hinge else "linear"
    value = math.degrees(position) if is_hinge else position
    return f"PhysicsJointStateAPI:{axis}", f"state:{axis}:physics:position", value


def set_joints(
    layer: Sdf.Layer, root: Sdf.Path, asset: Asset, positions: Mapping[str, float], prepared: bool = False
) -> None:
    """Override poses of links and states of joints below `root`.

    Args:
        positions: rad or m; joints that are not named are at zero. prepared: the layer below has ops and schemas.
    """
    for link in asset.links:
        if asset.is_moved(link.name):
            set_pose(layer, root.AppendChild(link.name), asset.asset_from_link(link.name, positions), prepared)
    for joint in asset.joints:
        spec = Sdf.CreatePrimInLayer(layer, root.AppendChild(JOINTS).AppendChild(joint.name))
        schema, attribute, position = joint_state(joint, positions.get(joint.name, 0.0))
        if not prepared:
            spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=[schema]))
        Sdf.AttributeSpec(spec, attribute, Sdf.ValueTypeNames.Float).default = position


def set_pose(layer: Sdf.Layer, path: Sdf.Path, pose: Pose | None, prepared: bool = False) -> None:
    """Write parent_from_prim over that of a layer below, and the order of its ops, which the identity has not."""
    spec, kinds = Sdf.CreatePrimInLayer(layer, path), Sdf.ValueTypeNames
    if pose is not None:
        Sdf.AttributeSpec(spec, XFORM_OPS[0], kinds.Double3).default = vec3d(pose.position)
        Sdf.AttributeSpec(spec, XFORM_OPS[1], kinds.Quatd).default = quatd(pose.quaternion)
    if not prepared:
        order = Sdf.AttributeSpec(spec, "xformOpOrder", kinds.TokenArray, Sdf.VariabilityUniform)
        order.default = list(XFORM_OPS)


def add_variants(layer: Sdf.Layer, root: Sdf.Path, name: str, options: Iterable[str], chosen: str = "") -> None:
    """Add a variant set to a prim; none is selected if none is chosen."""
    prim = layer.GetPrimAtPath(root)
    prim.variantSetNameList.prependedItems = [*prim.variantSetNameList.prependedItems, name]
    if chosen:
        prim.variantSelections[name] = chosen
    found = Sdf.VariantSetSpec(prim, name)
    for option in options:
        Sdf.VariantSpec(found, option)


# Nested ---------------------------------------------------------------------------------------------------------------
# Asset or scene -> a second layer, in which every body is below the body that carries it.
#
# The flat layer has all content, with bodies side by side, as SimReady requires. Newton and MuJoCo use trees of
# bodies. The nested layer refers to the flat one and relocates bodies: `/oven/door` becomes `/oven/object/door`, and
# everything that refers to it (joints, filters) follows. Only the pose of each body relative to its parent has to be
# written again.
#
# Needs OpenUSD 25.11: older versions do not parse bodies below bodies.


def nested_scene_text(scene: Scene, flat: str, world: str) -> str:
    """Return the nested layer of a scene as usda text, for the folder of its flat layer.

    Args:
        flat: file name of the flat layer. world: name of the prim that contains everything.
    """
    root, assets = Sdf.Path.absoluteRootPath.AppendChild(world), scene.asset_of
    copies = [(root.AppendChild(p.name), assets[p.name], key_positions(p, assets[p.name])) for p in scene.placements]
    return _nested_text(root, f"./{flat}", copies)


def nested_path(root: Sdf.Path, asset: Asset, link: str) -> Sdf.Path:
    """Path of a link below the prim of its asset: through all links that carry it."""
    parent = asset.link(link).parent
    return (root if parent is None else nested_path(root, asset, parent)).AppendChild(link)


def _nested_text(root: Sdf.Path, flat: str, copies: Iterable[tuple[Sdf.Path, Asset, Poses]]) -> str:
    """A layer that relocates the links of assets below the links that carry them, and sets their poses there.

    Args:
        root: its default prim, which refers to that of the flat layer, which selects a variant of poses.
        flat: path of the flat layer.
        copies: prim of an asset, the asset, its named poses.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda")
    top = Sdf.CreatePrimInLayer(layer, root)
    top.specifier, top.typeName = Sdf.SpecifierDef, "Xform"
    top.referenceList.prependedItems = [Sdf.Reference(flat)]
    layer.defaultPrim = root.name
    for name, value in (("upAxis", "Z"), ("metersPerUnit", 1.0), ("kilogramsPerUnit", 1.0)):
        layer.pseudoRoot.SetInfo(name, value)
    moves = []
    for prim, asset, poses in copies:
        for link in asset.links[1:]:
            path = nested_path(prim, asset, link.name)
            moves.append((prim.AppendChild(link.name), path))
            moving = poses if asset.is_moved(link.name) else {}
            set_pose(layer, path, None if moving else asset.parent_from_link(link.name))
            if moving and VARIANT_SET not in top.variantSets:
                add_variants(layer, root, VARIANT_SET, poses)
            for pose, positions in moving.items():
                variant = path.ReplacePrefix(root, root.AppendVariantSelection(VARIANT_SET, pose))
                set_pose(layer, variant, asset.parent_from_link(link.name, positions), prepared=True)
    layer.relocates = moves
    return str(layer.ExportToString())
