"""Filters of strangers' meshes (FLT): spoilt surfaces and colours, things unlike their category, that fall or slide."""

from __future__ import annotations

import copy
import io
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np
from PIL import Image
from scipy import ndimage

from casa_assets.checks import check
from casa_assets.checks.check import Package
from casa_assets.checks.motion.simulation import collision_spec, tilt_deg
from casa_assets.checks.readers import mujoco_facts
from casa_assets.core.numeric import Floats, Ints, Mask, linear_from_srgb_array, srgb_from_linear_array
from casa_assets.mesh.solid.deviation import Visibility, measure_visibility
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.mesh.solid.solids import convex_hull, hull_volume, union
from casa_assets.mesh.surface import edge_counts, face_components, face_normals, signed_volume, solid_moments, weld
from casa_assets.mesh.voxels import fillable_volume, voxelise
from casa_assets.model.asset.asset import Asset, Base, Visual
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.registry.category import Affordance, Category, MatterFill, RestingPose

NOT_LOOSE = "it did not come as one loose mesh"
# All lengths are parts of another length. Choices, tried on spoilt meshes by benchmarks/ingest/filters.py.
# A component thinner than this part of its width is flat.
FLATNESS = 0.005
# The share of a flat component that is seen from both sides, from which on it is a card and no side of a box.
TWO_SIDED_SHARE = 0.3
VOXEL = 0.03  # parts stand apart where no voxel of this part of the longest side, nor a neighbour of it, joins them
LARGE_PART = 0.3  # what reaches over less than this part of the longest side is a crumb and no part
# The lowest part of the height, in which a ground lies, and where what stands on it begins.
GROUND_TOP, OBJECT_BOTTOM = 0.04, 0.12
# How many times broader for its height than is usual for its category an object on a ground is.
BROADER_THAN_USUAL = 1.5
VISUALS = "links/object/visuals"
# Of the positive and of the negative direction of each axis.
SIDES = ("the right", "behind", "above"), ("the left", "the front", "below")
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # Weights of linear red, green and blue in luminance. Ref: ITU-R BT.709.
# From this metalness on a surface shows what is around it, and a grey is no lack of colour.
MIN_METALNESS = 0.5
IS_METAL = "it has bare metal on it, whose colour is that of what is around"
MIN_CONTRAST = 0.05  # contrast from which on what is seen of a picture counts as a picture, as displayed, 0..1
MIN_PIXELS = 1  # fewer pixels than this along the longest side are a palette of plain colours, and no picture
POINTS = 8000  # points at which colours are sampled, spread evenly over the area
MIN_TEXTURED_SHARE = 0.2  # the share of the points that has to lie on a picture for its sharpness to matter
MAX_PIXELS = 1024  # pictures are reduced to this many pixels along a side before they are looked at
GRADIENT_SHARE = 0.3  # an edge that takes this part of a picture is a gradient, and meant to be soft
# Name of textures that were painted by `ingest` from vertex colours, and are as sharp as those were.
PAINTED = "painted"
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


@dataclass(frozen=True)
class WeldedSurface:
    """(P, 3) welded points, m; (F, 3) faces in the order of the visuals; (F,) connected component; (F,) area, m^2."""

    points: Floats
    faces: Ints
    component: Ints
    areas: Floats
    visibility: Visibility

    @property
    def longest(self) -> float:
        """Longest side of the box around it, metres."""
        return float(np.ptp(self.visibility.samples, axis=0).max())


def welded_surface(asset: Asset) -> WeldedSurface:
    """The surface of a loose mesh. Raises Unmeasured for anything else."""
    if not check.is_loose_mesh(asset):
        raise check.Unmeasured(check.not_applicable(NOT_LOOSE))
    surface = _weld_visuals(asset.root.visuals) if asset.root.visuals else None
    if surface is None:
        raise check.Unmeasured(check.not_applicable(check.NO_VISUALS))
    return surface


@lru_cache(maxsize=4)
def _weld_visuals(visuals: tuple[Visual, ...]) -> WeldedSurface | None:
    vertices, faces = check.merged_mesh(visuals)
    points, welded = weld(vertices)
    faces = welded[faces]
    _, areas = face_normals(points, faces)
    if areas.sum() <= 0:
        return None
    component = face_components(faces, len(points))
    return WeldedSurface(points, faces, component, areas, measure_visibility(points, faces))


def surface_is_opaque(asset: Asset, limit: float) -> check.Measurement:
    """FLT001: share of what is seen from all around that shows backs of faces."""
    surface = welded_surface(asset)
    share = float(surface.visibility.behind.mean())
    message = f"{share:.1%} of what is seen are backs of faces; close the holes, or give the walls a thickness"
    return check.at_most(share, limit, VISUALS, message)


def no_side_is_missing(package: Package, limit: float) -> check.Measurement:
    """FLT002: share of the outline of a solid object that shows backs of faces, from the worst side."""
    surface, category = welded_surface(package.asset), package.category
    if category.build not in (MatterFill.SOLID, MatterFill.FILLED):
        return check.not_applicable(f"a {category.id} may be hollow and open")
    worst = int(surface.visibility.behind.argmax())
    share, toward = float(surface.visibility.behind[worst]), -surface.visibility.away[worst]
    axis = int(np.abs(toward).argmax())
    side = SIDES[0 if toward[axis] > 0 else 1][axis]
    message = f"seen from {side} {share:.0%} of it is an open hollow, and a {category.id} is full"
    return check.at_most(share, limit, VISUALS, f"{message}; close that side")


def winding_is_consistent(asset: Asset, limit: float) -> check.Measurement:
    """FLT003: share of the length of inner edges whose two faces wind against each other."""
    surface = welded_surface(asset)
    ends, uses, balance = edge_counts(surface.faces)
    lengths = np.linalg.norm(surface.points[ends[:, 0]] - surface.points[ends[:, 1]], axis=1)
    inner = lengths[uses == 2].sum()
    if inner <= 0:
        return check.not_applicable("no two of its faces share an edge")
    share = float(lengths[(uses == 2) & (balance != 0)].sum() / inner)
    message = f"neighbours face opposite ways along {share:.1%} of the edges; make the winding consistent"
    return check.at_most(share, limit, VISUALS, message)


def no_flat_cards(asset: Asset, limit: float) -> check.Measurement:
    """FLT004: share of what is seen that lies on flat sheets seen from both sides."""
    surface = welded_surface(asset)
    seen = surface.visibility.front | surface.visibility.back
    component = surface.component[surface.visibility.face]
    cards = [k for k in np.flatnonzero(_flat_components(surface)) if _is_card(surface, component == k)]
    share = float(np.isin(component[seen], cards).mean()) if seen.any() else 0.0
    message = f"{share:.0%} of what is seen are flat cards, which vanish from the side; model it in the round"
    return check.at_most(share, limit, VISUALS, message)


def mesh_is_connected(asset: Asset, limit: float) -> check.Measurement:
    """FLT005: number of large parts that are separate from each other; a rigid object is one."""
    surface = welded_surface(asset)
    samples = surface.visibility.samples
    at = np.floor((samples - samples.min(axis=0)) / (VOXEL * surface.longest)).astype(np.int64)
    occupied = np.zeros(at.max(axis=0) + 1, dtype=bool)
    occupied[tuple(at.T)] = True
    label, _ = ndimage.label(occupied, np.ones((3, 3, 3)))
    boxes = ndimage.find_objects(label)
    parts = sum(max(s.stop - s.start for s in box) * VOXEL > LARGE_PART for box in boxes)
    message = f"{parts} large parts stand apart, though they move as one"
    return check.at_most(float(parts), limit, VISUALS, f"{message}; give each object a file of its own, or join them")


def no_ground_plane(package: Package, limit: float) -> check.Measurement:
    """FLT006: factor by which the lowest layer is wider than all above it, where that is unusual."""
    surface, category = welded_surface(package.asset), package.category
    if category.upright is not RestingPose.STANDS or category.fixed:
        return check.not_applicable(f"a {category.id} does not stand by itself")
    points = surface.visibility.samples
    height = points[:, 2] - points[:, 2].min()
    tallest = float(height.max())
    lowest, above = points[height <= GROUND_TOP * tallest], points[height >= OBJECT_BOTTOM * tallest]
    if not len(above) or not len(lowest):
        return check.not_applicable("it is flat, with nothing above its lowest layer")
    size = np.ptp(points, axis=0)
    x, y, z = (extent.typical for extent in category.extents)
    if category.id != "object" and float(size[:2].max()) / float(size[2]) <= BROADER_THAN_USUAL * max(x, y) / z:
        return check.not_applicable(f"a {category.id} is usually as broad for its height")
    ratio = float((np.ptp(lowest[:, :2], axis=0) / np.maximum(np.ptp(above[:, :2], axis=0), 1e-9)).min())
    message = f"stands on a ground that is {ratio:.1f} times wider than itself; export it without"
    return check.at_most(ratio, limit, VISUALS, message)


def _flat_components(surface: WeldedSurface) -> Mask:
    components = int(surface.component.max()) + 1
    flat = np.zeros(components, dtype=bool)
    order = np.argsort(surface.component, kind="stable")
    ends = np.cumsum(np.bincount(surface.component, minlength=components))[:-1]
    for k, rows in enumerate(np.split(order, ends)):
        corners = surface.points[surface.faces[rows]].reshape(-1, 3)
        _, axes = np.linalg.eigh(np.cov(corners.T))
        thickness, width, _ = np.ptp(corners @ axes, axis=0)
        flat[k] = thickness <= FLATNESS * width
    return flat


def _is_card(surface: WeldedSurface, rows: Mask) -> bool:
    """True if a flat component, on which samples `rows` (N,) lie, is seen by its back or has faces to both sides."""
    front, back = surface.visibility.front[rows], surface.visibility.back[rows]
    if not (front | back).any():
        return False
    corners = surface.points[surface.faces[np.unique(surface.visibility.face[rows])]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    faces_both_ways = bool((normals @ normals[int(np.linalg.norm(normals, axis=1).argmax())] < 0).any())
    if float((front & back).mean()) > TWO_SIDED_SHARE:
        return True
    return faces_both_ways and float(front.mean()) > 2 * TWO_SIDED_SHARE


@dataclass(frozen=True)
class ColorSamples:
    """(N, 3) linear RGB of points spread over the visible surface.

    `texels_per_m`, `edges_per_m`: (N,) pixels of the picture, and its sharpest edges side by side, to a metre; 0: none.
    """

    linear: Floats
    texels_per_m: Floats
    edges_per_m: Floats


def is_not_too_dark(asset: Asset, limit: float) -> check.Measurement:
    """FLT010: mean luminance of what is seen in white light, 0..1; coal has 0.04."""
    colors = _own_colors(asset)
    luminance = float((colors.linear @ LUMINANCE).mean())
    message = f"is black, it gives back {luminance:.2%} of the light; set the colours of its materials"
    return check.at_least(luminance, limit, "materials", message)


def is_not_plain_grey(asset: Asset, limit: float) -> check.Measurement:
    """FLT011: largest distance of what is seen from one plain grey, as displayed, 0..1."""
    colors = _own_colors(asset)
    displayed = srgb_from_linear_array(colors.linear)
    distance = float(np.percentile(np.abs(displayed - displayed.mean()).max(axis=1), 99))
    message = "has one plain grey all over; bring its materials, or a picture"
    return check.at_least(distance, limit, "materials", message)


def textures_are_sharp(asset: Asset, limit: float) -> check.Measurement:
    """FLT012: points of the pictures that can be resolved along the longest side; the median."""
    colors, surface = _color_samples(asset), welded_surface(asset)
    textured = (colors.edges_per_m > 0) & (colors.texels_per_m * surface.longest >= MIN_PIXELS)
    if textured.mean() < MIN_TEXTURED_SHARE:
        share = f"less than {MIN_TEXTURED_SHARE:.0%}"
        return check.not_applicable(f"{share} of what is seen shows a picture with sharp edges in it")
    luminance = srgb_from_linear_array(colors.linear[textured]) @ LUMINANCE
    if float(np.ptp(np.percentile(luminance, (2, 98)))) < MIN_CONTRAST:
        return check.not_applicable("its pictures are one plain colour where they are seen")
    points = float(np.median(colors.edges_per_m[textured])) * surface.longest
    texels = float(np.median(colors.texels_per_m[textured])) * surface.longest
    fault = "is blurred" if texels > 2 * points else "is small"
    message = f"its picture {fault}: {points:.0f} points along the longest side can be told apart; bring a sharper one"
    return check.at_least(points, limit, "materials", message)


def _own_colors(asset: Asset) -> ColorSamples:
    """As `_color_samples`. Raises Unmeasured where one of the materials is bare metal."""
    colors = _color_samples(asset)
    if any(m.metallic >= MIN_METALNESS for m in asset.materials):
        raise check.Unmeasured(check.not_applicable(IS_METAL))
    return colors


def _color_samples(asset: Asset) -> ColorSamples:
    """Colours of a loose mesh. Raises Unmeasured for anything else."""
    welded_surface(asset)
    return _sample_colors(asset.root.visuals, asset.materials)


@lru_cache(maxsize=2)
def _sample_colors(visuals: tuple[Visual, ...], materials: tuple[Material, ...]) -> ColorSamples:
    by_id = {m.id: m for m in materials}
    areas = [float(_areas(v).sum()) for v in visuals]
    counts = [max(1, round(POINTS * area / sum(areas))) for area in areas]
    parts = [_sample_visual(v, by_id[v.material], n) for v, n in zip(visuals, counts, strict=True)]
    return ColorSamples(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _sample_visual(visual: Visual, material: Material, count: int) -> tuple[Floats, Floats, Floats]:
    base, image, uv = np.array(material.base_color[:3]), material.base_color_texture, visual.mesh.uv
    if image is None or uv is None:
        return np.tile(base, (count, 1)), np.zeros(count), np.zeros(count)
    pixels, edge_px = _pixels(image), _edge_width(image)
    face, weights = _points_on_faces(_areas(visual), count)
    at = np.einsum("nk,nkd->nd", weights, uv[visual.mesh.faces[face]])
    # The nearest pixels: pictures repeat, and v goes up.
    high, wide = pixels.shape[:2]
    column = np.minimum((at[:, 0] % 1.0 * wide).astype(np.int64), wide - 1)
    row = np.minimum(((1 - at[:, 1] % 1.0) * high).astype(np.int64), high - 1)
    displayed = pixels[np.maximum(row, 0), column]
    texels_per_m = _texels_per_m(visual, image)[face]
    is_gradient = edge_px > GRADIENT_SHARE * max(image.width_px, image.height_px)
    # What was painted by `ingest` has one patch to a triangle, however sharp the vertex colours were.
    edges_per_m = np.zeros(count) if image.name == PAINTED or is_gradient else texels_per_m / edge_px
    return base * linear_from_srgb_array(displayed), texels_per_m, edges_per_m


def _areas(visual: Visual) -> Floats:
    corners = visual.mesh.vertices[visual.mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(np.linalg.norm(cross, axis=1) / 2)


def _points_on_faces(areas: Floats, count: int) -> tuple[Ints, Floats]:
    """(N,) faces and (N, 3) barycentric weights of points spread evenly. Ref: the R2 sequence, Roberts 2018."""
    ends = np.cumsum(areas)
    face = np.minimum(np.searchsorted(ends, (np.arange(count) + 0.5) / count * ends[-1]), len(areas) - 1)
    u, v = ((np.arange(1, count + 1)[:, None] * np.array([0.7548776662466927, 0.5698402909980532])) % 1.0).T
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return face.astype(np.int64), np.stack([1 - u - v, u, v], axis=1)


def _texels_per_m(visual: Visual, image: Texture) -> Floats:
    """(F,) pixels of the picture to a metre on each face."""
    assert visual.mesh.uv is not None
    corners = visual.mesh.uv[visual.mesh.faces]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2 * image.width_px * image.height_px
    return np.asarray(np.sqrt(across / np.maximum(_areas(visual), 1e-300)))


@lru_cache(maxsize=8)
def _pixels(image: Texture) -> Floats:
    """(H, W, 3) as displayed, 0..1, no larger than is worth looking at."""
    with Image.open(io.BytesIO(image.png)) as opened:
        picture = opened.convert("RGB")
    picture.thumbnail((MAX_PIXELS, MAX_PIXELS), Image.Resampling.BOX, reducing_gap=None)
    return np.asarray(np.asarray(picture, dtype=np.float64) / 255)


@lru_cache(maxsize=8)
def _edge_width(image: Texture) -> float:
    """Pixels of the file that the sharpest edges of a picture take, its contrast over its steepest slope; 1 or more."""
    grey = _pixels(image) @ LUMINANCE
    if min(grey.shape) < 2:
        return 1.0
    slope = np.concatenate([np.abs(np.diff(grey, axis=0)).ravel(), np.abs(np.diff(grey, axis=1)).ravel()])
    contrast, steep = float(np.ptp(np.percentile(grey, (1, 99)))), float(np.percentile(slope, 99.8))
    file_px = max(image.width_px, image.height_px) / max(grey.shape)
    return max(1.0, contrast / steep * file_px) if contrast > 0 and steep > 0 else 1.0


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
    wide = ((name, width) for name, width in widths.items() if width > limit)
    problems = ((f"sites/{name}", f"is {width:.3f} m wide; a gripper opens to {limit:g} m") for name, width in wide)
    return check.Measurement(min(widths.values()), tuple(problems))


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
    if mujoco_facts.load_mjcf(package.mjcf).error:
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
    model = mujoco_facts.load_mjcf(package.scene).model
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
    body = mujoco_facts.free_bodies(model)[0]
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
