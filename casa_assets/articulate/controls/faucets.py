"""Find the levers of a faucet and its spout, from how its pieces touch each other.

A faucet is slender: a trunk of touching pieces leads from its mount, on the worktop or the wall, to the free end of its
spout. Groups of pieces that branch off the trunk are handles; each turns about the piece that attaches it, which is a
solid of revolution.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.controls.controls import MIN_STICK_RATIO
from casa_assets.articulate.controls.pipe_pieces import (
    STRAIGHT_COS,
    TOUCH_DISTANCE,
    Axis,
    Piece,
    PieceGraph,
    piece_graph,
)
from casa_assets.articulate.plan import JointPlan, PartKind, hinge, to_vec3
from casa_assets.articulate.segment.fragments import MeasuredFragments
from casa_assets.articulate.segment.orthographic import FRONT, LEFT, TOP
from casa_assets.core.numeric import Floats

# A faucet has this many fragments. Its picture fills at most this share of its rectangle, mean of front, left and top.
MIN_FRAGMENTS, MAX_FRAGMENTS, MAX_FILLED = 3, 120, 0.66
# Pieces within this of the lowest or rearmost point are the mount; all lengths in diagonals.
MOUNT_DEPTH = 0.02
# Share of a piece that lies so low where it is a foot of the trunk, not a handle that hangs down.
MIN_MOUNT_SHARE = 0.3
# The tip of the spout is so far before the mount, this near to the middle plane, and so high over a mount on a worktop.
MIN_OVERHANG, MAX_TIP_OFFSET, MIN_TIP_HEIGHT = 0.1, 0.15, 0.05
# The tip consists of the samples within this of the foremost one; its largest size; how far handles keep from it.
TIP_DEPTH, MAX_TIP_SIZE, TIP_REACH = 0.02, 0.2, 0.15
# Widest gap between a handle and what bears it.
MAX_GAP = 0.02
# Share of the surface that the trunk and its handles make up together.
MIN_EXPLAINED = 0.8
# Size of a handle, at most by that of the trunk, and of a lever by the width of what it turns about; height of a knob
# by its width; and the lowest upward component of its axis.
MIN_HANDLE_SIZE, MAX_HANDLE_SIZE, MAX_HANDLE_BY_TRUNK, MIN_SIZE_BY_WIDTH = 0.05, 0.65, 0.8, 1.3
MIN_KNOB_HEIGHT, MIN_AXIS_HEIGHT = 0.2, -0.5
MAX_HANDLES, MAX_TIPS = 4, 3
# Radius of round handles; wheels are larger.
MAX_ROUND_RADIUS = 0.075
# Offset of a handle from the mirror image of another one, upwards and backwards.
MIRROR_TOLERANCE = 0.05
# Share of a piece on the other side of the middle plane that makes it one of both sides.
MAX_OVERLAP = 0.2
# Share of the surface of a box that faces along the axes.
MIN_BOX_SHARE = 0.7
# Two axes are one where their directions agree within 8 degrees and they lie apart by this share of a radius.
SAME_DIRECTION_COS, SAME_LINE_BY_RADIUS = 0.99, 0.4
# Axes within 6 degrees of each other are the same.
SAME_AXIS_COS = 0.9945
# Radius, diagonals, up to which thinner things count as so thick; how far off the axis of a bar something is stuck in
# it, by its radius; and share of the length of a body from its middle from which on it is its end.
MIN_LINE_RADIUS, MAX_BAR_OFFSET, MIN_END_SHARE = 0.02, 1.2, 0.3
# A piece goes with what sits on its axis, in contacts narrower than this share of its own radius or off its middle by
# this share: a rod on a cap. A contact over its whole end is that of a stem, which stays.
MAX_SEAT_BY_RADIUS, MIN_SEAT_OFFSET = 0.7, 0.3
# Unevenness of a piece around an axis that it lies on: offset of its centre by its reach, and ratio of its spreads.
MAX_OFF_CENTRE, MAX_SPREAD_RATIO = 0.15, 2.0
# A spout that swivels rises over this share of the height of the faucet, and stands on a round seat: ratio of the
# spreads of the contact, cosine of its normal from upright, radius in diagonals. One on the end of a round upright post
# may rise less; it begins in the upper part of the post, by this share.
MIN_SPOUT_RISE, MAX_SEAT_RATIO, MIN_SEAT_UPRIGHT, MAX_SEAT_RADIUS = 0.5, 2.2, 0.97, 0.1
MIN_RISE_ON_POST, MIN_POST_SHARE = 0.1, 0.7
# Range of a handle from its closed pose, a quarter turn; of a spout to each side.
HANDLE_RANGE_RAD, SPOUT_RANGE_RAD = np.pi / 2, np.pi / 2


@dataclass(frozen=True)
class FaucetHandle:
    """A handle of a faucet.

    Attributes:
        pieces: those that turn about `axis`. is_lever: they extend from the axis to one side.
        place: index, on the path of the trunk, of the piece that carries them; -1 if they are attached elsewhere.
    """

    pieces: list[int]
    axis: Axis
    is_lever: bool
    place: int


@dataclass(frozen=True)
class Trunk:
    """The pieces of a faucet that carry its handles.

    Attributes:
        path: pieces from the mount to the tip of the spout, in order. bars: other pieces that do not move: the rest of
            the mount, and pipes across the path. tip: (3,) middle of the foremost points of the spout.
    """

    path: list[int]
    bars: list[int]
    tip: Floats

    @property
    def pieces(self) -> list[int]:
        """Return all pieces."""
        return [*self.bars, *self.path]


def find_faucet_parts(measured: MeasuredFragments, taken: set[int]) -> list[tuple[PartKind, list[int], JointPlan]]:
    """Return the handles of a faucet and its spout where that swivels: kind, fragments and joint of each.

    Args:
        measured: of an object whose front is that of its spout. taken: fragments of other parts.
    """
    if (
        taken
        or not MIN_FRAGMENTS <= measured.count <= MAX_FRAGMENTS
        or float(np.mean([(measured.depth_images[s].face >= 0).mean() for s in (FRONT, LEFT, TOP)])) > MAX_FILLED
    ):
        return []
    graph = piece_graph(measured)
    # A long lever may reach farther to the front than the spout.
    foremost = sorted(range(len(graph.pieces)), key=lambda i: float(graph.pieces[i].lower[1]))[:MAX_TIPS]
    for end in foremost:
        trunk = _trunk(graph, end)
        handles = _handles(graph, trunk) if trunk is not None else []
        if trunk is not None and handles:
            reason = "it branches off a slender trunk with a spout, and turns about its stem"
            parts = [
                (
                    PartKind.LEVER,
                    graph.fragments_of(h.pieces),
                    _turn(h.axis, (0.0, HANDLE_RANGE_RAD), 0.6 if h.is_lever else 0.5, reason),
                )
                for h in handles
            ]
            spout = _swivel(graph, trunk, handles)
            if spout is not None:
                pieces, axis = spout
                reason = "it rises from a round upright seat, and reaches to the front"
                joint = _turn(axis, (-SPOUT_RANGE_RAD, SPOUT_RANGE_RAD), 0.5, reason)
                parts.append((PartKind.SPOUT, graph.fragments_of(pieces), joint))
            return parts
    return []


def _handles(graph: PieceGraph, trunk: Trunk) -> list[FaucetHandle]:
    """Return the handles that branch off a trunk; empty if other objects branch off too, or too many handles."""
    branches = [
        b
        for group in graph.groups([i for i in range(len(graph.pieces)) if i not in set(trunk.pieces)])
        for b in _sides(graph, group, float(trunk.tip[0]))
    ]
    found = {i: h for i, b in enumerate(branches) if (h := _handle(graph, trunk, b)) is not None}
    # The trunk and its handles are nearly all of the object: legs and leaves branch off, too.
    known = {*trunk.pieces, *(p for i in found for p in branches[i])}
    if sum(graph.pieces[i].area for i in known) < MIN_EXPLAINED * sum(p.area for p in graph.pieces):
        return []
    # They turn about axes of the frame, or about the mirror image of each other's axis.
    straight = [
        h
        for h in found.values()
        if float(np.abs(h.axis.direction).max()) > SAME_AXIS_COS or _is_mirrored(h, list(found.values()))
    ]
    # A round thing alone is the knob of a lid; two alike may be the handles of a faucet.
    handles = [h for h in straight if h.is_lever or _is_mirrored(h, straight)]
    has_levers = any(h.is_lever for h in straight)
    handles = handles if has_levers or all(h.axis.radius <= MAX_ROUND_RADIUS for h in handles) else []
    return handles if len(handles) <= MAX_HANDLES else []


def _is_mirrored(handle: FaucetHandle, others: Sequence[FaucetHandle]) -> bool:
    """Return whether the axis of one handle is the mirror image of that of another, left for right."""
    mirrored = np.array([-1.0, 1.0, 1.0]) * handle.axis.direction
    return any(
        float(mirrored @ o.axis.direction) > SAME_AXIS_COS
        and float(np.abs(handle.axis.origin - o.axis.origin)[1:].max()) <= MIRROR_TOLERANCE
        for o in others
        if o is not handle
    )


def _trunk(graph: PieceGraph, end: int) -> Trunk | None:
    """Return the trunk of an object if a piece ends in the tip of a spout, otherwise None."""
    pieces = graph.pieces
    points = np.concatenate([p.points for p in pieces])
    owner = np.repeat(np.arange(len(pieces)), [len(p.points) for p in pieces])
    lower, upper = points.min(axis=0), points.max(axis=0)
    # The samples of a thin piece may all lie off its corner, so it is the foremost of them that counts.
    reach = float(pieces[end].points[:, 1].min())
    tip = pieces[end].points[pieces[end].points[:, 1] <= reach + TIP_DEPTH]
    middle = tip.mean(axis=0)
    height = float(tip[:, 2].min() - lower[2])
    if float(np.ptp(tip, axis=0).max()) > MAX_TIP_SIZE or abs(middle[0] - (lower + upper)[0] / 2) > MAX_TIP_OFFSET:
        return None
    for on_floor in (True, False):
        depth = points[:, 2] - lower[2] if on_floor else upper[1] - points[:, 1]
        mount = depth <= MOUNT_DEPTH
        overhang = float(points[mount, 1].min()) - reach
        if overhang < MIN_OVERHANG or (on_floor and height < MIN_TIP_HEIGHT):
            continue
        share = {m: float(mount[owner == m].mean()) for m in np.unique(owner[mount]).tolist()}
        ways = [w for m in share if (on_floor or share[m] >= MIN_MOUNT_SHARE) and (w := graph.path(m, end))]
        if ways:
            path = min(ways, key=lambda w: (len(w), -pieces[w[0]].area))
            flat = [w for w in ways if share[w[0]] >= MIN_MOUNT_SHARE]
            joining = {i for w in flat for i in w[: next(k for k, p in enumerate(w) if p in path)]}
            trunk = Trunk(path, sorted(joining), middle)
            return Trunk(path, _with_crossbars(graph, trunk), middle)
    return None


def _sides(graph: PieceGraph, branch: list[int], middle: float) -> list[list[int]]:
    """Split a branch that meets itself inside the trunk into what is left and what is right of the middle plane."""
    if any(_is_across(graph.pieces[i], middle) for i in branch):
        return [branch]
    left = [i for i in branch if graph.pieces[i].middle[0] < middle]
    return [*graph.groups(left), *graph.groups([i for i in branch if i not in left])]


def _with_crossbars(graph: PieceGraph, trunk: Trunk) -> list[int]:
    """Return the bars of a trunk, with the pipes across it that bear branches at both ends: two valves on one pipe."""
    middle, bars = float(trunk.tip[0]), trunk.bars
    for branch in graph.groups([i for i in range(len(graph.pieces)) if i not in set(trunk.pieces)]):
        across = [i for i in branch if _is_across(graph.pieces[i], middle)]
        rest = graph.groups([i for i in branch if i not in across])
        sides = [float(np.sign(np.mean([graph.pieces[i].middle[0] for i in g]) - middle)) for g in rest]
        wide = [i for i in across if _spans(graph.pieces[i], middle)]
        if wide and 1.0 in sides and -1.0 in sides:
            bars = sorted({*wide, *bars})
        left = [i for i in branch if i not in across and graph.pieces[i].middle[0] < middle]
        right = [i for i in branch if i not in across and graph.pieces[i].middle[0] >= middle]
        pairs = [(i, j) for i in left for j in right if (min(i, j), max(i, j)) in graph.touch]
        bars = sorted({*bars, *(i for pair in pairs for i in pair)})
    return bars


def _is_across(piece: Piece, middle: float) -> bool:
    """Return whether a good part of a piece lies on either side of an upright plane."""
    left, right = middle - float(piece.lower[0]), float(piece.upper[0]) - middle
    return min(left, right) > MAX_OVERLAP * (left + right)


def _spans(piece: Piece, middle: float) -> bool:
    """Return whether a piece reaches as far left of a plane as right, nearly, and farther than it is thick."""
    left, right = middle - float(piece.lower[0]), float(piece.upper[0]) - middle
    thick = float((piece.upper - piece.lower)[1:].min())
    return min(left, right) > 0.6 * max(left, right) and left + right > 1.5 * thick


def _handle(graph: PieceGraph, trunk: Trunk, branch: list[int]) -> FaucetHandle | None:
    """Return the handle that a branch off the trunk is or carries; None if it has no handle."""
    pieces = graph.pieces
    points = np.concatenate([pieces[i].points for i in branch])
    seat = graph.between(branch, trunk.pieces)
    touched = {t: len(c) for t in trunk.pieces if len(c := graph.between(branch, [t]))}
    floor = min(float(p.lower[2]) for p in pieces) + MOUNT_DEPTH
    if not len(seat) and float(points[:, 2].min()) <= floor:
        seat = points[points[:, 2] <= floor]
    elif not len(seat):
        away = {t: pieces[t].tree.query(points)[0] for t in trunk.pieces}
        nearest = min(away, key=lambda t: float(away[t].min()))
        gap = float(away[nearest].min())
        if gap > MAX_GAP:
            return None
        seat, touched = points[away[nearest] <= gap + TOUCH_DISTANCE], {nearest: 1}
    if float(np.linalg.norm(seat.mean(axis=0) - trunk.tip)) < TIP_REACH:
        return None
    axis = _spindle(graph, trunk, branch, sorted(touched), seat, points)
    if axis is None or float(axis.direction[2]) < MIN_AXIS_HEIGHT:
        return None
    moving = _turning(graph, branch, axis)
    if not moving:
        return None
    own = np.concatenate([pieces[i].points for i in moving])
    size, high = float(np.linalg.norm(np.ptp(own, axis=0))), float(np.ptp(axis.along(own)))
    whole = np.concatenate([pieces[i].points for i in trunk.path])
    largest = min(MAX_HANDLE_SIZE, MAX_HANDLE_BY_TRUNK * float(np.linalg.norm(np.ptp(whole, axis=0))))
    if not MIN_HANDLE_SIZE <= size <= largest:
        return None
    off = [i for i in moving if not _is_coaxial(pieces[i], axis)]
    is_lever = bool(off) and size >= MIN_SIZE_BY_WIDTH * 2 * axis.radius
    stands = float(axis.along(own).mean() - axis.along(seat).mean()) >= 0.25 * high
    on_floor = float(own[:, 2].min()) < floor
    if not is_lever and (on_floor or high < MIN_KNOB_HEIGHT * 2 * float(axis.distance(own).max()) or not stands):
        return None
    host = max(touched, key=lambda t: touched[t]) if touched else -1
    return FaucetHandle(moving, axis, is_lever, trunk.path.index(host) if host in trunk.path else -1)


def _spindle(
    graph: PieceGraph, trunk: Trunk, branch: Sequence[int], touched: Sequence[int], seat: Floats, points: Floats
) -> Axis | None:
    """Return the axis about which a branch turns, away from what bears it.

    It is that of the turned piece at the seat: of the branch, else of what bears it; else it is at right angles to the
    seat in its middle.
    """
    middle = seat.mean(axis=0)
    outward = points.mean(axis=0) - middle
    found: list[tuple[float, Axis]] = []
    for i in (*branch, *touched):
        piece = graph.pieces[i]
        axis = piece.turned
        if axis is None:
            continue
        from_seat = float(piece.tree.query(middle)[0])
        off = float(axis.distance(middle[None])[0])
        length = float(np.ptp(axis.along(piece.points)))
        if i in branch:
            # A stick turns about what it is stuck in, not about itself.
            fits = length < MIN_STICK_RATIO * 2 * axis.radius
            fits &= off <= SAME_LINE_BY_RADIUS * max(axis.radius, MIN_LINE_RADIUS)
        elif i in trunk.bars:
            fits = off <= MAX_BAR_OFFSET * axis.radius
        else:
            at_end = abs(float(axis.along(middle[None])[0])) > MIN_END_SHARE * length
            fits = at_end and off <= SAME_LINE_BY_RADIUS * max(axis.radius, MIN_LINE_RADIUS)
        if fits:
            found.append((from_seat + (0.0 if i in branch else 0.02), axis))
    if found:
        axis = min(found, key=lambda f: f[0])[1]
    else:
        values, vectors = np.linalg.eigh(np.cov((seat - middle).T)) if len(seat) > 3 else (np.ones(3), np.eye(3))
        along = [(np.abs(graph.pieces[i].normals).max(axis=1) > STRAIGHT_COS).mean() for i in touched]
        square = all(float(share) >= MIN_BOX_SHARE for share in along)
        if not square or values[1] < 2.0 * values[0] or values[2] > 6.0 * values[1]:
            return None
        normal = vectors[:, 0]
        largest = int(np.argmax(np.abs(normal)))
        if abs(float(normal[largest])) > STRAIGHT_COS:
            normal = np.eye(3)[largest]
        axis = Axis(middle, normal, float(np.sqrt(values[2]) * 1.5))
    direction = axis.direction if float(axis.direction @ outward) >= 0 else -axis.direction
    return Axis(axis.origin, direction, axis.radius)


def _is_coaxial(piece: Piece, axis: Axis) -> bool:
    """Return whether a piece lies evenly around an axis: turned about it, or a square or cross on it."""
    own = piece.turned
    if own is not None:
        same = abs(float(own.direction @ axis.direction)) > SAME_DIRECTION_COS
        return same and float(axis.distance(own.origin[None])[0]) <= SAME_LINE_BY_RADIUS * max(own.radius, axis.radius)
    reach = float(axis.distance(piece.points).max())
    away = piece.points - axis.origin
    across = away - np.outer(away @ axis.direction, axis.direction)
    spread = np.sort(np.linalg.eigvalsh(across.T @ across))[1:]
    centred = float(axis.distance(piece.middle[None])[0]) <= MAX_OFF_CENTRE * reach
    return centred and float(spread[1]) <= MAX_SPREAD_RATIO * max(float(spread[0]), 1e-12)


def _turning(graph: PieceGraph, branch: list[int], axis: Axis) -> list[int]:
    """Return the pieces of a branch that a hand turns: those off the axis, their hubs, and the pieces beyond the hubs.

    Without pieces off the axis, those beyond the neck.
    """
    coaxial = [i for i in branch if _is_coaxial(graph.pieces[i], axis)]
    off = [i for i in branch if i not in coaxial]
    if not off:
        return _beyond_neck(graph, coaxial, axis)
    hubs = [i for i in coaxial if _bears(graph, i, off, axis)]
    if hubs:
        start = min(float(axis.along(graph.pieces[i].middle[None])[0]) for i in hubs)
    else:
        start = float(axis.along(np.concatenate([graph.pieces[i].points for i in off])).min())
    beyond = [i for i in coaxial if float(axis.along(graph.pieces[i].middle[None])[0]) > start - 1e-6]
    return sorted({*off, *hubs, *beyond})


def _bears(graph: PieceGraph, hub: int, off: Sequence[int], axis: Axis) -> bool:
    """Return whether a piece on the axis is the hub of the pieces off the axis, not the stem they are pushed on."""
    contact = graph.between([hub], off)
    if not len(contact):
        return False
    own = graph.pieces[hub]
    radius = float(axis.distance(own.points).max())
    offset = float(axis.distance(contact.mean(axis=0)[None])[0])
    return offset >= MIN_SEAT_OFFSET * radius or float(axis.distance(contact).max()) <= MAX_SEAT_BY_RADIUS * radius


def _beyond_neck(graph: PieceGraph, coaxial: Sequence[int], axis: Axis) -> list[int]:
    """Return the coaxial pieces from the widest one on that lies beyond the thinnest, the neck of a knob."""
    order = sorted(coaxial, key=lambda i: float(axis.along(graph.pieces[i].middle[None])[0]))
    wide = [float(axis.distance(graph.pieces[i].points).max()) for i in order]
    if len(order) < 2:
        return order
    neck = int(np.argmin(wide[:-1]))
    return sorted(order[neck + 1 :]) if wide[neck] < max(wide[neck + 1 :]) else sorted(order[-1:])


def _swivel(graph: PieceGraph, trunk: Trunk, handles: Sequence[FaucetHandle]) -> tuple[list[int], Axis] | None:
    """Return the pieces of a spout that swivels on a round upright seat, and its axis; None if it is fixed."""
    pieces = graph.pieces
    low = min(float(p.lower[2]) for p in pieces)
    height = max(float(p.upper[2]) for p in pieces) - low
    held = {i for h in handles for i in h.pieces}
    first = max((h.place for h in handles), default=-1)
    path = trunk.path
    for k in range(max(first, 0), len(path) - 1):
        post = pieces[path[k]]
        seat = graph.between([path[k]], [path[k + 1]])
        axis = _round_seat(seat, pieces[path[k + 1]])
        if axis is None:
            continue
        stays = [*trunk.bars, *path[: k + 1]]
        groups = graph.groups([i for i in range(len(pieces)) if i not in stays and i not in held])
        moving = next((g for g in groups if path[-1] in g), [])
        points = np.concatenate([pieces[i].points for i in moving])
        is_post = post.turned is not None and abs(float(post.turned.direction[2])) >= MIN_SEAT_UPRIGHT
        bottom, top = float(post.lower[2]), float(post.upper[2])
        is_on_post = is_post and float(seat[:, 2].mean()) >= bottom + MIN_POST_SHARE * (top - bottom)
        rise = MIN_RISE_ON_POST if is_on_post else MIN_SPOUT_RISE
        if float(np.ptp(points[:, 2])) >= rise * height:
            return moving, axis
    return None


def _round_seat(seat: Floats, piece: Piece) -> Axis | None:
    """Return the upright axis of a round contact under a piece, or None."""
    if len(seat) < 4:
        return None
    middle = (seat.min(axis=0) + seat.max(axis=0)) / 2
    radius = float(np.linalg.norm((seat - middle)[:, :2], axis=1).max())
    own = piece.turned
    if own is not None and abs(float(own.direction[2])) > MIN_SEAT_UPRIGHT and own.radius <= MAX_SEAT_RADIUS:
        return Axis(own.origin, np.array([0.0, 0.0, 1.0]), own.radius)
    wide = np.ptp(seat, axis=0)
    level = float(wide[:2].max()) <= MAX_SEAT_RATIO**0.5 * float(wide[:2].min())
    if not level or radius > MAX_SEAT_RADIUS or float(middle[2]) > float(piece.middle[2]):
        return None
    return Axis(middle, np.array([0.0, 0.0, 1.0]), radius)


def _turn(axis: Axis, angles: tuple[float, float], confidence: float, reason: str) -> JointPlan:
    return hinge(to_vec3(axis.direction), to_vec3(axis.origin), angles, confidence, reason)
