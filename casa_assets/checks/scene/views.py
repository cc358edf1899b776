"""Find previews that are black or burnt out, and walls that no camera sees."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from casa_assets.checks.check import Measurement, all_at_least, all_at_most, not_run
from casa_assets.checks.motion.simulation import altered, reset_to_start
from casa_assets.checks.scene.placement.support import WALL
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.core.numeric import Floats, Ints
from casa_assets.model.kitchen.scene import Camera

Pixels = npt.NDArray[np.uint8]

# Of 255. A pixel is black where every channel is darker than this, and white where every channel is as bright as this.
BLACK, WHITE = 5, 254
RAYS_WIDE, RAYS_HIGH = 48, 36
# Geom groups that rays see: what is seen, without the ceiling. Looked-through walls are meanwhile put into another.
VISIBLE_GROUPS = np.array([0, 0, 1, 0, 0, 0], dtype=np.uint8)
HIDDEN_GROUP = 5
# A camera this far behind the middle of a wall looks at the room from outside.
BEHIND_WALL_M = 0.3
# What lies within these distances of the middle of a wall, on its outer and its room side, hangs on it.
HANGS_OUTSIDE_M, HANGS_INSIDE_M = 0.3, 0.12


@dataclass(frozen=True, eq=False)
class PreviewImages:
    """Previews of a scene.

    Attributes:
        images: name of a preview -> (height, width, 3) pixels.
    """

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
    rays = _rays(camera)
    geoms, distances = np.full(len(rays), -1, dtype=np.int32), np.zeros(len(rays))
    eye, flat = np.array(camera.pose.position), np.ascontiguousarray(rays.ravel())
    cutoff = mujoco.mjMAXVAL
    mujoco.mj_multiRay(model, data, eye, flat, VISIBLE_GROUPS, True, -1, geoms, distances, None, len(rays), cutoff)
    return np.where(geoms >= 0, model.geom_bodyid[geoms], -1).astype(np.int32)


def _rays(camera: Camera) -> Floats:
    """(N, 3) unit directions through the middles of coarse pixels, world frame."""
    half = math.tan(math.radians(camera.fov_y_deg) / 2)
    across = (np.arange(RAYS_WIDE) + 0.5) / RAYS_WIDE * 2 - 1
    up = 1 - (np.arange(RAYS_HIGH) + 0.5) / RAYS_HIGH * 2
    x, y = np.meshgrid(across * half * RAYS_WIDE / RAYS_HIGH, up * half)
    rays = np.stack([x.ravel(), y.ravel(), np.full(x.size, -1.0)], axis=1) @ camera.pose.rotation.T
    unit: Floats = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    return unit


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
