"""URDF, as MuJoCo compiles it, and the JSON that goes with it -> fact table, read without the writer, and compared."""

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

from casa_assets.checks.check import Problem
from casa_assets.checks.readers.facts import (
    CLOSED,
    ROOT_BODY,
    Cells,
    asset_facts,
    asset_table,
    compare,
    look_cells,
    place_cells,
    round_size,
    seen_from,
    state_cells,
    three,
    words_cells,
)
from casa_assets.checks.readers.mujoco_facts import (
    canonical,
    colliders_of,
    facts_of_model,
    native_warnings,
    rotations_of,
    shape_bounds,
)
from casa_assets.core.numeric import Floats, linear_from_srgb
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.behavior import Behavior
from casa_assets.model.pose import Pose

# In the name of a sphere at the end of a capsule, which is no collider by itself.
CAPSULE_END = "__end"
# Of ratios, unit vectors and radians: a URDF has nine digits of a number.
TOLERANCE = 1e-6
LENGTH_TOLERANCE_M = 1e-6  # a float32 six metres from the origin is right to 2.4e-7
Json = Mapping[str, Any]


def asset_differences(path: Path, asset: Asset) -> list[Problem]:
    """One problem for each cell in which a URDF differs from the asset that it was written from.

    Args:
        path: of the URDF; the JSON and the folders that it names are in the same folder.
    """
    try:
        return table_differences(UrdfAsset(read(path), beside(path)), asset)
    except (ValueError, KeyError, TypeError) as error:
        return [(path.name, f"cannot be read: {' '.join(str(error).split())}")]


def table_differences(written: UrdfAsset, asset: Asset) -> list[Problem]:
    """Differences between a written asset and the asset: the table of facts, and the bounds of each visual.

    Raises:
        ValueError, KeyError, TypeError: the files do not say what a table needs.
    """
    expected = on_joint_axes(asset_facts(asset))
    problems = compare(expected, written.table(), TOLERANCE, LENGTH_TOLERANCE_M)
    # Names of visuals are compared with the looks.
    found = written.visual_bounds()
    for link in asset.links:
        joint = asset.joint_of(link.name)
        anchor = np.array(joint.anchor if joint else (0.0, 0.0, 0.0))
        for visual in link.visuals:
            off = float(np.abs(found.get(visual.name, np.inf) - (visual.mesh.bounds - anchor)).max())
            if not off <= LENGTH_TOLERANCE_M:
                problems.append((f"visuals/{visual.name}", f"its bounds differ by {off:.3g} m"))
    return problems


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
    def bodies(self) -> Cells:
        """Rows of all bodies, as the model has them."""
        found: Cells = facts_of_model(self.model)["bodies"]
        return found

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
    def _names(self) -> dict[str, str]:
        """Name of each body in the URDF -> in the table."""
        found = [n for n in self.read.bodies if n == self.placement or n.startswith(self._prefix)]
        return {n: ROOT_BODY if n == self.placement else n.removeprefix(self._prefix) for n in found}

    @cached_property
    def _visuals(self) -> list[etree._Element]:
        links = [link for link in self.read.robot.findall("link") if link.get("name") in self._names]
        return [visual for link in links for visual in link.findall("visual")]

    def table(self) -> Cells:
        """The table of the asset.

        Raises:
            ValueError, KeyError: the JSON or an MTL file cannot be read, or lacks what a table needs.
        """
        aside = self.aside
        named = {CLOSED: {}, **aside["keyframes"]} if aside["keyframes"] else {}
        return asset_table(
            base=Base(aside["base"]),
            words=_words(aside),
            exclusions=aside["exclusions"],
            bodies=[(plain, self._body(name)) for name, plain in self._names.items()],
            places=[(item["name"], _place(item)) for item in (*aside["sites"], *aside["regions"])],
            looks=[_look(visual, self.read.folder, self._prefix) for visual in self._visuals],
            poses=[(name, self._pose(values)) for name, values in named.items()],
        )

    def _body(self, name: str) -> Cells:
        """The row with what the JSON says of friction, springs and armature."""
        model, prefix = self.read.model, self._prefix
        body: Cells = self.read.bodies[name]
        geoms = [model.geom(geom).name.removeprefix(prefix) for geom in colliders_of(model, model.body(name).id)]
        colliders = [name for name in geoms if CAPSULE_END not in name]
        matters = [self.aside["colliders"][name] for name in colliders]
        joint = body["joint"]
        if joint is not None:
            name = joint["name"].removeprefix(prefix)
            aside = self.aside["joints"][name]
            spring = aside["spring"] or {"stiffness": 0.0, "rest": 0.0}
            _, _, damping, friction, _ = joint["resistance"]
            resistance = (spring["stiffness"], spring["rest"], damping, friction, aside["armature"])
            joint = joint | {"name": name, "resistance": resistance}
        frictions = {(m["dynamic_friction"], m["torsional_friction"], m["rolling_friction"]) for m in matters}
        return body | {
            "parent": self._names.get(body["parent"], ""),
            "colliders": len(colliders),
            "frictions": tuple(sorted(frictions)),
            "joint": joint,
        }

    def _pose(self, values: Mapping[str, float]) -> Cells:
        """Poses of the links at joint positions, rad or m; joints that are not named are at zero."""
        data = mujoco.MjData(self.read.model)
        for joint, value in values.items():
            data.joint(self._prefix + joint).qpos[0] = value
        mujoco.mj_kinematics(self.read.model, data)
        frames = {}
        for name, plain in self._names.items():
            body = data.body(name)
            frames[plain] = {"position": body.xpos.tolist(), "quaternion": canonical(body.xquat)[0].tolist()}
        return seen_from(ROOT_BODY, frames)

    def visual_bounds(self) -> dict[str, Floats]:
        """(2, 3) corners of each visual in the frame of its link, metres."""
        model, turns = self.read.model, self.read.turns
        geoms = {visual.get("name", ""): model.geom(visual.get("name", "")).id for visual in self._visuals}
        return {name.removeprefix(self._prefix): shape_bounds(model, g, turns[g]) for name, g in geoms.items()}


def on_joint_axes(asset: Cells) -> Cells:
    """The same table in the frames of a URDF: the origin of each body is the anchor of its joint.

    Args:
        asset: in the frames of the asset, in which an anchor is a point of the body.
    """
    anchors, bodies = {}, {}
    for name, body in asset["bodies"].items():
        anchor = anchors[name] = np.array(body["joint"]["anchor"] if body["joint"] else (0.0, 0.0, 0.0))
        shapes = anchor if body["colliders"] else np.zeros(3)
        bodies[name] = body | {
            "position": _moved(body, anchor),
            "center_of_mass": three(np.array(body["center_of_mass"]) - anchor),
            "lower": three(np.array(body["lower"]) - shapes),
            "upper": three(np.array(body["upper"]) - shapes),
            "joint": body["joint"] and body["joint"] | {"anchor": (0.0, 0.0, 0.0)},
        }
    poses = {
        name: {body: cells | {"position": _moved(cells, anchors[body])} for body, cells in frames.items()}
        for name, frames in asset["poses"].items()
    }
    places = {
        name: p | {"position": three(np.array(p["position"]) - anchors[p["body"]])}
        for name, p in asset["places"].items()
    }
    return asset | {"bodies": bodies, "places": places, "poses": poses}


def _moved(frame: Cells, point: Floats) -> tuple[float, ...]:
    """Where a point of a frame is."""
    pose = Pose(position=frame["position"], quaternion=frame["quaternion"])
    return (pose @ Pose(position=three(point))).position


def _place(item: Json) -> Cells:
    place = {"position": tuple(item["position"]), "quaternion": tuple(item["quaternion"])}
    return place_cells(item["link"], item["kind"], place, round_size(item["kind"], item["size"]), item.get("color"))


def _look(visual: etree._Element, folder: Path, prefix: str) -> tuple[str, Cells]:
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
    if stated is not None and not np.allclose(
        [float(word) for word in stated.get("rgba", "").split()], shown, atol=1e-6
    ):
        raise ValueError(f"visual {name!r} has one colour in the URDF and another in {mtl['newmtl']}.mtl")
    picture = mtl.get("map_Kd", "")
    if picture and not (obj.parent / picture).is_file():
        raise ValueError(f"visual {name!r}: there is no picture {picture}")
    color = (*(linear_from_srgb(c) for c in shown[:3]), shown[3])
    light = [linear_from_srgb(float(c)) for c in mtl["Ke"].split()]
    return name.removeprefix(prefix), look_cells(color, light, Path(picture).name)


def _lines(file: Path) -> list[str]:
    try:
        return file.read_text(encoding="ascii").splitlines()
    except OSError as error:
        raise ValueError(f"{file.name} cannot be read: {error.strerror}") from error


def _words(aside: Json) -> Cells:
    shapes, joints, behavior = {**aside["visuals"], **aside["colliders"]}, aside["joints"].items(), aside["behavior"]
    return words_cells(
        classes=aside["classes"],
        portion=aside.get("portion", ""),
        labels=[(name, shape["label"]) for name, shape in shapes.items() if shape["label"]],
        grips=[(name, joint["grip"]) for name, joint in joints if joint["grip"]],
        behind=[(name, joint["behind"]) for name, joint in joints if joint["behind"]],
        contract=aside["contract"],
        behavior="" if behavior is None else Behavior.model_validate(behavior).digest,
        states=[(s["name"], state_cells(s["joint"], s["value"], *s["interval"])) for s in aside["states"]],
    )


def _child(element: etree._Element, tag: str) -> etree._Element:
    found = element.find(tag)
    if found is None:
        raise ValueError(f"<{element.tag} name={element.get('name')!r}> has no <{tag}>")
    return found
