"""Find previews that are black or burnt out, and walls that no camera sees."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from casa_assets.checks.check import Measurement, least, not_run
from casa_assets.checks.scene.placement.support import WALL
from casa_assets.checks.scene.subject import SceneSubject, reset
from casa_assets.core.typing import Floats
from casa_assets.model.kitchen.scene import Camera

Pixels = npt.NDArray[np.uint8]

# Of 255: darker in every channel is black, as bright in every channel is white.
BLACK, WHITE = 5, 254
RAYS_WIDE, RAYS_HIGH = 48, 36
SEEN, HIDDEN = 1, 5  # groups of geoms
# Metres: an eye so far behind the middle of a wall looks from outside; what hangs on the wall is so near.
BEHIND_M, HANGS_OUT_M, HANGS_IN_M = 0.3, 0.3, 0.12


@dataclass(frozen=True, eq=False)
class PreviewImages:
    """Previews of a scene.

    Attributes:
        shots: name of a picture -> (height, width, 3) pixels.
    """

    shots: dict[str, Pixels]


def previews_are_not_black(pictures: PreviewImages, limit: float | None) -> Measurement:
    """SCN024: largest share of black pixels of a preview. There is at least one preview."""
    shares = {name: float((shot.max(axis=2) < BLACK).mean()) for name, shot in pictures.shots.items()}
    return _held(shares, limit, "is black: put a light there, or move the camera out of what it stands in")


def previews_are_not_burnt_out(pictures: PreviewImages, limit: float | None) -> Measurement:
    """SCN025: largest share of wholly white pixels of a preview."""
    shares = {name: float((shot.min(axis=2) >= WHITE).mean()) for name, shot in pictures.shots.items()}
    return _held(shares, limit, "is wholly white: less light, or a darker finish")


def cameras_see_every_wall(subject: SceneSubject, limit: float | None) -> Measurement:
    """SCN023: least share of a picture that any wall fills in the camera that sees it best.

    Walls between a camera and the room are looked through, as previews do.
    """
    assert limit is not None
    best = walls_seen(subject)
    problems = tuple(
        (f"placements/{name}", f"no camera shows it: at best it fills {share:.2%} of a picture; turn a camera to it")
        for name, share in best.items()
        if share < limit
    )
    return least(best.values(), problems, "it has no walls")


def walls_seen(subject: SceneSubject) -> dict[str, float]:
    """Name of each wall -> the largest share of a camera's picture that it fills."""
    model = subject.loaded.model
    assert model is not None, "only scenes that load are looked at"
    data = mujoco.MjData(model)
    reset(model, data)
    mujoco.mj_forward(model, data)
    walls = {p.name: int(model.body(p.name).id) for p in subject.scene.placements if subject.category(p.name) == WALL}
    best = dict.fromkeys(walls, 0.0)
    for camera in subject.scene.cameras:
        with _looked_through(model, data, np.array(camera.pose.position), list(walls.values())):
            hit = _bodies_hit(model, data, camera)
        for name, body in walls.items():
            best[name] = max(best[name], float((hit == body).mean()))
    return best


def _bodies_hit(model: mujoco.MjModel, data: mujoco.MjData, camera: Camera) -> npt.NDArray[np.int32]:
    """(rays,) number of the body that each pixel of a coarse picture shows, -1 where it shows none."""
    rays = _rays(camera)
    geoms, far = np.full(len(rays), -1, dtype=np.int32), np.zeros(len(rays))
    groups = np.array([0, 1, 0, 0, 0, 0], dtype=np.uint8)
    eye = np.array(camera.pose.position)
    mujoco.mj_multiRay(
        model,
        data,
        eye,
        np.ascontiguousarray(rays.ravel()),
        groups,
        True,
        -1,
        geoms,
        far,
        None,
        len(rays),
        mujoco.mjMAXVAL,
    )
    return np.where(geoms >= 0, model.geom_bodyid[geoms], -1).astype(np.int32)


def _rays(camera: Camera) -> Floats:
    """(N, 3) unit directions through the middles of coarse pixels, world frame."""
    half = math.tan(math.radians(camera.fov_y_deg) / 2)
    across = (np.arange(RAYS_WIDE) + 0.5) / RAYS_WIDE * 2 - 1
    up = 1 - (np.arange(RAYS_HIGH) + 0.5) / RAYS_HIGH * 2
    x, y = np.meshgrid(across * half * RAYS_WIDE / RAYS_HIGH, up * half)
    rays = np.stack([x.ravel(), y.ravel(), np.full(x.size, -1.0)], axis=1) @ camera.pose.rotation.T
    found: Floats = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    return found


@contextmanager
def _looked_through(model: mujoco.MjModel, data: mujoco.MjData, eye: Floats, walls: list[int]) -> Iterator[None]:
    """While it lasts, walls that the eye is behind are not seen, nor what hangs on them."""
    before = model.geom_group.copy()
    for wall in walls:
        turn, at = data.xmat[wall].reshape(3, 3), data.xpos[wall]
        # A wall faces the room with its -y; the origin of its frame is in the middle of its thickness.
        if float((eye - at) @ turn[:, 1]) < BEHIND_M:
            continue
        boxes = model.geom_aabb[model.geom_bodyid == wall]
        reach = (np.abs(boxes[:, 0]) + boxes[:, 3]).max() + 0.1
        offset = (data.geom_xpos - at) @ turn
        on_it = (np.abs(offset[:, 0]) < reach) & (offset[:, 1] > -HANGS_IN_M) & (offset[:, 1] < HANGS_OUT_M)
        model.geom_group[on_it] = HIDDEN
    try:
        yield
    finally:
        model.geom_group[:] = before


def _held(shares: dict[str, float], limit: float | None, what: str) -> Measurement:
    assert limit is not None
    if not shares:
        return not_run("there is no picture of it")
    problems = tuple(
        (f"previews/{name}", f"{share:.1%} of it {what}") for name, share in shares.items() if share > limit
    )
    return Measurement(max(shares.values()), problems)
