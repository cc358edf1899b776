"""What a hand takes hold of: named, labelled, of a size that fits a gripper; and whether joints and masses are sane."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.check import Measured
from casa_assets.checks.motion import carried
from casa_assets.geometry.extent import link_bounds, shape_bounds
from casa_assets.model.asset import Asset, Collider, Joint

# What a hand may take. A rim or a tray is held where a thing has no handle of its own.
HELD = frozenset(
    {"handle", "knob", "button", "lever", "key", "lid", "rim", "pull", "spout", "roll", "tray", "rack", "seat"}
)
THINNEST_M = 0.0015


def has_a_handle(asset: Asset, limit: float | None) -> Measured:
    """What the hand takes is a labelled handle with a side that fits a gripper; metres of the widest such side."""
    assert limit is not None
    problems, widest = [], 0.0
    for joint in asset.joints:
        pointer = f"joints/{joint.name}"
        grip = _grip(asset, joint)
        if joint.grip is None:
            problems.append((pointer, "names no collider that a hand takes"))
        elif grip is None:
            problems.append((pointer, f"its grip {joint.grip!r} does not move with it"))
        elif grip.label not in HELD:
            problems.append((pointer, f"its grip is labelled {grip.label!r}, not one of {', '.join(sorted(HELD))}"))
        else:
            low, high = shape_bounds(grip.shape, grip.pose)
            side = float(min(high - low))
            widest = max(widest, side)
            if not THINNEST_M <= side <= limit:
                problems.append((pointer, f"its grip is {side:.3f} m across at its thinnest; no gripper holds that"))
    return Measured(widest, tuple(problems))


def is_upright(asset: Asset, limit: float | None) -> Measured:
    """Joints of built-in things turn or slide along x, y or z, as loaders that scale them expect; worst off, rad."""
    assert limit is not None
    if asset.contract is None:
        return Measured()
    problems, worst = [], 0.0
    for joint in asset.joints:
        pose = asset.asset_from_link(joint.child)
        axis = np.abs(pose.rotation @ np.array(joint.axis))
        off = float(np.arccos(np.clip(axis.max(), 0, 1)))
        worst = max(worst, off)
        if off > limit:
            problems.append((f"joints/{joint.name}", f"its axis is {off:.3f} rad off x, y or z"))
    return Measured(worst, tuple(problems))


def is_spread_like_matter(asset: Asset, limit: float | None) -> Measured:
    """The radius of gyration of each link lies within what its shapes span; largest share of half their diagonal."""
    assert limit is not None
    problems, worst = [], 0.0
    for link in asset.links:
        bounds = link_bounds(link)
        if bounds is None or (asset.contract is None and not asset.joints):
            continue
        half = float(np.linalg.norm(bounds[1] - bounds[0])) / 2
        gyration = float(np.sqrt(np.trace(link.inertial.tensor) / 2 / link.inertial.mass))
        share = gyration / half
        worst = max(worst, share)
        if not 0.15 * limit <= share <= limit:
            says = f"turns as if its mass were {gyration:.3f} m from its middle; its shapes reach {half:.3f} m"
            problems.append((f"links/{link.name}", says))
    return Measured(worst, tuple(problems))


def _grip(asset: Asset, joint: Joint) -> Collider | None:
    for link, _ in carried(asset, joint.child):
        for collider in asset.link(link).colliders:
            if collider.name == joint.grip:
                return collider
    return None
