"""Replace the meshes of an asset by boxes and cylinders that lie inside its colliders."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import block_diag

from casa_assets.core.numeric import Floats, decimals, significant
from casa_assets.errors import DegenerateShape
from casa_assets.mesh.solid.solids import hull_planes, hull_volume
from casa_assets.model.asset.asset import Asset, Base, Collider
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Hull, MeshShape, Shape, Sphere
from casa_assets.model.kitchen.scene import LightScene, Scene
from casa_assets.model.pose import Pose

# Sizes are multiples of this, rounded down, metres: the last digits of a solver are no promise.
SIZE_STEP_M = 1e-6
# Half the size of the smallest primitive, metres, for shapes that are too thin for the grid.
MIN_HALF_SIZE_M = 1e-5
# Share of a hull that one primitive has to fill for the search to end.
FULL_SHARE = 0.97
# A further box has to fill this share of the hull; the most boxes.
MIN_BOX_SHARE, MAX_EXTRA_BOXES = 0.04, 3
# A shape that ends less than this above the lowest point stands there, metres; half the height of a foot.
LEVEL_M, FOOT_HALF_HEIGHT_M = 2e-4, 1.5e-3
# Cosine of the angle by which a shape may lean and still stand flat.
FLAT_COSINE = 0.99999


class InscribedPrimitive(NamedTuple):
    """A primitive inside a hull: half sizes (x, y, z) of a box, (radius, half height) of a cylinder, in a frame."""

    frame: Floats
    center: Floats
    half: Floats

    @property
    def volume(self) -> float:
        """m^3."""
        if len(self.half) == 3:
            return float(8 * self.half.prod())
        return float(2 * np.pi * self.half[0] ** 2 * self.half[1])


def lighten(asset: Asset) -> Asset:
    """Remove visuals and materials from an asset and replace its colliders by primitives inside of them.

    So nothing that was apart touches. Mass, joints, sites and regions stay; effects on visuals are left out.
    """
    behavior = asset.behavior
    if behavior is not None:
        visuals = {v.name for link in asset.links for v in link.visuals}
        behavior = behavior.replace(effects=tuple(e for e in behavior.effects if e.target not in visuals))
    # What stands has to stand on what it stood on; only the root link's frame is upright.
    heights = [_foot_of(c.shape, c.pose) for c in asset.root.colliders] if asset.base is Base.FREE else []
    links = []
    for link in asset.links:
        low = min(heights, default=None) if link is asset.root else None
        colliders = tuple(c for item in link.colliders for c in _light_collider(item, low))
        links.append(link.replace(visuals=(), colliders=colliders))
    return asset.replace(links=tuple(links), materials=(), behavior=behavior)


def light_scene(scene: Scene, form: Callable[[Asset], Asset] = lighten) -> LightScene:
    """The light form of a scene. `form`: `lighten`, or what gives the same faster."""
    return LightScene(scene=scene, light_assets=tuple(form(asset) for asset in scene.assets))


def inscribed_primitives(points: Floats) -> tuple[tuple[Box | Cylinder, Pose], ...]:
    """Fit a box, a few boxes or a cylinder inside the convex hull of (N, 3) points; with their poses in its frame.

    If one box leaves much of the hull empty (the corner of a worktop), a few more boxes are added that overlap neither
    it nor each other. Boxes are used if a single cylinder would fill less.

    Raises DegenerateShape: the points span no volume.
    """
    planes, volume = hull_planes(points), hull_volume(points)
    boxes: list[InscribedPrimitive] = []
    rods: list[InscribedPrimitive] = []
    # Rotations (cloud from shape) worth trying: each axis of the cloud as z, then those of its covariance.
    x, y, z = np.eye(3)
    axes: list[Floats] = [np.stack([x, y, z], axis=1), np.stack([y, z, x], axis=1), np.stack([z, x, y], axis=1)]
    _, vectors = np.linalg.eigh(np.cov(points.T))
    a, b, c = (v * np.sign(v[np.argmax(np.abs(v))]) for v in vectors.T)
    axes += [np.stack([a, np.cross(c, a), c], axis=1), np.stack([b, np.cross(a, b), a], axis=1)]
    for frames in (axes[:1], axes[1:]):
        spans = [np.ptp(points @ frame, axis=0) / 2 for frame in frames]
        normals = [planes[:, :3] @ frame for frame in frames]
        wanted = [_Wanted(planes, *one) for one in zip(frames, map(np.abs, normals), spans, strict=True)]
        # How far a cylinder of radius one, and one of half height one, reaches towards each plane.
        reach = [np.stack([np.hypot(n[:, 0], n[:, 1]), np.abs(n[:, 2])], axis=1) for n in normals]
        wide = [np.array([min(span[0], span[1]), span[2]]) for span in spans]
        wanted += [_Wanted(planes, *one) for one in zip(frames, reach, wide, strict=True)]
        found = _largest(wanted)
        boxes += [one for one in found[: len(frames)] if one is not None]
        rods += [one for one in found[len(frames) :] if one is not None]
        if any(found.volume >= FULL_SHARE * volume for found in (*boxes, *rods)):
            break
    if not boxes or not rods:
        raise DegenerateShape("nothing fits inside the hull")
    # Of equals the first: a later frame has to be better by more than rounding.
    box, rod = (max(found, key=lambda f: significant(f.volume, 6)) for found in (boxes, rods))
    several = [box, *_beside(planes, box, volume)]
    best = [rod] if rod.volume > sum(one.volume for one in several) else several
    return tuple(_rounded(found) for found in best)


def _beside(planes: Floats, first: InscribedPrimitive, volume: float) -> list[InscribedPrimitive]:
    """The largest boxes in what is left of a hull on each side of a box, largest first."""
    if first.volume >= FULL_SHARE * volume:
        return []
    wanted: list[_Wanted] = []
    rest = planes
    for axis in range(3):
        for sign in (1.0, -1.0):
            normal = sign * first.frame[:, axis]
            face = sign * first.center[axis] + first.half[axis]
            beyond = np.vstack([rest, [*-normal, face]])
            wanted.append(_Wanted(beyond, first.frame, np.abs(beyond[:, :3] @ first.frame), first.half))
            # What comes after stays on the near side of this face.
            rest = np.vstack([rest, [*normal, -face]])
    found = [box for box in _largest(wanted) if box is not None and box.volume >= MIN_BOX_SHARE * volume]
    return sorted(found, key=lambda box: -box.volume)[:MAX_EXTRA_BOXES]


def _rounded(found: InscribedPrimitive) -> tuple[Box | Cylinder, Pose]:
    matrix = np.eye(4)
    matrix[:3, :3] = found.frame
    # Thousandths of the grid first: what lies on a line of the grid must not fall to either side by its last bit.
    matrix[:3, 3] = np.round((found.frame @ found.center / SIZE_STEP_M).round(3)) * SIZE_STEP_M
    # The centre was rounded by up to half a unit along each axis.
    half = np.maximum(np.floor(((found.half - SIZE_STEP_M) / SIZE_STEP_M).round(3)) * SIZE_STEP_M, MIN_HALF_SIZE_M)
    pose = Pose.from_matrix(matrix)
    w, x, y, z = (decimals(c, 12) for c in pose.quaternion)  # a turn without the last digits
    pose = pose.replace(quaternion=(w, x, y, z))
    if len(half) == 3:
        x, y, z = (2 * float(h) for h in half)
        return Box(size=(x, y, z)), pose
    return Cylinder(radius=float(half[0]), height=2 * float(half[1])), pose


def _light_collider(item: Collider, low: float | None) -> tuple[Collider, ...]:
    """The collider as primitives; a mesh without volume is left out, as it would hold nothing up anyway."""
    if not isinstance(item.shape, Hull | MeshShape):
        return (item,)
    points = item.shape.mesh.vertices
    try:
        found = inscribed_primitives(points)
        if low is not None and item.pose.apply(points)[:, 2].min() < low + LEVEL_M:
            found = (*found, *_foot(item.pose, points, found))
    except DegenerateShape:
        return ()
    pairs = zip([item.name, *(LightScene.part_name(item.name, k) for k in range(1, len(found)))], found, strict=True)
    return tuple(item.replace(name=name, shape=shape, pose=item.pose @ pose) for name, (shape, pose) in pairs)


def _foot_of(shape: Shape, pose: Pose) -> float:
    """Height of the lowest point of a shape."""
    if isinstance(shape, Hull | MeshShape):
        return float(pose.apply(shape.mesh.vertices)[:, 2].min())
    down = pose.rotation[2]
    if isinstance(shape, Box):
        return float(pose.position[2] - np.abs(down) @ (np.array(shape.size) / 2))
    if isinstance(shape, Sphere):
        return float(pose.position[2] - shape.radius)
    along = abs(float(down[2])) * shape.height / 2
    round_ = shape.radius * (1.0 if isinstance(shape, Capsule) else float(np.hypot(down[0], down[1])))
    return float(pose.position[2] - along - round_)


def _foot(pose: Pose, points: Floats, found: Sequence[tuple[Shape, Pose]]) -> tuple[tuple[Box, Pose], ...]:
    """Return a thin upright box in the lowest part of a hull, or nothing if another shape already rests flat there.

    `pose`: of the hull in its link. `points`: (N, 3) its vertices. `found`: primitives fitted to it, in its frame.
    """
    low = float(pose.apply(points)[:, 2].min())
    flat = [(shape, pose @ at) for shape, at in found if np.abs((pose @ at).rotation[2]).max() > FLAT_COSINE]
    if min((_foot_of(shape, at) for shape, at in flat), default=np.inf) < low + LEVEL_M:
        return ()
    planes, spans = hull_planes(pose.apply(points)), np.ptp(pose.apply(points), axis=0) / 2
    thick = min(FOOT_HALF_HEIGHT_M, spans[2] / 2)
    normals, height = planes[:, :3], low + SIZE_STEP_M + thick
    reach, wide = np.abs(normals[:, :2]), spans[:2]
    room = SIZE_STEP_M - planes[:, 3] - normals[:, 2] * height - np.abs(normals[:, 2]) * thick
    # As in `_largest`, in the plane: first of the proportions of the hull, then as much wider as there is room.
    matrix = np.column_stack([normals[:, :2], reach @ wide])
    (first,) = _maxima([_Program([0, 0, 1], matrix, room, [-np.inf, -np.inf, 0])])
    if first is None or first[2] <= 0:
        return ()
    least = [-np.inf, -np.inf, *(0.999 * first[2] * wide)]
    (best,) = _maxima([_Program([0, 0, *(1 / wide)], np.column_stack([normals[:, :2], reach]), room, least)])
    if best is None:
        return ()
    half = np.array([*best[2:], thick])
    upright = InscribedPrimitive(np.eye(3), np.array([best[0], best[1], height]), half)
    if half.min() <= MIN_HALF_SIZE_M:
        return ()
    shape, at = _rounded(upright)
    assert isinstance(shape, Box)
    return ((shape, pose.inverse() @ at),)


class _Wanted(NamedTuple):
    """Input of one fit: planes of a hull, a frame, how far a primitive of unit half sizes reaches, its proportions.

    `reach`: (F, 3) of a box, (F, 2) of a cylinder, towards each plane.
    """

    planes: Floats
    frame: Floats
    reach: Floats
    wide: Floats


def _largest(wanted: Sequence[_Wanted]) -> list[InscribedPrimitive | None]:
    """Return the largest primitive for each request, or None if nothing fits.

    First the largest primitive of the requested proportions is found, then it is widened as far as there is room. Both
    steps are linear programs in the centre and the half sizes: normal . centre + reach . half <= -offset. The half
    sizes of the first may be negative, so that it has a solution even if the hull is empty.
    """
    sides = [(one.planes[:, :3] @ one.frame, -one.planes[:, 3]) for one in wanted]
    free = [-np.inf] * 3
    first = _maxima(
        [
            _Program([0, 0, 0, 1], np.column_stack([normals, one.reach @ one.wide]), most, [*free, -np.inf])
            for one, (normals, most) in zip(wanted, sides, strict=True)
        ]
    )
    fitting = [(i, x) for i, x in enumerate(first) if x is not None and x[3] > 0]
    second = _maxima(
        [
            _Program(
                [0, 0, 0, *(1 / wanted[i].wide)],
                np.column_stack([sides[i][0], wanted[i].reach]),
                sides[i][1],
                [*free, *(0.999 * x[3] * wanted[i].wide)],
            )
            for i, x in fitting
        ]
    )
    found: list[InscribedPrimitive | None] = [None] * len(wanted)
    for (i, x), wider in zip(fitting, second, strict=True):
        center, half = (x[:3], x[3] * wanted[i].wide) if wider is None else (wider[:3], wider[3:])
        found[i] = InscribedPrimitive(wanted[i].frame, center, half)
    return found


class _Program(NamedTuple):
    """A linear program: maximise gain . x where matrix @ x <= most and x >= least."""

    gain: Sequence[float]
    matrix: Floats
    most: Floats
    least: Sequence[float]


def _maxima(programs: Sequence[_Program]) -> list[Floats | None]:
    """Return the solution x of each program, or None if it has no solution.

    They are solved as one program with a block-diagonal matrix: a kitchen has thousands, each of a few variables, and a
    call of the solver takes longer than the solving. If that fails, each is solved alone, to find the one without a
    solution. `milp` without integer variables calls the same solver as `linprog`, which spends longer on checking its
    arguments.
    """
    if not programs:
        return []
    matrix = block_diag([program.matrix for program in programs], format="csc")
    gain = np.concatenate([program.gain for program in programs])
    constraints = LinearConstraint(matrix, -np.inf, np.concatenate([program.most for program in programs]))
    answer = milp(-gain, constraints=constraints, bounds=Bounds(np.concatenate([p.least for p in programs]), np.inf))
    if answer.status == 0:
        return list(np.split(answer.x, np.cumsum([len(program.gain) for program in programs])[:-1]))
    return [None] if len(programs) == 1 else [_maxima([program])[0] for program in programs]
