"""Find implausible sizes, masses, densities, collision shapes and joint ranges in the asset record."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from casa_assets.checks.asset.built import NO_COLLIDERS, NO_JOINTS, UNSEEN, is_from_family
from casa_assets.checks.check import Measurement, largest, least, no_fault, not_applicable, not_run, required_limit
from casa_assets.checks.package.package import Package
from casa_assets.core.typing import Floats
from casa_assets.geometry.mesh.measure import face_normals, signed_volume
from casa_assets.geometry.mesh.topology import is_closed
from casa_assets.geometry.solid.bounds import link_bounds
from casa_assets.geometry.solid.manifold import union
from casa_assets.geometry.solid.tessellate import tessellate
from casa_assets.model.asset.asset import Asset, Base, Collider, Inertial, Link
from casa_assets.model.asset.shape import Hull

FIXED = "it is fixed in its place and has no footprint"
NO_HULLS = "none of its collision shapes is a hull"
BOTH = "none of its links is both seen and touched"
FLAT = "its collision shapes enclose no volume"
WATER = 1000.0  # kg/m^3. Ref: CRC Handbook of Chemistry and Physics, water at 4 degrees Celsius.


def size_is_bounded(asset: Asset, limit: float | None) -> Measurement:
    """AST001: longest side of the box around all that is seen, metres; parts of a room may be longer."""
    if asset.contract == "room":
        return not_applicable("it is a part of a room, which may be longer than a thing in it")
    if not any(k.visuals for k in asset.links):
        return not_applicable(UNSEEN)
    longest = float(_seen(asset).max())
    message = f"is {longest:.3g} m long, more than {required_limit(limit):g} m; look for a wrong unit of length"
    return Measurement(longest, (("", message),) if longest > required_limit(limit) else ())


def colliders_are_thick_enough(asset: Asset, limit: float | None) -> Measurement:
    """AST002: least thickness of the collision shapes of a link, metres."""
    found = {k.name: _thickness(np.concatenate(_clouds(k))) for k in _touchable(asset)}
    message = "has collision shapes of {:.2g} m thickness; thicken the sheet or mend the scale"
    problems = tuple((f"links/{k}/colliders", message.format(t)) for k, t in found.items() if t < required_limit(limit))
    return least(found.values(), problems, NO_COLLIDERS)


def density_is_not_too_high(asset: Asset, limit: float | None) -> Measurement:
    """AST003: highest density of a link over that of water, mass over the union of its shapes."""
    found = _densities(asset)
    if not found:
        return not_run(FLAT) if _touchable(asset) else not_applicable(NO_COLLIDERS)
    message = "weighs {:.3g} times water for the volume of its collision shapes; mend the mass, or fill the shapes"
    problems = tuple((f"links/{k}/inertial", message.format(d)) for k, d in found.items() if d > required_limit(limit))
    return Measurement(max(found.values()), problems)


def density_is_not_too_low(asset: Asset, limit: float | None) -> Measurement:
    """AST004: lowest density of a link over that of water, mass over the union of its shapes."""
    found = _densities(asset)
    if not found:
        return not_run(FLAT) if _touchable(asset) else not_applicable(NO_COLLIDERS)
    message = "weighs {:.3g} times water for the volume of its collision shapes; mend the mass unless it is hollow"
    problems = tuple((f"links/{k}/inertial", message.format(d)) for k, d in found.items() if d < required_limit(limit))
    return Measurement(min(found.values()), problems)


def collider_count_is_bounded(asset: Asset, limit: float | None) -> Measurement:
    """AST005: largest number of collision shapes of a link."""
    counts = {k.name: len(k.colliders) for k in asset.links}
    message = "has {} collision shapes; merge some"
    problems = tuple(
        (f"links/{k}/colliders", message.format(n)) for k, n in counts.items() if n > required_limit(limit)
    )
    return Measurement(float(max(counts.values())), problems)


def hull_vertex_count_is_bounded(asset: Asset, limit: float | None) -> Measurement:
    """AST006: largest number of vertices of a convex hull."""
    counts = {pointer: len(hull.mesh.vertices) for pointer, hull in _hulls(asset)}
    message = "has {} vertices; take a hull of fewer"
    problems = tuple((pointer, message.format(n)) for pointer, n in counts.items() if n > required_limit(limit))
    return largest(map(float, counts.values()), problems, NO_HULLS)


def hulls_are_convex(asset: Asset, limit: float | None) -> Measurement:
    """AST007: farthest that a vertex of a hull lies outside one of its faces, metres."""
    dents, problems = [], []
    for pointer, hull in _hulls(asset):
        dent = _dent(hull)
        dents.append(dent)
        if not is_closed(hull.mesh.faces.astype(np.int64)):
            problems.append((pointer, "is not closed; take the convex hull of its vertices"))
        elif dent > required_limit(limit):
            problems.append((pointer, f"is dented by {dent:.2g} m or inside out; take the convex hull of its vertices"))
    return largest(dents, tuple(problems), NO_HULLS)


def mass_lies_inside_colliders(asset: Asset, limit: float | None) -> Measurement:
    """AST008: farthest that the centre or spread of mass lies outside the collision shapes, metres."""
    found, problems = [], []
    for link in _touchable(asset):
        out, wide = _outside(link)
        found += [out, wide]
        pointer = f"links/{link.name}/inertial"
        if out > required_limit(limit):
            problems.append((pointer, f"centre of mass is {out:.2g} m outside the collision shapes; measure it again"))
        if wide > required_limit(limit):
            problems.append((pointer, f"inertia is that of a body {2 * wide:.2g} m longer; mend its unit or frame"))
    return largest(found, tuple(problems), NO_COLLIDERS)


def colliders_match_visual_bounds(asset: Asset, limit: float | None, ratio: float, built_m: float) -> Measurement:
    """AST009: widest gap between the boxes around what is seen and what collides of a link, metres.

    Args:
        limit: metres that any link is granted.
        ratio: part of its longest side that a large link is granted instead, where that is more.
        built_m: the most that this may come to where a family built it, which knows its own shape; metres.
    """
    found, problems = [], []
    for link in _touchable(asset):
        if not link.visuals:
            continue
        seen = _visual_bounds(link)
        gaps = np.abs(seen - _bounds(link))
        gap, side = float(gaps.max()), int(gaps.argmax())
        found.append(gap)
        share = ratio * float(np.ptp(seen, axis=0).max())
        if gap > max(required_limit(limit), min(share, built_m) if is_from_family(asset) else share):
            where = f"{'low' if side < 3 else 'high'} {'xyz'[side % 3]}"
            message = f"collision shapes end {gap:.3g} m away from what is seen at {where}; fit them again"
            problems.append((f"links/{link.name}/colliders", message))
    return largest(found, tuple(problems), BOTH)


def origin_is_at_base_center(asset: Asset, limit: float | None) -> Measurement:
    """AST010: distance of a free asset's footprint centre from its origin, metres."""
    if asset.base is not Base.FREE:
        return not_applicable(FIXED)
    if not any(k.visuals for k in asset.links):
        return not_applicable(UNSEEN)
    low, high = asset.bounds
    x, y = (low + high)[:2] / 2
    off = {"middle in x": float(x), "middle in y": float(y), "lowest point": float(low[2])}
    message = "{} is at {:.3g} m, not at 0; move the origin to the middle of the footprint"
    problems = tuple(("", message.format(what, at)) for what, at in off.items() if abs(at) > required_limit(limit))
    return Measurement(max(abs(at) for at in off.values()), problems)


def licence_is_stated(asset: Asset, limit: float | None) -> Measurement:
    """AST011: the source states a licence."""
    known = asset.provenance.licence not in ("", "unknown")
    message = "is unknown; ask the author before the asset is passed on"
    return no_fault() if known else Measurement(None, (("provenance/licence", message),))


def visible_links_have_colliders(asset: Asset, limit: float | None) -> Measurement:
    """AST012: number of visible links without a collision shape."""
    if not any(k.visuals for k in asset.links):
        return not_applicable(UNSEEN)
    ghosts = [k.name for k in asset.links if k.visuals and not k.colliders]
    problems = tuple((f"links/{k}", "is seen, but has no collision shape; give it one") for k in ghosts)
    return Measurement(float(len(ghosts)), problems)


def mass_fits_category(package: Package, limit: float | None) -> Measurement:
    """AST013: factor between the mass and the nearer end of its category's range, below 1 inside."""
    span, mass = package.category.mass_kg, package.asset.mass
    factor = max(span.low / mass, mass / span.high)
    message = f"is {mass:.3g} kg; a {package.category.id} weighs {span.low:g} to {span.high:g} kg"
    return Measurement(factor, (("mass", message),) if factor > required_limit(limit) else ())


def size_fits_category(package: Package, limit: float | None) -> Measurement:
    """AST014: factor between the longest side and the nearer end of its category's range, below 1 inside."""
    span, longest = package.category.longest_m, float(_seen(package.asset).max())
    if longest <= 0:
        return not_applicable(UNSEEN)
    factor = max(span.low / longest, longest / span.high)
    message = f"is {longest:.3g} m long; a {package.category.id} has {span.low:g} to {span.high:g} m"
    return Measurement(factor, (("bounds", message),) if factor > required_limit(limit) else ())


def joints_are_closed_at_zero(asset: Asset, limit: float | None) -> Measurement:
    """AST015: distance of zero from the range of a joint, or from its ends where states name it, rad or m."""
    stated = {s.joint for s in asset.states}
    found, problems = [], []
    for joint in asset.joints:
        low, high = joint.range
        off = min(abs(low), abs(high)) if joint.name in stated else max(low, -high, 0.0)
        found.append(off)
        if off > 0:
            wanted = "start or end at" if joint.name in stated else "hold"
            message = f"goes from {low:g} to {high:g}; it should {wanted} zero, where it is closed"
            problems.append((f"joints/{joint.name}/range", message))
    return largest(found, tuple(problems), NO_JOINTS)


def _touchable(asset: Asset) -> list[Link]:
    """Links with collision shapes; that the others have none is said by `visible_links_have_colliders` alone."""
    return [k for k in asset.links if k.colliders]


def _hulls(asset: Asset) -> Iterator[tuple[str, Hull]]:
    """(pointer, hull) of every convex hull."""
    for link in asset.links:
        for collider in link.colliders:
            if isinstance(collider.shape, Hull):
                yield f"links/{link.name}/colliders/{collider.name}", collider.shape


def _seen(asset: Asset) -> Floats:
    """(3,) size of the box around all that is seen, metres; zeros where nothing is."""
    return np.diff(asset.bounds, axis=0)[0] if any(k.visuals for k in asset.links) else np.zeros(3)


def _visual_bounds(link: Link) -> Floats:
    cloud = np.concatenate([v.mesh.vertices for v in link.visuals])
    return np.array([cloud.min(axis=0), cloud.max(axis=0)])


def _bounds(link: Link) -> Floats:
    bounds = link_bounds(link)
    assert bounds is not None, "links without colliders were left out"
    return bounds


def _clouds(link: Link) -> list[Floats]:
    return [tessellate(c.shape, c.pose)[0] for c in link.colliders]


def _thickness(points: Floats) -> float:
    """Extent along the direction of least spread, metres."""
    _, vectors = np.linalg.eigh(np.cov(points.T))
    return float(np.ptp(points @ vectors[:, 0]))


def _densities(asset: Asset) -> dict[str, float]:
    """Density over that of water by link, for each whose collision shapes enclose a volume."""
    volumes = {k.name: _volume(k.colliders) for k in _touchable(asset)}
    return {name: asset.link(name).inertial.mass / v / WATER for name, v in volumes.items() if v > 0}


@lru_cache(maxsize=64)
def _volume(colliders: tuple[Collider, ...]) -> float:
    """Volume of the union, m^3; zero where no shape is a solid. Two checks of one asset ask for it."""
    joined = union([tessellate(c.shape, c.pose) for c in colliders])
    return 0.0 if joined is None else signed_volume(*joined)


def _dent(hull: Hull) -> float:
    """How far the farthest vertex lies outside a face, metres."""
    vertices, faces = hull.mesh.vertices, hull.mesh.faces.astype(np.int64)
    normals, areas = face_normals(vertices, faces)
    offsets = np.einsum("ij,ij->i", normals, vertices[faces[:, 0]])
    heights = (vertices @ normals.T - offsets)[:, areas > 0]
    return max(0.0, float(heights.max(initial=0.0)))


def _outside(link: Link) -> tuple[float, float]:
    """How far the centre of mass is outside the box of the colliders, and how much too wide mass is spread, metres.

    Ref: Popoviciu 1935, the deviation of what lies in an interval is at most half its length.
    """
    bounds = _bounds(link)
    center = np.array(link.inertial.center_of_mass)
    out = float(np.maximum(bounds[0] - center, center - bounds[1]).max())
    wide = float((_deviation(link.inertial) - np.ptp(bounds, axis=0) / 2).max())
    return max(0.0, out), max(0.0, wide)


def _deviation(inertial: Inertial) -> Floats:
    """(3,) standard deviation of mass along the axes of the link, metres."""
    diagonal = np.diag(inertial.tensor)
    deviation: Floats = np.sqrt(np.maximum(diagonal.sum() / 2 - diagonal, 0.0) / inertial.mass)
    return deviation
