"""Compare the requirements of a contract with an asset: what is missing or wrong."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TypeVar

import numpy as np

from casa_assets.checks.check import Problem
from casa_assets.model.asset.asset import Asset, Collider, Joint, Region, Site, Visual
from casa_assets.model.registry.contract import (
    Axis,
    Contract,
    JointRule,
    LinkRule,
    NamePattern,
    OpeningSide,
    Requirements,
    ShapeRule,
    SiteRule,
)

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
    for link_rule in needs.links:
        for link in asset.links:
            if link_rule.matches(link.name):
                faults += _depth(f"links/{link.name}", link_rule, depth_of(asset, link.name))
    faults += _counted("joints", needs.joints, [j.name for j in asset.joints])
    for rule in needs.joints:
        for joint in asset.joints:
            if rule.matches(joint.name):
                faults += [(f"joints/{joint.name}", message) for message in _joint(asset, joint, rule)]
    return faults


def sites(asset: Asset, needs: Requirements) -> list[Problem]:
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
                if rule.matches(shape.name):
                    faults += [(f"{kind}/{shape.name}", message) for message in _shape(link, shape, rule)]
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
    for rule in needs.variables:
        for variable in found:
            missing = [v for v in rule.values if v not in variable.values]
            if rule.matches(variable.name) and missing:
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
            there = ", ".join(names) or "none"
            yield (
                f"{kind}/{rule.name}",
                f"there are {count} of that name, {rule.min_count} wanted; there are: {there:.160}",
            )
        elif rule.max_count is not None and count > rule.max_count:
            yield f"{kind}/{rule.name}", f"there are {count} of that name, at most {rule.max_count} wanted"


T = TypeVar("T", Site, Region)


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
    if rule.axis is not None and not _along(axis_of(asset, joint), rule.axis):
        yield f"turns or slides along {axis_of(asset, joint)}, not along {rule.axis.value}"
    found = opening(joint)
    if rule.opens is not None and (found is None or rule.opens not in _ways(found)):
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


def _along(found: str, wanted: Axis) -> bool:
    return found == wanted.value or (len(wanted.value) == 1 and found[1:] == wanted.value)


def _ways(found: OpeningSide) -> tuple[OpeningSide, ...]:
    return (found,) if found is OpeningSide.BOTH else (found, OpeningSide.EITHER)


def _shape(link: str, shape: Collider | Visual, rule: ShapeRule) -> Iterator[str]:
    if rule.link is not None and not re.fullmatch(rule.link, link):
        yield f"is on link {link!r}, not on {rule.link!r}"
    if rule.label is not None and shape.label != rule.label:
        yield f"is labelled {shape.label!r}, not {rule.label!r}"
