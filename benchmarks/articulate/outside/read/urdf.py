"""Read a URDF: links, their visible shapes and joints."""

from __future__ import annotations

import re
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
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.parts import Box, Cylinder, Sphere

# Reach of a sliding joint that states none, units. A guess: no drawer of the sources is without limits.
ANY_REACH = 0.3
MOVING = ("revolute", "continuous", "prismatic")


def numbers(text: str | None, count: int, default: float = 0.0) -> list[float]:
    """Return the numbers of an attribute, or as many defaults."""
    found = [float(w) for w in (text or "").replace(",", " ").split()]
    return found if len(found) == count else [default] * count


def read(path: Path, root: Path, values: Mapping[str, float]) -> Model:
    """Read a URDF file.

    Args:
        root: folder of the repository, in which `package://` paths are looked for. values: see `with_closed_pose`.
    Raises:
        Unreadable: it is broken, or a mesh is missing.
    """
    robot = parsed(path)
    read_before: dict[tuple[Path, str], Floats] = {}

    def shapes(link: etree._Element, tag: str) -> list[Floats]:
        out = []
        for visual in link.iter(tag):
            geometry = visual.find("geometry")
            found = None if geometry is None else _shape(geometry, path.parent, root, read_before)
            if found is not None:
                out.append(moved(found, _pose(visual.find("origin"))))
        return out

    elements = {str(link.get("name")): link for link in robot.iter("link")}
    tag = "visual" if any(next(link.iter("visual"), None) is not None for link in elements.values()) else "collision"
    parents, poses, joints = dict.fromkeys(elements, ""), {}, {}
    for joint in robot.iter("joint"):
        child, parent = joint.find("child"), joint.find("parent")
        if child is None or parent is None:
            continue
        name, kind = str(child.get("link")), joint.get("type", "fixed")
        parents[name], poses[name] = str(parent.get("link")), _pose(joint.find("origin"))
        if kind in MOVING:
            joints[name] = (str(joint.get("name")), kind, *_axis_and_range(joint, kind))
    links = {n: (parents[n], poses.get(n, np.eye(4)), shapes(elements[n], tag)) for n in parents_first(parents)}
    return Model(with_closed_pose(links, joints, values))


def parsed(path: Path) -> etree._Element:
    """Return the root of an XML file, as far as it can be read. Raises Unreadable if nothing can."""
    # Prefixes that nothing declares, as in Drake's files, are passed over.
    root = etree.fromstring(
        path.read_bytes(), etree.XMLParser(recover=True, remove_comments=True, resolve_entities=False)
    )
    if root is None:
        raise Unreadable("no XML")
    return root


def _axis_and_range(joint: etree._Element, kind: str) -> tuple[Floats, tuple[float, float]]:
    axis, limit = joint.find("axis"), joint.find("limit")
    direction = np.array(numbers(None if axis is None else axis.get("xyz"), 3)) if axis is not None else np.zeros(3)
    direction = direction if direction.any() else np.array([1.0, 0, 0])
    if kind == "continuous" or limit is None:
        return direction, (-np.pi, np.pi) if kind != "prismatic" else (0.0, ANY_REACH)
    return direction, (float(limit.get("lower", 0)), float(limit.get("upper", 0)))


def _pose(origin: etree._Element | None) -> Floats:
    if origin is None:
        return np.eye(4)
    return transform(numbers(origin.get("xyz"), 3), roll_pitch_yaw(numbers(origin.get("rpy"), 3)))


def _shape(geometry: etree._Element, folder: Path, root: Path, known: dict[tuple[Path, str], Floats]) -> Floats | None:
    for shape in geometry:
        if shape.tag == "box":
            x, y, z = numbers(shape.get("size"), 3)
            return primitive(Box(size=(x, y, z)))
        if shape.tag == "cylinder":
            return primitive(Cylinder(radius=float(shape.get("radius", 0)), height=float(shape.get("length", 0))))
        if shape.tag == "sphere":
            return primitive(Sphere(radius=float(shape.get("radius", 0))))
        if shape.tag == "mesh":
            scale = np.array(numbers(shape.get("scale"), 3, 1.0))
            mesh = mesh_file(find_file(shape.get("filename", ""), folder, root), known, turns=True)
            return moved(mesh, np.diag([*scale, 1.0]))
    return None


def find_file(name: str, folder: Path, root: Path) -> Path:
    """Return the file that a path of a URDF or SDF names: beside it, in the repository, or by the end of its path."""
    plain = re.sub(r"^(package|model|file|model_)://", "", name).lstrip("/")
    words = plain.split("/")
    tries = [folder / name, folder / plain, root / plain]
    for base in (folder, *folder.parents):
        tries += [base / "/".join(words[k:]) for k in range(len(words))]
        if base == root:
            break
    for path in tries:
        if path.is_file():
            return path
    ends = sorted(p for p in root.rglob(words[-1]) if str(p).endswith("/".join(words[-3:])))
    return ends[0] if ends else folder / plain
