"""Turn the document of a lying object upright by a quarter turn, as in a toaster or a cup.

Ref: robocasa v1.0 reads `model_upright.xml` next to `model.xml` if a task asks for it (slices of bread, straws).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from lxml import etree

from casa_assets.export.mjcf import shapes
from casa_assets.model.asset.asset import Asset
from casa_assets.model.pose import Pose

# Longer than this many times its width it stands on end (a straw), else on its edge (a slice of bread), whose thickness
# is along x: toasters have their slots beside each other along x, and tasks put bread into them without turning it.
MIN_SLENDERNESS = 2.5
ON_EDGE = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # y goes up; z, the thickness, goes along x
AROUND_Y = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])  # x goes up


def turn_of(asset: Asset) -> Pose:
    """stood_from_lying: quarter turns, and the translation that moves the middle of the object back to the origin.

    An object that is taller than wide is not turned.
    """
    lower, upper = asset.bounds
    x, y, z = upper - lower
    if z >= max(x, y):
        return Pose()
    rotation = AROUND_Y if x > MIN_SLENDERNESS * y else ON_EDGE
    corners = asset.bounds @ rotation.T
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = -(lower + upper) / 2
    return Pose.from_matrix(matrix)


def stand_up(root: etree._Element, asset: Asset) -> None:
    """Turn all elements in the document of an object in place; meshes and their files are not changed."""
    turn = turn_of(asset)
    if turn == Pose():
        return
    outer = root.find("worldbody/body")
    assert outer is not None, "the writer has made it"
    root_body = outer.find("body")
    assert root_body is not None, "the writer has made it"
    for element in root_body:
        if element.tag == "inertial":
            _turn_inertial(element, turn)
        elif element.get("name", "").startswith("reg_") and element.get("type") == "box":
            _turn_box(element, turn)
        else:
            _turn_pose(element, turn)
    corners = turn.apply(asset.bounds)
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    points = {
        "bottom_site": (0.0, 0.0, lower[2]),
        "top_site": (0.0, 0.0, upper[2]),
        "horizontal_radius_site": (*(upper[:2] - lower[:2]) / 2, 0.0),
    }
    for site in outer.findall("site"):
        if site.get("name", "") in points:
            site.set("pos", _text(points[site.get("name", "")]))


def _pose(element: etree._Element) -> Pose:
    w, x, y, z = _numbers(element.get("quat", "1 0 0 0"))
    return Pose(position=_point(element), quaternion=(w, x, y, z))


def _point(element: etree._Element) -> tuple[float, float, float]:
    x, y, z = _numbers(element.get("pos", "0 0 0"))
    return x, y, z


def _numbers(text: str) -> list[float]:
    return [float(word) for word in text.split()]


def _turn_pose(element: etree._Element, turn: Pose) -> None:
    pose = turn @ _pose(element)
    element.set("pos", _text(pose.position))
    if any(pose.quaternion[1:]):
        element.set("quat", _text(pose.quaternion))
    elif "quat" in element.attrib:
        del element.attrib["quat"]


def _turn_box(element: etree._Element, turn: Pose) -> None:
    """Turn an axis-aligned box so that it stays one: runtimes ignore the rotation of a region."""
    pose = turn @ _pose(element)
    half = np.abs(pose.rotation) @ np.array(_numbers(element.get("size", "")))
    element.set("pos", _text(pose.position))
    element.set("size", _text(half))
    if "quat" in element.attrib:
        del element.attrib["quat"]


def _turn_inertial(element: etree._Element, turn: Pose) -> None:
    xx, yy, zz, xy, xz, yz = _numbers(element.get("fullinertia", ""))
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    rotated = np.rint(turn.rotation) @ tensor @ np.rint(turn.rotation).T  # a quarter turn only changes places and signs
    element.set("pos", _text(turn.apply(np.array([_point(element)]))[0]))
    inertia = (rotated[0, 0], rotated[1, 1], rotated[2, 2], rotated[0, 1], rotated[0, 2], rotated[1, 2])
    element.set("fullinertia", shapes.numbers(inertia))


def _text(values: Iterable[float]) -> str:
    """Text with twelve decimals: a quarter turn must not leave rounding errors such as 1e-17."""
    return shapes.numbers(round(float(value), 12) for value in values)
