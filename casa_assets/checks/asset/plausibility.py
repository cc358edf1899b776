"""Find implausible sizes, masses and joint ranges, surfaces without collision shapes, and rooms that shapes fill."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from casa_assets.checks import check
from casa_assets.checks.package import Package
from casa_assets.core.numeric import Floats
from casa_assets.mesh.solid.deviation import distances_outside_hulls, surface_samples
from casa_assets.mesh.solid.primitive import link_bounds, tessellate
from casa_assets.mesh.solid.solids import union
from casa_assets.mesh.surface import face_normals, signed_volume
from casa_assets.mesh.topology import is_closed, weld
from casa_assets.mesh.voxels import closed_shares, open_rooms
from casa_assets.model.asset.asset import Asset, Base, Collider, Link
from casa_assets.model.asset.parts import Hull

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
    thickness = {f"links/{k.name}/colliders": _thickness(k) for k in _touchable(asset)}
    message = "has collision shapes of {:.2g} m thickness; thicken the sheet or correct the scale"
    return check.all_at_least(thickness, limit, message, check.NO_COLLIDERS)


def density_is_not_too_high(asset: Asset, limit: float) -> check.Measurement:
    """AST003: highest density of a link over that of water, mass over the union of its shapes."""
    densities = _densities(asset)
    if not densities and _touchable(asset):
        return check.not_run(NO_VOLUME)
    message = "weighs {:.3g} times water for the volume of its collision shapes; correct the mass, or fill the shapes"
    return check.all_at_most(densities, limit, message, check.NO_COLLIDERS)


def density_is_not_too_low(asset: Asset, limit: float) -> check.Measurement:
    """AST004: lowest density of a link over that of water, mass over the union of its shapes."""
    densities = _densities(asset)
    if not densities and _touchable(asset):
        return check.not_run(NO_VOLUME)
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
            problems.append(
                (pointer, f"is dented by {depth:.2g} m or inside out; take the convex hull of its vertices")
            )
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
        sides = np.abs(visible - _bounds(link))
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


def _bounds(link: Link) -> Floats:
    bounds = link_bounds(link)
    assert bounds is not None, "links without colliders were left out"
    return bounds


def _thickness(link: Link) -> float:
    """Extent of the collision shapes along the direction of least spread, metres."""
    points = np.concatenate([tessellate(c.shape, c.pose)[0] for c in link.colliders])
    _, vectors = np.linalg.eigh(np.cov(points.T))
    return float(np.ptp(points @ vectors[:, 0]))


def _densities(asset: Asset) -> dict[str, float]:
    """Pointer -> density over that of water, of each link whose collision shapes enclose a volume."""
    volumes = ((link, _volume(link.colliders)) for link in _touchable(asset))
    return {f"links/{k.name}/inertial": k.inertial.mass / v / WATER_KG_M3 for k, v in volumes if v > 0}


@lru_cache(maxsize=64)
def _volume(colliders: tuple[Collider, ...]) -> float:
    """Volume of the union, m^3; zero where no shape is a solid. Cached because two checks of one asset ask for it."""
    joined = union([tessellate(c.shape, c.pose) for c in colliders])
    return 0.0 if joined is None else signed_volume(*joined)


def _mass_outside(link: Link) -> tuple[float, float]:
    """How far the centre of mass is outside the box of the colliders, and how much too wide mass is spread, metres.

    Ref: Popoviciu 1935, the deviation of what lies in an interval is at most half its length.
    """
    lower, upper = _bounds(link)
    center = np.array(link.inertial.center_of_mass)
    outside = float(np.maximum(lower - center, center - upper).max())
    diagonal = np.diag(link.inertial.tensor)
    # (3,) along the axes of the link
    deviation = np.sqrt(np.maximum(diagonal.sum() / 2 - diagonal, 0.0) / link.inertial.mass)
    excess = float((deviation - (upper - lower) / 2).max())
    return max(0.0, outside), max(0.0, excess)
