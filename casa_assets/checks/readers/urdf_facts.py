"""URDF and the JSON that goes with it -> fact table, read without the writer."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from casa_assets.checks.readers.facts import (
    CLOSED,
    OUTER,
    AssetFacts,
    BodyFacts,
    JointFacts,
    PlaceFacts,
    ProgramTexts,
    StateFacts,
    VisualFacts,
    bounds_around,
    frames_of,
    pose_facts,
    tensor_entries,
    three,
)
from casa_assets.core.numeric import Floats, about_axis, linear_from_srgb
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.model.asset.asset import Base, JointKind
from casa_assets.model.asset.behavior import Behavior
from casa_assets.model.asset.parts import Box, Cylinder, Sphere
from casa_assets.model.pose import Pose

KINDS = {"revolute": JointKind.HINGE, "prismatic": JointKind.SLIDE}
# In the name of a sphere at the end of a capsule, which is no collider of its own.
CAPSULE_END = "__end"
ROOT = "object"
Json = Mapping[str, Any]


@dataclass(frozen=True)
class UrdfLink:
    """A link of a URDF with the joint that ties it to its parent.

    Attributes:
        parent: name, empty if no joint has it as child. joint: its `<joint>`, None if it has no joint.
        element: its `<link>`.
    """

    name: str
    parent: str
    element: etree._Element
    joint: etree._Element | None

    @property
    def pose(self) -> Pose:
        """parent_from_link at zero."""
        return Pose() if self.joint is None else origin(self.joint)

    @property
    def is_moved(self) -> bool:
        """True if the joint moves it."""
        return self.joint is not None and self.joint.get("type") in KINDS

    def motion(self, value: float) -> Pose:
        """Pose of the link in its own frame at zero, at a joint position in rad or m."""
        assert self.joint is not None
        axis = np.array(_numbers(_child(self.joint, "axis"), "xyz"))
        if self.joint.get("type") == "prismatic":
            return Pose(position=three(axis * value))
        return Pose.from_matrix(about_axis(axis, value))


def facts(path: Path) -> AssetFacts:
    """The table of a URDF of one asset, in the frames of its links, whose origins are on the axes of their joints.

    Raises:
        ValueError: the URDF, the JSON that goes with it or a mesh file cannot be read, or lacks what a table needs.
    """
    return table(links(path), path.parent, beside(path))


def beside(path: Path) -> Json:
    """The JSON of the same name and folder as a URDF. Raises ValueError if it cannot be read."""
    try:
        data = json.loads(path.with_suffix(".json").read_text(encoding="ascii"))
    except OSError as error:
        raise ValueError(f"{path.stem}.json cannot be read: {error.strerror}") from error
    return dict(data)


def links(path: Path) -> tuple[UrdfLink, ...]:
    """Every link of a URDF, in the order of the document.

    Raises:
        ValueError: it is no URDF, a joint names a link that is not there, or the links are not one tree.
    """
    try:
        root = etree.fromstring(path.read_bytes(), etree.XMLParser(resolve_entities=False, no_network=True))
    except (OSError, etree.XMLSyntaxError) as error:
        raise ValueError(f"{path.name} cannot be read: {error}") from error
    by_child = {_child(joint, "child").get("link"): joint for joint in root.findall("joint")}
    found = []
    for element in root.findall("link"):
        name = element.get("name", "")
        joint = by_child.get(name)
        parent = "" if joint is None else _child(joint, "parent").get("link", "")
        found.append(UrdfLink(name, parent, element, joint))
    names = {link.name for link in found}
    lost = sorted(link.parent for link in found if link.parent and link.parent not in names)
    roots, joints = sum(link.joint is None for link in found), len(root.findall("joint"))
    if len(names) != len(found) or lost or roots != 1 or joints != len(found) - 1:
        what = f"a joint hangs on {lost[0]!r}, which is no link" if lost else "its links are not one tree"
        raise ValueError(f"{path.name}: {what}")
    return tuple(found)


def table(tree: tuple[UrdfLink, ...], folder: Path, aside: Json, prefix: str = "") -> AssetFacts:
    """The table of links that belong to one asset, including the root.

    Args:
        tree: links of the asset, whose root is called `object`. folder: of the URDF. aside: the JSON that goes with it.
        prefix: begins the names of its joints, visuals and colliders, which the table has without it.
    """
    named = {CLOSED: {}, **aside["keyframes"]} if aside["keyframes"] else {}
    at_zero = root_from_links(tree)
    return AssetFacts(
        base=Base(aside["base"]),
        exclusions=aside["exclusions"],
        words=_words(aside),
        bodies=[_body(link, at_zero, folder, aside, prefix) for link in tree],
        places=[_place(item) for item in (*aside["sites"], *aside["regions"]) if item["name"] != OUTER],
        looks=[_look(visual, folder, prefix) for link in tree for visual in link.element.findall("visual")],
        poses=[pose_facts(n, frames_of(root_from_links(tree, values, prefix))) for n, values in named.items()],
    )


def on_joint_axes(asset: AssetFacts) -> AssetFacts:
    """The same table in the frames of a URDF: the origin of each body is the anchor of its joint.

    Args:
        asset: in the frames of the asset, in which an anchor is a point of the body.
    """
    anchors = {body.name: np.array(body.joint.anchor if body.joint else (0.0, 0.0, 0.0)) for body in asset.bodies}
    bodies, poses = [], []
    for body in asset.bodies:
        anchor = anchors[body.name]
        moved = Pose(position=body.position, quaternion=body.quaternion) @ Pose(position=three(anchor))
        shapes = anchor if body.colliders else np.zeros(3)
        changes = {
            "position": moved.position,
            "center_of_mass": three(np.array(body.center_of_mass) - anchor),
            "lower": three(np.array(body.lower) - shapes),
            "upper": three(np.array(body.upper) - shapes),
            "joint": body.joint and body.joint.replace(anchor=(0.0, 0.0, 0.0)),
        }
        bodies.append(body.replace(**changes))
    for pose in asset.poses:
        frames = zip(pose.bodies, pose.positions, pose.quaternions, strict=True)
        by_body = {b: Pose(position=p, quaternion=q) @ Pose(position=three(anchors[b])) for b, p, q in frames}
        poses.append(pose.replace(positions=[by_body[body].position for body in pose.bodies]))
    places = [p.replace(position=three(np.array(p.position) - anchors[p.body])) for p in asset.places]
    return asset.replace(bodies=bodies, places=places, poses=poses)


def root_from_links(
    tree: tuple[UrdfLink, ...], values: Mapping[str, float] | None = None, prefix: str = ""
) -> dict[str, Pose]:
    """Pose of each link in the frame of the root, by name.

    Args:
        values: joint name without `prefix` -> position, rad or m; those not named are at zero.
    """
    by_name = {link.name: link for link in tree}

    @cache
    def pose_of(name: str) -> Pose:
        link = by_name[name]
        if link.parent not in by_name:
            return Pose()
        pose = pose_of(link.parent) @ link.pose
        value = (values or {}).get(_joint_name(link, prefix), 0.0)
        return pose @ link.motion(value) if link.is_moved and value else pose

    return {name: pose_of(name) for name in by_name}


def visual_bounds(tree: tuple[UrdfLink, ...], folder: Path, prefix: str = "") -> dict[str, Floats]:
    """(2, 3) corners of each visual in the frame of its link, metres, by its name without `prefix`."""
    return {
        visual.get("name", "").removeprefix(prefix): _bounds(visual, folder)
        for link in tree
        for visual in link.element.findall("visual")
    }


def origin(element: etree._Element) -> Pose:
    """Pose of an `<origin>`: roll, pitch and yaw turn about the fixed axes, one after the other."""
    found = element.find("origin")
    if found is None:
        return Pose()
    roll, pitch, yaw = _numbers(found, "rpy", "0 0 0")
    turns = [about_axis(np.eye(3)[i], angle) for i, angle in enumerate((roll, pitch, yaw))]
    turned = Pose.from_matrix(turns[2] @ turns[1] @ turns[0])
    return turned.replace(position=three(np.array(_numbers(found, "xyz", "0 0 0"))))


def _body(link: UrdfLink, at_zero: Mapping[str, Pose], folder: Path, aside: Json, prefix: str) -> BodyFacts:
    """Row of a link. `at_zero`: poses of all links of the asset."""
    own, pose = link.parent not in at_zero, at_zero[link.name]
    inertial = _child(link.element, "inertial")
    frame, moments = origin(inertial), _child(inertial, "inertia")
    xx, yy, zz, xy, xz, yz = (_number(moments, name) for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
    tensor = frame.rotation @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ frame.rotation.T
    shapes = link.element.findall("collision")
    lower, upper = bounds_around([_bounds(shape, folder) for shape in shapes])
    names = [shape.get("name", "").removeprefix(prefix) for shape in shapes]
    colliders = [name for name in names if CAPSULE_END not in name]
    matters = [aside["colliders"][name] for name in colliders]
    return BodyFacts(
        name=link.name,
        parent="" if own else link.parent,
        colliders=len(colliders),
        position=pose.position,
        center_of_mass=frame.position,
        lower=lower,
        upper=upper,
        quaternion=pose.quaternion,
        mass=_number(_child(inertial, "mass"), "value"),
        inertia=tensor_entries(tensor),
        frictions={(m["dynamic_friction"], m["torsional_friction"], m["rolling_friction"]) for m in matters},
        joint=None if own or not link.is_moved else _joint(link, aside, prefix),
    )


def _joint_name(link: UrdfLink, prefix: str) -> str:
    return "" if link.joint is None else link.joint.get("name", "").removeprefix(prefix)


def _joint(link: UrdfLink, aside: Json, prefix: str) -> JointFacts:
    assert link.joint is not None
    name = _joint_name(link, prefix)
    said = aside["joints"][name]
    spring = said["spring"] or {"stiffness": 0.0, "rest": 0.0}
    limit, dynamics = _child(link.joint, "limit"), _child(link.joint, "dynamics")
    damping, friction = _number(dynamics, "damping"), _number(dynamics, "friction")
    return JointFacts(
        name=name,
        kind=KINDS[link.joint.get("type", "")],
        axis=three(np.array(_numbers(_child(link.joint, "axis"), "xyz"))),
        anchor=(0.0, 0.0, 0.0),
        range=(_number(limit, "lower"), _number(limit, "upper")),
        resistance=(spring["stiffness"], spring["rest"], damping, friction, said["armature"]),
    )


def _place(item: Json) -> PlaceFacts:
    x, y, z = item["size"]
    return PlaceFacts(
        name=item["name"],
        body=item["link"],
        kind=item["kind"],
        position=item["position"],
        quaternion=item["quaternion"],
        size=(x, x, z) if item["kind"] == "cylinder" else (x, y, z),
        color=item.get("color"),
    )


def _look(visual: etree._Element, folder: Path, prefix: str) -> VisualFacts:
    """Appearance of a visual from its MTL file.

    Raises:
        ValueError: the URDF states another plain colour than the MTL file, or a picture does not exist.
    """
    name = visual.get("name", "")
    obj = folder / _child(_child(visual, "geometry"), "mesh").get("filename", "")
    library = next((line for line in _lines(obj) if line.startswith("mtllib ")), None)
    if library is None:
        raise ValueError(f"{obj.name} has no mtllib")
    pairs = [line.split(maxsplit=1) for line in _lines(obj.parent / library.removeprefix("mtllib "))]
    mtl = {pair[0]: pair[1] for pair in pairs if len(pair) == 2}
    shown = [*map(float, mtl["Kd"].split()), float(mtl["d"])]
    stated = visual.find("material/color")
    if stated is not None and not np.allclose(_numbers(stated, "rgba"), shown, atol=1e-6):
        raise ValueError(f"visual {name!r} has one colour in the URDF and another in {mtl['newmtl']}.mtl")
    picture = mtl.get("map_Kd", "")
    if picture and not (obj.parent / picture).is_file():
        raise ValueError(f"visual {name!r}: there is no picture {picture}")
    return VisualFacts(
        name=name.removeprefix(prefix),
        color=(*(linear_from_srgb(c) for c in shown[:3]), shown[3]),
        light=[linear_from_srgb(float(c)) for c in mtl["Ke"].split()],
        picture=Path(picture).name,
    )


def _lines(file: Path) -> list[str]:
    try:
        return file.read_text(encoding="ascii").splitlines()
    except OSError as error:
        raise ValueError(f"{file.name} cannot be read: {error.strerror}") from error


def _bounds(element: etree._Element, folder: Path) -> Floats:
    """(2, 3) corners of a visual or collider in the frame of its link."""
    shape, pose = _child(element, "geometry")[0], origin(element)
    if shape.tag == "box":
        x, y, z = _numbers(shape, "size")
        return shape_bounds(Box(size=(x, y, z)), pose)
    if shape.tag == "sphere":
        return shape_bounds(Sphere(radius=_number(shape, "radius")), pose)
    if shape.tag == "cylinder":
        return shape_bounds(Cylinder(radius=_number(shape, "radius"), height=_number(shape, "length")), pose)
    obj = folder / shape.get("filename", "")
    rows = [line[2:].split() for line in _lines(obj) if line.startswith("v ")]
    if not rows:
        raise ValueError(f"{obj.name} has no points")
    points = pose.apply(np.array(rows, dtype=np.float64))
    return np.array([points.min(axis=0), points.max(axis=0)])


def _words(aside: Json) -> ProgramTexts:
    shapes, joints, behavior = {**aside["visuals"], **aside["colliders"]}, aside["joints"].items(), aside["behavior"]
    return ProgramTexts(
        classes=aside["classes"],
        portion=aside.get("portion", ""),
        labels=[(name, said["label"]) for name, said in shapes.items() if said["label"]],
        grips=[(name, said["grip"]) for name, said in joints if said["grip"]],
        behind=[(name, said["behind"]) for name, said in joints if said["behind"]],
        contract=aside["contract"],
        behavior="" if behavior is None else Behavior.model_validate(behavior).digest,
        states=[
            StateFacts(name=s["name"], joint=s["joint"], value=s["value"], interval=s["interval"])
            for s in aside["states"]
        ],
    )


def _child(element: etree._Element, tag: str) -> etree._Element:
    found = element.find(tag)
    if found is None:
        raise ValueError(f"<{element.tag} name={element.get('name')!r}> has no <{tag}>")
    return found


def _number(element: etree._Element, name: str) -> float:
    (value,) = _numbers(element, name)
    return value


def _numbers(element: etree._Element, name: str, default: str = "") -> list[float]:
    return [float(word) for word in element.get(name, default).split()]
