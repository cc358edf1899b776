"""Read a model of an SDF file: links, their visible shapes and joints."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from lxml import etree

from benchmarks.articulate.outside.model import (
    Model,
    Unreadable,
    mesh_file,
    moved,
    parents_first,
    primitive,
    roll_pitch_yaw,
    transform,
    with_closed_pose,
)
from benchmarks.articulate.outside.read.urdf import ANY_REACH, find_file, numbers, parsed
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.parts import Box, Cylinder, Sphere

# Limits beyond this are none.
FAR = 1e3


def read(path: Path, root: Path, values: Mapping[str, float]) -> Model:
    """Read the first model of an SDF file; arguments and errors as of `urdf.read`."""
    model = next(parsed(path).iter("model"), None)
    if model is None:
        raise Unreadable("it has no model")
    read_before: dict[tuple[Path, str], Floats] = {}
    elements = {str(link.get("name")): link for link in model.findall("link")}
    world = {name: _pose(link, elements) for name, link in elements.items()}
    tag = "visual" if any(link.find("visual") is not None for link in elements.values()) else "collision"
    parents, joints, at = dict.fromkeys(elements, ""), {}, dict(world)
    offset = {}
    for joint in model.findall("joint"):
        child, parent = str(joint.findtext("child")).split("::")[-1], str(joint.findtext("parent")).split("::")[-1]
        kind = joint.get("type", "fixed")
        if child not in elements:
            continue
        parents[child] = parent if parent in elements else ""
        place = joint.find("pose")
        based = place is not None and place.get("relative_to", child) == parent and parent in elements
        frame = (world[parent] if based else world[child]) @ (np.eye(4) if place is None else _of(place))
        # A link moves about the frame of its joint: its shapes are kept against that.
        offset[child] = np.linalg.inv(frame) @ world[child]
        at[child] = frame
        axis = joint.find("axis")
        if kind in ("revolute", "prismatic", "continuous") and axis is not None:
            direction = np.array(numbers(axis.findtext("xyz"), 3))
            in_model = axis.findtext("use_parent_model_frame", "0").strip() in ("1", "true")
            direction = frame[:3, :3].T @ direction if in_model else direction
            low, high = (float(axis.findtext(f"limit/{end}", "nan")) for end in ("lower", "upper"))
            no_limits = not (abs(low) < FAR and abs(high) < FAR)
            if no_limits:
                low, high = (0.0, ANY_REACH) if kind == "prismatic" else (-np.pi, np.pi)
            kind = "continuous" if no_limits and kind == "revolute" else kind
            joints[child] = (str(joint.get("name")), kind, direction, (low, high))
    links = {}
    for name in parents_first(parents):
        parent = parents[name]
        pose = np.linalg.inv(at[parent]) @ at[name] if parent in at else at[name]
        own = offset.get(name, np.eye(4))
        shapes = [moved(s, own) for s in _shapes(elements[name], tag, path.parent, root, read_before)]
        links[name] = (parent, pose, shapes)
    return Model(with_closed_pose(links, joints, values))


def _of(pose: etree._Element | None) -> Floats:
    values = numbers(None if pose is None else pose.text, 6)
    return transform(values[:3], roll_pitch_yaw(values[3:]))


def _pose(link: etree._Element, elements: Mapping[str, etree._Element]) -> Floats:
    pose = link.find("pose")
    base = "" if pose is None else pose.get("relative_to", "")
    return (_pose(elements[base], elements) if base in elements else np.eye(4)) @ _of(pose)


def _shapes(
    link: etree._Element, tag: str, folder: Path, root: Path, known: dict[tuple[Path, str], Floats]
) -> list[Floats]:
    out = []
    for visual in link.findall(tag):
        geometry = visual.find("geometry")
        for shape in [] if geometry is None else list(geometry):
            if shape.tag == "box":
                x, y, z = numbers(shape.findtext("size"), 3)
                found = primitive(Box(size=(x, y, z)))
            elif shape.tag == "cylinder":
                radius, height = (float(shape.findtext(n, "0")) for n in ("radius", "length"))
                found = primitive(Cylinder(radius=radius, height=height))
            elif shape.tag == "sphere":
                found = primitive(Sphere(radius=float(shape.findtext("radius", "0"))))
            elif shape.tag == "mesh":
                scale = numbers(shape.findtext("scale"), 3, 1.0)
                part = shape.findtext("submesh/name", "")
                file = find_file(shape.findtext("uri", "").strip(), folder, root)
                mesh = mesh_file(file, known, part, turns=True)
                if part and shape.findtext("submesh/center", "false").strip() in ("1", "true"):
                    corners = mesh.reshape(-1, 3)
                    mesh = mesh - (corners.min(axis=0) + corners.max(axis=0)) / 2
                found = moved(mesh, np.diag([*scale, 1.0]))
            else:
                continue
            out.append(moved(found, _of(visual.find("pose"))))
    return out
