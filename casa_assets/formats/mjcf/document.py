"""Asset -> model.xml and scene.xml: bodies, joints, contacts, keyframes and labels."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from lxml import etree

from casa_assets.formats.mjcf import shapes
from casa_assets.formats.mjcf.shapes import Meshes
from casa_assets.formats.values import ROBOSUITE_GROUPS, VIEWER_GROUPS, Groups, number, numbers
from casa_assets.model.asset.asset import Asset, Base, Collider, Exclusion, Inertial, Joint, Link, Visual
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import OUTER_FACE
from casa_assets.model.written_formats import BehaviorFile

# Joint ----------------------------------------------------------------------------------------------------------------
# Joint -> hinge or slide; a drive becomes a spring to its target, since an asset has no actuators.


def add_joint(body: etree._Element, joint: Joint, prefix: str = "") -> None:
    """`<joint>` below the body that it moves; radians and metres, body frame; `prefix`: prefix of its name."""
    drive = joint.drive
    attributes = {
        "name": prefix + joint.name,
        "type": joint.kind.value,
        "pos": numbers(joint.anchor),
        "axis": numbers(joint.axis),
        # Written although autolimits would do: consumers that merge models drop <compiler>.
        "limited": "true",
        "range": numbers(joint.range),
        "damping": number(joint.damping + (drive.damping if drive else 0.0)),
        "frictionloss": number(joint.frictionloss),
        "armature": number(joint.armature),
        "solimplimit": numbers(joint.limit_impedance),
    }
    if joint.frictionloss:
        attributes["solimpfriction"] = numbers(joint.friction_impedance)
    if drive:
        attributes |= {
            "stiffness": number(drive.stiffness),
            "springref": number(drive.target),
            "margin": number(joint.limit_margin),
        }
    etree.SubElement(body, "joint", attributes)


# Body -----------------------------------------------------------------------------------------------------------------
# Link -> `<body>` with explicit mass properties; bodies are nested like the links that carry each other.

# Share of the trace that is added to the moments of a flat plate, so that nine digits cannot break A + B >= C.
PLATE_MARGIN = 1e-8


@dataclass(frozen=True)
class BodyContext:
    """Names, meshes and groups that every body of a document shares.

    Attributes:
        asset: asset whose links are written.
        meshes: its mesh files.
        materials: material id -> name in the document.
        groups: groups of geoms.
        placement: name of the copy in a document that holds several: the name of its root body, and with `__` the
            prefix of all other names. None to keep the names unchanged.
        collider_colors: collider name -> `rgba`, if colliders are drawn instead of visuals.
    """

    asset: Asset
    meshes: Meshes
    materials: dict[str, str]
    groups: Groups = ROBOSUITE_GROUPS
    placement: str | None = None
    collider_colors: Mapping[str, str] = field(default_factory=dict)

    @property
    def prefix(self) -> str:
        """Prefix of all names except that of the root body."""
        return "" if self.placement is None else f"{self.placement}__"

    def body_name(self, link: str) -> str:
        """Name of the body of a link."""
        if self.placement is not None and link == self.asset.root.name:
            return self.placement
        return self.prefix + link


def add_body(parent: etree._Element, link: Link, context: BodyContext) -> etree._Element:
    """`<body>` of a link and of all links that it carries, without a free joint.

    Order inside a body: mass, joint, colliders, visuals, regions, sites, carried bodies.
    """
    asset, prefix = context.asset, context.prefix
    body = etree.SubElement(parent, "body", {"name": context.body_name(link.name), **shapes.place(link.pose)})
    inertial = etree.SubElement(body, "inertial")
    inertial.set("pos", numbers(link.inertial.center_of_mass))
    inertial.set("mass", number(link.inertial.mass))
    inertial.set("fullinertia", numbers(full_inertia(link.inertial)))
    link_joint = asset.joint_of(link.name)
    if link_joint is not None:
        add_joint(body, link_joint, prefix)
    for shape in link.colliders:
        substance = asset.substance(shape.substance)
        geom = shapes.add_collider(body, shape, substance, context.meshes, context.groups.colliders, prefix)
        if shape.name in context.collider_colors:
            geom.set("rgba", context.collider_colors[shape.name])
    for shown in link.visuals:
        material = context.materials[shown.material]
        group = context.groups.shell if shown.label == OUTER_FACE else context.groups.visuals
        shapes.add_visual(body, shown, context.meshes.of[shown.name], material, group, prefix)
    outer = shapes.outer_region(asset) if link.parent is None else None
    for region in [*([outer] if outer else []), *asset.regions]:
        if region.link == link.name:
            shapes.add_region(body, region, context.groups.regions, prefix)
            if asset.contract:
                shapes.add_corners(body, region, prefix)
    for point in asset.sites:
        if point.link == link.name:
            shapes.add_site(body, point, prefix)
    for carried in asset.links:
        if carried.parent == link.name:
            add_body(body, carried, context)
    return body


def full_inertia(inertial: Inertial) -> list[float]:
    """(xx, yy, zz, xy, xz, yz), kg*m^2, adjusted so that nine digits of it are still a valid inertia."""
    moments = np.linalg.eigvalsh(inertial.tensor)
    trace = float(moments.sum())
    is_plate = moments[0] + moments[1] - moments[2] < 2 * PLATE_MARGIN * trace
    diagonal = [m + PLATE_MARGIN * trace if is_plate else m for m in inertial.inertia[:3]]
    return [*diagonal, *inertial.inertia[3:]]


def add_exclusion(contact: etree._Element, exclusion: Exclusion, context: BodyContext) -> None:
    """`<exclude>` below `<contact>`; `context` gives the bodies their names."""
    first, second = context.body_name(exclusion.first), context.body_name(exclusion.second)
    name = f"{context.prefix}{exclusion.first}__{exclusion.second}"
    etree.SubElement(contact, "exclude", {"name": name, "body1": first, "body2": second})


def exclude(contact: etree._Element, first: str, second: str) -> None:
    """`<exclude>` for two bodies of a scene, named after both."""
    etree.SubElement(contact, "exclude", {"name": f"{first}__beside__{second}", "body1": first, "body2": second})


def exclude_from_world(body: etree._Element, is_moved: bool = False) -> None:
    """Exclude contacts between parts that are fixed to the world and moving parts on them, below a fixed body.

    A door is always near the frames, walls and worktops around it, so that half of all collision tests would be spent
    on pairs that never touch: a check of every scene makes sure that no joint runs into anything over its whole range.
    Doors still collide with doors, and everything collides with robots and loose objects, whose contype and conaffinity
    are 1, MuJoCo's default.

    Args:
        body: a fixed body, or with `is_moved` a body that a joint carries.
    """
    is_moved = is_moved or body.find("joint") is not None
    for geom in [g for g in body.findall("geom") if g.get("contype") == "1"]:
        contype, conaffinity = ("3", "2") if is_moved else ("1", "0")
        geom.set("contype", contype)
        geom.set("conaffinity", conaffinity)
    for carried in body.findall("body"):
        exclude_from_world(carried, is_moved)


# Keyframe -------------------------------------------------------------------------------------------------------------


def add_keyframes(root: etree._Element, asset: Asset, free_joint: tuple[float, ...] = ()) -> None:
    """`<keyframe>` with one `<key>` for each named pose; `free_joint`: position of a free base."""
    if not asset.keyframes:
        return
    block = etree.SubElement(root, "keyframe")
    joints = joint_order(asset, asset.root.name)
    for key in asset.keyframes:
        positions = joint_positions(key.joints)
        values = [*free_joint, *(positions.get(name, 0.0) for name in joints)]
        etree.SubElement(block, "key", {"name": key.name, "qpos": numbers(values)})


def joint_order(asset: Asset, link: str) -> list[str]:
    """Names of the joints of a link and of all that it carries, in the order of the document."""
    joint = asset.joint_of(link)
    found = [joint.name] if joint else []
    for carried in asset.links:
        if carried.parent == link:
            found += joint_order(asset, carried.name)
    return found


# Label ----------------------------------------------------------------------------------------------------------------
# Labels, states, grips, behaviour and the kind of base -> `<custom>` texts, which MuJoCo stores but does not use.


def add_labels(root: etree._Element, asset: Asset) -> None:
    """`<custom>` with the texts of an asset."""
    custom = etree.SubElement(root, "custom")
    for name, data in label_texts(asset).items():
        etree.SubElement(custom, "text", {"name": name, "data": data})


def label_texts(asset: Asset, prefix: str = "") -> dict[str, str]:
    """Texts of an asset in a model, by name.

    Always `base`, `class` (from the category upwards) and `qcode`; if the asset has them `portion`, `contract`,
    `state__<name>`, `label__<label>` (names of geoms), `grip__<joint>` (name of a geom), `behind__<joint>` (name of a
    joint) and `behavior` (JSON).

    Args:
        prefix: prefix of the names of its geoms and joints in the document; names in the JSON have no prefix.
    """
    found = {
        "base": asset.base.value,
        "class": " ".join(asset.labels.classes),
        "qcode": asset.labels.qcode.id,
    }
    if asset.labels.portion is not None:
        found["portion"] = asset.labels.portion.value
    for state in asset.states:
        found[f"state__{state.name}"] = f"{prefix}{state.joint} {state.value} {numbers(state.interval)}"
    if asset.contract is not None:
        found["contract"] = asset.contract
    labelled = geoms_by_label(asset).items()
    found |= {f"label__{label}": " ".join(prefix + name for name in names) for label, names in labelled}
    found |= {f"grip__{joint.name}": prefix + joint.grip for joint in asset.joints if joint.grip is not None}
    found |= {f"behind__{joint.name}": prefix + joint.behind for joint in asset.joints if joint.behind is not None}
    if asset.behavior is not None:
        found["behavior"] = asset.behavior.to_json()
    return found


def geoms_by_label(asset: Asset) -> dict[str, list[str]]:
    """Label -> names of the geoms that carry it, sorted."""
    found: dict[str, list[str]] = {}
    for link in asset.links:
        parts: tuple[Collider | Visual, ...] = (*link.colliders, *link.visuals)
        for part in parts:
            if part.label is not None:
                found.setdefault(part.label, []).append(part.name)
    return {label: sorted(found[label]) for label in sorted(found)}


def behavior_file(asset: Asset) -> bytes:
    """The state machine, the named states of joints and the named poses as JSON for people and programs."""
    assert asset.behavior is not None, "the caller checks"
    data: dict[str, Any] = {
        "behavior": asset.behavior.model_dump(mode="json", exclude_none=True),
        "states": [state.model_dump(mode="json") for state in asset.states],
        "keyframes": [key.model_dump(mode="json") for key in asset.keyframes],
    }
    BehaviorFile.model_validate(data)
    return (json.dumps(data, indent=1, sort_keys=True) + "\n").encode("ascii")


# Stage ----------------------------------------------------------------------------------------------------------------

# Pale floor, pale sky: neutral for any colour of object.
SKY = {
    "name": "scene__sky",
    "type": "skybox",
    "builtin": "gradient",
    "rgb1": "0.92 0.94 0.96",
    "rgb2": "0.62 0.66 0.7",
    "width": "256",
    "height": "1536",
}
FLOOR_MATERIAL = {"name": "scene__floor", "rgba": "0.78 0.78 0.76 1", "specular": "0.1", "shininess": "0.1"}
# A thing on a plane creeps in MuJoCo 3.3: a mesh touches it with neighbours of its lowest vertex alone, and rocks.
# On a box it has contacts all around its foot, also where that is ten micrometres above the floor. The box is deep: a
# shape that a fall drives into it is pushed out along the line between the two middles, which has to be upright.
FLOOR_BOX = {"type": "box", "size": "25 25 10", "pos": "0 0 -10", "margin": "0.00001"}
HEADLIGHT = {"ambient": "0.38 0.38 0.38", "diffuse": "0.3 0.3 0.3", "specular": "0.1 0.1 0.1"}
LIGHT_DISTANCE = 1.5  # diagonals of the asset
LIGHTS = (
    ((0.4, 0.5, -0.8), {"diffuse": "0.45 0.44 0.42", "specular": "0.4 0.4 0.4", "castshadow": "true"}),
    ((-0.7, 0.3, -0.8), {"diffuse": "0.12 0.13 0.15", "specular": "0.1 0.1 0.1", "castshadow": "false"}),
)


def add_stage_frame(root: etree._Element, asset: Asset) -> None:
    """`<statistic>` and `<visual>`: initial view of the viewer, and its light."""
    center, diagonal = _center_and_diagonal(asset)
    etree.SubElement(root, "statistic", {"center": numbers(center), "extent": number(diagonal)})
    view = etree.SubElement(root, "visual")
    angles = {"azimuth": "60", "elevation": "-22", "fovy": "40"}
    etree.SubElement(view, "global", {**angles, "offwidth": "1280", "offheight": "960"})
    etree.SubElement(view, "quality", {"shadowsize": "4096", "offsamples": "8"})
    etree.SubElement(view, "headlight", HEADLIGHT)
    etree.SubElement(view, "map", {"znear": "0.02", "zfar": "80", "shadowclip": "2"})
    etree.SubElement(view, "rgba", {"haze": "0.92 0.94 0.96 1"})


def add_stage(assets: etree._Element, world: etree._Element, asset: Asset) -> None:
    """Add sky, floor and lights. The floor is a plane for viewing and a box for contacts."""
    etree.SubElement(assets, "texture", SKY)
    etree.SubElement(assets, "material", FLOOR_MATERIAL)
    center, diagonal = _center_and_diagonal(asset)
    for i, (direction, light) in enumerate(LIGHTS):
        # A directional light shines from everywhere, but its shadows are drawn from here: near means sharp.
        position = numbers(center - LIGHT_DISTANCE * diagonal * np.array(direction))
        placed = {"directional": "true", "pos": position, "dir": numbers(direction)}
        etree.SubElement(world, "light", {"name": f"scene__light_{i}", **placed, **light})
    # MuJoCo takes the larger of two frictions. The least of the asset's own lets each collider's value act.
    names = ("dynamic_friction", "torsional_friction", "rolling_friction")
    friction = [min(getattr(s, name) for s in asset.substances) for name in names]
    seen = {"name": "scene__ground", "type": "plane", "size": "0 0 0.05", "material": "scene__floor"}
    seen |= {"group": str(VIEWER_GROUPS.visuals), "mass": "0", "contype": "0", "conaffinity": "0"}
    etree.SubElement(world, "geom", seen)
    floor = {"name": "scene__floor", "group": str(VIEWER_GROUPS.colliders), **FLOOR_BOX}
    floor |= {"contype": "1", "conaffinity": "1", "condim": "3", "friction": numbers(friction)}
    etree.SubElement(world, "geom", floor)


def add_object(world: etree._Element, context: BodyContext) -> tuple[float, ...]:
    """Put the asset on the floor: with a free joint if its base is free, else welded to the world.

    Returns:
        Position of the free joint (x, y, z, w, x, y, z); empty if it is welded.
    """
    asset = context.asset
    object_body = add_body(world, asset.root, context)
    x, y, z = asset.root.pose.position
    object_body.set("pos", numbers((x, y, z + _lift(asset))))
    if asset.base is Base.FREE:
        object_body.insert(0, etree.Element("freejoint", {"name": "scene__free"}))
        return (x, y, z + _lift(asset), *asset.root.pose.quaternion)
    return ()


def _center_and_diagonal(asset: Asset) -> tuple[npt.NDArray[np.float64], float]:
    """Centre of the visuals in the pose of the scene, and the diagonal of their bounds, metres."""
    lower, upper = asset.bounds
    center = (lower + upper) / 2
    center[2] += _lift(asset)
    return center, float(np.linalg.norm(upper - lower))


def _lift(asset: Asset) -> float:
    """Height by which to raise the asset so that its lowest collider touches z = 0, metres."""
    return -float(shapes.collision_bounds(asset)[0, 2])


def write(asset: Asset, groups: Groups = ROBOSUITE_GROUPS) -> Files:
    """Return the MJCF package of an asset; the same asset gives the same bytes.

    Args:
        groups: groups of the geoms of `model.xml`.
    Returns:
        `model.xml` (body `object` inside an unnamed body, no floor, no free joint, for robosuite and robocasa to
        merge), `scene.xml` (the same body on a floor, with a free joint if its base is free), `meshes/*.obj` and
        `textures/*.png`, and `behavior.json` if the asset has a behaviour. Paths are relative to the XML.
    """
    meshes, names = shapes.gather_meshes(asset), shapes.material_names(asset)
    entries = {file.path: file.data for file in meshes.files}
    entries |= {path: image.png for path, image in shapes.texture_files(asset).items()}
    entries["model.xml"] = _model(BodyContext(asset, meshes, names, groups))
    entries["scene.xml"] = _scene(BodyContext(asset, meshes, names, VIEWER_GROUPS))
    if asset.behavior is not None:
        entries["behavior.json"] = behavior_file(asset)
    return Files.of(entries)


def _model(context: BodyContext) -> bytes:
    asset = context.asset
    root = _root(asset.id)
    _add_assets(root, context)
    world = etree.SubElement(root, "worldbody")
    outer = etree.SubElement(world, "body")
    add_body(outer, asset.root, context)
    shapes.add_size_sites(outer, asset)
    _add_exclusions_and_labels(root, context)
    add_keyframes(root, asset)
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)


def _scene(context: BodyContext) -> bytes:
    asset = context.asset
    root = _root(f"{asset.id}__scene")
    option = etree.SubElement(root, "option", {"timestep": "0.002", "integrator": "implicitfast"})
    # Several contacts between a pair of shapes, so that things at rest do not rock. MuJoCo 4 does so by default, but
    # its own detection tilts their normals by up to four degrees, and they slide; libccd's are level on average.
    etree.SubElement(option, "flag", {"multiccd": "enable", "nativeccd": "disable"})
    add_stage_frame(root, asset)
    assets = _add_assets(root, context)
    world = etree.SubElement(root, "worldbody")
    add_stage(assets, world, asset)
    free_joint = add_object(world, context)
    _add_exclusions_and_labels(root, context)
    add_keyframes(root, asset, free_joint)
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)


def _root(name: str) -> etree._Element:
    root = etree.Element("mujoco", {"model": name})
    etree.SubElement(root, "compiler", {"angle": "radian", "autolimits": "true"})
    return root


def _add_assets(root: etree._Element, context: BodyContext) -> etree._Element:
    assets = etree.SubElement(root, "asset")
    shapes.add_materials(assets, context.asset)
    for file in context.meshes.files:
        shapes.add_mesh(assets, file)
    return assets


def _add_exclusions_and_labels(root: etree._Element, context: BodyContext) -> None:
    if context.asset.exclusions:
        pairs = etree.SubElement(root, "contact")
        for exclusion in context.asset.exclusions:
            add_exclusion(pairs, exclusion, context)
    add_labels(root, context.asset)
