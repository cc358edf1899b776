"""Repair an articulated asset that fails its checks: fit collision shapes anew, open doors wider, exclude contacts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from casa_assets import registry
from casa_assets.articulate.assemble import ROOT
from casa_assets.checks.motion.joint_travel import joint_travels
from casa_assets.checks.motion.sweep import Penetration, contacts_of_files
from casa_assets.export import mjcf
from casa_assets.model.asset.asset import Asset, Exclusion
from casa_assets.model.asset.joint import JointKind
from casa_assets.model.issue import Report
from casa_assets.pipeline.articulate.build import ArticulateResult

# Checks of collision shapes that shapes fitted anew may pass: their box, where mass lies, and what they cover.
SHAPE_CODES = frozenset({"AST008", "AST009", "AST016"})
# The check of parts that run into each other, and its limit in registry/limits.yaml.
CONTACT_CODE, CONTACT_LIMIT = "MJC009", "sweep_penetration_m"
# Angles to which a door is opened so that what is behind it gets out. Choices: hinges of cabinets go that far.
WIDER_RAD = (math.radians(110.0), math.radians(135.0), math.radians(150.0))
# Pairs of parts that are looked for one after another; of each joint only the deepest contact is known at a time.
MAX_ROUNDS = 6


def mend(built: ArticulateResult, named: ArticulateResult, report: Report) -> ArticulateResult | None:
    """Return the asset with what its checks complain of mended; None where nothing of it can be.

    Args:
        built: under the names of its parts. named: the same under the names that runtimes look for, as it was checked.
    """
    child = {joint.name: joint.child for joint in named.asset.joints}
    part_of = {child[joint]: part for part, joint in named.joints.items()}
    links = [issue.pointer.split("/")[1] for issue in report.errors if issue.code in SHAPE_CODES]
    refit = {part_of.get(link, ROOT) for link in links} - built.spec.refit
    mended = built.with_refit_shapes(refit) if refit else built
    if any(issue.code == CONTACT_CODE for issue in report.errors):
        mended = _without_contacts(_with_doors_wider(mended))
    return None if mended is built else mended


def _with_doors_wider(built: ArticulateResult) -> ArticulateResult:
    """Return the asset with doors opened wider where what moves behind them runs into them."""
    joints = {joint.name: joint for joint in built.asset.joints}
    for name, (contact, _) in _contacts(built.asset).items():
        door = joints.get(joints[name].behind or "")
        if door is None or door.kind is not JointKind.HINGE or door.child not in _links(contact):
            continue
        plan = next(p.joint for p in built.articulation.parts if p.name == door.child)
        for angle in WIDER_RAD:
            reason = f"{plan.reason}; opened so far that {joints[name].child} gets out"
            wider = built.with_joints({door.child: plan.replace(range=(0.0, angle), reason=reason)})
            is_free = {t.joint: t.free_share for t in joint_travels(wider.asset, mjcf.write(wider.asset), pushed=False)}
            still = _contacts(wider.asset).get(name)
            if is_free[door.name] >= 1.0 and (still is None or door.child not in _links(still[0])):
                built = wider
                break
    return built


def _without_contacts(built: ArticulateResult) -> ArticulateResult:
    """Return the asset with parts that run into each other left out of contact, and what of it is to be looked at.

    Shapes that overlap where all is closed are coarser than what is seen. What runs into another part on its way does
    so by its joint, by its kind, or by shapes that cannot tell: a person has to look.
    """
    asset, words = built.asset, list(built.contacts)
    for _ in range(MAX_ROUNDS):
        found = _contacts(asset)
        if not found:
            break
        pairs: dict[tuple[str, str], None] = {}
        for name, (contact, at_rest) in found.items():
            first, second = _links(contact)
            pairs[first, second] = None
            moving = next(joint.child for joint in asset.joints if joint.name == name)
            if contact.depth > at_rest + registry.load().limits[CONTACT_LIMIT]:
                words.append(f"{moving} runs into {second if moving == first else first} on its way")
        exclusions = tuple(Exclusion(first=first, second=second) for first, second in pairs)
        asset = asset.replace(exclusions=(*asset.exclusions, *exclusions))
    return replace(built, asset=asset, contacts=tuple(dict.fromkeys(words)))


def _contacts(asset: Asset) -> Mapping[str, tuple[Penetration, float]]:
    """Return the deepest contact of each joint that goes deeper into another part than it may, by the joint's name.

    With it stands how deep the two parts are in each other where all is closed, metres.
    """
    limit = registry.load().limits[CONTACT_LIMIT]
    return {name: row for name, row in contacts_of_files(mjcf.write(asset)).items() if row[0].depth > limit}


def _links(contact: Penetration) -> tuple[str, str]:
    """Return the two links that touch."""
    return contact.body1, contact.body2
