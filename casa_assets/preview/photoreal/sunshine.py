"""Where the sun stands, so that its patches lie where a camera sees them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np

from casa_assets.core.typing import Floats, Mask
from casa_assets.preview.photoreal.viewpoint import BEYOND_M, View

ELEVATIONS_DEG = (20.0, 24.0, 28.0, 32.0, 36.0, 40.0)
ASIDE_DEG = (-55.0, -45.0, -35.0, -25.0, -15.0, 15.0, 25.0, 35.0, 45.0, 55.0)  # from straight through the window
ACROSS, UP = (0.15, 0.35, 0.5, 0.65, 0.85), (0.1, 0.25, 0.4, 0.55)  # of an opening; a blind may cover its top
NEAR_M = 1.2  # a patch as near to the window is a strip on its sill and worktop
LEVEL, UPRIGHT = 1.0, 0.6  # worth of a patch on a floor or a worktop, and on a front or a wall
FROM_BEHIND = -0.5  # worth of one on a front through the glazed doors behind the camera: as flat as a flash
NOT_SOLID = (
    "window",
    "door",
    "lamp",
    "floor",
    "ceiling",
    "wall",
    "skirting",
    "cornice",
    "switch",
    "outlet",
    "sink",
    "recess",
)


def sun_direction(scene: Mapping[str, Any], view: View, aspect: float) -> tuple[float, float, float] | None:
    """Unit direction of sunlight through the first window or, where there is none, the first open side; None: neither.

    Args:
        scene: of scene.json. view: of the camera. aspect: of its picture, width over height.
    """
    opening = _opening(scene["room"])
    if opening is None:
        return None
    origins, into = opening
    low, high = _boxes(scene)
    best, found = -math.inf, (0.0, 0.0, -1.0)
    through_window = any(o["kind"] == "window" for o in scene["room"]["openings"])
    for elevation, aside in product(ELEVATIONS_DEG, ASIDE_DEG):
        down, turn = math.radians(elevation), math.radians(aside)
        flat = np.array(
            [into[0] * math.cos(turn) - into[1] * math.sin(turn), into[0] * math.sin(turn) + into[1] * math.cos(turn)]
        )
        ray = np.array([*(flat * math.cos(down)), -math.sin(down)])
        places, level = _landings(origins, ray, low, high, scene["room"])
        far = np.linalg.norm(places[:, :2] - origins[:, :2], axis=1) > NEAR_M
        worth = (
            np.where(level, LEVEL, UPRIGHT if through_window else FROM_BEHIND)
            * far
            * _in_view(places, view, aspect, low, high)
        )
        if worth.mean() > best + 1e-9:
            best, found = float(worth.mean()), (float(ray[0]), float(ray[1]), float(ray[2]))
    return found


def _opening(room: Mapping[str, Any]) -> tuple[Floats, Floats] | None:
    """Points (N, 3) of the opening and the direction (2,) from it into the room."""
    walls = {wall["id"]: wall for wall in room["walls"]}
    windows = [o for o in room["openings"] if o["kind"] == "window"]
    sides = [wall for wall in room["walls"] if wall["open"]]
    if not windows and not sides:
        return None
    wall = walls[windows[0]["wall"]] if windows else sides[0]
    along = np.array(wall["to"][:2]) - np.array(wall["from"][:2])
    into = np.array([along[1], -along[0]]) / np.linalg.norm(along)
    start, end = (np.array((windows or sides)[0][key], dtype=float) for key in ("from", "to"))
    if not windows:
        start, end = start - [*(into * BEYOND_M), 0.0], end - [*(into * BEYOND_M), 0.0]
        end[2] = room["bounds"][1][2]
    shares = [(a, a, u) for a in ACROSS for u in UP]
    points: Floats = start + np.array(shares) * (end - start)
    return points, into


def _boxes(scene: Mapping[str, Any]) -> tuple[Floats, Floats]:
    """Corners (N, 3) of what stops light."""
    low, high = [], []
    for fixture in scene["fixtures"]:
        box = fixture["regions"].get("main")
        if box is None or fixture["role"] in NOT_SOLID:
            continue
        w, _, _, z = fixture["quaternion"]
        turned = abs(math.sin(2 * math.atan2(z, w))) > 0.7
        half = np.array(box["size"])[[1, 0, 2] if turned else [0, 1, 2]] / 2
        low.append(np.array(box["position"]) - half)
        high.append(np.array(box["position"]) + half)
    return np.array(low).reshape(-1, 3), np.array(high).reshape(-1, 3)


def _entries(origins: Floats, rays: Floats, low: Floats, high: Floats) -> Floats:
    """(R, N) length, in units of each ray, at which it enters each box; infinite where it does not."""
    safe = np.where(np.abs(rays) < 1e-9, 1e-9, rays)
    first, second = ((corner[None] - origins[:, None]) / safe[:, None] for corner in (low, high))
    enter, leave = np.minimum(first, second).max(axis=2), np.maximum(first, second).min(axis=2)
    entries: Floats = np.where((enter < leave) & (enter > 1e-6), enter, np.inf)
    return entries


def _landings(origins: Floats, ray: Floats, low: Floats, high: Floats, room: Mapping[str, Any]) -> tuple[Floats, Mask]:
    """(R, 3) where light ends, and (R,) whether that is level."""
    rays = np.repeat(ray[None], len(origins), axis=0)
    boxes = _entries(origins, rays, low, high).min(axis=1, initial=np.inf)
    floor = origins[:, 2] / -ray[2]
    bounds = np.array(room["bounds"])[:, :2]
    with np.errstate(divide="ignore"):
        exits = np.where(ray[:2] > 0, (bounds[1] - origins[:, :2]) / ray[:2], (bounds[0] - origins[:, :2]) / ray[:2])
    exits = np.where(exits > 1e-3, exits, np.inf).min(axis=1)
    length = np.minimum(np.minimum(boxes, floor), exits)
    places: Floats = origins + length[:, None] * ray
    on_top = (np.abs(places[:, None, 2] - high[None, :, 2]) < 2e-3) & (
        (places[:, None, :2] > low[None, :, :2] - 1e-6) & (places[:, None, :2] < high[None, :, :2] + 1e-6)
    ).all(axis=2)
    level: Mask = (places[:, 2] < 1e-3) | on_top.any(axis=1)
    return places, level


def _in_view(places: Floats, view: View, aspect: float, low: Floats, high: Floats) -> Mask:
    """(R,) True where a level camera sees a place."""
    w, x, y, z = view.quaternion
    ahead = -np.array([2 * (x * z + w * y), 2 * (y * z - w * x)])
    ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
    offset = places - np.array(view.position)
    depth = offset[:, :2] @ ahead
    across, up = offset[:, :2] @ np.array([ahead[1], -ahead[0]]), offset[:, 2]
    half = math.tan(view.fov_x / 2) * 0.95
    shift = view.shift_y * 2 * math.tan(view.fov_x / 2)
    inside = (depth > 0.1) & (np.abs(across) < half * depth) & (np.abs(up - shift * depth) < half / aspect * depth)
    eyes = np.repeat(np.array(view.position)[None], len(places), axis=0)
    hidden = (_entries(eyes, offset, low, high) < 0.98).any(axis=1)
    seen: Mask = inside & ~hidden
    return seen
