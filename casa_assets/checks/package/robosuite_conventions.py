"""Find violations of robosuite's and robocasa's conventions in a model.xml.

Ref: robosuite 1.5 models/objects/objects.py and robocasa 1.0 models/objects and models/fixtures, read and tried.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from lxml import etree

from casa_assets.checks.check import Problem

# Whether a rule holds, and what to say where it does not.
Rule = tuple[bool, str]

VISUAL_GROUPS = {"1", "2"}
UNIT_ATTRIBUTES = ("specular", "shininess", "reflectance", "metallic", "roughness")
NONNEGATIVE_ATTRIBUTES = ("damping", "frictionloss", "armature", "stiffness")
NAMED_TAGS = ("body", "joint", "geom", "site", "mesh", "texture", "material", "text", "exclude")
HASHED_NAME = re.compile(r".*_[0-9a-f]{12}$")
# A little more than a whole turn, radians; a larger range of a hinge was meant in degrees.
FULL_TURN_RAD = 6.3
PNG = b"\x89PNG\r\n\x1a\n"


def faults(path: Path) -> Iterator[Problem]:
    """Every rule that a model.xml breaks. Raises etree.XMLSyntaxError where it is no XML."""
    root = etree.parse(str(path)).getroot()
    yield from _tree_faults(root)
    for geom in root.iter("geom"):
        yield from _broken(geom, _geom_rules(geom))
    for joint in root.iter("joint"):
        yield from _broken(joint, _joint_rules(joint))
    for material in root.iter("material"):
        yield from _broken(material, _material_rules(material))
    for element in root.iter("mesh", "texture"):
        yield from _broken(element, _file_rules(element, path.parent))
    yield from _repeated_names(root)


def visual_faults(path: Path) -> Iterator[Problem]:
    """Visual geoms that have mass or collide."""
    for geom in etree.parse(str(path)).getroot().iter("geom"):
        if geom.get("type") == "plane" or geom.get("group") not in VISUAL_GROUPS:
            continue
        rules = (
            (geom.get("mass") == "0", "is seen and should have mass 0"),
            (geom.get("contype") == "0", "is seen and should have contype 0"),
            (geom.get("conaffinity") == "0", "is seen and should have conaffinity 0"),
        )
        yield from ((f"{path.name}/{pointer}", message) for pointer, message in _broken(geom, rules))


def _broken(element: etree._Element, rules: tuple[Rule, ...]) -> Iterator[Problem]:
    pointer = f"{element.tag}/{element.get('name', '(unnamed)')}"
    return ((pointer, message) for holds, message in rules if not holds)


def _tree_faults(root: etree._Element) -> Iterator[Problem]:
    """Faults of the nesting of bodies."""
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


def _geom_rules(geom: etree._Element) -> tuple[Rule, ...]:
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


def _joint_rules(joint: etree._Element) -> tuple[Rule, ...]:
    span = [float(n) for n in joint.get("range", "").split()]
    negative = [name for name in NONNEGATIVE_ATTRIBUTES if float(joint.get(name, "0")) < 0]
    return (
        (joint.get("limited") == "true" and len(span) == 2, "should be limited and say its range"),
        (joint.get("type") != "hinge" or all(abs(n) <= FULL_TURN_RAD for n in span), "range is not in radians"),
        (not negative, f"{', '.join(negative)} should not be negative"),
    )


def _material_rules(material: etree._Element) -> tuple[Rule, ...]:
    outside = [name for name in UNIT_ATTRIBUTES if not 0.0 <= float(material.get(name, "0")) <= 1.0]
    colors = [float(n) for n in material.get("rgba", "1 1 1 1").split()]
    return (
        (not outside, f"{', '.join(outside)} should be in 0 to 1"),
        (len(colors) == 4 and all(0.0 <= c <= 1.0 for c in colors), "rgba should be four numbers in 0 to 1"),
        (
            HASHED_NAME.match(material.get("name", "")) is not None,
            "name should end in twelve hex digits of its content",
        ),
    )


def _file_rules(element: etree._Element, folder: Path) -> tuple[Rule, ...]:
    name = element.get("file", "")
    pure = PurePosixPath(name)
    inside = bool(name) and not pure.is_absolute() and ".." not in pure.parts and "\\" not in name
    exists = inside and (folder / name).is_file()
    picture = element.tag != "texture" or (exists and (folder / name).read_bytes().startswith(PNG))
    return (
        (inside, "file should be a path relative to model.xml and below it"),
        (not inside or exists, f"file {name} does not exist"),
        (not exists or picture, f"file {name} is not a PNG"),
        (HASHED_NAME.match(element.get("name", "")) is not None, "name should end in twelve hex digits of its content"),
    )


def _repeated_names(root: etree._Element) -> Iterator[Problem]:
    for tag in NAMED_TAGS:
        names = [e.get("name") for e in root.iter(tag) if e.get("name") is not None]
        for name in sorted({n for n in names if n is not None and names.count(n) > 1}):
            yield f"{tag}/{name}", "name occurs twice"
