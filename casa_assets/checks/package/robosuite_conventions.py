"""Find violations of robosuite's and robocasa's conventions in a model.xml.

Ref: robosuite 1.5 models/objects/objects.py and robocasa 1.0 models/objects and models/fixtures, read and tried.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from lxml import etree

Fault = tuple[str, str]
Test = tuple[bool, str]

VISUAL_GROUPS = {"1", "2"}
UNIT_ATTRIBUTES = ("specular", "shininess", "reflectance", "metallic", "roughness")
NOT_NEGATIVE = ("damping", "frictionloss", "armature", "stiffness")
NAMED = ("body", "joint", "geom", "site", "mesh", "texture", "material", "text", "exclude")
HASHED = re.compile(r".*_[0-9a-f]{12}$")
# A whole turn; a larger hinge range was meant in degrees.
FULL_TURN = 6.3
PNG = b"\x89PNG\r\n\x1a\n"


def faults(path: Path) -> Iterator[Fault]:
    """(pointer, message) of every rule that a model.xml breaks. Raises etree.XMLSyntaxError where it is no XML."""
    root = etree.parse(str(path)).getroot()
    yield from _shape(root)
    for geom in root.iter("geom"):
        yield from _said(geom, _geom(geom))
    for joint in root.iter("joint"):
        yield from _said(joint, _joint(joint))
    for material in root.iter("material"):
        yield from _said(material, _material(material))
    for element in root.iter("mesh", "texture"):
        yield from _said(element, _file(element, path.parent))
    yield from _names(root)


def visual_faults(path: Path) -> Iterator[Fault]:
    """Visual geoms that weigh or touch, as (pointer, message)."""
    for geom in etree.parse(str(path)).getroot().iter("geom"):
        if geom.get("type") == "plane" or geom.get("group") not in VISUAL_GROUPS:
            continue
        tests = (
            (geom.get("mass") == "0", "is seen and should have mass 0"),
            (geom.get("contype") == "0", "is seen and should have contype 0"),
            (geom.get("conaffinity") == "0", "is seen and should have conaffinity 0"),
        )
        yield from ((f"{path.name}/{pointer}", message) for pointer, message in _said(geom, tests))


def _said(element: etree._Element, tests: tuple[Test, ...]) -> Iterator[Fault]:
    pointer = f"{element.tag}/{element.get('name', '(unnamed)')}"
    return ((pointer, message) for holds, message in tests if not holds)


def _shape(root: etree._Element) -> Iterator[Fault]:
    outer = root.findall("worldbody/*")
    bodies = root.findall("worldbody/body/body")
    if [(b.tag, b.get("name")) for b in outer] != [("body", None)]:
        yield "worldbody", "should hold one unnamed body and nothing else"
    if [b.get("name") for b in bodies] != ["object"]:
        yield "worldbody/body", "should hold one body, called object"
    if root.find(".//freejoint") is not None or root.find(".//joint[@type='free']") is not None:
        yield "worldbody", "has a free joint; the program that merges the model adds it"
    for body in root.iter("body"):
        if body.get("name") is not None and len(body.findall("inertial")) != 1:
            yield f"body/{body.get('name')}", "should say its mass in one <inertial>"


def _geom(geom: etree._Element) -> tuple[Test, ...]:
    kind, size = geom.get("type"), geom.get("size", "").split()
    region = geom.get("name", "").startswith("reg_")
    explicit = all(geom.get(name) for name in ("pos", "size", "rgba"))
    return (
        (geom.get("group") is not None, "should name its group"),
        (kind != "sphere" or len(size) == 3, "sphere should have three sizes, the loader scales by axis"),
        (kind not in ("cylinder", "capsule") or len(size) == 2, "should have two sizes: radius and half length"),
        (
            not region or (explicit and kind in ("box", "cylinder")),
            "region should be a box or cylinder with pos, size, rgba",
        ),
        (geom.get("contype") == "0" or geom.get("friction") is not None, "touches and should name its friction"),
    )


def _joint(joint: etree._Element) -> tuple[Test, ...]:
    span = [float(n) for n in joint.get("range", "").split()]
    negative = [name for name in NOT_NEGATIVE if float(joint.get(name, "0")) < 0]
    return (
        (joint.get("limited") == "true" and len(span) == 2, "should be limited and say its range"),
        (joint.get("type") != "hinge" or all(abs(n) <= FULL_TURN for n in span), "range is not in radians"),
        (not negative, f"{', '.join(negative)} should not be negative"),
    )


def _material(material: etree._Element) -> tuple[Test, ...]:
    outside = [name for name in UNIT_ATTRIBUTES if not 0.0 <= float(material.get(name, "0")) <= 1.0]
    colors = [float(n) for n in material.get("rgba", "1 1 1 1").split()]
    return (
        (not outside, f"{', '.join(outside)} should be in 0 to 1"),
        (len(colors) == 4 and all(0.0 <= c <= 1.0 for c in colors), "rgba should be four numbers in 0 to 1"),
        (HASHED.match(material.get("name", "")) is not None, "name should end in twelve hex digits of its content"),
    )


def _file(element: etree._Element, folder: Path) -> tuple[Test, ...]:
    name = element.get("file", "")
    pure = PurePosixPath(name)
    inside = bool(name) and not pure.is_absolute() and ".." not in pure.parts and "\\" not in name
    there = inside and (folder / name).is_file()
    picture = element.tag != "texture" or (there and (folder / name).read_bytes().startswith(PNG))
    return (
        (inside, "file should be a path relative to model.xml and below it"),
        (not inside or there, f"file {name} does not exist"),
        (not there or picture, f"file {name} is not a PNG"),
        (HASHED.match(element.get("name", "")) is not None, "name should end in twelve hex digits of its content"),
    )


def _names(root: etree._Element) -> Iterator[Fault]:
    for tag in NAMED:
        names = [e.get("name") for e in root.iter(tag) if e.get("name") is not None]
        for name in sorted({n for n in names if n is not None and names.count(n) > 1}):
            yield f"{tag}/{name}", "name occurs twice"
