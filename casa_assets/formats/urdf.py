"""Asset -> URDF with its meshes and a JSON of what URDF cannot say; Scene -> scene.urdf and scene.json.

In URDF the axis of a joint passes through the origin of the link that it moves. So the frame of a URDF link is at the
anchor of its joint, and the content of the link is shifted accordingly; if the anchor is zero, both frames are equal.
"""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass
from typing import Any

from lxml import etree

from casa_assets.formats.mjcf import shapes
from casa_assets.formats.mjcf.document import full_inertia
from casa_assets.formats.mjcf.kitchen import world_from_root
from casa_assets.formats.mjcf.shapes import MESHES, MeshUse, mesh_uses, obj_text
from casa_assets.formats.values import number, numbers, rounded, srgb
from casa_assets.model.asset.asset import Asset, Base, Collider, Joint, JointKind, Link, Region, Site
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Shape, Sphere, joint_positions
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import WORLD, PlacedLink, Placement, Scene
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

# Below this cosine of the pitch, roll and yaw turn about one axis; the roll is then zero.
GIMBAL_LOCK = 1e-12


def add_origin(element: etree._Element, pose: Pose) -> None:
    """`<origin>` of parent_from_element below `element`."""
    attributes = {"xyz": numbers(pose.position), "rpy": numbers(roll_pitch_yaw(pose))}
    etree.SubElement(element, "origin", attributes)


def roll_pitch_yaw(pose: Pose) -> Vec3:
    """Angles about the fixed axes x, y, z, applied in this order, radians; the pitch is in -pi/2..pi/2.

    The yaw is computed from the rotation that remains after the roll, so that the three angles reproduce the rotation
    near a pitch of 90 degrees too.
    """
    r = [[float(v) for v in row] for row in pose.rotation]
    across = math.hypot(r[0][0], r[1][0])
    roll = math.atan2(r[2][1], r[2][2]) if across > GIMBAL_LOCK else 0.0
    c, s = math.cos(roll), math.sin(roll)
    return roll, math.atan2(-r[2][0], across), math.atan2(s * r[0][2] - c * r[0][1], c * r[1][1] - s * r[1][2])


# Material -------------------------------------------------------------------------------------------------------------
# Material -> MTL file next to the meshes, and `<material>` if it has a plain colour only.
#
# A `<material>` overrides the material in a mesh file, and few programs read a `<texture>` in it. So a visual with a
# picture has no `<material>`: the MTL file names the picture. The picture is in the folder of the MTL file, since
# trimesh ignores pictures in other folders.


def mtl_name(material: Material) -> str:
    """`<id>_<digest>.mtl`: the same material twice is one file."""
    return f"{material.id}_{material.digest[:12]}.mtl"


def mtl_text(material: Material) -> bytes:
    """MTL text: colour and emitted light as display values, opacity, roughness and metallic, and the picture."""
    lines = [
        f"newmtl {material.id}",
        f"Kd {srgb(material.base_color[:3])}",
        f"Ke {srgb([material.glow * c for c in material.base_color[:3]])}",
        f"d {number(material.base_color[3])}",
        f"Pr {number(material.roughness)}",
        f"Pm {number(material.metallic)}",
    ]
    if material.base_color_texture is not None:
        lines.append(f"map_Kd {material.base_color_texture.file_name}")
    return ("\n".join(lines) + "\n").encode("ascii")


# Visual ---------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Meshes:
    """Mesh files of an asset.

    Attributes:
        of: name of a visual or collider -> path of its OBJ file, relative to the URDF.
        entries: path -> bytes of every OBJ, MTL and PNG file.
    """

    of: dict[str, str]
    entries: dict[str, bytes]


def add_mesh(element: etree._Element, path: str) -> None:
    """`<geometry>` with a mesh in metres."""
    etree.SubElement(etree.SubElement(element, "geometry"), "mesh", {"filename": path})


def gather_meshes(asset: Asset) -> Meshes:
    """Files of every visual and of every collider that is a mesh; equal ones share a file."""
    looks = {item.id: item for item in asset.materials}
    shown = {visual.name: looks[visual.material] for link in asset.links for visual in link.visuals}
    of: dict[str, str] = {}
    by_content: dict[str, str] = {}
    entries = {f"{MESHES}/{image.file_name}": image.png for image in shapes.texture_files(asset).values()}
    for name, mesh, use in mesh_uses(asset):
        data = obj_text(mesh, bare=use is MeshUse.HULL)
        if name in shown:
            look = shown[name]
            entries[f"{MESHES}/{mtl_name(look)}"] = mtl_text(look)
            data = f"mtllib {mtl_name(look)}\nusemtl {look.id}\n".encode("ascii") + data
        content = hashlib.sha256(data).hexdigest()
        of[name] = by_content.setdefault(content, f"{MESHES}/{name}_{content[:12]}.obj")
        entries[of[name]] = data
    return Meshes(of, entries)


# Collider -------------------------------------------------------------------------------------------------------------
# Collider -> `<collision>`; URDF has no capsule, so it becomes a cylinder with a sphere at each end.

# Between the name of a capsule and the number of the sphere at one of its ends; no name of ours holds it.
END_MARK = "__end"


def add_colliders(
    link: etree._Element, collider: Collider, meshes: Meshes, urdf_from_link: Pose, prefix: str = ""
) -> None:
    """Every `<collision>` of a collider below `<link>`; their names begin with `prefix`."""
    shape, pose = collider.shape, collider.pose
    elements: list[tuple[str, Shape, Pose]] = [(collider.name, shape, pose)]
    if isinstance(shape, Capsule):
        elements = [(collider.name, Cylinder(radius=shape.radius, height=shape.height), pose)]
        for end, z in enumerate((-shape.height / 2, shape.height / 2)):
            ball, at = Sphere(radius=shape.radius), pose @ Pose(position=(0.0, 0.0, z))
            elements.append((f"{collider.name}{END_MARK}{end}", ball, at))
    for name, part, link_from_part in elements:
        element = etree.SubElement(link, "collision", {"name": prefix + name})
        add_origin(element, urdf_from_link @ link_from_part)
        if isinstance(part, Box):
            size = {"size": numbers(part.size)}
        elif isinstance(part, Sphere):
            size = {"radius": number(part.radius)}
        elif isinstance(part, Cylinder):
            size = {"radius": number(part.radius), "length": number(part.height)}
        else:
            add_mesh(element, meshes.of[collider.name])
            continue
        etree.SubElement(etree.SubElement(element, "geometry"), part.kind, size)


# Joint ----------------------------------------------------------------------------------------------------------------

KINDS = {JointKind.HINGE: "revolute", JointKind.SLIDE: "prismatic"}
# URDF asks for the strength and the speed of a motor. Our joints have no motor, so neither bounds anything: N*m or N,
# and rad/s or m/s, far above what a hand brings about.
NO_BOUND = {"effort": "1000", "velocity": "100"}
# At the end of the name of a fixed joint; no joint of an asset is called so.
FIXED = "__fixed"


def add_joint(
    robot: etree._Element, joint: Joint | None, parent: str, child: str, parent_from_child: Pose, prefix: str = ""
) -> None:
    """Add the `<joint>` between two links of the URDF, with its origin on the axis.

    The damping includes that of a drive, since the drive is a spring that no motor switches off; its stiffness and rest
    position cannot be written to URDF.

    Args:
        joint: None adds a fixed joint.
    """
    if joint is None:
        element = etree.SubElement(robot, "joint", {"name": child + FIXED, "type": "fixed"})
    else:
        element = etree.SubElement(robot, "joint", {"name": prefix + joint.name, "type": KINDS[joint.kind]})
    etree.SubElement(element, "parent", {"link": parent})
    etree.SubElement(element, "child", {"link": child})
    add_origin(element, parent_from_child)
    if joint is None:
        return
    low, high = joint.range
    damping = joint.damping + (joint.drive.damping if joint.drive else 0.0)
    etree.SubElement(element, "axis", {"xyz": numbers(joint.axis)})
    etree.SubElement(element, "limit", {"lower": number(low), "upper": number(high), **NO_BOUND})
    etree.SubElement(element, "dynamics", {"damping": number(damping), "friction": number(joint.frictionloss)})


# Body -----------------------------------------------------------------------------------------------------------------

INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def link_name(asset: Asset, link: str, placement: str = "") -> str:
    """Name of a link; of a placement the root has its name, and the others begin with it."""
    if not placement:
        return link
    return placement if link == asset.root.name else f"{placement}__{link}"


def link_from_urdf(asset: Asset, link: str) -> Pose:
    """Pose of a link's URDF frame in the link's own frame: at the anchor of its joint."""
    moved_by = asset.joint_of(link)
    return Pose() if moved_by is None else Pose(position=moved_by.anchor)


def add_links(robot: etree._Element, asset: Asset, meshes: Meshes, placement: str = "") -> None:
    """Add every `<link>` of an asset below `<robot>`, parents first, each non-root link followed by its `<joint>`.

    Args:
        placement: name of the copy in a document that holds several, which begins all names in it.
    """
    prefix = f"{placement}__" if placement else ""
    for link in asset.links:
        name = link_name(asset, link.name, placement)
        _add_link(etree.SubElement(robot, "link", {"name": name}), link, asset, meshes, prefix)
        if link.parent is not None:
            parent_from_link = link_from_urdf(asset, link.parent).inverse() @ link.pose
            pose = parent_from_link @ link_from_urdf(asset, link.name)
            parent = link_name(asset, link.parent, placement)
            add_joint(robot, asset.joint_of(link.name), parent, name, pose, prefix)


def _add_link(element: etree._Element, link: Link, asset: Asset, meshes: Meshes, prefix: str) -> None:
    """Mass, visuals and colliders of a `<link>`."""
    looks = {item.id: item for item in asset.materials}
    urdf_from_link = link_from_urdf(asset, link.name).inverse()
    inertial = etree.SubElement(element, "inertial")
    add_origin(inertial, urdf_from_link @ Pose(position=link.inertial.center_of_mass))
    etree.SubElement(inertial, "mass", {"value": number(link.inertial.mass)})
    etree.SubElement(inertial, "inertia", dict(zip(INERTIA, map(number, full_inertia(link.inertial)), strict=True)))
    for shown in link.visuals:
        visual = etree.SubElement(element, "visual", {"name": prefix + shown.name})
        add_origin(visual, urdf_from_link)
        add_mesh(visual, meshes.of[shown.name])
        look = looks[shown.material]
        if look.base_color_texture is None:
            plain = etree.SubElement(visual, "material", {"name": mtl_name(look).removesuffix(".mtl")})
            etree.SubElement(plain, "color", {"rgba": srgb(look.base_color)})
    for shape in link.colliders:
        add_colliders(element, shape, meshes, urdf_from_link, prefix)


# Label ----------------------------------------------------------------------------------------------------------------
# Data that URDF cannot represent -> JSON: springs, friction of surfaces, sites, states, labels, named poses.

SCHEMA_VERSION = 1


def json_text(data: Any) -> bytes:
    """JSON text with sorted keys."""
    return (json.dumps(data, indent=1, sort_keys=True, allow_nan=False) + "\n").encode("ascii")


def facts_beside(asset: Asset, urdf: str) -> dict[str, Any]:
    """All data of the asset that its URDF cannot represent; poses are in the frames of the URDF's links.

    Args:
        urdf: name of the URDF file.
    """
    portion = asset.labels.portion
    return {
        "schema_version": SCHEMA_VERSION,
        "id": asset.id,
        "urdf": urdf,
        "base": asset.base.value,
        "asset_from_root": pose_values(asset.root.pose),
        "classes": list(asset.labels.classes),
        "contract": asset.contract or "",
        **({} if portion is None else {"portion": portion.value}),
        "joints": {joint.name: _joint(joint) for joint in asset.joints},
        "colliders": _colliders(asset),
        "visuals": {v.name: {"label": v.label} for link in asset.links for v in link.visuals},
        "sites": [{**_place(asset, site), "color": list(site.color)} for site in asset.sites],
        "regions": [_place(asset, region) for region in asset.regions],
        "states": [state.model_dump(mode="json") for state in asset.states],
        "keyframes": {key.name: joint_positions(key.joints) for key in asset.keyframes},
        "exclusions": [[pair.first, pair.second] for pair in asset.exclusions],
        "behavior": None if asset.behavior is None else asset.behavior.model_dump(mode="json"),
    }


def pose_values(value: Pose) -> dict[str, list[float]]:
    """Position in metres, quaternion (w, x, y, z), nine digits."""
    return {"position": rounded(value.position), "quaternion": rounded(value.quaternion)}


def _joint(joint: Joint) -> dict[str, Any]:
    """Armature, stiffness of dry friction, spring, collider that a hand takes hold of, joint that opens first."""
    return {
        "armature": joint.armature,
        "friction_impedance": list(joint.friction_impedance),
        "spring": joint.drive and {"stiffness": joint.drive.stiffness, "rest": joint.drive.target},
        "grip": joint.grip,
        "behind": joint.behind,
    }


def _colliders(asset: Asset) -> dict[str, Any]:
    found = {}
    for collider in (c for link in asset.links for c in link.colliders):
        matter = asset.substance(collider.substance)
        found[collider.name] = {
            "substance": matter.id,
            "static_friction": matter.static_friction,
            "dynamic_friction": matter.dynamic_friction,
            "torsional_friction": matter.torsional_friction,
            "rolling_friction": matter.rolling_friction,
            "label": collider.label,
        }
    return found


def _place(asset: Asset, item: Site | Region) -> dict[str, Any]:
    """Name, link, kind, pose in the frame of the URDF's link, and full size."""
    inside = link_from_urdf(asset, item.link).inverse() @ item.pose
    size = [2 * item.radius] * 3 if item.size is None else list(item.size)
    return {"name": item.name, "link": item.link, "kind": item.kind, "size": size, **pose_values(inside)}


def write(asset: Asset) -> Files:
    """Return the URDF package of an asset; the same asset gives the same bytes.

    Returns:
        `<id>.urdf` (root link `object`, not attached to anything), `<id>.json`, and `meshes/` with OBJ, MTL and PNG
        files. Paths are plain and relative to the URDF, without `package://`.
    """
    meshes = gather_meshes(asset)
    return Files.of({**texts(asset, meshes), **meshes.entries})


def texts(asset: Asset, meshes: Meshes) -> dict[str, bytes]:
    """`<id>.urdf` and `<id>.json`, which are in the same folder as the folders of the meshes."""
    root = robot(asset.id)
    add_links(root, asset, meshes)
    return {
        urdf_name(asset.id): document_text(root),
        f"{asset.id}.json": json_text(facts_beside(asset, urdf_name(asset.id))),
    }


def urdf_name(asset: str) -> str:
    """Name of the URDF of an asset."""
    return f"{asset}.urdf"


def robot(name: str) -> etree._Element:
    """`<robot>`, with the settings with which MuJoCo reads all of it; other programs ignore them."""
    root = etree.Element("robot", {"name": name})
    settings = {"strippath": "false", "discardvisual": "false", "fusestatic": "false"}
    etree.SubElement(etree.SubElement(root, "mujoco"), "compiler", settings)
    return root


def document_text(root: etree._Element) -> bytes:
    """Return the file."""
    return etree.tostring(root, encoding="us-ascii", pretty_print=True, xml_declaration=True)


# Kitchen --------------------------------------------------------------------------------------------------------------
# Scene -> `scene.urdf` with all fixed objects, a URDF of every asset, and `scene.json` with all placements.
#
# Names in `scene.urdf`: the root link of a placement has the placement's name, everything else in it
# `<placement>__<name>`. Loose objects are not in `scene.urdf`: they would need floating joints, which few programs
# read.

FILE, LIST = "scene.urdf", "scene.json"


def write_scene(scene: Scene) -> Files:
    """Return the URDF files of a scene, flat in one folder; the same scene gives the same bytes.

    Returns:
        `scene.urdf`, `scene.json`, `<asset>.urdf` and `<asset>.json` of every asset, and `meshes/`.
    """
    meshes = {asset.id: gather_meshes(asset) for asset in scene.assets}
    entries = {FILE: _document(scene, meshes), LIST: json_text(_list(scene))}
    for asset in scene.assets:
        entries |= texts(asset, meshes[asset.id])
        entries |= meshes[asset.id].entries
    return Files.of(entries)


def _document(scene: Scene, meshes: dict[str, Meshes]) -> bytes:
    root = robot(scene.id)
    etree.SubElement(root, "link", {"name": WORLD})
    for place in scene.placements:
        asset = scene.asset_of[place.name]
        if asset.base is Base.FIXED:
            add_links(root, asset, meshes[asset.id], place.name)
            add_joint(root, None, WORLD, place.name, world_from_root(place, asset))
    return document_text(root)


def _list(scene: Scene) -> dict[str, Any]:
    asset_of = scene.asset_of

    def name_of(end: PlacedLink) -> str:
        return link_name(asset_of[end.placement], end.link, end.placement)

    return {
        "schema_version": SCHEMA_VERSION,
        "id": scene.id,
        "urdf": FILE,
        "gravity": list(scene.gravity),
        "placements": [_placement(place, asset_of[place.name]) for place in scene.placements],
        "exclusions": [[name_of(first), name_of(second)] for first, second in scene.exclusions],
        # They look along their -z, y up.
        "cameras": [{"name": c.name, "fov_y_deg": c.fov_y_deg, **pose_values(c.pose)} for c in scene.cameras],
    }


def _placement(place: Placement, asset: Asset) -> dict[str, Any]:
    """One row of the list; the pose is that of the root link in the world."""
    pose = world_from_root(place, asset)
    return {
        "name": place.name,
        "asset": asset.id,
        "urdf": urdf_name(asset.id),
        "base": asset.base.value,
        "layer": place.layer.value,
        "joints": joint_positions(place.joints),
        **pose_values(pose),
        "rpy": rounded(roll_pitch_yaw(pose)),
    }
