"""Find the front of a thing: its handle goes to +x, its length along x, its face to -y."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from casa_assets.core.typing import Floats
from casa_assets.ingest.pose.cloud import plan_axes
from casa_assets.ingest.pose.evidence import FOOT_SHARE
from casa_assets.model.registry.category import Category, FrontRule

# A turn smaller than this is left undone, radians: files that lie along their axes stay as they are.
MIN_TURN_RAD = np.radians(3.0)
# A handle reaches so much farther from the axis than the body does, at least.
HANDLE_REACH = 1.15
SECTORS = 36
# What fills this share of the rectangle around it is square in plan.
BOXY = 0.87
# Sides of a box around something round differ by no more than this.
ROUND_SIDE_RATIO = 0.85
# A handle points along a side of the outline where it is so close to one, radians.
SNAP_ANGLE_RAD = np.radians(20.0)
# Prior of the side that a face is on, as the file lies: -y, +x, +y, -x. glTF says that the front looks along its +z,
# which is our -y; other formats say nothing.
STATED_FACE = (0.80, 0.06, 0.08, 0.06)
SILENT_FACE = (0.46, 0.18, 0.18, 0.18)


@dataclass(frozen=True)
class Facing:
    """A turn about z, radians, what was found, how sure, and why."""

    angle: float
    value: str
    confidence: float
    reason: str


def facing(samples: Floats, category: Category, stated: bool) -> Facing:
    """Find the turn that brings the front of a thing where its category has it.

    Args:
        samples: (N, 3) points spread evenly over the surface, z up. stated: the format says where the front is.
    """
    if category.front is FrontRule.LENGTH:
        return _lengthwise(samples)
    if category.front is FrontRule.HANDLE:
        return _handle(samples)
    if category.front is FrontRule.FACE:
        return _face(samples, category, stated)
    return Facing(0.0, "any", 1.0, f"a {category.id} has no front")


def _small(angle: float, period: float) -> float:
    """Smallest turn equal to this one modulo a period; 0 where it is next to none."""
    turn = (angle + period / 2) % period - period / 2
    return 0.0 if abs(turn) < MIN_TURN_RAD else turn


def straightened(samples: Floats) -> float:
    """The least turn about z that lays the outline along x and y, 0 where that makes its box no smaller."""
    angle, a, b = plan_axes(samples[:, :2])
    now = float(np.ptp(samples[:, 0]) * np.ptp(samples[:, 1]))
    return _small(-angle, np.pi / 2) if a * b < 0.92 * now else 0.0


def _lengthwise(samples: Floats) -> Facing:
    angle, long, wide = plan_axes(samples[:, :2])
    ratio = long / max(wide, 1e-9)
    confidence = float(np.clip(0.4 + 1.2 * np.log(ratio), 0.3, 0.98))
    turn = _small(-angle, np.pi)
    return Facing(turn, "length along x", confidence, f"{ratio:.2g} times as long as wide")


def _axis(samples: Floats) -> tuple[Floats, float]:
    """Middle of the body in plan, and its radius: from the foot, and from what lies close around it."""
    height = max(float(np.ptp(samples[:, 2])), 1e-9)
    level = (samples[:, 2] - samples[:, 2].min()) / height
    foot = samples[level < max(FOOT_SHARE, 0.06, 0.035 / height)][:, :2]  # scans of flat things tilt a little
    low, high = foot.min(axis=0), foot.max(axis=0)
    middle = (low + high) / 2
    a, b = sorted(np.maximum(high - low, 1e-9))
    whole = float(np.ptp(samples[:, :2], axis=0).min())
    rounds = (
        0 if a > ROUND_SIDE_RATIO * b and a > 0.4 * whole else 6
    )  # a round foot that is wide enough is the body's own
    for _ in range(rounds):  # else the circle that the lower half of what is seen lies on
        lower = samples[level < 0.6][:, :2] - middle
        reach = np.linalg.norm(lower, axis=1)
        radius = float(np.quantile(reach, 0.7))
        near = reach < 1.12 * radius
        body = lower[near]
        middle = middle + (body.min(axis=0) + body.max(axis=0)) / 2 * 0.7
    spread = np.linalg.norm(samples[:, :2] - middle, axis=1)
    angle = np.arctan2(*(samples[:, :2] - middle).T[::-1])
    sector = np.floor((angle + np.pi) / (2 * np.pi) * SECTORS).astype(int) % SECTORS
    outer = np.zeros(SECTORS)
    np.maximum.at(outer, sector, spread)
    return middle, float(np.median(outer[outer > 0]))


def _handle(samples: Floats) -> Facing:
    """The side to which most surface sticks out beyond the body."""
    middle, radius = _axis(samples)
    local = samples[:, :2] - middle
    reach = np.linalg.norm(local, axis=1)
    out = reach > HANDLE_REACH * radius
    if out.sum() < 0.004 * len(samples):
        return Facing(0.0, "no handle", 0.4, "nothing sticks out of the body")
    angle = np.arctan2(local[out, 1], local[out, 0])
    weight = reach[out] / radius - 1
    grid = np.arange(-np.pi, np.pi, np.pi / 90)
    around = np.maximum(np.cos(angle[None] - grid[:, None]), 0) ** 8 @ weight
    first = int(np.argmax(around))
    near = np.cos(angle - grid[first]) > 0.5
    mean = np.arctan2((weight * np.sin(angle))[near].sum(), (weight * np.cos(angle))[near].sum())
    far = np.abs((grid - grid[first] + np.pi) % (2 * np.pi) - np.pi) > np.pi / 3
    second = float(around[far].max()) / float(around[first])
    share = float(out.mean())
    # Two handles across from each other have no first, and a spout may be larger than the handle.
    confidence = float(np.clip(0.95 - 0.9 * second, 0.4, 0.95)) if share > 0.02 else 0.55
    message = f"{share:.0%} of the surface sticks out of the body, the next side {second:.0%} as much"
    period = np.pi if second > 0.85 else 2 * np.pi
    return Facing(_small(-_along(samples, float(mean)), period), "handle to x", confidence, message)


def _along(samples: Floats, direction: float) -> float:
    """A direction in plan, or that of the side of the outline that is close to it: a square pot stays square."""
    side, long, wide = plan_axes(samples[:, :2])
    off = (direction - side + np.pi / 4) % (np.pi / 2) - np.pi / 4
    # Corners of what is square stick out of the circle that a body is taken for.
    square = float(ConvexHull(samples[:, :2]).volume) > BOXY * long * wide
    return direction - off if square or abs(off) < SNAP_ANGLE_RAD else direction


def _face(samples: Floats, category: Category, stated: bool) -> Facing:
    """The file's word, weighed with the usual width over depth and with what stands out of each side."""
    box = straightened(samples)
    c, s = np.cos(box), np.sin(box)
    plan = samples[:, :2] @ np.array([[c, s], [-s, c]])
    x, y = np.ptp(plan, axis=0)
    usual = np.log(category.extents[0].typical / category.extents[1].typical)
    have = float(np.log(max(x, 1e-9) / max(y, 1e-9)))
    detail = _details(np.column_stack([plan, samples[:, 2]]))
    odds = np.log(np.array(STATED_FACE if stated else SILENT_FACE))
    for k in range(4):
        turned = have if k % 2 == 0 else -have
        odds[k] += -0.5 * ((turned - usual) / 0.35) ** 2 + 1.5 * detail[k]
    best = int(np.argmax(odds))
    weights = np.exp(odds - odds[best])
    confidence = float(1 / weights.sum())
    sides = ("-y", "+x", "+y", "-x")
    message = (
        f"{'the format says -y' if stated else 'the format says nothing'}; width over depth and detail speak as well"
    )
    # A face at +x comes to -y by a quarter turn clockwise, and so on.
    return Facing(box - best * np.pi / 2, f"face was at {sides[best]}", confidence, message)


def _details(samples: Floats) -> Floats:
    """(4,) how much of what is seen from -y, +x, +y, -x lies off the side's own plane, relative to the mean side."""
    found = []
    for axis, sign in ((1, -1.0), (0, 1.0), (1, 1.0), (0, -1.0)):
        out = sign * samples[:, axis]
        across = samples[:, [1 - axis, 2]]
        low, extent = across.min(axis=0), np.maximum(np.ptp(across, axis=0), 1e-9)
        cells = np.minimum(((across - low) / extent * 32).astype(int), 31)
        depth = np.full((32, 32), -np.inf)
        np.maximum.at(depth, (cells[:, 0], cells[:, 1]), out)
        seen = depth[np.isfinite(depth)]
        plane = np.median(seen)
        found.append(float(np.mean(np.clip(np.abs(seen - plane) - 0.01, 0, 0.05))) + 0.002)
    logs = np.log(np.array(found))
    relative: Floats = logs - logs.mean()
    return relative
