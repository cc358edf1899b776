"""Find components that do not belong to the object: ground planes, backdrops, pedestals, sky domes, floating specks."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from casa_assets.core.numeric import Floats, Mask
from casa_assets.ingest.draft import warning
from casa_assets.ingest.repair.components import Components, box_gaps
from casa_assets.mesh.solid.deviation import surface_samples
from casa_assets.mesh.solid.solids import hull_volume
from casa_assets.mesh.surface import face_normals, signed_volume
from casa_assets.mesh.topology import is_closed
from casa_assets.model.issue import Issue
from casa_assets.model.registry.category import FALLBACK, Category

# All numbers below are choices. Sizes are longest sides of bounding boxes.
# A mesh of more components is left as it is.
MAX_COMPONENTS = 5000
# A speck is smaller than this share of the largest component. It floats if its distance to the rest is larger than
# SPECK_GAP of the largest component and SPECK_GAP_OF_OWN of its own size, so that crumbs and sprinkles stay.
SPECK_SIZE = 0.05
SPECK_GAP = 0.03
SPECK_GAP_OF_OWN = 3.0
# Specks nearer to each other than this share of their size are connected, as the links of a chain are. That is tested
# for no more specks than these.
LINK_GAP_SHARE = 0.25
MAX_LINKED = 1500
SURFACE_SAMPLES = 40_000
# A ground plane is at least this many times wider than the rest, and at most this thick, as a share of its size.
GROUND_WIDTH = 1.5
GROUND_THICKNESS = 1e-3
# A sky dome is at least this many times larger than all that is in it, and fills this share of its hull.
SKY_WIDTH = 5.0
SKY_HULL_FILL = 0.9
# Tolerance of cosines between faces that are parallel or perpendicular.
COSINE_TOLERANCE = 0.02
# Several flat sheets are the walls of a room if they are this many times wider than the rest.
ROOM_WIDTH = 2.5
# A backdrop is an open sheet that is bent along one line. Its normals n lie in a plane across that line: largest mean
# |n . line|, smallest second moment of the normals in that plane (.5 for a right angle of equal sides), and smallest
# length of the mean normal. The rest of the mesh lies in front of this share of the sheet.
MAX_OFF_PLANE = 0.03
MIN_BEND_MOMENT = 0.1
MIN_MEAN_NORMAL = 0.5
MIN_SHARE_BEHIND = 0.9
# A stand is a slab: at most this thick, as a share of its width, filling this share of its hull, this many times wider
# than the rest and no farther from it than this share of its size.
STAND_THICKNESS = 0.15
STAND_HULL_FILL = 0.9
STAND_WIDTH = 1.2
STAND_GAP = 0.05
# Without its stand the mesh is nearer to the usual proportions by this much, and this near; logarithms of ratios.
MIN_IMPROVEMENT = 0.2
MAX_PROPORTION_ERROR = 0.7
# Components this large and this far apart, as shares of the largest one, are separate objects. That is tested for no
# more components than these.
APART_SIZE = 0.3
APART_GAP = 0.1
MAX_APART = 64


def foreign_parts(components: Components, category: Category | None) -> tuple[Mask, list[Issue]]:
    """(N,) True for components that do not belong to the object, and notes on them.

    The usual proportions of the category distinguish a pedestal from a foot; without one, pedestals stay.
    """
    is_foreign = np.zeros(components.count, dtype=bool)
    if components.count == 1 or components.count > MAX_COMPONENTS:
        return is_foreign, []
    notes: list[Issue] = []
    for kind, message, rows in (
        ("ground", "a wide flat sheet under or behind the object was taken away", _ground_planes(components)),
        ("backdrop", "a bent sheet behind the object was taken away", _backdrop(components)),
    ):
        if (rows & ~is_foreign).any():
            is_foreign |= rows
            notes.append(warning("MSH012", kind, message))
    sky = _sky(components, is_foreign)
    if sky is not None:
        is_foreign[sky] = True
        notes.append(warning("MSH012", "sky", "a shell far around the object was taken away"))
    stand = None if category is None or category.id == FALLBACK else _stand(components, is_foreign, category)
    if stand is not None:
        is_foreign[stand] = True
        notes.append(warning("MSH012", "stand", "a slab that the object stands on was taken away"))
    specks = _specks(components, is_foreign)
    if specks.any():
        message = f"{int(specks.sum())} stray pieces that touch nothing were taken away"
        notes.append(warning("MSH013", "floaters", message))
    return is_foreign | specks, notes


def separate_objects(components: Components, is_foreign: Mask) -> list[Issue]:
    """A note if large components form groups that are apart from each other."""
    if is_foreign.all():
        return []
    largest = float(components.longest_side[~is_foreign].max())
    large = np.flatnonzero(~is_foreign & (components.longest_side > APART_SIZE * largest))
    if not 1 < len(large) <= MAX_APART:
        return []
    near = box_gaps(components.lower[large], components.upper[large]) <= APART_GAP * largest
    groups = int(connected_components(near, directed=False)[0])
    message = f"{groups} groups of pieces stand apart from each other; give each object a file of its own"
    return [warning("MSH024", "pieces", message)] if groups > 1 else []


def _ground_planes(components: Components) -> Mask:
    """(N,) flat sheets that are much wider than all that is not flat; several, which might be boards, even wider."""
    flat = (components.upper - components.lower).min(axis=1) <= GROUND_THICKNESS * components.longest_side
    width = float(components.extents_of(~flat).max())
    wide: Mask = flat & (components.longest_side > GROUND_WIDTH * width) & (width > 0)
    return wide if wide.sum() == 1 else wide & (components.longest_side > ROOM_WIDTH * width)


def _backdrop(components: Components) -> Mask:
    """(N,) the largest component if it is an open sheet, bent along a line and much wider than the rest in front."""
    out = np.zeros(components.count, dtype=bool)
    component = int(np.argmax(components.longest_side))
    others = np.arange(components.count) != component
    faces = components.faces_of(component)
    longest, rest = components.longest_side[component], components.extents_of(others).max()
    if longest <= GROUND_WIDTH * rest or is_closed(faces):
        return out
    normals, areas = face_normals(components.points, faces)
    share = areas / areas.sum()
    spread, axes = np.linalg.eigh(np.einsum("n,ni,nj->ij", share, normals, normals))
    is_bent = spread[1] > MIN_BEND_MOMENT and float(share @ np.abs(normals @ axes[:, 0])) < MAX_OFF_PLANE
    is_corner = longest > ROOM_WIDTH * rest and _is_corner(normals, share)
    # The normals of a tube cancel each other out, so their mean is short.
    mean_normal_length = float(np.linalg.norm(share @ normals))
    center_of_others = (components.lower[others].min(axis=0) + components.upper[others].max(axis=0)) / 2
    height = np.einsum("ij,ij->i", center_of_others - components.points[faces].mean(axis=1), normals)
    share_ahead = float(share[height > 0].sum())
    out[component] = (
        (is_bent or is_corner)
        and mean_normal_length > MIN_MEAN_NORMAL
        and max(share_ahead, 1 - share_ahead) > MIN_SHARE_BEHIND
    )
    return out


def _is_corner(normals: Floats, share: Floats) -> bool:
    """True if nearly all of the area, (F,) shares with (F, 3) normals, is a floor and two perpendicular walls."""
    first = normals[int(np.argmax(share))]
    is_perpendicular = np.abs(normals @ first) < COSINE_TOLERANCE
    if not is_perpendicular.any():
        return False
    second = normals[int(np.argmax(np.where(is_perpendicular, share, -1)))]
    axes = np.stack([first, second, np.cross(first, second)], axis=1)
    is_along_axis = np.abs(normals @ axes) > 1 - COSINE_TOLERANCE
    is_on_planes = float(share @ is_along_axis.any(axis=1)) > MIN_SHARE_BEHIND
    return is_on_planes and bool((share @ is_along_axis > MIN_BEND_MOMENT).all())


def _sky(components: Components, is_foreign: Mask) -> int | None:
    """The component that is a convex shell far around all others and faces inwards; None if there is no such shell."""
    for component in np.argsort(-components.longest_side, kind="stable")[:3]:
        others = ~is_foreign & (np.arange(components.count) != component)
        if is_foreign[component] or not others.any():
            continue
        encloses_others = (components.lower[component] < components.lower[others]).all() and (
            components.upper[others] < components.upper[component]
        ).all()
        if encloses_others and components.extents_of(others).max() * SKY_WIDTH < components.longest_side[component]:
            points, faces = components.surface_of(int(component))
            # Negative: a dome faces inwards, while a fruit around its seeds faces outwards. A vessel fills less.
            if -signed_volume(points, faces) > SKY_HULL_FILL * hull_volume(points) > 0:
                return int(component)
    return None


def _stand(components: Components, is_foreign: Mask, category: Category) -> int | None:
    """The slab below all others without which the object has the proportions of its category, if there is one."""
    usual = np.sort(np.array(category.shape))
    for component in np.flatnonzero(~is_foreign):
        others = ~is_foreign & (np.arange(components.count) != component)
        if not others.any() or not _is_under(components, int(component), others):
            continue
        # Sorted proportions, so that the pose does not matter: the largest logarithm of the ratio to the usual ones.
        errors = []
        for sides in (components.extents_of(~is_foreign), components.extents_of(others)):
            proportions = np.sort(sides) / max(float(sides.max()), 1e-300)
            errors.append(float(np.abs(np.log(np.maximum(proportions, 1e-9) / usual)).max()))
        if errors[1] > MAX_PROPORTION_ERROR or errors[1] > errors[0] - MIN_IMPROVEMENT:
            continue
        points, faces = components.surface_of(int(component))
        if abs(signed_volume(points, faces)) >= STAND_HULL_FILL * hull_volume(points) > 0:  # a slab
            return int(component)
    return None


def _is_under(components: Components, component: int, others: Mask) -> bool:
    """True if a component is flat, wider than all others, and these are all on one side of it."""
    lower, upper = components.lower[component], components.upper[component]
    normal_axis = int(np.argmin(upper - lower))
    plane_axes = [k for k in range(3) if k != normal_axis]
    sides, other_sides = upper - lower, components.extents_of(others)
    if (
        sides[normal_axis] > STAND_THICKNESS * sides[plane_axes].min()
        or (sides[plane_axes] < STAND_WIDTH * other_sides[plane_axes]).any()
    ):
        return False
    gap = STAND_GAP * float(other_sides.max())
    above = components.lower[others][:, normal_axis].min() - upper[normal_axis]
    below = lower[normal_axis] - components.upper[others][:, normal_axis].max()
    return bool(abs(above) <= gap or abs(below) <= gap)


def _specks(components: Components, is_foreign: Mask) -> Mask:
    """(N,) small components that touch nothing and are not linked to others that do."""
    is_speck = np.zeros(components.count, dtype=bool)
    if is_foreign.all():
        return is_speck
    largest = float(components.longest_side[~is_foreign].max())
    small = ~is_foreign & (components.longest_side < SPECK_SIZE * largest)
    large = ~is_foreign & ~small
    if not small.any():
        return is_speck
    faces = components.faces[large[components.label]]
    used, local = np.unique(faces, return_inverse=True)
    samples = surface_samples(components.points[used], local.reshape(-1, 3), SURFACE_SAMPLES)
    index, face_is_small = np.flatnonzero(small), small[components.label]
    distance = cKDTree(np.concatenate([components.points[used], samples])).query(
        components.points[components.faces[face_is_small]].reshape(-1, 3)
    )[0]
    gap = np.full(components.count, np.inf)
    np.minimum.at(gap, components.label[face_is_small], distance.reshape(-1, 3).min(axis=1))
    floating = gap[index] > np.maximum(SPECK_GAP * largest, SPECK_GAP_OF_OWN * components.longest_side[index])
    if len(index) <= MAX_LINKED and not floating.all() and floating.any():
        sizes = np.minimum(components.longest_side[index][:, None], components.longest_side[index][None])
        cluster = connected_components(
            box_gaps(components.lower[index], components.upper[index]) <= LINK_GAP_SHARE * sizes, directed=False
        )[1]
        is_held = np.zeros(int(cluster.max()) + 1, dtype=bool)
        is_held[cluster[~floating]] = True
        floating &= ~is_held[cluster]
    is_speck[index[floating]] = True
    return is_speck
