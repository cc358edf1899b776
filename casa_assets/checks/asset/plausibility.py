"""Find implausible sizes, masses, joints and grips, surfaces without collision shapes, and rooms that shapes fill."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from casa_assets.checks import check
from casa_assets.checks.check import Package
from casa_assets.checks.motion.simulation import grip_of
from casa_assets.core.numeric import Floats
from casa_assets.mesh.solid.deviation import distances_outside_hulls, fibonacci_directions, surface_samples
from casa_assets.mesh.solid.primitive import link_bounds, shape_bounds, tessellate
from casa_assets.mesh.solid.solids import union
from casa_assets.mesh.surface import face_normals, is_closed, signed_volume, weld
from casa_assets.mesh.voxels import closed_shares, open_rooms
from casa_assets.model.asset.asset import Asset, Base, Collider, Joint, Link
from casa_assets.model.asset.parts import Hull, MeshShape
from casa_assets.model.pose import Pose

SAMPLES = 4000  # Points of the visible surface that are looked at. Our choice.
# A point is uncovered where it is farther than this from every collision shape: metres, or this part of the longest
# side of the link where that is more. Both are twice what the boxes around the two may differ by (AST009).
REACH_M = 0.008
REACH_RATIO = 0.04
NOT_LOOSE = "it did not come as one loose mesh; what is built or taken apart gives each part its own shapes"
NO_ROOM = "no open room takes a share of its hull that matters"
NO_HULLS = "none of its collision shapes is a hull"
NO_VOLUME = "its collision shapes enclose no volume"
WATER_KG_M3 = 1000.0  # Ref: CRC Handbook of Chemistry and Physics, water at 4 degrees Celsius.
# What two fingers close on; keys are pressed, and rims, trays and racks are pushed along.
HELD_LABELS = frozenset({"handle", "pull", "knob", "lever"})
# A finger as a bar. Ref: the fingers of a Panda hand are 2 cm wide and some 5 cm long; here, half of their pad's width.
PAD_M, FINGER_M, OPENING_M = 0.01, 0.05, 0.08
DEEPEST_M, LAYER_M = 0.02, 0.002  # thickness of a finger up to which room is looked for, and the steps of it
POINT_M = 0.005  # between points along a finger
PLACES = (0.0, 0.5, -0.5, 0.95, -0.95)  # along a handle, as shares of half its length
FREE_M = 1e-4  # distance from other parts at which a point lies free
# Labels of what a hand may take. A rim or a tray is held where a thing has no handle.
GRIP_LABELS = frozenset(
    {"handle", "knob", "button", "lever", "key", "lid", "rim", "pull", "spout", "roll", "tray", "rack", "seat"}
)
# What fingers close on: one side of it at least is no thinner than this. Our choice: finger pads of rubber give by a
# millimetre or two, and slip off an edge that is thinner than both of them.
HANDLE_LABELS = frozenset({"handle", "pull"})
MIN_HANDLE_M = 0.005
# What is pushed round or along and need not fit between two fingers.
PUSHED_LABELS = frozenset({"roll", "seat", "lid", "rack", "tray"})
MIN_GRIP_M = 0.0015
# Points of a grip's surface that are looked at, the share of them that has to lie free, and how far from other parts.
GRIP_SAMPLES = 64
MIN_FREE_SHARE = 0.1
FREE_DISTANCE_M = 2e-4
# How far a centre of mass may lie outside the hull of its link's shapes: thin walls without colliders have mass, too.
MAX_OFF_HULL_M = 0.001
# A radius of gyration below this part of the limit is too small. Our choice.
MIN_GYRATION_RATIO = 0.15
DIRECTIONS = fibonacci_directions(256)


def visible_surface_is_covered(asset: Asset, limit: float) -> check.Measurement:
    """AST016: largest share of a link's visible surface that is away from every collision shape, 0..1."""
    shares = {f"links/{k.name}/colliders": _uncovered_share(k) for k in asset.links if k.visuals and k.colliders}
    message = "{:.0%} of what is seen lies outside every collision shape; add shapes, or close the holes of the mesh"
    return check.all_at_most(shares, limit, message, "none of its links is both seen and touched")


def _uncovered_share(link: Link) -> float:
    vertices, faces = check.merged_mesh(link.visuals)
    reach = max(REACH_M, REACH_RATIO * float(np.ptp(vertices, axis=0).max()))
    uncovered = surface_samples(vertices, faces, SAMPLES)
    for collider in link.colliders:
        # What one shape covers need not be held against the others.
        hull = tessellate(collider.shape, collider.pose)[0]
        uncovered = uncovered[distances_outside_hulls(uncovered, [hull]) > reach]
        if not len(uncovered):
            break
    return len(uncovered) / SAMPLES


def open_rooms_stay_open(asset: Asset, limit: float) -> check.Measurement:
    """AST018: largest share of an open room that collision shapes fill or close off, 0..1, whatever the category.

    Rooms into which only the backs of faces look are gaps in a surface and do not count.
    """
    if not check.is_loose_mesh(asset):
        return check.not_applicable(NOT_LOOSE)
    link = asset.root
    if not link.visuals or not link.colliders:
        return check.not_applicable("it is not both seen and touched")
    vertices, faces = check.merged_mesh(link.visuals)
    used, compact = np.unique(faces, return_inverse=True)
    points, places = weld(vertices[used])
    rooms = open_rooms(points, places[compact.reshape(-1, 3)])
    kept = rooms.kept(with_gaps=False)
    if not kept:
        return check.not_applicable(NO_ROOM)
    shapes = [tessellate(c.shape, c.pose) for c in link.colliders]
    starts = np.cumsum([0, *(len(p) for p, _ in shapes)])
    shape_faces = np.concatenate([f + start for (_, f), start in zip(shapes, starts, strict=False)])
    shares = closed_shares(rooms, np.concatenate([p for p, _ in shapes]), shape_faces)
    message = "collision shapes fill or close off {:.0%} of an open room that takes {:.0%} of the hull; fit them again"
    rows = ((f"links/{link.name}/colliders", shares[k], message.format(shares[k], rooms.shares[k])) for k in kept)
    return check.worst_above(rows, limit, NO_ROOM)


def size_is_bounded(asset: Asset, limit: float) -> check.Measurement:
    """AST001: longest side of the box around all that is seen, metres; parts of a room may be longer."""
    if asset.contract == "room":
        return check.not_applicable("it is a part of a room, which may be longer than a thing in it")
    longest = _longest_visible_side(asset)
    if longest is None:
        return check.not_applicable(check.NO_VISUALS)
    message = f"is {longest:.3g} m long, more than {limit:g} m; look for a wrong unit of length"
    return check.at_most(longest, limit, "", message)


def colliders_are_thick_enough(asset: Asset, limit: float) -> check.Measurement:
    """AST002: least thickness of the collision shapes of a link, metres."""
    thickness = {}
    for link in _touchable(asset):
        points = np.concatenate([tessellate(c.shape, c.pose)[0] for c in link.colliders])
        # The direction of least spread is the first.
        _, vectors = np.linalg.eigh(np.cov(points.T))
        thickness[f"links/{link.name}/colliders"] = float(np.ptp(points @ vectors[:, 0]))
    message = "has collision shapes of {:.2g} m thickness; thicken the sheet or correct the scale"
    return check.all_at_least(thickness, limit, message, check.NO_COLLIDERS)


def density_is_not_too_high(asset: Asset, limit: float) -> check.Measurement:
    """AST003: highest density of a link over that of water, mass over the union of its shapes."""
    densities = _densities(asset)
    message = "weighs {:.3g} times water for the volume of its collision shapes; correct the mass, or fill the shapes"
    return check.all_at_most(densities, limit, message, check.NO_COLLIDERS)


def density_is_not_too_low(asset: Asset, limit: float) -> check.Measurement:
    """AST004: lowest density of a link over that of water, mass over the union of its shapes."""
    densities = _densities(asset)
    message = "weighs {:.3g} times water for the volume of its collision shapes; correct the mass unless it is hollow"
    return check.all_at_least(densities, limit, message, check.NO_COLLIDERS)


def collider_count_is_bounded(asset: Asset, limit: float) -> check.Measurement:
    """AST005: largest number of collision shapes of a link."""
    counts = {f"links/{k.name}/colliders": len(k.colliders) for k in asset.links}
    return check.all_at_most(counts, limit, "has {} collision shapes; merge some", check.NO_COLLIDERS)


def hull_vertex_count_is_bounded(asset: Asset, limit: float) -> check.Measurement:
    """AST006: largest number of vertices of a convex hull."""
    counts = {pointer: len(hull.mesh.vertices) for pointer, hull in _hulls(asset)}
    return check.all_at_most(counts, limit, "has {} vertices; use a hull of fewer", NO_HULLS)


def hulls_are_convex(asset: Asset, limit: float) -> check.Measurement:
    """AST007: farthest that a vertex of a hull lies outside one of its faces, metres."""
    depths, problems = [], []
    for pointer, hull in _hulls(asset):
        vertices, faces = hull.mesh.vertices, hull.mesh.faces.astype(np.int64)
        normals, areas = face_normals(vertices, faces)
        offsets = np.einsum("ij,ij->i", normals, vertices[faces[:, 0]])
        depth = max(0.0, float((vertices @ normals.T - offsets)[:, areas > 0].max(initial=0.0)))
        depths.append(depth)
        if not is_closed(faces):
            problems.append((pointer, "is not closed; take the convex hull of its vertices"))
        elif depth > limit:
            dented = f"is dented by {depth:.2g} m or inside out"
            problems.append((pointer, f"{dented}; take the convex hull of its vertices"))
    return check.largest(depths, problems, NO_HULLS)


def mass_lies_inside_colliders(asset: Asset, limit: float) -> check.Measurement:
    """AST008: farthest that the centre or spread of mass lies outside the collision shapes, metres."""
    rows: list[check.Row] = []
    for link in _touchable(asset):
        center, spread = _mass_outside(link)
        off = f"centre of mass is {center:.2g} m outside the collision shapes; measure it again"
        longer = f"inertia is that of a body {2 * spread:.2g} m longer; correct its unit or frame"
        rows += [(f"links/{link.name}/inertial", *row) for row in ((center, off), (spread, longer))]
    return check.worst_above(rows, limit, check.NO_COLLIDERS)


def colliders_match_visual_bounds(asset: Asset, limit: float, ratio: float, built_m: float) -> check.Measurement:
    """AST009: widest gap between the boxes around what is seen and what collides of a link, metres.

    A link is granted `limit` metres, or where that is more `ratio` of its longest side; `built_m` at most where a
    family built it, which knows its own shape.
    """
    gaps, problems = [], []
    for link in _touchable(asset):
        if not link.visuals:
            continue
        vertices = np.concatenate([v.mesh.vertices for v in link.visuals])
        visible = np.array([vertices.min(axis=0), vertices.max(axis=0)])
        sides = np.abs(visible - np.asarray(link_bounds(link)))
        gap, side = float(sides.max()), int(sides.argmax())
        gaps.append(gap)
        relative = ratio * float(np.ptp(visible, axis=0).max())
        if gap > max(limit, min(relative, built_m) if check.is_from_family(asset) else relative):
            where = f"{'low' if side < 3 else 'high'} {'xyz'[side % 3]}"
            message = f"collision shapes end {gap:.3g} m away from what is seen at {where}; fit them again"
            problems.append((f"links/{link.name}/colliders", message))
    return check.largest(gaps, problems, "none of its links is both seen and touched")


def origin_is_at_base_center(asset: Asset, limit: float) -> check.Measurement:
    """AST010: distance of a free asset's footprint centre from its origin, metres."""
    if asset.base is not Base.FREE:
        return check.not_applicable("it is fixed in its place and has no footprint")
    if not any(k.visuals for k in asset.links):
        return check.not_applicable(check.NO_VISUALS)
    lower, upper = asset.bounds
    x, y = (lower + upper)[:2] / 2
    offsets = {"middle in x": float(x), "middle in y": float(y), "lowest point": float(lower[2])}
    message = "{} is at {:.3g} m, not at 0; move the origin to the middle of the footprint"
    problems = tuple(("", message.format(what, at)) for what, at in offsets.items() if abs(at) > limit)
    return check.Measurement(max(abs(at) for at in offsets.values()), problems)


def licence_is_stated(asset: Asset) -> check.Measurement:
    """AST011: the source states a licence."""
    if asset.provenance.licence not in ("", "unknown"):
        return check.no_fault()
    message = "is unknown; ask the author before the asset is passed on"
    return check.Measurement(problems=(("provenance/licence", message),))


def visible_links_have_colliders(asset: Asset) -> check.Measurement:
    """AST012: number of visible links without a collision shape."""
    if not any(k.visuals for k in asset.links):
        return check.not_applicable(check.NO_VISUALS)
    message = "is seen, but has no collision shape; give it one"
    return check.count((f"links/{k.name}", message) for k in asset.links if k.visuals and not k.colliders)


def mass_fits_category(package: Package, limit: float) -> check.Measurement:
    """AST013: factor between the mass and the nearer end of its category's range, below 1 inside."""
    category, portion, mass = package.category, package.asset.labels.portion, package.asset.mass
    usual = category.usual(portion).mass_kg
    message = f"is {mass:.3g} kg; {category.called(portion)} weighs {usual.low:g} to {usual.high:g} kg"
    return check.at_most(usual.beyond(mass), limit, "mass", message)


def size_fits_category(package: Package, limit: float) -> check.Measurement:
    """AST014: factor between the longest side and the nearer end of its category's range, below 1 inside."""
    category, portion, longest = package.category, package.asset.labels.portion, _longest_visible_side(package.asset)
    if not longest:
        return check.not_applicable(check.NO_VISUALS)
    usual = category.usual(portion).longest_m
    message = f"is {longest:.3g} m long; {category.called(portion)} has {usual.low:g} to {usual.high:g} m"
    return check.at_most(usual.beyond(longest), limit, "bounds", message)


def joints_are_closed_at_zero(asset: Asset) -> check.Measurement:
    """AST015: distance of zero from the range of a joint, or from its ends where states name it, rad or m."""
    with_states = {s.joint for s in asset.states}
    rows = []
    for joint in asset.joints:
        low, high = joint.range
        distance = min(abs(low), abs(high)) if joint.name in with_states else max(low, -high, 0.0)
        expected = "start or end at" if joint.name in with_states else "hold"
        message = f"goes from {low:g} to {high:g}; it should {expected} zero, where it is closed"
        rows.append((f"joints/{joint.name}/range", distance, message))
    return check.worst_above(rows, 0.0, check.NO_JOINTS)


def _touchable(asset: Asset) -> list[Link]:
    """Links with collision shapes; `visible_links_have_colliders` reports those without."""
    return [k for k in asset.links if k.colliders]


def _hulls(asset: Asset) -> Iterator[tuple[str, Hull]]:
    for pointer, _, collider in check.colliders_of(asset):
        if isinstance(collider.shape, Hull):
            yield pointer, collider.shape


def _longest_visible_side(asset: Asset) -> float | None:
    """Longest side of the box around all visible parts, metres; None if nothing is visible."""
    return float(np.ptp(asset.bounds, axis=0).max()) if any(k.visuals for k in asset.links) else None


def _densities(asset: Asset) -> dict[str, float]:
    """Pointer -> density over that of water, of each link whose collision shapes enclose a volume.

    Raises Unmeasured where there are shapes and none encloses one.
    """
    volumes = [(link, _volume(link.colliders)) for link in _touchable(asset)]
    found = {f"links/{k.name}/inertial": k.inertial.mass / v / WATER_KG_M3 for k, v in volumes if v > 0}
    if volumes and not found:
        raise check.Unmeasured(check.not_run(NO_VOLUME))
    return found


@lru_cache(maxsize=64)
def _volume(colliders: tuple[Collider, ...]) -> float:
    """Volume of the union, m^3; zero where no shape is a solid. Cached because two checks of one asset ask for it."""
    joined = union([tessellate(c.shape, c.pose) for c in colliders])
    return 0.0 if joined is None else signed_volume(*joined)


def _mass_outside(link: Link) -> tuple[float, float]:
    """How far the centre of mass is outside the box of the colliders, and how much too wide mass is spread, metres.

    Ref: Popoviciu 1935, the deviation of what lies in an interval is at most half its length.
    """
    lower, upper = np.asarray(link_bounds(link))
    center = np.array(link.inertial.center_of_mass)
    outside = float(np.maximum(lower - center, center - upper).max())
    diagonal = np.diag(link.inertial.tensor)
    # (3,) along the axes of the link
    deviation = np.sqrt(np.maximum(diagonal.sum() / 2 - diagonal, 0.0) / link.inertial.mass)
    excess = float((deviation - (upper - lower) / 2).max())
    return max(0.0, outside), max(0.0, excess)


def fingers_have_room(asset: Asset, limit: float) -> check.Measurement:
    """KIN011: thickness of the fingers that find room on both sides of each handle and knob, metres; the least."""
    if not check.is_from_family(asset):
        return check.not_applicable(check.NOT_BUILT)
    rooms = {}
    for joint in asset.joints:
        link, grip = grip_of(asset, joint)
        if grip is not None and grip.label in HELD_LABELS:
            rooms[f"joints/{joint.name}"] = _room(asset, joint, link, grip)
    message = "beside its grip, fingers of {:.3f} m at most find room on both sides; bring it out"
    return check.all_at_least(rooms, limit, message, check.NO_JOINTS)


def _room(asset: Asset, joint: Joint, link: str, grip: Collider) -> float:
    """Thickness of the thickest fingers that close on a grip somewhere, metres; at most `DEEPEST_M`."""
    lower, upper = shape_bounds(grip.shape, Pose())
    pose = asset.asset_from_link(link) @ grip.pose
    clouds = _others(asset, joint, grip, shape_bounds(grip.shape, pose))
    if not clouds:
        return DEEPEST_M
    best = 0.0
    for fingers in _grasps((lower + upper) / 2, (upper - lower) / 2):
        free = distances_outside_hulls(pose.apply(fingers.reshape(-1, 3)), clouds) > FREE_M
        # Layers of points from the grip outwards; a finger is as thick as all layers up to it are free.
        layers = free.reshape(fingers.shape[0], -1).all(axis=1)
        best = max(best, LAYER_M * int(np.logical_and.accumulate(layers).sum()))
        if best >= DEEPEST_M:
            break
    return best


def _others(asset: Asset, joint: Joint, grip: Collider, bounds: Floats) -> list[Floats]:
    """Vertices of the shapes near a grip, joints at zero; without the door that has to be open before it is taken."""
    lower, upper = bounds[0] - FINGER_M, bounds[1] + FINGER_M
    door = asset.carried_by([j.child for j in asset.joints if j.name == joint.behind])
    found = []
    for _, owner, collider in check.colliders_of(asset):
        if collider is grip or isinstance(collider.shape, MeshShape) or owner.name in door:
            continue
        pose = asset.asset_from_link(owner.name) @ collider.pose
        low, high = shape_bounds(collider.shape, pose)
        if (low < upper).all() and (high > lower).all():
            found.append(tessellate(collider.shape, pose)[0])
    return found


def _grasps(centre: Floats, half: Floats) -> Iterator[Floats]:
    """Two fingers around a box, in each way: points of shape (layers, points, 3), the layers from the box outwards."""
    layers = np.arange(LAYER_M, DEEPEST_M + LAYER_M / 2, LAYER_M)
    for close in np.argsort(half, kind="stable"):
        if 2 * half[close] > OPENING_M:
            continue
        for come in (k for k in range(3) if k != close):
            across = 3 - close - come
            wide = min(PAD_M / 2, half[across])
            deep = np.arange(-min(PAD_M, half[come]), FINGER_M, POINT_M)
            for sign in (1.0, -1.0):
                for share in PLACES[: 1 if half[across] <= PAD_M else None]:
                    middle = share * (half[across] - wide)
                    grid = np.stack(np.meshgrid(layers, (-1.0, 1.0), (-wide, 0.0, wide), deep, indexing="ij"), axis=-1)
                    points = np.empty((*grid.shape[:-1], 3))
                    points[..., close] = grid[..., 1] * (half[close] + grid[..., 0])
                    points[..., across] = middle + grid[..., 2]
                    points[..., come] = sign * (half[come] + grid[..., 3])
                    yield centre + points.reshape(len(layers), -1, 3)


def grips_fit_a_gripper(asset: Asset, limit: float) -> check.Measurement:
    """KIN007: each joint has a labelled grip that is free and fits a gripper; metres of the widest."""
    if not check.is_fixture_like(asset) or not asset.joints:
        return check.not_applicable(check.NO_JOINTS if check.is_fixture_like(asset) else check.NOT_BUILT)
    problems, widest = [], 0.0
    for joint in asset.joints:
        link, grip = grip_of(asset, joint)
        if joint.grip is None:
            fault = "names no collider that a hand takes"
        elif grip is None:
            fault = f"its grip {joint.grip!r} does not move with it"
        elif grip.label not in GRIP_LABELS:
            fault = f"its grip is labelled {grip.label!r}, not one of {', '.join(sorted(GRIP_LABELS))}"
        else:
            # Full sizes along its own axes, metres.
            sides = np.sort(np.ptp(shape_bounds(grip.shape, Pose()), axis=0)).tolist()
            if grip.label not in PUSHED_LABELS:
                widest = max(widest, sides[0])
            fault = _size_fault(grip, sides, limit)
            if not fault and _free_share(asset, link, grip) < MIN_FREE_SHARE:
                fault = f"its grip {grip.name!r} is buried in other parts; bring it out"
        if fault:
            problems.append((f"joints/{joint.name}", fault))
    return check.Measurement(widest, tuple(problems))


def joint_axes_are_aligned(asset: Asset, limit: float) -> check.Measurement:
    """KIN008: joint axes of built things lie along x, y or z; largest deviation, rad."""
    if not check.is_fixture_like(asset) or not asset.joints:
        return check.not_applicable(check.NO_JOINTS if check.is_fixture_like(asset) else check.NOT_BUILT)
    deviations = {}
    for joint in asset.joints:
        x, y, z = np.sort(np.abs(asset.asset_from_link(joint.child).rotation @ np.array(joint.axis)))
        # The arc cosine of a number near 1 would lose half of the digits.
        deviations[f"joints/{joint.name}"] = float(np.arctan2(np.hypot(x, y), z))
    message = "its axis is {:.3g} rad off x, y or z; turn it straight"
    return check.all_at_most(deviations, limit, message, check.NO_JOINTS)


def inertia_matches_colliders(asset: Asset, limit: float) -> check.Measurement:
    """AST017: largest radius of gyration of a link over half the diagonal of its shapes."""
    if not check.is_fixture_like(asset):
        return check.not_applicable(check.NOT_BUILT)
    problems, ratios = [], []
    for link in asset.links:
        bounds = link_bounds(link)
        if bounds is None:
            continue
        half = float(np.linalg.norm(bounds[1] - bounds[0])) / 2
        gyration = float(np.sqrt(np.trace(link.inertial.tensor) / 2 / link.inertial.mass))
        ratio = gyration / half
        ratios.append(ratio)
        pointer = f"links/{link.name}/inertial"
        if not MIN_GYRATION_RATIO * limit <= ratio <= limit:
            message = f"turns as if its mass were {gyration:.3f} m from its middle; its shapes reach {half:.3f} m"
            problems.append((pointer, message))
        points = np.concatenate([tessellate(c.shape, c.pose)[0] for c in link.colliders])
        support = (DIRECTIONS @ points.T).max(axis=1)
        # Along the worst direction.
        outside = float((DIRECTIONS @ np.array(link.inertial.center_of_mass) - support).max())
        if outside > MAX_OFF_HULL_M:
            problems.append((pointer, f"centre of mass is {outside:.3f} m outside the hull of its shapes"))
    return check.largest(ratios, problems, check.NO_COLLIDERS)


def _size_fault(grip: Collider, sides: list[float], limit: float) -> str:
    """Why no gripper of that opening takes a shape; empty where one does."""
    if grip.label in PUSHED_LABELS:
        return ""
    if not MIN_GRIP_M <= sides[0] <= limit:
        return f"its grip is {sides[0]:.4f} m across at its thinnest; no gripper holds that"
    if grip.label in HANDLE_LABELS and not any(MIN_HANDLE_M <= side <= limit for side in sides):
        return f"no side of its handle is {MIN_HANDLE_M:g} to {limit:g} m; fingers find no hold on it"
    return ""


def _free_share(asset: Asset, link: str, grip: Collider) -> float:
    """Share of the surface of a grip that lies in no other part, joints at zero. Parts that move with it count, too."""
    asset_from_grip = asset.asset_from_link(link) @ grip.pose
    points = surface_samples(*tessellate(grip.shape, asset_from_grip), GRIP_SAMPLES)
    lower, upper = points.min(axis=0), points.max(axis=0)
    clouds = []
    for _, other, collider in check.colliders_of(asset):
        pose = asset.asset_from_link(other.name) @ collider.pose
        bounds = shape_bounds(collider.shape, pose)
        is_apart = (bounds[0] > upper).any() or (bounds[1] < lower).any()
        # A handle may be made of several colliders of one label, which fingers close on together.
        is_same = other.name == link and collider.label == grip.label
        if not is_apart and not is_same and not isinstance(collider.shape, MeshShape):
            clouds.append(tessellate(collider.shape, pose)[0])
    return float((distances_outside_hulls(points, clouds) > FREE_DISTANCE_M).mean()) if clouds else 1.0
