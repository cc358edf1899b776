"""Find MJCF packages that do not compile, break conventions, contradict the asset or do not come to rest."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from lxml import etree

from casa_assets.checks.check import (
    NO_COMPILE,
    NO_JOINTS,
    Measurement,
    Package,
    Problem,
    Unmeasured,
    all_at_most,
    at_most,
    count,
    not_applicable,
    not_run,
)
from casa_assets.checks.motion import simulation
from casa_assets.checks.motion.simulation import TUNNEL_M, DropProtocol, DropResult, drop_on_floor
from casa_assets.checks.readers import mujoco_facts
from casa_assets.checks.readers.facts import asset_facts, differences, measured
from casa_assets.model.asset.asset import Base
from casa_assets.model.registry.category import RestingPose

# Robosuite conventions ------------------------------------------------------------------------------------------------
# Find violations of robosuite's and robocasa's conventions in a model.xml.
#
# Ref: robosuite 1.5 models/objects/objects.py and robocasa 1.0 models/objects and models/fixtures, read and tried.

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
    for tag, rules in (("geom", _geom_rules), ("joint", _joint_rules), ("material", _material_rules)):
        for element in root.iter(tag):
            yield from _broken(element, rules(element))
    for element in root.iter("mesh", "texture"):
        yield from _broken(element, _file_rules(element, path.parent))
    for tag in NAMED_TAGS:
        counts = Counter(element.get("name") for element in root.iter(tag))
        for name in sorted(name for name, number in counts.items() if name is not None and number > 1):
            yield f"{tag}/{name}", "name occurs twice"


def visual_faults(path: Path) -> Iterator[Problem]:
    """Visual geoms that have mass or collide."""
    for geom in etree.parse(str(path)).getroot().iter("geom"):
        if geom.get("type") == "plane" or geom.get("group") not in VISUAL_GROUPS:
            continue
        names = ("mass", "contype", "conaffinity")
        rules = tuple((geom.get(name) == "0", f"is seen and should have {name} 0") for name in names)
        yield from ((f"{path.name}/{pointer}", message) for pointer, message in _broken(geom, rules))


def _broken(element: etree._Element, rules: tuple[Rule, ...]) -> Iterator[Problem]:
    pointer = f"{element.tag}/{element.get('name', '(unnamed)')}"
    return ((pointer, message) for holds, message in rules if not holds)


def _tree_faults(root: etree._Element) -> Iterator[Problem]:
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


# Checks ---------------------------------------------------------------------------------------------------------------
# MJC001 alone reports what cannot be read or compiled; the other checks are then not run.


def mjcf_compiles(package: Package) -> Measurement:
    """MJC001: number of files that do not compile."""
    errors = {path.name: mujoco_facts.load_mjcf(path).error for path in (package.mjcf, package.scene)}
    return count((name, f"does not compile: {error}") for name, error in errors.items() if error)


def mjcf_compiles_without_warnings(package: Package) -> Measurement:
    """MJC002: number of warnings of MuJoCo."""
    return count((path.name, text) for path in _compiling(package) for text in mujoco_facts.load_mjcf(path).warnings)


def mjcf_follows_conventions(package: Package) -> Measurement:
    """MJC003: number of names, groups, sizes and files against robosuite's and robocasa's conventions."""
    return not_run(NO_COMPILE) if mujoco_facts.load_mjcf(package.mjcf).error else count(faults(package.mjcf))


def visuals_are_massless(package: Package) -> Measurement:
    """MJC004: number of visuals that have mass or collide."""
    return count(fault for path in _compiling(package) for fault in visual_faults(path))


def mjcf_equals_record(package: Package, limit: float) -> Measurement:
    """MJC005: largest difference between the compiled files and the facts of the asset."""
    paths = _compiling(package)
    expected = asset_facts(package.asset)
    worst, problems = 0.0, []
    for path in paths:
        try:
            actual = mujoco_facts.facts(path)
        except ValueError as error:
            problems.append((path.name, str(error)))
            continue
        compared = measured(differences(expected, actual), limit)
        worst = max(worst, compared.number or 0.0)
        problems += [(f"{path.name}/{pointer}", message) for pointer, message in compared.problems]
    return Measurement(worst, tuple(problems))


def comes_to_rest_after_drop(package: Package, limit: float, *protocol: float) -> Measurement:
    """MJC006: seconds until rest after a drop from twice the height, without falling through the floor."""
    drop = _drop(package, protocol)
    problems = [("scene.xml", f"simulation in trouble: {warning}") for warning in drop.warnings]
    if drop.rest_s is None or drop.rest_s + DropProtocol(*protocol).rest_s > limit:
        problems.append(("scene.xml", f"is not at rest {limit:g} s after it was dropped"))
    if drop.deepest_m > TUNNEL_M:
        problems.append(("scene.xml", f"sank {drop.deepest_m:.3f} m into the floor"))
    return Measurement(drop.rest_s, tuple(problems))


def stays_upright_after_drop(package: Package, limit: float, *protocol: float) -> Measurement:
    """MJC007: tilt after the drop, degrees."""
    if package.category.upright is RestingPose.ANY:
        return not_applicable(f"a {package.category.id} lies as it falls")
    drop = _drop(package, protocol, at_rest=True)
    return at_most(drop.tilt_deg, limit, "scene.xml", f"tipped by {drop.tilt_deg:.1f} degrees")


def rests_on_floor_after_drop(package: Package, limit: float, *protocol: float) -> Measurement:
    """MJC008: deepest penetration of the floor at rest, metres."""
    drop = _drop(package, protocol, at_rest=True)
    return at_most(drop.rest_m, limit, "scene.xml", f"rests {drop.rest_m:.4f} m inside the floor")


def joints_move_without_collision(package: Package, limit: float) -> Measurement:
    """MJC009: deepest contact between parts while each joint moves through its range, metres."""
    if not package.asset.joints:
        return not_applicable(NO_JOINTS)
    depths = {f"joints/{name}": depth for name, depth in simulation.deepest_contacts(package.scene).items()}
    if not depths:
        return not_run("scene.xml does not compile")
    return all_at_most(depths, limit, "its part sinks {:.4f} m into another on the way", NO_JOINTS)


def _compiling(package: Package) -> list[Path]:
    """The files that compile. Raises Unmeasured: neither does."""
    paths = [path for path in (package.mjcf, package.scene) if not mujoco_facts.load_mjcf(path).error]
    if not paths:
        raise Unmeasured(not_run("neither file compiles"))
    return paths


def _drop(package: Package, protocol: tuple[float, ...], at_rest: bool = False) -> DropResult:
    """Result of the drop. Raises Unmeasured: there is none, or with `at_rest` it never came to rest."""
    if package.asset.base is not Base.FREE:
        raise Unmeasured(not_applicable("it is fixed in its place and cannot fall"))
    drop = drop_on_floor(package.scene, DropProtocol(*protocol))
    if drop is None:
        raise Unmeasured(not_run("scene.xml does not compile or holds nothing free"))
    if at_rest and drop.rest_s is None:
        raise Unmeasured(not_run("it never came to rest"))
    return drop
