"""Find things without support, black or burnt-out previews, and walls that no camera sees."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull

from casa_assets.checks.check import Measurement, all_at_least, all_at_most, count, not_applicable, not_run, worst_above
from casa_assets.checks.motion.simulation import (
    altered,
    box_around,
    geom_boxes,
    reset_to_start,
    vertices_of,
)
from casa_assets.checks.scene.subject import SceneSubject, boxes_meet
from casa_assets.core.numeric import Floats, Ints
from casa_assets.model.kitchen.scene import Camera

# Categories of placements.
FLOOR, WALL, CEILING, RECESS = "floor", "wall", "ceiling", "recess"
ROOM = (FLOOR, WALL, CEILING, RECESS)
# How far a thing may be from what carries it, metres: feet are adjusted, walls are uneven and have skirting or tiles
# between, canopies of lamps cover a gap. Our choices.
FLOOR_GAP_M, WALL_GAP_M, CEILING_GAP_M, OTHER_GAP_M = 0.002, 0.012, 0.005, 0.002
# Categories that are held by their neighbours, at any side.
HELD_BESIDE = frozenset(
    {"filler", "cabinet_panel", "cornice", "toe_kick", "sink", "hob", "skirting", "backsplash", "curtain"}
)
# Categories that hang on a wall even near the floor. All else whose foot is lower than this stands on the floor.
HUNG_LOW = frozenset({"outlet", "switch", "window", "door", "curtain", "wall_panelling"})
LOW_M = 0.6
# Screwed to the sides of the cabinet round it.
BUILT_IN, HOUSING = frozenset({"microwave", "wall_oven"}), "housing_cabinet"
# How much higher than its visible foot the colliders of a thing may end, as collider_bounds_m grants single assets.
MAX_COLLIDER_GAP_M = 0.004
MM_PER_M = 1000.0
# How far handles and sills of doors and windows may stand out of the outer face of a wall, metres.
ALLOWED_BESIDE_M = {"door": 0.08, "window": 0.08}
Pixels = npt.NDArray[np.uint8]
# Of 255. A pixel is black where every channel is darker than this, and white where every channel is as bright as this.
BLACK, WHITE = 5, 254
RAYS_WIDE, RAYS_HIGH = 48, 36
# Geom groups that rays see: what is seen, without the ceiling. Looked-through walls are meanwhile put into another.
VISIBLE_GROUPS = np.array([0, 0, 1, 0, 0, 0], dtype=np.uint8)
HIDDEN_GROUP = 5
BEHIND_WALL_M = 0.3  # a camera this far behind the middle of a wall looks at the room from outside
# What lies within these distances of the middle of a wall, on its outer and its room side, hangs on it.
HANGS_OUTSIDE_M, HANGS_INSIDE_M = 0.3, 0.12


def fixed_things_are_supported(subject: SceneSubject, limit: float) -> Measurement:
    """SCN008: number of fixed things that nothing holds; SCN011 and SCN003 report those that rest by their weight."""
    tester = SupportTester(subject)
    room = [p.name for p in subject.scene.placements if subject.category(p.name) in ROOM]
    waiting = [p.name for p in subject.fixed if p.name not in room]
    # Support goes from thing to thing: the wall holds the shelf, the shelf holds the jar.
    carriers = room
    while carriers:
        held = [name for name in waiting if any(tester.holds(name, carrier) for carrier in carriers)]
        waiting = [name for name in waiting if name not in held]
        carriers = held
    problems = []
    for name in waiting:
        height = tester.bounds[name][0, 2] - tester.floor
        foot = f"its foot is {height * MM_PER_M:.0f} mm over the floor"
        problems.append((f"placements/{name}", f"is held by nothing: {foot}; set it on, or against, what carries it"))
    return count(problems, allowed=limit)


class SupportTester:
    """Tests whether one placement holds another."""

    def __init__(self, subject: SceneSubject) -> None:
        self.subject = subject
        self.boxes: dict[str, Floats] = {
            name: geom_boxes(subject.model, subject.data, geoms) for name, geoms in subject.geoms_of.items()
        }
        self.bounds = {name: box_around(boxes) for name, boxes in self.boxes.items()}
        floors = [self.bounds[n][1, 2] for n in self.bounds if subject.category(n) == FLOOR]
        self.floor = float(max(floors, default=0.0))
        lowest = {a.id: float(a.bounds[0, 2]) for a in subject.scene.assets}
        # Heights of what is seen of each thing; fixed things are upright.
        self.visible_foot = {
            p.name: p.pose.position[2] + lowest[subject.assets[p.name].id] for p in subject.scene.placements
        }
        # The scene with one thing lowered by a little, to measure what is below it.
        self.lowered = mujoco.MjData(subject.model)
        self.lowered.geom_xmat[:] = subject.data.geom_xmat

    def holds(self, name: str, carrier: str) -> bool:
        """True if a carrier, which is itself held, holds a thing."""
        category, carrier_category = self.subject.category(name), self.subject.category(carrier)
        is_low = self.bounds[name][0, 2] - self.floor < LOW_M
        if carrier_category == FLOOR:
            return self._stands_on(name, carrier, FLOOR_GAP_M)
        if category in BUILT_IN and carrier_category == HOUSING and self._is_near(name, carrier, OTHER_GAP_M):
            return True
        if category in HELD_BESIDE:
            return self._is_near(name, carrier, WALL_GAP_M if carrier_category == WALL else OTHER_GAP_M)
        if carrier_category == WALL:
            return (not is_low or category in HUNG_LOW) and self._is_near(name, carrier, WALL_GAP_M)
        if carrier_category == CEILING:
            return self._is_near(name, carrier, CEILING_GAP_M)
        return self._stands_on(name, carrier, OTHER_GAP_M)

    def _is_near(self, name: str, other: str, gap: float) -> bool:
        """True if two things come as near as that, in any direction."""
        return self._distance(self.subject.data, name, other, gap) <= gap

    def _stands_on(self, name: str, other: str, gap: float) -> bool:
        """True if a thing lowered by `gap` penetrates the other one, and did not do so as deeply before.

        The colliders of a thing may end a little higher than its visible foot, which it rests on.
        """
        gap += float(np.clip(self.bounds[name][0, 2] - self.visible_foot[name], 0.0, MAX_COLLIDER_GAP_M))
        if not self._is_near(name, other, gap):
            return False
        before = self._distance(self.subject.data, name, other, gap)
        self.lowered.geom_xpos[:] = self.subject.data.geom_xpos
        self.lowered.geom_xpos[self.subject.geoms_of[name], 2] -= gap
        after = self._distance(self.lowered, name, other, gap)
        return after <= 0.0 and after < before - gap / 4

    def _distance(self, data: mujoco.MjData, name: str, other: str, gap: float) -> float:
        """Distance of two things, metres; negative is a depth; `2 * gap` where they are farther apart than that."""
        geoms1, geoms2 = self.subject.geoms_of[name], self.subject.geoms_of[other]
        near = boxes_meet(self.boxes[name][:, None], self.boxes[other][None], 2 * gap)
        distances = [
            float(mujoco.mj_geomDistance(self.subject.model, data, int(geoms1[i]), int(geoms2[k]), 2 * gap, None))
            for i, k in np.argwhere(near)
        ]
        return min([2 * gap, *distances])


def fixed_things_do_not_overlap(subject: SceneSubject, limit: float) -> Measurement:
    """SCN007: deepest overlap of fixed shapes of two things, metres (SCN002: of what moves)."""
    worst: dict[tuple[str, str], tuple[float, int, int]] = {}
    for geom1, geom2, depth in overlapping_pairs(subject, limit):
        names = (subject.placement_of[geom1], subject.placement_of[geom2])
        if depth > worst.get(names, (0.0, 0, 0))[0]:
            worst[names] = (depth, geom1, geom2)
    rows = []
    for names, (depth, geom1, geom2) in worst.items():
        overlap = f"{subject.geom_name(geom1)} is {depth * MM_PER_M:.1f} mm in {subject.geom_name(geom2)}"
        rows.append((f"placements/{names[0]}", depth, f"{overlap}; move one, or make it smaller"))
    return worst_above(rows, limit)


def overlapping_pairs(subject: SceneSubject, limit: float) -> Iterator[tuple[int, int, float]]:
    """Fixed geoms of two placements, and how deep they are in each other where that is more than `limit`, metres."""
    model, data = subject.model, subject.data
    geoms = np.flatnonzero(subject.is_fixed)
    boxes = geom_boxes(model, data, geoms)
    # Shapes are never deeper in each other than their boxes are.
    candidates = np.triu(boxes_meet(boxes[:, None], boxes[None], -limit), 1)
    for i, k in np.argwhere(candidates):
        geom1, geom2 = int(geoms[i]), int(geoms[k])
        if subject.placement_of[geom1] == subject.placement_of[geom2]:
            continue
        depth = -mujoco.mj_geomDistance(model, data, geom1, geom2, limit, None)
        if depth > limit:
            yield geom1, geom2, float(depth)


def things_are_inside_room(subject: SceneSubject, limit: float) -> Measurement:
    """SCN009: farthest that a shape lies outside floor, walls and ceiling, metres."""
    categories = {p.name: subject.category(p.name) for p in subject.scene.placements}
    if FLOOR not in categories.values():
        return not_applicable("it has no floor, and so no room to leave")
    outlines = [
        # Normals and offsets of the edges of a floor or wall seen from above.
        ConvexHull(vertices_of(subject.model, subject.data, int(geom))[:, :2]).equations
        for name, category in categories.items()
        if category in (FLOOR, WALL, RECESS)
        for geom in subject.geoms_of[name]
    ]
    low, high = _heights(subject, categories)
    rows = []
    for name, category in categories.items():
        if category in ROOM:
            continue
        geoms = subject.geoms_of[name]
        points = np.concatenate([vertices_of(subject.model, subject.data, int(g), turned=True) for g in geoms])
        # (outlines, points) how far beyond the farthest edge, metres; 0 inside.
        outside = [np.maximum(0.0, (points[:, :2] @ e[:, :2].T + e[:, 2]).max(axis=1)) for e in outlines]
        beside = float(np.min(outside, axis=0).max())
        distances = {
            "beside the room": max(0.0, beside - ALLOWED_BESIDE_M.get(category, 0.0)),
            "below the floor": low - points[:, 2].min(),
            "above the ceiling": points[:, 2].max() - high,
        }
        for where, distance in distances.items():
            message = f"reaches {distance * MM_PER_M:.0f} mm {where}; move it in"
            rows.append((f"placements/{name}", float(distance), message))
    return worst_above(rows, limit)


def _heights(subject: SceneSubject, categories: dict[str, str]) -> tuple[float, float]:
    """Underside of the floor and upper side of the ceiling, or of the walls where it has none; metres."""

    def z_ranges(category: str) -> list[Floats]:
        names = [name for name, of in categories.items() if of == category]
        return [box_around(geom_boxes(subject.model, subject.data, subject.geoms_of[n]))[:, 2] for n in names]

    tops = [float(z[1]) for z in z_ranges(CEILING) or z_ranges(WALL)]
    return min(float(z[0]) for z in z_ranges(FLOOR)), max(tops, default=np.inf)


@dataclass(frozen=True, eq=False)
class PreviewImages:
    """Previews of a scene by name, (height, width, 3) pixels."""

    images: dict[str, Pixels]


def previews_are_not_black(previews: PreviewImages, limit: float) -> Measurement:
    """SCN024: largest share of black pixels of a preview."""
    black = {name: float((image.max(axis=2) < BLACK).mean()) for name, image in previews.images.items()}
    return _shares(black, limit, "is black: put a light there, or move the camera out of what it stands in")


def previews_are_not_burnt_out(previews: PreviewImages, limit: float) -> Measurement:
    """SCN025: largest share of wholly white pixels of a preview."""
    white = {name: float((image.min(axis=2) >= WHITE).mean()) for name, image in previews.images.items()}
    return _shares(white, limit, "is wholly white: less light, or a darker finish")


def _shares(shares: dict[str, float], limit: float, fault: str) -> Measurement:
    if not shares:
        return not_run("there is no picture of it")
    by_pointer = {f"previews/{name}": share for name, share in shares.items()}
    return all_at_most(by_pointer, limit, f"{{:.1%}} of it {fault}", "")


def cameras_see_every_wall(subject: SceneSubject, limit: float) -> Measurement:
    """SCN023: least share of a picture that any wall fills in the camera that sees it best.

    Walls between a camera and the room are looked through, as previews do.
    """
    shares = {f"placements/{name}": share for name, share in visible_wall_shares(subject).items()}
    message = "no camera shows it: at best it fills {:.2%} of a picture; turn a camera to it"
    return all_at_least(shares, limit, message, "it has no walls")


def visible_wall_shares(subject: SceneSubject) -> dict[str, float]:
    """Name of each wall -> the largest share of a camera's picture that it fills."""
    model = subject.loaded.model
    assert model is not None, "only scenes that load are looked at"
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_forward(model, data)
    walls = {p.name: int(model.body(p.name).id) for p in subject.scene.placements if subject.category(p.name) == WALL}
    best = dict.fromkeys(walls, 0.0)
    for camera in subject.scene.cameras:
        with altered(model, geom_group=_groups(model, data, np.array(camera.pose.position), list(walls.values()))):
            bodies = _bodies_hit(model, data, camera)
        for name, body in walls.items():
            best[name] = max(best[name], float((bodies == body).mean()))
    return best


def _bodies_hit(model: mujoco.MjModel, data: mujoco.MjData, camera: Camera) -> npt.NDArray[np.int32]:
    """(rays,) number of the body that each pixel of a coarse picture shows, -1 where it shows none."""
    half = math.tan(math.radians(camera.fov_y_deg) / 2)
    across = (np.arange(RAYS_WIDE) + 0.5) / RAYS_WIDE * 2 - 1
    up = 1 - (np.arange(RAYS_HIGH) + 0.5) / RAYS_HIGH * 2
    x, y = np.meshgrid(across * half * RAYS_WIDE / RAYS_HIGH, up * half)
    rays = np.stack([x.ravel(), y.ravel(), np.full(x.size, -1.0)], axis=1) @ camera.pose.rotation.T
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    geoms, distances = np.full(len(rays), -1, dtype=np.int32), np.zeros(len(rays))
    eye, flat = np.array(camera.pose.position), np.ascontiguousarray(rays.ravel())
    cutoff = mujoco.mjMAXVAL
    mujoco.mj_multiRay(model, data, eye, flat, VISIBLE_GROUPS, True, -1, geoms, distances, None, len(rays), cutoff)
    return np.where(geoms >= 0, model.geom_bodyid[geoms], -1).astype(np.int32)


def _groups(model: mujoco.MjModel, data: mujoco.MjData, eye: Floats, walls: list[int]) -> Ints:
    """(ngeom,) group of each geom, with the walls that the eye is behind, and what hangs on them, hidden."""
    groups: Ints = model.geom_group.copy()
    for wall in walls:
        rotation, position = data.xmat[wall].reshape(3, 3), data.xpos[wall]
        # A wall faces the room with its -y; the origin of its frame is in the middle of its thickness.
        if float((eye - position) @ rotation[:, 1]) < BEHIND_WALL_M:
            continue
        boxes = model.geom_aabb[model.geom_bodyid == wall]
        reach = (np.abs(boxes[:, 0]) + boxes[:, 3]).max() + 0.1
        x, y, _ = ((data.geom_xpos - position) @ rotation).T
        groups[(np.abs(x) < reach) & (y > -HANGS_INSIDE_M) & (y < HANGS_OUTSIDE_M)] = HIDDEN_GROUP
    return groups
