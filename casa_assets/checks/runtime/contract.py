"""Find names, paths, ranges and thresholds of a runtime's contract that an asset lacks (CON)."""

from __future__ import annotations

import re

import numpy as np
import numpy.typing as npt

from casa_assets.checks.check import Measurement, Problem, count, not_applicable, not_run
from casa_assets.checks.package.package import Package
from casa_assets.checks.runtime import contract_names as names
from casa_assets.checks.runtime import contract_paths, loader_places
from casa_assets.model.asset.asset import Asset, Collider, Joint, Region, Visual
from casa_assets.model.registry.contract import Contract, KeyRule

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
    faults = names.missing_requirements(package.asset, contract, names.links_and_joints)
    for each in contract.for_each:
        used = names.in_use(package.asset, contract, each.key)
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
    return (
        count(names.missing_requirements(package.asset, contract, names.sites)) if contract else _no_contract(package)
    )


def colliders_and_visuals_meet_contract(package: Package) -> Measurement:
    """CON003: number of colliders, visuals and labels that are missing or would be mistaken."""
    contract, asset = _contract(package), package.asset
    if contract is None:
        return _no_contract(package)
    faults = names.missing_requirements(asset, contract, names.shapes)
    shown: list[Collider | Visual] = []
    for link in asset.links:
        shown += [*link.colliders, *link.visuals]
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
    faults = names.missing_requirements(asset, contract, names.regions)
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
            faults.append(
                ("regions/main", f"is {spare:.4f} m wider than what is seen; {contract.main_margin_m:g} is enough")
            )
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
    return count(list(contract_paths.faults(package.mjcf, package.asset, contract)))


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
            at = threshold.position(joint.range)
            if re.fullmatch(threshold.joint, joint.name) and not _within(at, joint, threshold.share is None):
                message = (
                    f"{threshold.name} is at {at:.4g}, out of the range {joint.range[0]:.4g}..{joint.range[1]:.4g}"
                )
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


def _within(at: float, joint: Joint, fixed: bool) -> bool:
    low, high = joint.range
    margin = MARGIN if fixed else 0.0
    return low + margin <= at <= high - margin


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
