"""Asset -> USD package: links, joints, filtered pairs, poses as variants, and the nested layer."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
import numpy.typing as npt
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdPhysics

from casa_assets.formats.usd import number, shapes
from casa_assets.formats.usd.joint import SCOPE, attach_labels, define_behavior, define_joints
from casa_assets.formats.usd.shapes import MaterialPrims
from casa_assets.model.asset.asset import Asset, Base, Joint, JointKind, Link
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import CLOSED_POSE, Scene, key_positions
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

# Contact --------------------------------------------------------------------------------------------------------------


def filter_pair(layer: Sdf.Layer, first: Sdf.Path, second: Sdf.Path) -> None:
    """Filter the contacts of two bodies of referenced assets, in addition to the assets' own filters."""
    spec = Sdf.CreatePrimInLayer(layer, first)
    if not spec.HasInfo("apiSchemas"):
        spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["PhysicsFilteredPairsAPI"]))
    path = first.AppendProperty("physics:filteredPairs")
    pairs = layer.GetRelationshipAtPath(path) or Sdf.RelationshipSpec(spec, "physics:filteredPairs", custom=False)
    pairs.targetPathList.prependedItems = [*pairs.targetPathList.prependedItems, second]


# Keyframe -------------------------------------------------------------------------------------------------------------
# Keyframe -> variant of the root prim: link poses and joint states.

VARIANT_SET = "pose"
XFORM_OPS = ("xformOp:translate", "xformOp:orient")


def define_poses(stage: Usd.Stage, root: Usd.Prim, asset: Asset) -> None:
    """Add the variant set `pose`, with `closed` selected; the layer itself has the joints at zero.

    A variant is weaker than opinions of the layer outside of it, so poses of links that move are only set in variants.
    """
    if not asset.keyframes:
        return
    variants = root.GetVariantSets().AddVariantSet(VARIANT_SET)
    poses = {CLOSED_POSE: {}, **{key.name: joint_positions(key.joints) for key in asset.keyframes}}
    moving, scope = [link.name for link in asset.links if asset.is_moved(link.name)], root.GetPath().AppendChild(SCOPE)
    # Outside of the variants: xform ops without values, and the schema of joint states.
    for link in moving:
        xform = UsdGeom.Xformable(stage.GetPrimAtPath(root.GetPath().AppendChild(link)))
        xform.ClearXformOpOrder()
        for op in XFORM_OPS:
            xform.GetPrim().RemoveProperty(op)
        xform.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble)
        xform.AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
    for joint in asset.joints:
        stage.GetPrimAtPath(scope.AppendChild(joint.name)).AddAppliedSchema(state_schema(joint))
    for name, positions in poses.items():
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            for link in moving:
                prim = stage.OverridePrim(root.GetPath().AppendChild(link))
                pose = asset.asset_from_link(link, positions)
                prim.GetAttribute(XFORM_OPS[0]).Set(number.vec3d(pose.position))
                prim.GetAttribute(XFORM_OPS[1]).Set(number.quatd(pose.quaternion))
            for joint in asset.joints:
                prim = stage.OverridePrim(scope.AppendChild(joint.name))
                name, position = state_attribute(joint), state_position(joint, positions.get(joint.name, 0.0))
                prim.CreateAttribute(name, Sdf.ValueTypeNames.Float, custom=False).Set(position)
    variants.SetVariantSelection(CLOSED_POSE)


def state_schema(joint: Joint) -> str:
    """Applied schema of the joint state that PhysX reads. Ref: PhysxSchema, PhysicsJointStateAPI."""
    return f"PhysicsJointStateAPI:{_axis(joint)}"


def state_attribute(joint: Joint) -> str:
    """Attribute of the position in that schema."""
    return f"state:{_axis(joint)}:physics:position"


def state_position(joint: Joint, position: float) -> float:
    """Joint position (rad or m) in the units of that schema: degrees or metres."""
    return math.degrees(position) if joint.kind is JointKind.HINGE else position


def _axis(joint: Joint) -> str:
    return "angular" if joint.kind is JointKind.HINGE else "linear"


# Body -----------------------------------------------------------------------------------------------------------------
# Link -> rigid body prim with explicit mass properties.

JACOBI_SWEEPS = 16  # Jacobi on 3x3 converges quadratically; six sweeps reach the last bit


def define_body(stage: Usd.Stage, path: Sdf.Path, asset: Asset, link: Link, materials: MaterialPrims) -> Usd.Prim:
    """Body prim at `path` with its visuals and colliders. Bodies are siblings, so the pose is asset_from_link."""
    prim = UsdGeom.Xform.Define(stage, path).GetPrim()
    number.place(prim, asset.asset_from_link(link.name))
    UsdPhysics.RigidBodyAPI.Apply(prim)
    moments, axes = principal_axes(link.inertial.tensor)
    mass = UsdPhysics.MassAPI.Apply(prim)
    mass.CreateMassAttr(link.inertial.mass)
    mass.CreateCenterOfMassAttr(number.vec3f(link.inertial.center_of_mass))
    mass.CreateDiagonalInertiaAttr(number.vec3f(float32_moments(moments)))
    mass.CreatePrincipalAxesAttr(number.quatf(axes.quaternion))
    if link is asset.root and (len(asset.links) > 1 or asset.base is Base.FIXED):
        # Newton refuses joints, even fixed ones, outside an articulation. Only on the base body do SimReady, MuJoCo and
        # Newton all accept its root.
        UsdPhysics.ArticulationRootAPI.Apply(prim)
    shapes.define_visuals(stage, path, link, materials)
    shapes.define_colliders(stage, path, link, materials)
    return prim


def principal_axes(tensor: npt.NDArray[np.float64]) -> tuple[Vec3, Pose]:
    """Moments and axes of a symmetric tensor by cyclic Jacobi rotations.

    LAPACK is not used: its last bits depend on the processor, and its axes flip if moments are equal. Rotations compose
    to a proper rotation, and a tensor that is already diagonal keeps its axes and their order.

    Args:
        tensor: (3, 3) symmetric, kg*m^2.
    Returns:
        Moments along the axes, and body_from_principal as a pose without translation.
    """
    a = [[float(tensor[i, j]) for j in range(3)] for i in range(3)]
    v = [[float(i == j) for j in range(3)] for i in range(3)]
    for _ in range(JACOBI_SWEEPS):
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if abs(a[p][q]) <= 1e-18 * (abs(a[p][p]) + abs(a[q][q])):
                a[p][q] = a[q][p] = 0.0
                continue
            # Ref: Golub and Van Loan, Matrix Computations, algorithm 8.4.1: the smaller of the two angles.
            tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q])
            t = math.copysign(1.0, tau) / (abs(tau) + math.sqrt(1.0 + tau * tau))
            c = 1.0 / math.sqrt(1.0 + t * t)
            s = t * c
            for k in range(3):
                a[k][p], a[k][q] = c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]
            for k in range(3):
                a[p][k], a[q][k] = c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]
            for k in range(3):
                v[k][p], v[k][q] = c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]
    return (a[0][0], a[1][1], a[2][2]), Pose.from_matrix(np.array(v))


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


# Nested ---------------------------------------------------------------------------------------------------------------
# Asset or scene -> a second layer, in which every body is below the body that carries it.
#
# The flat layer has all content, with bodies side by side, as SimReady requires. Newton and MuJoCo use trees of
# bodies. The nested layer refers to the flat one and relocates bodies: `/oven/door` becomes `/oven/object/door`, and
# everything that refers to it (joints, filters) follows. Only the pose of each body relative to its parent has to be
# written again.
#
# Needs OpenUSD 25.11: older versions do not parse bodies below bodies.

# In the folder of the flat layer of an asset, where SimReady allows no second layer.
NESTED_FOLDER = "nested"
# Positions of the joints of an asset, by the name of a pose.
Poses = Mapping[str, Mapping[str, float]]


def asset_text(asset: Asset) -> str:
    """Return the nested layer of an asset with several links as usda text, for `FOLDER` next to the flat layer."""
    root = Sdf.Path.absoluteRootPath.AppendChild(asset.id)
    layer = _layer(root, f"../{asset.id}.usda")
    poses: Poses = {CLOSED_POSE: {}, **{key.name: joint_positions(key.joints) for key in asset.keyframes}}
    _nest(layer, root, [(root, asset, poses if asset.keyframes else {})])
    text: str = layer.ExportToString()
    return text


def scene_text(scene: Scene, flat: str, world: str) -> str:
    """Return the nested layer of a scene as usda text, for the folder of its flat layer.

    Args:
        scene: the scene of the flat layer.
        flat: file name of the flat layer.
        world: name of the prim that contains everything.
    """
    root = Sdf.Path.absoluteRootPath.AppendChild(world)
    layer = _layer(root, f"./{flat}")
    assets = scene.asset_of
    copies = [(root.AppendChild(p.name), assets[p.name], key_positions(p, assets[p.name])) for p in scene.placements]
    _nest(layer, root, copies)
    text: str = layer.ExportToString()
    return text


def nested_path(root: Sdf.Path, asset: Asset, link: str) -> Sdf.Path:
    """Path of a link below the prim of its asset: through all links that carry it."""
    parent = asset.link(link).parent
    return (root if parent is None else nested_path(root, asset, parent)).AppendChild(link)


def _layer(root: Sdf.Path, flat: str) -> Sdf.Layer:
    """A layer whose default prim refers to that of the flat one, in the same units and axes."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    prim = Sdf.CreatePrimInLayer(layer, root)
    prim.specifier, prim.typeName = Sdf.SpecifierDef, "Xform"
    prim.referenceList.prependedItems = [Sdf.Reference(flat)]
    layer.defaultPrim = root.name
    for name, value in (("upAxis", "Z"), ("metersPerUnit", 1.0), ("kilogramsPerUnit", 1.0)):
        layer.pseudoRoot.SetInfo(name, value)
    return layer


def _nest(layer: Sdf.Layer, root: Sdf.Path, copies: Iterable[tuple[Sdf.Path, Asset, Poses]]) -> None:
    """Relocate the links of assets below the links that carry them, and set their poses there.

    Args:
        layer: layer that refers to the flat one.
        root: the prim that has the variants of poses.
        copies: prim of an asset, the asset, its named poses.
    """
    moves = []
    for prim, asset, poses in copies:
        for link in asset.links[1:]:
            path = nested_path(prim, asset, link.name)
            moves.append((prim.AppendChild(link.name), path))
            spec = Sdf.CreatePrimInLayer(layer, path)
            write_ops(spec)
            if not poses or not asset.is_moved(link.name):
                write_pose(spec, asset.parent_from_link(link.name))
                continue
            for pose, positions in poses.items():
                variant = _variant(layer, root, pose)
                spec = Sdf.CreatePrimInLayer(layer, path.ReplacePrefix(root, variant))
                write_pose(spec, asset.parent_from_link(link.name, positions))
    layer.relocates = moves


def _variant(layer: Sdf.Layer, root: Sdf.Path, pose: str) -> Sdf.Path:
    """Return the path of a variant of `pose`, created if missing; the flat layer selects the variant."""
    prim = layer.GetPrimAtPath(root)
    if VARIANT_SET not in prim.variantSets:
        prim.variantSetNameList.prependedItems = [VARIANT_SET]
        Sdf.VariantSetSpec(prim, VARIANT_SET)
    found = prim.variantSets[VARIANT_SET]
    if pose not in found.variants:
        Sdf.VariantSpec(found, pose)
    return root.AppendVariantSelection(VARIANT_SET, pose)


def write_pose(spec: Sdf.PrimSpec, pose: Pose) -> None:
    """Write parent_from_prim over that of a layer below."""
    translate, orient = XFORM_OPS
    Sdf.AttributeSpec(spec, translate, Sdf.ValueTypeNames.Double3).default = number.vec3d(pose.position)
    Sdf.AttributeSpec(spec, orient, Sdf.ValueTypeNames.Quatd).default = number.quatd(pose.quaternion)


def write_ops(spec: Sdf.PrimSpec) -> None:
    """Write the order of the xform ops: where the pose in the layer below is the identity, it has none."""
    order = Sdf.AttributeSpec(spec, "xformOpOrder", Sdf.ValueTypeNames.TokenArray, Sdf.VariabilityUniform)
    order.default = list(XFORM_OPS)


# Document -------------------------------------------------------------------------------------------------------------
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
# The day on which this writer's output last changed, not the day of the run, which would make two runs over the same
# asset differ. Change it whenever the bytes that the writer makes change.
WRITER_DATE = "2026-11-22"
WRITER_VERSION = "1"
UNKNOWN = "unknown"  # SimReady refuses an empty string


def write(asset: Asset, thumbnail: bytes) -> Files:
    """Return the USD package of an asset, paths relative to the asset's folder.

    Args:
        asset: the asset.
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
        entries[f"{USD_FOLDER}/{NESTED_FOLDER}/{name}"] = asset_text(asset).encode("utf-8")
    for look in asset.materials:
        entries |= {f"{USD_FOLDER}/{TEXTURES}/{t.file_name}": t.png for t in look.textures}
    return Files.of(entries)


def layer_text(asset: Asset, textures: str = f"./{TEXTURES}") -> str:
    """Return the root layer as usda text: the same asset gives the same text, whatever was written before.

    Args:
        asset: the asset.
        textures: path from the layer to the folder of the pictures.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    root = UsdGeom.Xform.Define(stage, Sdf.Path.absoluteRootPath.AppendChild(asset.id)).GetPrim()
    path = root.GetPath()
    set_stage(stage, root)
    model = Usd.ModelAPI(root)
    model.SetKind(Kind.Tokens.component)
    model.SetAssetName(asset.id)
    model.SetAssetIdentifier(Sdf.AssetPath(f"./{asset.id}.usda"))
    model.SetAssetVersion(WRITER_VERSION)
    layer.customLayerData = {"SimReady_Metadata": _provenance(asset)}
    attach_labels(root, asset)
    materials = shapes.define_materials(stage, path, asset, textures)
    for link in asset.links:
        define_body(stage, path.AppendChild(link.name), asset, link, materials)
    define_joints(stage, path, asset)
    shapes.define_sites(stage, path, asset)
    for pair in asset.exclusions:
        api = UsdPhysics.FilteredPairsAPI.Apply(stage.GetPrimAtPath(path.AppendChild(pair.first)))
        api.CreateFilteredPairsRel().AddTarget(path.AppendChild(pair.second))
    define_behavior(stage, root, asset)
    define_poses(stage, root, asset)
    text: str = layer.ExportToString()
    return text


def set_stage(stage: Usd.Stage, root: Usd.Prim) -> None:
    """Set z up, metres, kilograms, and `root` as the default prim."""
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    stage.SetDefaultPrim(root)


def _provenance(asset: Asset) -> dict[str, object]:
    """The fields that SimReady asks for, with the asset's own values.

    Ref: SimReady Foundation requirement SR.004.
    """
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
