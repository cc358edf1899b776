"""Find objects unlike their category, and those that do not rest, stand or stack (FLT)."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks import check
from casa_assets.checks.filters.surface import NOT_LOOSE, welded_surface
from casa_assets.checks.motion.simulation import collision_spec, tilt_deg
from casa_assets.checks.package import Package
from casa_assets.checks.readers import mujoco_facts as mujoco_load
from casa_assets.checks.readers.mujoco_facts import free_bodies
from casa_assets.core.numeric import Floats
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.solid.solids import convex_hull, hull_volume, union
from casa_assets.mesh.surface import signed_volume, solid_moments
from casa_assets.mesh.voxels import fillable_volume, voxelise
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.registry.category import Affordance, Category, MatterFill, RestingPose

# Milliseconds that MuJoCo takes to load a thousand triangles, and a million pixels, as benchmarks/ingest/filters.py
# measures them on one core. The time is estimated with them and not measured, so that it is the same on any machine.
FACES_MS, PIXELS_MS = 5.0, 25.0
SLIGHT_SHARE = 0.05  # part of the greatest moment of inertia that another one may be off without being felt
GRASP = "grasp_"  # sites that say where a hand takes a thing; their x is what the fingers open to
UNKNOWN = "object"  # the category of what nobody could name
# Voxels along the longest side of the grid in which the water that a vessel holds is measured.
CELLS = 64
RATE_HZ = 240
# The steps of a runtime. Slender things jitter more on long ones, on the few points that a hull touches a floor with.
FINE_RATE_HZ = 500
SETTLE_S, WATCH_S = 4.0, 3.0  # how long an object may take to settle, and how long it is then watched, seconds
# What moves more than this is watched again in finer steps, three times in all: an object that was put down on an edge
# falls late, and then lies still.
STILL_M, MAX_WATCHES = 1e-3, 3
FAR_M = 1e3  # stands for any longer way, and for one that is no number, because reports hold finite numbers
# Height above the lower object at which the upper one is let go, metres, and how long both are simulated, seconds.
STACK_GAP_M, STACK_S = 0.005, 3.0
MAX_STACK_TILT_DEG = 30.0
UPPER, LOWER = "upper_", "lower_"


def inertia_is_plausible(asset: Asset, limit: float) -> check.Measurement:
    """FLT014: factor between the inertia and that of the evenly filled shapes, on the worst axis."""
    if not check.is_loose_mesh(asset) or not asset.root.colliders:
        return check.not_applicable(check.NO_COLLIDERS if check.is_loose_mesh(asset) else NOT_LOOSE)
    link = asset.root
    surfaces = [tessellate(c.shape, c.pose) for c in link.colliders]
    solid = union(surfaces) or convex_hull(np.concatenate([s[0] for s in surfaces]))
    volume = signed_volume(*solid)
    if volume <= 0:
        return check.not_run("its collision shapes enclose no volume")
    tensor = solid_moments(*solid)[2]
    expected = np.linalg.eigvalsh(tensor * (link.inertial.mass / volume))
    actual = np.linalg.eigvalsh(link.inertial.tensor)
    # The moment of a knife about its own length hangs on its thickness, which meshes do not say exactly. So moments
    # that are small beside the greatest one count less.
    slight = SLIGHT_SHARE * expected.max()
    ratio = (actual + slight) / (expected + slight)
    factor = float(np.maximum(ratio, 1 / ratio).max())
    message = f"turns {factor:.1f} times harder or easier than its shapes filled evenly; measure the inertia again"
    return check.at_most(factor, limit, "links/object/inertial", message)


def load_time_is_bounded(asset: Asset, limit: float) -> check.Measurement:
    """FLT013: estimated loading time in a simulator, from triangles and pixels, milliseconds."""
    if not check.is_loose_mesh(asset):
        return check.not_applicable(NOT_LOOSE)
    faces = sum(len(v.mesh.faces) for v in asset.root.visuals)
    # MuJoCo reads the colours alone; the other pictures are read by those who load the USD.
    images = {t.file_name: t.width_px * t.height_px for m in asset.materials for t in m.textures}
    million_pixels = sum(images.values()) / 1e6
    load_ms = FACES_MS * faces / 1e3 + PIXELS_MS * sum(images.values()) / 1e6
    message = f"takes about {load_ms:.0f} ms to load ({faces} triangles, {million_pixels:.1f} million pixels)"
    return check.at_most(load_ms, limit, "", f"{message}; scale its pictures down")


def fits_a_gripper(package: Package, limit: float) -> check.Measurement:
    """FLT018: width of the narrowest grasp of a graspable object, metres; its least side where it has none."""
    asset, category = package.asset, package.category
    if not check.is_loose_mesh(asset):
        return check.not_applicable(NOT_LOOSE)
    if asset.base is not Base.FREE or not category.can(Affordance.GRASPABLE):
        return check.not_applicable(f"a {category.id} is not said to be graspable")
    widths = {s.name: s.size[0] for s in asset.sites if s.name.startswith(GRASP) and s.size is not None}
    if not widths:
        least = float(np.ptp(asset.bounds, axis=0).min())
        message = f"has no body, rim or handle that a gripper of {limit:g} m takes (its least side is {least:.3f} m)"
        return check.Measurement(least, (("sites", f"{message}; look at its size, or do not call it graspable"),))
    problems = tuple(
        (f"sites/{name}", f"is {width:.3f} m wide; a gripper opens to {limit:g} m")
        for name, width in widths.items()
        if width > limit
    )
    return check.Measurement(min(widths.values()), problems)


def category_is_known(package: Package) -> check.Measurement:
    """FLT007: the category is known, so that a size and a mass can be expected."""
    if not check.is_loose_mesh(package.asset):
        return check.not_applicable(NOT_LOOSE)
    if package.category.id != UNKNOWN:
        return check.no_fault()
    message = "nobody says what it is, so that no size, pose or mass could be expected; name its category"
    return check.Measurement(problems=(("labels/category", message),))


def proportions_fit_category(package: Package, limit: float) -> check.Measurement:
    """FLT008: least factor by which a side leaves the range of its category, at the best scale."""
    surface, category = welded_surface(package.asset), package.category
    if category.id == UNKNOWN:
        return check.not_applicable("nobody says what it is, so no proportions are expected (FLT007)")
    size = np.ptp(surface.visibility.samples, axis=0)
    proportions = " x ".join(f"{side / size.max():.2g}" for side in size)
    message = f"is {proportions} in proportion; none of the sizes of a {category.id} is like that: look at what it is"
    return check.at_most(misfit(size, category), limit, "labels/category", message)


def vessel_is_open(package: Package, limit: float) -> check.Measurement:
    """FLT009: share of its hull in which a vessel, in its given pose, holds water."""
    surface, category = welded_surface(package.asset), package.category
    if category.build is not MatterFill.VESSEL or not category.can(Affordance.CONTAINER):
        return check.not_applicable(f"a {category.id} is no open vessel")
    grid = voxelise(surface.points, surface.faces, CELLS)
    share = int(fillable_volume(grid.solid).sum()) * grid.cell**3 / hull_volume(surface.points)
    message = f"holds nothing as it stands ({share:.1%} of its hull), though a {category.id} is open"
    return check.at_least(share, limit, "links/object/visuals", f"{message}; look at its pose, and for a lid")


def misfit(size: Floats, category: Category) -> float:
    """The least factor by which a side of a thing of (3,) `size`, at its best scale, leaves its range; 1 within all.

    Which of the two level sides is the longer one does not matter, nor, for what has no pose, which side is up.
    """
    # Sides that may be swapped are sorted before they are compared.
    swapped = slice(0, 3 if category.upright is RestingPose.ANY else 2)
    sides = [np.maximum(size, 1e-9), [s.low for s in category.extents], [s.high for s in category.extents]]
    arrays = [np.array(values, dtype=np.float64) for values in sides]
    for array in arrays:
        array[swapped] = np.sort(array[swapped])
    actual, low, high = arrays
    return float(np.exp(max(0.0, (np.log(low / actual).max() - np.log(high / actual).min()) / 2)))


@dataclass(frozen=True)
class RestResult:
    """Tilt of the up axis of an object that was put down, and the farthest that a corner of its box then moves."""

    tilt_deg: float
    drift_m: float


def lies_still(package: Package, limit: float) -> check.Measurement:
    """FLT015: farthest that a corner still moves after the object was put down and has settled, metres."""
    rest = _rest_of(package)
    message = f"{WATCH_S:g} s after it was put down a corner of it still goes {1000 * rest.drift_m:.1f} mm by itself"
    return check.at_most(rest.drift_m, limit, "scene.xml", f"{message}; correct its collision shapes")


def does_not_fall_over(package: Package, limit: float) -> check.Measurement:
    """FLT016: tilt of the object after it was put down in its given pose, degrees."""
    category = package.category
    if category.upright is not RestingPose.STANDS:
        return check.not_applicable(f"a {category.id} does not stand by itself")
    rest = _rest_of(package)
    message = f"tips over by {rest.tilt_deg:.0f} degrees when it is put down, though a {category.id} stands"
    return check.at_most(rest.tilt_deg, limit, "scene.xml", f"{message}; look at its pose and its foot")


def stacks_on_another(package: Package, limit: float) -> check.Measurement:
    """FLT017: offset of a second object let down on the first, in parts of its width."""
    asset = package.asset
    _require_free_mesh(asset)
    if not package.category.can(Affordance.STACKABLE):
        return check.not_applicable(f"nobody stacks a {package.category.id}")
    if mujoco_load.load_mjcf(package.mjcf).error:
        return check.not_run(check.NO_COMPILE)
    offset, tilt = _stack(package.mjcf, np.ptp(asset.bounds, axis=0))
    message = f"another one put on it ends {offset:.2f} widths off its middle, tilted by {tilt:.0f} degrees"
    problems = (("model.xml", f"{message}; look at its pose, its foot and its rim"),)
    return check.Measurement(offset, () if offset <= limit and tilt <= MAX_STACK_TILT_DEG else problems)


def _require_free_mesh(asset: Asset) -> None:
    """Raises Unmeasured unless an asset is a loose mesh that is free to move."""
    if not check.is_loose_mesh(asset) or asset.base is not Base.FREE:
        raise check.Unmeasured(
            check.not_applicable("it is fixed in its place" if check.is_loose_mesh(asset) else NOT_LOOSE)
        )


def _rest_of(package: Package) -> RestResult:
    """Motion of a loose mesh on the floor of its scene. Raises Unmeasured where there is none."""
    _require_free_mesh(package.asset)
    model = mujoco_load.load_mjcf(package.scene).model
    if model is None:
        raise check.Unmeasured(check.not_run("scene.xml does not compile"))
    lower, upper = package.asset.bounds
    return _simulate_rest(model, (*map(float, lower), *map(float, upper)))


@lru_cache(maxsize=4)
def _simulate_rest(shared: mujoco.MjModel, box: tuple[float, ...]) -> RestResult:
    model = copy.copy(shared)
    model.opt.timestep = 1.0 / RATE_HZ
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    body = free_bodies(model)[0]
    before = data.xmat[body].reshape(3, 3).copy()
    corners = np.array([[x, y, z] for x in box[::3] for y in box[1::3] for z in box[2::3]])
    mujoco.mj_step(model, data, nstep=int(SETTLE_S * RATE_HZ))
    drift = FAR_M
    for _ in range(MAX_WATCHES):
        drift = min(drift, _drift(model, data, body, corners))
        if drift <= STILL_M:
            break
        model.opt.timestep = 1.0 / FINE_RATE_HZ
    return RestResult(tilt_deg(data.xmat[body].reshape(3, 3) @ before.T), drift)


def _drift(model: mujoco.MjModel, data: mujoco.MjData, body: int, corners: Floats) -> float:
    """Largest distance that a corner moves in the watched time, metres; at most `FAR_M`, and that if it diverges."""
    start, drift = _world(data, body, corners), 0.0
    for _ in range(int(WATCH_S / model.opt.timestep / 8)):
        mujoco.mj_step(model, data, nstep=8)
        drift = max(drift, float(np.linalg.norm(_world(data, body, corners) - start, axis=1).max()))
    return min(drift, FAR_M) if np.isfinite(data.qpos).all() else FAR_M


def _world(data: mujoco.MjData, body: int, points: Floats) -> Floats:
    """(N, 3) points of a body in the world frame, metres."""
    return np.asarray(data.xpos[body] + points @ data.xmat[body].reshape(3, 3).T)


def _stack(mjcf: Path, size: Floats) -> tuple[float, float]:
    """Offset of an object from an equal one below, in parts of its width, and its tilt, degrees. `size`: (3,) m."""
    spec = mujoco.MjSpec()
    spec.option.timestep = 1.0 / RATE_HZ
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], friction=[0.6, 0.005, 0.0001])
    for prefix, height in ((LOWER, 0.0), (UPPER, float(size[2]) + STACK_GAP_M)):
        frame = spec.worldbody.add_frame(pos=[0, 0, height])
        frame.attach_body(collision_spec(mjcf).body("object"), prefix, "").add_freejoint()
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=int(STACK_S * RATE_HZ))
    upper, lower = data.body(f"{UPPER}object"), data.body(f"{LOWER}object")
    aside = np.linalg.norm((upper.xpos - lower.xpos)[:2]) / max(size[:2])
    # What lies on the floor beside the other one, or under it, is not on it: it counts as a width farther off.
    below = 1.0 if float(upper.xpos[2]) <= float(lower.xpos[2]) else 0.0
    return min(float(np.nan_to_num(aside, nan=FAR_M)), FAR_M) + below, tilt_deg(upper.xmat.reshape(3, 3))
