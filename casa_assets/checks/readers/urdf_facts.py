"""URDF, as MuJoCo compiles it, and the JSON that goes with it -> fact table, read without the writer."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from lxml import etree

from casa_assets.checks.readers.facts import (
    CLOSED,
    OUTER,
    ROOT_BODY,
    AssetFacts,
    BodyFacts,
    PlaceFacts,
    PoseFacts,
    ProgramTexts,
    StateFacts,
    VisualFacts,
    canonical,
    pose_facts,
    rotations_of,
    three,
)
from casa_assets.checks.readers.mujoco_facts import colliders_of, facts_of_model, native_warnings, shape_bounds
from casa_assets.core.numeric import Floats, linear_from_srgb
from casa_assets.model.asset.asset import Base
from casa_assets.model.asset.behavior import Behavior
from casa_assets.model.pose import Pose

# In the name of a sphere at the end of a capsule, which is no collider of its own.
CAPSULE_END = "__end"
Json = Mapping[str, Any]


@dataclass(frozen=True)
class UrdfReading:
    """A URDF of one asset, or of many placements.

    Attributes:
        model: that MuJoCo compiles from it. robot: its root element. folder: it is in, with the files that it names.
    """

    model: mujoco.MjModel
    robot: etree._Element
    folder: Path

    @cached_property
    def bodies(self) -> tuple[BodyFacts, ...]:
        """Rows of all bodies, as the model has them."""
        return facts_of_model(self.model, base=Base.FIXED, words=ProgramTexts()).bodies

    @cached_property
    def turns(self) -> Floats:
        """(ngeom, 3, 3) body_from_geom."""
        return rotations_of(self.model.geom_quat)


def read(path: Path) -> UrdfReading:
    """Read a URDF. Raises ValueError where it, or a mesh that it names, cannot be read."""
    try:
        robot = etree.fromstring(path.read_bytes(), etree.XMLParser(resolve_entities=False, no_network=True))
    except (OSError, etree.XMLSyntaxError) as error:
        raise ValueError(f"{path.name} cannot be read: {error}") from error
    with native_warnings():
        spec = mujoco.MjSpec.from_file(str(path))
        for mesh in spec.meshes:
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # flat and open meshes load too
        return UrdfReading(spec.compile(), robot, path.parent)


def beside(path: Path) -> Json:
    """The JSON of the same name and folder as a URDF. Raises ValueError if it cannot be read."""
    try:
        data = json.loads(path.with_suffix(".json").read_text(encoding="ascii"))
    except OSError as error:
        raise ValueError(f"{path.stem}.json cannot be read: {error.strerror}") from error
    return dict(data)


@dataclass(frozen=True)
class UrdfAsset:
    """One asset of a URDF, in the frames of its links, whose origins are on the axes of their joints.

    Attributes:
        aside: the JSON that goes with it.
        placement: name of the copy where the URDF holds many, which begins all names in it. The table has them without.
    """

    read: UrdfReading
    aside: Json
    placement: str = ""

    @property
    def _prefix(self) -> str:
        return f"{self.placement}__" if self.placement else ""

    @cached_property
    def _bodies(self) -> dict[str, BodyFacts]:
        """Name in the URDF -> row."""
        rows = self.read.bodies
        return {b.name: b for b in rows if b.name == self.placement or b.name.startswith(self._prefix)}

    def _plain(self, name: str) -> str:
        return ROOT_BODY if name == self.placement else name.removeprefix(self._prefix)

    @cached_property
    def _visuals(self) -> list[etree._Element]:
        links = [link for link in self.read.robot.findall("link") if link.get("name") in self._bodies]
        return [visual for link in links for visual in link.findall("visual")]

    def table(self) -> AssetFacts:
        """The table of the asset.

        Raises:
            ValueError, KeyError: the JSON or an MTL file cannot be read, or lacks what a table needs.
        """
        aside = self.aside
        named = {CLOSED: {}, **aside["keyframes"]} if aside["keyframes"] else {}
        return AssetFacts(
            base=Base(aside["base"]),
            exclusions=aside["exclusions"],
            words=_words(aside),
            bodies=[self._body(body) for body in self._bodies.values()],
            places=[_place(item) for item in (*aside["sites"], *aside["regions"]) if item["name"] != OUTER],
            looks=[_look(visual, self.read.folder, self._prefix) for visual in self._visuals],
            poses=[self._pose(name, values) for name, values in named.items()],
        )

    def _body(self, body: BodyFacts) -> BodyFacts:
        """The row with what the JSON says of friction, springs and armature."""
        model, prefix = self.read.model, self._prefix
        geoms = [model.geom(geom).name.removeprefix(prefix) for geom in colliders_of(model, model.body(body.name).id)]
        colliders = [name for name in geoms if CAPSULE_END not in name]
        matters = [self.aside["colliders"][name] for name in colliders]
        joint = body.joint
        if joint is not None:
            name = joint.name.removeprefix(prefix)
            said = self.aside["joints"][name]
            spring = said["spring"] or {"stiffness": 0.0, "rest": 0.0}
            _, _, damping, friction, _ = joint.resistance
            resistance = (spring["stiffness"], spring["rest"], damping, friction, said["armature"])
            joint = joint.replace(name=name, resistance=resistance)
        return body.replace(
            name=self._plain(body.name),
            parent=self._plain(body.parent) if body.parent in self._bodies else "",
            colliders=len(colliders),
            frictions={(m["dynamic_friction"], m["torsional_friction"], m["rolling_friction"]) for m in matters},
            joint=joint,
        )

    def _pose(self, name: str, values: Mapping[str, float]) -> PoseFacts:
        """Poses of the links at joint positions, rad or m; joints that are not named are at zero."""
        data = mujoco.MjData(self.read.model)
        for joint, value in values.items():
            data.joint(self._prefix + joint).qpos[0] = value
        mujoco.mj_kinematics(self.read.model, data)
        frames = {
            self._plain(body): (data.body(body).xpos.tolist(), canonical(data.body(body).xquat)[0].tolist())
            for body in self._bodies
        }
        return pose_facts(name, frames, ROOT_BODY)

    def visual_bounds(self) -> dict[str, Floats]:
        """(2, 3) corners of each visual in the frame of its link, metres."""
        model, found = self.read.model, {}
        for name in (visual.get("name", "") for visual in self._visuals):
            geom = model.geom(name).id
            found[name.removeprefix(self._prefix)] = shape_bounds(model, geom, self.read.turns[geom])
        return found


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


def _numbers(element: etree._Element, name: str, default: str = "") -> list[float]:
    return [float(word) for word in element.get(name, default).split()]
