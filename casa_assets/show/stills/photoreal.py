"""Path-traced stills of a kitchen's or an asset's USD, by Blender's Cycles in a separate process; their viewpoints."""

from __future__ import annotations

import io
import json
import math
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from casa_assets.core import system
from casa_assets.core.numeric import Floats, Mask
from casa_assets.errors import CasaError
from casa_assets.show.stills import pictures
from casa_assets.show.stills.pictures import Pixels

EYE = "eye"  # the view that `eye_view` finds
EYE_M = 1.45
FOV_X_RAD = math.radians(70.0)  # a lens of 26 mm on a sensor 36 mm wide
SHIFT_Y = -0.055  # of the lens, as a share of the width: worktops are seen, uprights stay upright
PLACES_M, TURNS = 0.2, 144  # steps of the search
CLEARANCE_M, WALL_CLEARANCE_M, OPEN_CLEARANCE_M = 0.55, 0.25, 0.1
BEYOND_M = 2.4  # depth of what stills build beyond an open side
BEYOND_CLEARANCE_M = 0.3  # from its walls
TALL_M = 1.3  # what is higher hides what is behind it
SIZE_THAT_COUNTS = 0.012  # solid angle, steradian, of a fixture that is half as good as a large one
WEIGHTS = {
    **dict.fromkeys(("range", "window"), 3.0),
    **dict.fromkeys(("fridge", "island"), 2.5),
    **dict.fromkeys(("hob", "hood", "oven", "sink"), 2.0),
    "dishwasher": 1.5,
    "stool": 1.0,
    "base": 1.0,
    **dict.fromkeys(("lamp", "upper", "shelf"), 1.2),
}
SMALL = 0.4  # weight of everything else
ELEVATIONS_DEG = (20.0, 24.0, 28.0, 32.0, 36.0, 40.0)
ASIDE_DEG = (-55.0, -45.0, -35.0, -25.0, -15.0, 15.0, 25.0, 35.0, 45.0, 55.0)  # from straight through the window
ACROSS, UP = (0.15, 0.35, 0.5, 0.65, 0.85), (0.1, 0.25, 0.4, 0.55)  # of an opening; a blind may cover its top
NEAR_M = 1.2  # a patch as near to the window is a strip on its sill and worktop
LEVEL, UPRIGHT = 1.0, 0.6  # worth of a patch on a floor or a worktop, and on a front or a wall
FROM_BEHIND = -0.5  # worth of one on a front through the glazed doors behind the camera: as flat as a flash
SHELL = ("floor", "ceiling", "wall", "skirting", "cornice", "recess")
NOT_SOLID = (*SHELL, "window", "door", "lamp", "switch", "outlet", "sink")
CUTAWAY = "cutaway"  # a view that every kitchen has beside its own cameras, as it has EYE
CUTAWAY_FOV_X_RAD = math.radians(45.0)
ASSET_FOV_X_RAD, ASSET_AZIMUTH_DEG, ASSET_ELEVATION_DEG = math.radians(26.0), 32.0, 20.0
ASSET_SAMPLES = 4  # times those of a room: the plain floor of a studio shows noise that a room hides
ABOVE = ("overview", "above")  # cameras of a scene that look in from above
_SCRIPT = Path(__file__).with_name("blender") / "main.py"


@dataclass(frozen=True)
class View:
    """A camera.

    Attributes:
        position, quaternion: world_from_camera, metres and (w, x, y, z); it looks along its -z, its y is up.
        fov_x: from left to right, radians. shift_y: of the lens upwards, as a share of the picture's width.
        fit: it is moved so that it just sees these points, or all of the scene if empty; None: it is not moved.
    """

    name: str
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    fov_x: float
    shift_y: float = 0.0
    fit: tuple[tuple[float, float, float], ...] | None = None


@dataclass(frozen=True)
class _Fixtures:
    """Axis-aligned boxes (N, 3) of fixtures to be shown, the direction (N, 2) that each faces, and the weight of each.

    `room_m` (N,) is the distance that the photographer keeps from each: out of the swing of a door.
    """

    lower: Floats
    upper: Floats
    front: Floats
    worth: Floats
    room_m: Floats


def eye_view(scene: Mapping[str, Any], name: str, aspect: float, beyond_m: float = 0.0) -> View:
    """The view at eye level of a scene.json that shows most; the camera is level, so that verticals stay vertical.

    The photographer may be up to `beyond_m` beyond an open side.
    """
    fixtures, outline = _fixtures(scene), np.array(scene["room"]["outline"])
    walls = [(np.array(w["from"][:2]), np.array(w["to"][:2]), bool(w["open"])) for w in scene["room"]["walls"]]
    half_y = math.atan(math.tan(FOV_X_RAD / 2) / aspect)
    best, found = -math.inf, (0.0, 0.0, 0.0)
    everything = [*walls, *_walls_beyond(walls, beyond_m)]
    for x, y in _places(outline, walls, fixtures, beyond_m):
        scores = _scores(np.array([x, y]), fixtures, everything, half_y)
        turn = int(np.argmax(scores))
        if scores[turn] > best + 1e-9:
            best, found = float(scores[turn]), (x, y, 2 * math.pi * turn / TURNS)
    x, y, yaw = found
    # Level, from looking along +y: a quarter turn about x, then the yaw about z.
    c, s, q = math.cos(yaw / 2), math.sin(yaw / 2), math.sqrt(0.5)
    return View(name, (x, y, EYE_M), (c * q, c * q, s * q, s * q), FOV_X_RAD, SHIFT_Y)


def _fixtures(scene: Mapping[str, Any]) -> _Fixtures:
    rows = []
    for role, yaw, size, lower, upper in _boxes(scene, SHELL):
        room_m = max(size[:2]) if role == "door" else CLEARANCE_M
        rows.append((lower, upper, (math.sin(yaw), -math.cos(yaw)), WEIGHTS.get(role, SMALL), room_m))
    return _Fixtures(*(np.array(column) for column in zip(*rows, strict=True)))


def _boxes(
    scene: Mapping[str, Any], without: Sequence[str]
) -> Iterator[tuple[str, float, list[float], Floats, Floats]]:
    """Role, yaw (rad), size along its own axes, and corners (3,) in the room, of each fixture of other roles."""
    for fixture in scene["fixtures"]:
        box = fixture["regions"].get("main")
        if box is not None and fixture["role"] not in without:
            w, _, _, z = fixture["quaternion"]
            yaw = 2 * math.atan2(z, w)
            half = np.array(box["size"])[[1, 0, 2] if abs(math.sin(yaw)) > 0.7 else [0, 1, 2]] / 2
            middle = np.array(box["position"])
            yield fixture["role"], yaw, box["size"], middle - half, middle + half


def _places(
    outline: Floats, walls: Sequence[tuple[Floats, Floats, bool]], fixtures: _Fixtures, beyond_m: float
) -> list[tuple[float, float]]:
    """Points of the floor with room for the photographer; a default point if there are no such points."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    on_floor = fixtures.lower[:, 2] < EYE_M
    boxes = np.concatenate([fixtures.lower[on_floor, :2], fixtures.upper[on_floor, :2]], axis=1)
    places = []
    out = max(0, math.ceil((beyond_m - BEYOND_CLEARANCE_M) / PLACES_M - 1e-9)) * PLACES_M
    for x in np.arange(low[0] + OPEN_CLEARANCE_M - out, high[0] + out, PLACES_M):
        for y in np.arange(low[1] + OPEN_CLEARANCE_M - out, high[1] + out, PLACES_M):
            point = np.array([x, y])
            inside = min(
                _inside(point, a, b) - (OPEN_CLEARANCE_M if is_open else WALL_CLEARANCE_M) for a, b, is_open in walls
            )
            away = np.hypot(
                np.maximum(np.maximum(boxes[:, 0] - x, x - boxes[:, 2]), 0.0),
                np.maximum(np.maximum(boxes[:, 1] - y, y - boxes[:, 3]), 0.0),
            )
            within = (low <= point).all() and (point <= high).all() and inside >= -1e-9
            if (within or _is_beyond(point, walls, beyond_m)) and (away > fixtures.room_m[on_floor]).all():
                places.append((round(float(x), 3), round(float(y), 3)))
    return places or [(float(outline[:, 0].mean()), float(low[1]) + OPEN_CLEARANCE_M)]


def _is_beyond(point: Floats, walls: Sequence[tuple[Floats, Floats, bool]], beyond_m: float) -> bool:
    """True in what is built beyond an open side; beyond a corner of two open sides it goes on round the corner."""
    for k, (start, end, is_open) in enumerate(walls):
        if not is_open:
            continue
        length = float(np.linalg.norm(end - start))
        along = (end - start) / length
        at, depth = float((point - start) @ along), -float((point - start) @ np.array([along[1], -along[0]]))
        before, after = (beyond_m if walls[(k + step) % len(walls)][2] else 0.0 for step in (-1, 1))
        between = BEYOND_CLEARANCE_M - before <= at <= length + after - BEYOND_CLEARANCE_M
        if between and 0.0 <= depth <= beyond_m - BEYOND_CLEARANCE_M:
            return True
    return False


def _walls_beyond(walls: Sequence[tuple[Floats, Floats, bool]], beyond_m: float) -> list[tuple[Floats, Floats, bool]]:
    """Walls that continue those next to an open side."""
    found = []
    for k, (start, end, is_open) in enumerate(walls):
        if is_open:
            along = (end - start) / np.linalg.norm(end - start)
            out = np.array([-along[1], along[0]]) * beyond_m
            if not walls[k - 1][2]:
                found.append((start, start + out, False))
            if not walls[(k + 1) % len(walls)][2]:
                found.append((end + out, end, False))
    return found


def _inside(point: Floats, start: Floats, end: Floats) -> float:
    """Metres from a wall's line to the point, positive inside, if the wall is next to the point; 99 if it is not."""
    along = (end - start) / np.linalg.norm(end - start)
    at = float((point - start) @ along)
    depth = float((point - start) @ np.array([along[1], -along[0]]))
    return depth if -0.1 <= at <= np.linalg.norm(end - start) + 0.1 else 99.0


def _scores(eye: Floats, fixtures: _Fixtures, walls: Sequence[tuple[Floats, Floats, bool]], half_y: float) -> Floats:
    """(TURNS,) how good the view from a point is in each direction."""
    lower, upper = fixtures.lower, fixtures.upper
    middle = (lower + upper) / 2
    offset = middle[:, :2] - eye
    distance = np.maximum(np.linalg.norm(offset, axis=1), 0.3)
    facing = np.clip(-(offset * fixtures.front).sum(axis=1) / distance, 0.15, 1.0)
    wide = np.maximum(*(upper - lower)[:, :2].T)
    high = np.maximum((upper - lower)[:, 2], 0.05)
    size = facing * wide * high / (distance**2 + 0.2)
    steep = np.abs(np.arctan2(middle[:, 2] - EYE_M, distance))
    # A unit as large as a quarter of the view is too near to be a part of a room.
    value = fixtures.worth * size / (size + SIZE_THAT_COUNTS) * (steep < half_y) * np.clip(distance / 1.3, 0.0, 1.0)
    value *= _seen(eye, middle[:, :2], fixtures, walls)
    bearing = np.arctan2(-offset[:, 0], offset[:, 1])
    yaws = 2 * np.pi * np.arange(TURNS) / TURNS
    angle = np.abs((bearing[None] - yaws[:, None] + np.pi) % (2 * np.pi) - np.pi)
    # What the frame cuts off is worth less than its share that is seen.
    half_wide = np.maximum(np.arctan2(wide / 2, distance), 0.06)
    within = np.clip((FOV_X_RAD / 2 - angle + half_wide) / (2 * half_wide), 0.0, 1.0) ** 2
    score = (within @ value) * _room_ahead(eye, fixtures, walls)
    straight = np.abs(np.sin(2 * yaws)) < 1e-6
    return np.asarray(score * np.where(straight, 1.06, 1.0))


def _seen(eye: Floats, points: Floats, fixtures: _Fixtures, walls: Sequence[tuple[Floats, Floats, bool]]) -> Floats:
    """(N,) 1 for fixtures that no tall fixture and no wall hides from the eye, else 0."""
    tall = (fixtures.upper[:, 2] > TALL_M) & (fixtures.lower[:, 2] < EYE_M - 0.3)
    low, high = fixtures.lower[tall, :2], fixtures.upper[tall, :2]
    entry, leave = _crossings(eye, points - eye, low, high)
    # Things within the same outline (a refrigerator in its housing) are not hidden by it.
    within = ((points[:, None] > low - 0.02) & (points[:, None] < high + 0.02)).all(axis=2)
    hides = (entry < leave) & (entry > 0.0) & (entry < 0.97) & ~within
    behind = np.zeros(len(points), dtype=bool)
    for start, end, is_open in walls:
        if not is_open:
            behind |= _reach(eye, points - eye, start, end) < 0.97
    return np.where(hides.any(axis=1) | behind, 0.0, 1.0)


def _crossings(eye: Floats, rays: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Lengths, in units of each ray (R, 2), at which it enters and leaves each rectangle (N, 2): (R, N) both."""
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = ((corner - eye)[None] / rays[:, None] for corner in (low, high))
    first, second = np.nan_to_num(first, nan=-np.inf), np.nan_to_num(second, nan=np.inf)
    return np.minimum(first, second).max(axis=2), np.maximum(first, second).min(axis=2)


def _reach(eye: Floats, rays: Floats, start: Floats, end: Floats) -> Floats:
    """Length, in units of each ray (R, 2), at which it meets the inner side of a wall; infinite if it does not meet it.

    Only the inner side counts: somebody beyond an open side looks in through it.
    """
    along, offset = end - start, start - eye
    cross = rays[:, 0] * along[1] - rays[:, 1] * along[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        at = (offset[0] * along[1] - offset[1] * along[0]) / cross
        share = (offset[0] * rays[:, 1] - offset[1] * rays[:, 0]) / cross
    hit = (cross < -1e-9) & (at > 1e-6) & (share >= -1e-6) & (share <= 1 + 1e-6)
    return np.where(hit, at, np.inf)


def _room_ahead(eye: Floats, fixtures: _Fixtures, walls: Sequence[tuple[Floats, Floats, bool]]) -> Floats:
    """(TURNS,) factor below 1 where near things, or open or bare walls, fill the view."""
    angles = 2 * np.pi * np.arange(TURNS) / TURNS
    rays = np.stack([-np.sin(angles), np.cos(angles)], axis=1)
    reach, is_open = np.full(TURNS, 30.0), np.zeros(TURNS, dtype=bool)
    for start, end, opened in walls:
        at = _reach(eye, rays, start, end)
        hit = at < reach
        reach, is_open = np.where(hit, at, reach), np.where(hit, opened, is_open)
    entry, leave = _crossings(eye, rays, fixtures.lower[:, :2], fixtures.upper[:, :2])
    before_wall = (entry < leave) & (entry > 0.0) & (entry < reach[:, None]) & (fixtures.upper[:, 2] > 0.5)
    tall = before_wall & (fixtures.upper[:, 2] > TALL_M) & (fixtures.lower[:, 2] < EYE_M)
    near = np.minimum(reach, np.where(tall, entry, 30.0).min(axis=1)) < 1.1
    is_open &= ~tall.any(axis=1)
    bare = ~before_wall.any(axis=1) & ~is_open
    half = round(FOV_X_RAD / 2 / (2 * np.pi) * TURNS)
    window = (np.arange(TURNS)[:, None] + np.arange(-half, half + 1)) % TURNS
    shares = [kind[window].mean(axis=1) for kind in (near, is_open, bare)]
    return np.asarray((1 - 0.85 * shares[0]) * (1 - 0.75 * shares[1]) * (1 - 0.5 * shares[2]))


def sun_direction(scene: Mapping[str, Any], view: View, aspect: float) -> tuple[float, float, float] | None:
    """Unit direction of sunlight through the first window, or else the first open side; None if there is neither."""
    opening = _opening(scene["room"])
    if opening is None:
        return None
    origins, into = opening
    solids = [(low, high) for *_, low, high in _boxes(scene, NOT_SOLID)]
    low, high = np.array(solids).reshape(-1, 2, 3).swapaxes(0, 1)
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
        kind = np.where(level, LEVEL, UPRIGHT if through_window else FROM_BEHIND)
        worth = kind * far * _in_view(places, view, aspect, low, high)
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


def _entries(origins: Floats, rays: Floats, low: Floats, high: Floats) -> Floats:
    """(R, N) length, in units of each ray, at which it enters each box; infinite where it does not."""
    safe = np.where(np.abs(rays) < 1e-9, 1e-9, rays)
    first, second = ((corner[None] - origins[:, None]) / safe[:, None] for corner in (low, high))
    enter, leave = np.minimum(first, second).max(axis=2), np.maximum(first, second).min(axis=2)
    return np.where((enter < leave) & (enter > 1e-6), enter, np.inf)


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
    return np.asarray(inside & ~hidden)


class NoPathTracer(CasaError):
    """There is no Blender, or it failed; the message says what to do."""


@dataclass(frozen=True)
class StillSettings:
    """Size of a still, and what it costs: paths of each pixel of a room, and threads, on which no picture depends."""

    width_px: int = 960
    height_px: int = 540
    samples: int = 20
    threads: int = 2
    seed: int = 1


@dataclass(frozen=True)
class Still:
    """One picture: its name, (height, width, 3) pixels, and the wall seconds that it took."""

    name: str
    pixels: Pixels
    seconds: float

    @property
    def png(self) -> bytes:
        """Encoded, without a date."""
        return pictures.png(self.pixels)


def scene_stills(
    folder: Path, cameras: Sequence[str] = (), settings: StillSettings | None = None, pose: str = "closed"
) -> Iterator[Still]:
    """Stills of a kitchen through its own cameras, `eye` or `cutaway`; by default the last two. Raises NoPathTracer."""
    frame = settings or StillSettings()
    facts = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    aspect = frame.width_px / frame.height_px
    views = [_view(facts, name, aspect) for name in cameras or (EYE, CUTAWAY)]
    # Views from above look into the room without its ceiling, which is a choice that holds for a whole process.
    for above in (False, True):
        chosen = [view for view in views if (view.name in (*ABOVE, CUTAWAY)) == above]
        if chosen:
            job = {
                "usd": (folder / "scene.usda").resolve().as_posix(),
                "root": "World",
                "variants": {"pose": pose, "ceiling": "hidden" if above else "shown"},
                "room": facts["room"],
                "beyond_m": BEYOND_M,
                "sun": None if above else sun_direction(facts, eye_view(facts, EYE, aspect, BEYOND_M), aspect),
                "kind": "cutaway" if above else "room",
            }
            yield from _run(job, chosen, frame)


def _view(facts: Mapping[str, Any], name: str, aspect: float) -> View:
    """The view that is called so, for pictures of `aspect` (width over height). Raises NoPathTracer."""
    if name == EYE:
        return eye_view(facts, name, aspect, BEYOND_M)
    camera = next((c for c in facts["cameras"] if c["name"] == ("overview" if name == CUTAWAY else name)), None)
    if camera is None:
        names = [EYE, CUTAWAY, *(c["name"] for c in facts["cameras"])]
        raise NoPathTracer(f"there is no camera {name!r}; there are {', '.join(names)}")
    position, quaternion = tuple(camera["position"]), tuple(camera["quaternion"])
    if name == CUTAWAY:
        corners = tuple(product(*zip(*facts["room"]["bounds"], strict=True)))
        return View(name, position, quaternion, CUTAWAY_FOV_X_RAD, fit=corners)
    half = math.tan(math.radians(camera["fov_y_deg"]) / 2) * aspect
    return View(name, position, quaternion, 2 * math.atan(half))


def asset_still(usd: Path, settings: StillSettings | None = None, pose: str = "") -> Still:
    """Still of an asset on a studio's floor, seen from the front and a little from its right and above."""
    turn, tilt = math.radians(ASSET_AZIMUTH_DEG) / 2, math.radians(90 - ASSET_ELEVATION_DEG) / 2
    c, s, up, down = math.cos(turn), math.sin(turn), math.cos(tilt), math.sin(tilt)
    view = View(usd.stem, (0.0, 0.0, 0.0), (c * up, c * down, s * down, s * up), ASSET_FOV_X_RAD, fit=())
    variants = {"pose": pose} if pose else {}
    job = {"usd": usd.resolve().as_posix(), "root": usd.stem, "variants": variants, "kind": "asset"}
    frame = settings or StillSettings()
    (still,) = _run(job, [view], replace(frame, samples=ASSET_SAMPLES * frame.samples))
    return still


def _run(job: Mapping[str, Any], views: Sequence[View], frame: StillSettings) -> Iterator[Still]:
    program = system.find_blender()
    if not program:
        raise NoPathTracer(f"stills by a path tracer need Blender, {system.how_to_install()}")
    with tempfile.TemporaryDirectory(prefix="casa_photoreal_") as place:
        folder = Path(place)
        text = json.dumps({**job, **asdict(frame), "views": [asdict(view) for view in views]})
        (folder / "job.json").write_text(text, encoding="utf-8")
        line, around = system.command(program, _SCRIPT, str(folder)), system.environment(folder)
        done = subprocess.run(line, cwd=folder, env=around, capture_output=True, check=False)
        drawn = folder / "drawn.json"
        if done.returncode or not drawn.is_file():
            words = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
            why = words[0] if words else f"it ended with {done.returncode}"
            raise NoPathTracer(f"Blender ({program}) failed: {why}")
        for view in json.loads(drawn.read_text(encoding="utf-8"))["views"]:
            pixels = np.asarray(Image.open(io.BytesIO((folder / f"{view['name']}.png").read_bytes())).convert("RGB"))
            yield Still(view["name"], pixels, float(view["seconds"]))
