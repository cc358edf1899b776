"""Find names, paths, ranges and thresholds of a runtime's contract that an asset lacks (CON)."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np
import numpy.typing as npt
from lxml import etree

from casa_assets.checks.check import Measurement, Problem, count, not_applicable, not_run
from casa_assets.checks.package import Package
from casa_assets.checks.runtime import loader_places
from casa_assets.model.asset.asset import Asset, Collider, Joint, Link, Region, Site, Visual
from casa_assets.model.asset.behavior import Variable
from casa_assets.model.registry.contract import (
    Contract,
    JointRule,
    KeyRule,
    LinkRule,
    NamePattern,
    OpeningSide,
    Requirements,
    SiteRule,
)

# Contract names -------------------------------------------------------------------------------------------------------
# Compare the requirements of a contract with an asset: what is missing or wrong.

RuleCheck = Callable[[Asset, Requirements], list[Problem]]
Rule = TypeVar("Rule", bound=NamePattern)
# How far an axis may be off and a range from zero: what nine written digits leave, rad or m.
ROUNDING = 1e-6


def missing_requirements(asset: Asset, contract: Contract, check: RuleCheck) -> list[Problem]:
    """Problems of all requirements that apply to an asset.

    Args:
        check: finds the problems of one set of requirements. Of the sets of a choice the one counts that comes nearest
            to being met.
    """
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
                if rule.link is not None and not re.fullmatch(rule.link, link):
                    faults.append((f"{kind}/{shape.name}", f"is on link {link!r}, not on {rule.link!r}"))
                if rule.label is not None and shape.label != rule.label:
                    faults.append((f"{kind}/{shape.name}", f"is labelled {shape.label!r}, not {rule.label!r}"))
    return faults


def regions(asset: Asset, needs: Requirements) -> list[Problem]:
    """Rules on regions: that they are there, and on which link."""
    faults = list(_counted("regions", needs.regions, [r.name for r in asset.regions]))
    for rule, region in _pairs(needs.regions, asset.regions):
        if rule.link is not None and not re.fullmatch(rule.link, region.link):
            faults.append((f"regions/{region.name}", f"is on link {region.link!r}, not on {rule.link!r}"))
    return faults


def variables(asset: Asset, needs: Requirements) -> list[Problem]:
    """Rules on the variables of the behaviour."""
    found = asset.behavior.variables if asset.behavior else ()
    faults = list(_counted("behavior/variables", needs.variables, [v.name for v in found]))
    for rule, variable in _pairs(needs.variables, found):
        missing = [v for v in rule.values if v not in variable.values]
        if missing:
            faults.append((f"behavior/variables/{variable.name}", f"has no value {missing[0]!r}"))
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


T = TypeVar("T", Link, Joint, Site, Region, Variable)


def _pairs(rules: Iterable[Rule], things: Iterable[T]) -> list[tuple[Rule, T]]:
    listed = list(things)
    return [(rule, thing) for rule in rules for thing in listed if rule.matches(thing.name)]


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


# Contract paths -------------------------------------------------------------------------------------------------------
# Find elements of a model.xml that the reference runtime would miss: literal paths, fixed depths.
#
# Ref: RoboCasa v0.2 and v1.0, models/fixtures: Stove.knob_joints and burner_sites, Sink.handle_joint and water_site,
# CoffeeMachine; Fixture reads `ext_*` sites (v0.2) or `reg_*` geoms (v1.0); ranges are read from the element.

OBJECT = "./worldbody/body/body[@name='object']"
CORNERS = ("p0", "px", "py", "pz")
TOUCHED = "0"  # group of what collides


def path_faults(path: Path, asset: Asset, contract: Contract) -> Iterator[Problem]:
    """(pointer, message) of everything that a runtime would not find.

    The file is well-formed and compiles: see MJC001.
    """
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


# Contract -------------------------------------------------------------------------------------------------------------

Bounds = npt.NDArray[np.float64]
UNNAMED = "it names no contract: no runtime looks things of its kind up by name"
NO_FILE = "model.xml is missing"
# Rounding of what nine written digits hold, and of sums of lengths.
SLACK_M = 1e-4
# A threshold closer than this to an end of the range is met by chance: rad or m.
MARGIN = 1e-3


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
    return count(missing_requirements(package.asset, contract, site_faults)) if contract else _no_contract(package)


def colliders_and_visuals_meet_contract(package: Package) -> Measurement:
    """CON003: number of colliders, visuals and labels that are missing or would be mistaken."""
    contract, asset = _contract(package), package.asset
    if contract is None:
        return _no_contract(package)
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
    if contract is None:
        return _no_contract(package)
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
    for region in asset.regions:
        if region.name == "main" or not _is_inside(contract, region):
            continue
        inner = _box(asset, region)
        gap = float(max((low - inner[0]).max(), (inner[1] - high).max()))
        if gap > SLACK_M:
            worst = max(worst, gap)
            faults.append((f"regions/{region.name}", f"reaches {gap:.4f} m out of the region main"))
    return Measurement(worst, tuple(faults))


def xml_paths_meet_contract(package: Package) -> Measurement:
    """CON005: number of elements that are not at the literal paths of model.xml where RoboCasa looks."""
    contract = _contract(package)
    if contract is None:
        return _no_contract(package)
    if not package.mjcf.is_file():
        return not_run(NO_FILE)
    return count(list(path_faults(package.mjcf, package.asset, contract)))


def thresholds_meet_contract(package: Package) -> Measurement:
    """CON006: number of thresholds outside their joints' ranges, and of named poses with wrong joint positions."""
    contract, asset = _contract(package), package.asset
    if contract is None:
        return _no_contract(package)
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
    contract = _contract(package)
    if contract is None:
        return _no_contract(package)
    if not package.mjcf.is_file():
        return not_run(NO_FILE)
    return count(list(loader_places.faults(package.mjcf, contract)))


def seen_bounds(asset: Asset, contract: Contract) -> Bounds | None:
    """(2, 3) corners of what `main` has to hold: all visuals but those whose labels may stick out; asset frame, m."""
    clouds = [
        asset.asset_from_link(k.name).apply(v.mesh.vertices)
        for k in asset.links
        for v in k.visuals
        if v.label not in contract.outside
    ]
    if not clouds:
        return None
    cloud = np.concatenate(clouds)
    return np.array([cloud.min(axis=0), cloud.max(axis=0)])


def _contract(package: Package) -> Contract | None:
    # An id that the registry does not know is the business of CON001 alone.
    contract = package.contract
    return contract if contract is not None and contract.id == package.asset.contract else None


def _no_contract(package: Package) -> Measurement:
    """Result if there is no contract to compare with, with the reason."""
    named = package.asset.contract
    return not_applicable(UNNAMED) if named is None else not_run(f"registry/contracts has no {named!r}")


def _box(asset: Asset, region: Region) -> Bounds:
    half = np.array(region.size) / 2
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    points = asset.asset_from_link(region.link).apply(region.pose.apply(signs * half))
    return np.array([points.min(axis=0), points.max(axis=0)])


def _is_inside(contract: Contract, region: Region) -> bool:
    """True if a rule names this region and wants it inside `main`; extra regions may lie anywhere."""
    rules = [*contract.regions, *(r for c in contract.one_of for needs in c.any_of for r in needs.regions)]
    named = [rule for rule in rules if rule.matches(region.name)]
    return bool(named) and all(rule.inside for rule in named)


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
