"""Handles and spouts of a vessel by its parameters, with their finishes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from casa_assets.families.kit.solids.solid import Solid
from casa_assets.families.objects.vessels.fittings import arch, ear, long_handle, loop, spout, strap
from casa_assets.families.objects.vessels.params import HandleForm, Vessel
from casa_assets.families.objects.vessels.surface import Plan, Profile

# A solid, its finish and its label.
Part = tuple[Solid, str, str]


def seated(part: Solid, p: Vessel, plan: Plan, profile: Profile) -> Solid:
    """A handle or spout whose end is drawn back into the wall where it would come out on the inside."""
    x, y, z = part.points.T
    within = np.array([profile.radius(float(h)) for h in z]) - 0.7 * p.wall
    if plan.corner is not None:
        flat = np.column_stack([np.sign(x) * np.maximum(np.abs(x), within), y])
    else:
        short = np.maximum(plan.half_y - (plan.half_x - within), 1e-4)
        far = np.hypot(x, y * within / short)
        flat = part.points[:, :2] * np.maximum(1.0, within / np.maximum(far, 1e-6))[:, None]
    below = z < p.height
    points = np.column_stack([np.where(below[:, None], flat, part.points[:, :2]), z])
    return replace(part, points=points)


def handles(p: Vessel, profile: Profile, plan: Plan) -> list[Part]:
    """Handles with their finishes and labels."""
    own = p.handle_finish or p.skin
    top, low = p.handle_top * p.height, p.handle_low * p.height
    into = 0.55 * p.wall
    r = profile.radius(top)
    reach = p.handle_reach
    if p.handle in (HandleForm.EAR, HandleForm.EARS):
        ends = [(profile.radius(z) - into, z) for z in (top, low)]
        out = max(profile.radius(z) for z in np.linspace(low, top, 5)) + reach
        part = ear(ends[0], ends[1], out, p.handle_width, p.handle_thick, p.handle_square, p.handle_sag)
        both = [part] if p.handle is HandleForm.EAR else [part, part.rotated("z", math.pi)]
        return [(part, own, "handle") for part in both]
    if p.handle is HandleForm.LOOPS:
        return [(part, own, "handle") for part in _loops(p, profile, plan, top)]
    if p.handle is HandleForm.ARCH:
        part = arch(r - into, top, p.height + reach, p.handle_width, p.handle_thick, p.handle_square, 1.25)
        return [(part, own, "handle")]
    if p.handle is HandleForm.NONE:
        return []
    w, t = p.handle_width, p.handle_thick
    if p.handle is HandleForm.LONG:
        taper = ((0, 1.5 * w, 1.1 * t), (0.12, w, t), (0.55, 0.8 * w, t), (0.9, 1.15 * w, t), (1, 0.7 * w, 0.8 * t))
        bar = long_handle((r - into, 0.0, top), reach, p.handle_rise, taper, p.handle_hole)
        return [(bar, own, "handle")]
    # A strap of metal, and on its end a grip.
    bare = 0.26 * reach
    run = p.handle_rise
    # The strap leaves the wall as steeply as the grip begins.
    metal = strap(
        [
            (r - into, 0.0, top),
            (r + 0.2 * bare, 0.0, top + 0.3 * bare * math.sin(run)),
            *((r + s * bare * math.cos(run), 0.0, top + s * bare * math.sin(run) * 1.15) for s in (0.45, 0.8, 1.15)),
        ],
        [(1.5 * w, 0.35 * t), (1.1 * w, 0.35 * t), (0.7 * w, 0.45 * t), (0.6 * w, 0.5 * t), (0.6 * w, 0.5 * t)],
        power=0.7,
    )
    start = (r + bare * math.cos(run), 0.0, top + 1.15 * bare * math.sin(run))
    swell = ((0, 0.72 * w, 0.8 * t), (0.06, 0.85 * w, t), (0.5, w, 1.1 * t), (0.85, 1.1 * w, t), (1, 0.6 * w, 0.6 * t))
    grip = long_handle(start, reach - bare, run, swell, p.handle_hole)
    found = [(metal, own, "handle"), (grip, p.grip_finish, "handle")]
    if p.handle is HandleForm.LONG_LOOP:
        found.append((_loops(p, profile, plan, top)[1], own, "handle"))
    return found


def _loops(p: Vessel, profile: Profile, plan: Plan, z: float) -> list[Solid]:
    """Level loops to both sides."""
    r, half = profile.radius(z), 0.5 * min(0.5 * p.width * p.across, 0.1)
    short = plan.half_y - (plan.half_x - r)
    x = r - 0.55 * p.wall
    if plan.corner is None:
        # Its ends go in far enough to be covered; `seated` keeps them within the wall.
        x = r * math.sqrt(max(0.0, 1 - (half / short) ** 2)) - 0.55 * p.wall - p.handle_thick - p.weave
    reach = r + (0.5 if p.handle is HandleForm.LONG_LOOP and p.handle_reach > 0.08 else 1.0) * min(p.handle_reach, 0.05)
    part = loop(x, half, z, reach - x, p.handle_thick, min(p.handle_width, 2 * p.handle_thick), p.handle_square)
    return [part, part.rotated("z", math.pi)]


def spouts(p: Vessel, profile: Profile) -> list[Part]:
    """The tube of a spout."""
    if p.spout <= 0:
        return []
    z = p.spout_from * p.height
    start = (-(profile.radius(z) - 0.6 * p.wall - 0.3 * p.spout_radius), z)
    end = (-(max(profile.radius(z), profile.radius(0.5 * p.height)) + p.spout), p.spout_to * p.height)
    return [(spout(start, end, p.spout_radius, p.spout_tip, p.spout_curve), p.skin, "spout")]
