"""Find fixtures that a runtime cannot operate: names, sites, regions and poses of its contract."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import mujoco
import numpy as np
from lxml import etree

from casa_assets.checks.check import Measurement, Package, Problem, Unmeasured, count, not_applicable, not_run
from casa_assets.checks.readers.mujoco_facts import load_mjcf
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.asset import Asset, Collider, Joint, Link, Region, Site, Visual
from casa_assets.model.asset.behavior import Variable
from casa_assets.model.registry.contract import (
    Contract,
    JointRule,
    KeyRule,
    LinkRule,
    NamePattern,
    OpeningSide,
    PlaceRule,
    Requirements,
    SiteRule,
)

# The arithmetic of the loader. Ref: RoboCasa v1.0, models/fixtures: Fixture takes the `pos` and `size` that are written
# on a region's geom for a box on the fixture itself, whatever body the geom is in; get_reset_regions puts things on its
# lower side, if that is within heights above the floor; anchor_offset is the `pos` of a site next to the body `object`,
# under the same parent; Sink looks for `water` in its basins.
PREFIX = "reg_"
OUTER = "main"
# A cube of this edge is put into the middle of a region, from this far above its lower side; where nothing is that
# far below that side, it falls.
CUBE_M, LIFT_M, MAX_FALL_M = 0.05, 0.015, 0.02
RuleCheck = Callable[[Asset, Requirements], list[Problem]]
Rule = TypeVar("Rule", bound=NamePattern)
# How far an axis may be off and a range from zero: what nine written digits leave, rad or m.
ROUNDING = 1e-6
T = TypeVar("T", Link, Joint, Site, Region, Variable)
# Ref: RoboCasa v0.2 and v1.0, models/fixtures: Stove.knob_joints and burner_sites, Sink.handle_joint and water_site,
# CoffeeMachine; Fixture reads `ext_*` sites (v0.2) or `reg_*` geoms (v1.0); ranges are read from the element.
OBJECT = "./worldbody/body/body[@name='object']"
CORNERS = ("p0", "px", "py", "pz")
TOUCHED = "0"  # group of what collides
UNNAMED = "it names no contract: no runtime looks things of its kind up by name"
SLACK_M = 1e-4  # rounding of what nine written digits hold, and of sums of lengths
MARGIN = 1e-3  # a threshold closer than this to an end of the range is met by chance: rad or m


@dataclass(frozen=True)
class ReadRegion:
    """A region as the loader reads it: its corners on the fixture, metres, and the body that its geom is in."""

    lower: Floats
    upper: Floats
    body: str

    @property
    def middle(self) -> Floats:
        """Its middle on the fixture, metres."""
        return (self.lower + self.upper) / 2


def faults(path: Path, contract: Contract) -> Iterator[Problem]:
    """(pointer, message) of everything that the loader finds elsewhere than it is in the model, or not at all.

    Reports nothing that other checks report: a file that does not compile (MJC001), without `object` (CON005), without
    regions of a name (CON004).
    """
    model = load_mjcf(path).model
    if model is None or mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "object") < 0:
        return
    root = etree.parse(str(path)).getroot()
    regions = read_regions(root)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    origin = data.body("object").xpos
    for name, region in regions.items():
        off = float(np.linalg.norm(data.geom(PREFIX + name).xpos - origin - region.middle))
        if off > SLACK_M:
            message = f"is {off:.4f} m from where RoboCasa takes it to be; its body's frame should be that of object"
            yield f"model.xml/geom/{PREFIX}{name}", message
    for rule in contract.places:
        yield from _missing_places(model, data, regions, rule)
    for name in contract.beside:
        site = root.find(f"./worldbody/body/site[@name='{name}']")
        if site is None or site.get("pos") is None:
            yield f"model.xml/site/{name}", "is not at worldbody/body/site with a pos, where RoboCasa looks"
    for name, pattern in contract.falls_into.items():
        if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, name) < 0:
            yield f"model.xml/site/{name}", f"is missing; it has to be above one of the regions {pattern!r}"
            continue
        at = (data.site(name).xpos - origin)[:2]
        into = [found for of, found in regions.items() if re.fullmatch(pattern, of)]
        if not any((found.lower[:2] < at).all() and (at < found.upper[:2]).all() for found in into):
            yield f"model.xml/site/{name}", f"is above none of the regions {pattern!r} with the joints at zero"


def read_regions(root: etree._Element) -> dict[str, ReadRegion]:
    """Name without `reg_` -> region, of all geoms that the loader takes for regions."""
    found = {}
    for body in root.iter("body"):
        for geom in body.findall("geom"):
            name = geom.get("name", "")
            if name.startswith(PREFIX):
                middle, half = (np.array([float(n) for n in geom.get(key, "").split()]) for key in ("pos", "size"))
                if geom.get("type") == "cylinder":
                    half = np.array([half[0], half[0], half[1]])
                found[name.removeprefix(PREFIX)] = ReadRegion(middle - half, middle + half, body.get("name", ""))
    return found


def _missing_places(
    model: mujoco.MjModel, data: mujoco.MjData, regions: Mapping[str, ReadRegion], rule: PlaceRule
) -> Iterator[Problem]:
    """Places that RoboCasa offers in too small a number, that move, or that have nothing under them."""
    foot = float(regions[OUTER].lower[2]) if OUTER in regions else 0.0
    top = float(regions[OUTER].upper[2]) if OUTER in regions else 0.0
    stands = rule.stands_m - (top if rule.let_in else foot)
    offered = 0
    named = {name: region for name, region in regions.items() if re.fullmatch(rule.regions, name)}
    for name, region in named.items():
        if region.upper[2] - region.lower[2] < rule.min_height_m:
            continue
        pointer, height = f"model.xml/geom/{PREFIX}{name}", stands + float(region.lower[2])
        if rule.fixed and region.body != "object":
            yield pointer, f"is in the body {region.body!r}, which moves; RoboCasa takes it for a shelf"
        if rule.heights_m is None or rule.heights_m[0] <= height <= rule.heights_m[1]:
            offered += 1
        if not _holds(model, data, region):
            below = f"has nothing within {MAX_FALL_M:g} m below the middle of its lower side"
            yield pointer, f"{below}; what is put there falls"
    if named and offered < rule.min_count:
        yield "model.xml/geom", f"{offered} regions {rule.regions!r} are where things are put, {rule.min_count} wanted"


def _holds(model: mujoco.MjModel, data: mujoco.MjData, region: ReadRegion) -> bool:
    """True if something is under a cube in the middle of a region's lower side."""
    edge = min(CUBE_M, *(0.75 * (region.upper - region.lower)[:2]))
    start = data.body("object").xpos + np.array([*region.middle[:2], region.lower[2] + LIFT_M])
    groups, geom = np.array([1, 0, 0, 0, 0, 0], dtype=np.uint8), np.zeros(1, dtype=np.int32)
    for x in np.linspace(-edge / 2, edge / 2, 5):
        for y in np.linspace(-edge / 2, edge / 2, 5):
            point = start + np.array([x, y, 0.0])
            reach = mujoco.mj_ray(model, data, point, [0.0, 0.0, -1.0], groups, 1, -1, geom)
            if 0.0 <= reach <= LIFT_M + MAX_FALL_M:
                return True
    return False


def missing_requirements(asset: Asset, contract: Contract, check: RuleCheck) -> list[Problem]:
    """Problems that `check` finds of all requirements of an asset; of a choice, the nearest set."""
    problems = check(asset, contract)
    for choice in contract.one_of:
        nearest: list[Problem] = min([check(asset, needs) for needs in choice.any_of], key=len)
        problems += nearest
    for each in contract.for_each:
        for value in in_use(asset, contract, each.key):
            problems += check(asset, each.needs.filled(each.key, value))
    return problems


def in_use(asset: Asset, contract: Contract, key: str) -> list[str]:
    """Values of a `for_each` that the asset makes use of, in the order of the contract."""
    each = next(e for e in contract.for_each if e.key == key)
    names = [j.name for j in asset.joints] + [s.name for s in asset.sites] + [r.name for r in asset.regions]
    names += [c.name for k in asset.links for c in k.colliders]
    used = []
    for value in each.values:
        patterns = [p.replace("{" + key + "}", value) for p in each.used_by]
        if any(re.fullmatch(p, name) for p in patterns for name in names):
            used.append(value)
    return used


def links_and_joints(asset: Asset, needs: Requirements) -> list[Problem]:
    """Rules on links and on joints."""
    faults = list(_counted("links", needs.links, [k.name for k in asset.links]))
    for link_rule, link in _pairs(needs.links, asset.links):
        faults += _depth(f"links/{link.name}", link_rule, depth_of(asset, link.name))
    faults += _counted("joints", needs.joints, [j.name for j in asset.joints])
    for rule, joint in _pairs(needs.joints, asset.joints):
        faults += [(f"joints/{joint.name}", message) for message in _joint(asset, joint, rule)]
    return faults


def site_faults(asset: Asset, needs: Requirements) -> list[Problem]:
    """Rules on sites."""
    faults = list(_counted("sites", needs.sites, [s.name for s in asset.sites]))
    for rule, site in _pairs(needs.sites, asset.sites):
        pointer = f"sites/{site.name}"
        faults += _depth(pointer, rule, depth_of(asset, site.link))
        if rule.kind is not None and site.kind != rule.kind:
            faults.append((pointer, f"is a {site.kind}; it should be a {rule.kind}"))
    return faults


def shapes(asset: Asset, needs: Requirements) -> list[Problem]:
    """Rules on colliders and visuals."""
    faults: list[Problem] = []
    for kind, rules in (("colliders", needs.colliders), ("visuals", needs.visuals)):
        found: list[tuple[str, Collider | Visual]] = [
            (k.name, s) for k in asset.links for s in (k.colliders if kind == "colliders" else k.visuals)
        ]
        faults += _counted(kind, rules, [shape.name for _, shape in found])
        for rule in rules:
            for link, shape in found:
                if not rule.matches(shape.name):
                    continue
                faults += _on_link(f"{kind}/{shape.name}", rule.link, link)
                if rule.label is not None and shape.label != rule.label:
                    faults.append((f"{kind}/{shape.name}", f"is labelled {shape.label!r}, not {rule.label!r}"))
    return faults


def regions(asset: Asset, needs: Requirements) -> list[Problem]:
    """Rules on regions: that they are there, and on which link."""
    faults = list(_counted("regions", needs.regions, [r.name for r in asset.regions]))
    for rule, region in _pairs(needs.regions, asset.regions):
        faults += _on_link(f"regions/{region.name}", rule.link, region.link)
    return faults


def variables(asset: Asset, needs: Requirements) -> list[Problem]:
    """Rules on the variables of the behaviour."""
    found = asset.behavior.variables if asset.behavior else ()
    faults = list(_counted("behavior/variables", needs.variables, [v.name for v in found]))
    for rule, variable in _pairs(needs.variables, found):
        missing = [v for v in rule.values if v not in variable.values]
        faults += [(f"behavior/variables/{variable.name}", f"has no value {value!r}") for value in missing[:1]]
    return faults


def depth_of(asset: Asset, link: str) -> int:
    """Number of links that carry this one; 0 for `object`."""
    parent = asset.link(link).parent
    return 0 if parent is None else 1 + depth_of(asset, parent)


def axis_of(asset: Asset, joint: Joint) -> str:
    """`+x`, `-z`, ...: direction of the axis in the asset frame, or `askew`."""
    axis = asset.asset_from_link(joint.child).rotation @ np.array(joint.axis)
    k = int(np.argmax(np.abs(axis)))
    if abs(abs(axis[k]) - 1.0) > ROUNDING:
        return "askew"
    return ("+" if axis[k] > 0 else "-") + "xyz"[k]


def opening(joint: Joint) -> OpeningSide | None:
    """Side of zero that the range lies on; None if zero is neither an end of it nor within it."""
    low, high = joint.range
    if abs(low) <= ROUNDING:
        return OpeningSide.POSITIVE
    if abs(high) <= ROUNDING:
        return OpeningSide.NEGATIVE
    return OpeningSide.BOTH if low < 0.0 < high else None


def _counted(kind: str, rules: Iterable[NamePattern], names: Sequence[str]) -> Iterator[Problem]:
    for rule in rules:
        count = sum(rule.matches(name) for name in names)
        if count < rule.min_count:
            there = f"{', '.join(names) or 'none':.160}"
            message = f"there are {count} of that name, {rule.min_count} wanted; there are: {there}"
            yield f"{kind}/{rule.name}", message
        elif rule.max_count is not None and count > rule.max_count:
            yield f"{kind}/{rule.name}", f"there are {count} of that name, at most {rule.max_count} wanted"


def _pairs(rules: Iterable[Rule], things: Iterable[T]) -> list[tuple[Rule, T]]:
    listed = list(things)
    return [(rule, thing) for rule in rules for thing in listed if rule.matches(thing.name)]


def _on_link(pointer: str, wanted: str | None, link: str) -> list[Problem]:
    if wanted is None or re.fullmatch(wanted, link):
        return []
    return [(pointer, f"is on link {link!r}, not on {wanted!r}")]


def _depth(pointer: str, rule: LinkRule | SiteRule, depth: int) -> list[Problem]:
    if rule.depth is None or rule.depth == depth:
        return []
    return [(pointer, f"is {depth} links below object, not {rule.depth}: RoboCasa looks at a fixed depth")]


def _joint(asset: Asset, joint: Joint, rule: JointRule) -> Iterator[str]:
    low, high = joint.range
    if rule.kind is not None and joint.kind is not rule.kind:
        yield f"is a {joint.kind.value}, not a {rule.kind.value}"
    axis = axis_of(asset, joint)
    # A rule without a sign is met by both directions.
    if rule.axis is not None and rule.axis.value not in (axis, axis[1:]):
        yield f"turns or slides along {axis}, not along {rule.axis.value}"
    found = opening(joint)
    ways = {found} if found in (None, OpeningSide.BOTH) else {found, OpeningSide.EITHER}
    if rule.opens is not None and rule.opens not in ways:
        yield f"has the range {low:.4g}..{high:.4g}; it should open {rule.opens.value}, zero is closed"
    if rule.reach is not None and (low > rule.reach[0] + ROUNDING or high < rule.reach[1] - ROUNDING):
        yield f"has the range {low:.4g}..{high:.4g}, which does not reach {rule.reach[0]:.4g}..{rule.reach[1]:.4g}"
    if rule.travel is not None and not rule.travel[0] - ROUNDING <= high - low <= rule.travel[1] + ROUNDING:
        yield f"travels {high - low:.4g}, not {rule.travel[0]:.4g}..{rule.travel[1]:.4g}"
    if rule.depth is not None and depth_of(asset, joint.child) != rule.depth:
        depth = depth_of(asset, joint.child)
        yield f"moves a link {depth} below object, not {rule.depth}: RoboCasa looks at a fixed path"
    if rule.link is not None and not re.fullmatch(rule.link, joint.child):
        yield f"moves link {joint.child!r}, not {rule.link!r}"


def path_faults(path: Path, asset: Asset, contract: Contract) -> Iterator[Problem]:
    """(pointer, message) of everything that a runtime would not find in a file that compiles (MJC001)."""
    try:
        root = etree.parse(str(path)).getroot()
        body = root.find(OBJECT)
    except etree.XMLSyntaxError:
        body = None
    if body is None:
        yield "model.xml", "has no worldbody/body/body called object"
        return
    if any(float(n) != 0.0 for n in body.get("pos", "0").split()) or body.get("quat") is not None:
        yield "model.xml/object", "is moved or turned; RoboCasa takes places on it as places on the fixture"
    if root.find("actuator") is not None:
        yield "model.xml/actuator", "should not be there: RoboCasa would hand it to the robot's controller"
    for needs in met(asset, contract):
        yield from _deep_elements(root, asset, needs)
        # Named colliders are geoms that touch; names of contacts and handles are looked up as geoms.
        groups = {g.get("name", ""): g.get("group") for g in root.iter("geom")}
        for rule in needs.colliders:
            for name in (c.name for k in asset.links for c in k.colliders if rule.matches(c.name)):
                if groups.get(name) != TOUCHED:
                    yield f"model.xml/geom/{name}", f"should be a geom of group {TOUCHED}, which is touched"
    geoms = {g.get("name") for g in root.iter("geom")}
    for region in asset.regions:
        if f"reg_{region.name}" not in geoms:
            yield f"model.xml/geom/reg_{region.name}", "is not there: v1.0 reads regions from geoms"
    if any(region.name == "main" for region in asset.regions):
        sites = {s.get("name") for s in body.findall("site")}
        missing = [f"ext_{end}" for end in CORNERS if f"ext_{end}" not in sites]
        if missing:
            yield f"model.xml/site/{missing[0]}", "is not on object: v0.2 reads the outer size from sites"


def met(asset: Asset, contract: Contract) -> list[Requirements]:
    """All needs that apply to the asset: its own, the nearest set of each choice, and those of each value in use."""
    found: list[Requirements] = [contract]
    looks = (links_and_joints, site_faults, shapes, regions)
    for choice in contract.one_of:
        found.append(min(choice.any_of, key=lambda needs: sum(len(look(asset, needs)) for look in looks)))
    for each in contract.for_each:
        found += [each.needs.filled(each.key, value) for value in in_use(asset, contract, each.key)]
    return found


def _deep_elements(root: etree._Element, asset: Asset, needs: Requirements) -> Iterator[Problem]:
    """Joints and sites that are not at the depth where RoboCasa looks, or do not say what it reads."""
    joints, sites = _pairs(needs.joints, asset.joints), _pairs(needs.sites, asset.sites)
    named = [("joint", rule.depth, joint.name) for rule, joint in joints]
    named += [("site", rule.depth, site.name) for rule, site in sites]
    for tag, depth, name in named:
        if depth is None:
            continue
        where = "./worldbody/body/body" + "/body" * depth + f"/{tag}"
        element = root.find(f"{where}[@name='{name}']")
        if element is None:
            yield f"model.xml/{tag}/{name}", f"is not at {where[2:]}, where RoboCasa looks"
        elif tag == "joint" and len(element.get("range", "").split()) != 2:
            yield f"model.xml/joint/{name}", "says no range; RoboCasa reads it from the element"
        elif tag == "site" and (element.get("pos") is None or element.get("size") is None):
            yield f"model.xml/site/{name}", "should say pos and size; RoboCasa reads them from the element"


def links_and_joints_meet_contract(package: Package) -> Measurement:
    """CON001: number of links and joints that are missing or of wrong kind, axis, sign, range or depth."""
    if package.asset.contract is None:
        return not_applicable(UNNAMED)
    contract = package.contract
    if contract is None or contract.id != package.asset.contract:
        message = f"there is no contract {package.asset.contract!r} in registry/contracts"
        return Measurement(1.0, (("contract", message),))
    faults = missing_requirements(package.asset, contract, links_and_joints)
    for each in contract.for_each:
        used = in_use(package.asset, contract, each.key)
        if len(used) < each.min_count:
            message = f"{len(used)} in use, {each.min_count} wanted: {', '.join(each.values)}"
            faults.append((f"contract/for_each/{each.key}", message))
    for joint in package.asset.joints:
        for pattern in contract.forbidden_joints:
            if re.fullmatch(pattern, joint.name):
                faults.append((f"joints/{joint.name}", f"a runtime mistakes it for another: {pattern!r}"))
    return count(faults)


def sites_meet_contract(package: Package) -> Measurement:
    """CON002: number of sites that are missing or on another link than RoboCasa expects."""
    contract = _contract(package)
    return count(missing_requirements(package.asset, contract, site_faults))


def colliders_and_visuals_meet_contract(package: Package) -> Measurement:
    """CON003: number of colliders, visuals and labels that are missing or would be mistaken."""
    contract, asset = _contract(package), package.asset
    faults = missing_requirements(asset, contract, shapes)
    shown: list[Collider | Visual] = []
    for link in asset.links:
        shown += (*link.colliders, *link.visuals)
    labels = {s.label for s in shown}
    faults += [("links", f"nothing is labelled {label!r}") for label in contract.labels if label not in labels]
    for shape in shown:
        for pattern in contract.forbidden_geoms:
            if re.fullmatch(pattern, shape.name):
                faults.append((f"links/{shape.name}", f"a runtime mistakes it for another: {pattern!r}"))
    return count(faults)


def regions_meet_contract(package: Package, limit: float) -> Measurement:
    """CON004: largest distance that a region is off: `main` encloses what is seen, interiors lie in it; metres."""
    contract, asset = _contract(package), package.asset
    faults = missing_requirements(asset, contract, regions)
    main = next((r for r in asset.regions if r.name == "main"), None)
    if main is None:
        return Measurement(0.0, tuple(faults))
    worst = 0.0
    low, high = _box(asset, main)
    seen = seen_bounds(asset, contract)
    if seen is not None:
        gap = float(max((low - seen[0]).max(), (seen[1] - high).max()))
        whole = asset.bounds
        spare = float(max((whole[0] - low).max(), (high - whole[1]).max()))
        worst = max(gap, 0.0)
        if gap > limit:
            faults.append(("regions/main", f"leaves out {gap:.4f} m of what is seen"))
        if spare > contract.main_margin_m:
            wider = f"is {spare:.4f} m wider than what is seen"
            faults.append(("regions/main", f"{wider}; {contract.main_margin_m:g} is enough"))
    rules = [*contract.regions, *(r for c in contract.one_of for needs in c.any_of for r in needs.regions)]
    for region in asset.regions:
        # Regions that no rule names may lie anywhere.
        named = [rule for rule in rules if rule.matches(region.name)]
        if region.name == "main" or not named or not all(rule.inside for rule in named):
            continue
        inner = _box(asset, region)
        gap = float(max((low - inner[0]).max(), (inner[1] - high).max()))
        if gap > SLACK_M:
            worst = max(worst, gap)
            faults.append((f"regions/{region.name}", f"reaches {gap:.4f} m out of the region main"))
    return Measurement(worst, tuple(faults))


def xml_paths_meet_contract(package: Package) -> Measurement:
    """CON005: number of elements that are not at the literal paths of model.xml where RoboCasa looks."""
    contract = _contract(package, with_file=True)
    return count(path_faults(package.mjcf, package.asset, contract))


def thresholds_meet_contract(package: Package) -> Measurement:
    """CON006: number of thresholds outside their joints' ranges, and of named poses with wrong joint positions."""
    contract, asset = _contract(package), package.asset
    if not contract.thresholds and not contract.keyframes:
        return not_applicable("its contract names no threshold and no pose")
    faults = []
    for threshold in contract.thresholds:
        for joint in asset.joints:
            at, (low, high) = threshold.position(joint.range), joint.range
            margin = MARGIN if threshold.share is None else 0.0
            if re.fullmatch(threshold.joint, joint.name) and not low + margin <= at <= high - margin:
                message = f"{threshold.name} is at {at:.4g}, out of the range {low:.4g}..{high:.4g}"
                faults.append((f"joints/{joint.name}", message))
    for rule in contract.keyframes:
        faults += _pose(asset, rule)
    return count(faults)


def places_meet_contract(package: Package) -> Measurement:
    """CON008: number of regions and sites of model.xml that are elsewhere for RoboCasa than in the model."""
    return count(faults(package.mjcf, _contract(package, with_file=True)))


def seen_bounds(asset: Asset, contract: Contract) -> Floats | None:
    """(2, 3) corners of what `main` has to hold: all visuals but those whose labels may stick out; asset frame, m."""
    shown = ((k.name, v.mesh.vertices) for k in asset.links for v in k.visuals if v.label not in contract.outside)
    clouds = [asset.asset_from_link(link).apply(vertices) for link, vertices in shown]
    if not clouds:
        return None
    cloud = np.concatenate(clouds)
    return np.array([cloud.min(axis=0), cloud.max(axis=0)])


def _contract(package: Package, with_file: bool = False) -> Contract:
    """The contract to compare with. Raises Unmeasured without one, or without the file that is asked for."""
    contract, named = package.contract, package.asset.contract
    # An id that the registry does not know is the business of CON001 alone.
    if contract is None or contract.id != named:
        raise Unmeasured(not_applicable(UNNAMED) if named is None else not_run(f"registry/contracts has no {named!r}"))
    if with_file and not package.mjcf.is_file():
        raise Unmeasured(not_run("model.xml is missing"))
    return contract


def _box(asset: Asset, region: Region) -> Floats:
    half = np.array(region.size) / 2
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    points = asset.asset_from_link(region.link).apply(region.pose.apply(signs * half))
    return np.array([points.min(axis=0), points.max(axis=0)])


def _pose(asset: Asset, rule: KeyRule) -> list[Problem]:
    key = next((k for k in asset.keyframes if k.name == rule.name), None)
    if key is None:
        return [(f"keyframes/{rule.name}", "there is no such pose")] if rule.min_count else []
    stands = {at.joint: at.value for at in key.joints}
    faults = []
    for joint in asset.joints:
        share = stands.get(joint.name, 0.0) / max(joint.range, key=abs)
        wanted = [least for pattern, least in rule.joint_shares.items() if re.fullmatch(pattern, joint.name)]
        if any(share < least for least in wanted):
            message = f"{joint.name} stands at {share:.2f} of its way, not at {max(wanted):.2f}"
            faults.append((f"keyframes/{rule.name}", message))
    return faults
