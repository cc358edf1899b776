"""Find signs of moving parts that were not found in an object: names of the file, handles, fronts, controls, levers.

A mesh with such a sign is not declared free of moving parts; a person looks at it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from casa_assets.articulate.controls.controls import find_controls
from casa_assets.articulate.controls.pipe_pieces import Axis, Piece, PieceGraph, piece_graph
from casa_assets.articulate.fronts.front_hypotheses import find_fronts
from casa_assets.articulate.fronts.relief import is_handle
from casa_assets.articulate.kinds import KIND_TRAITS
from casa_assets.articulate.plan import Models
from casa_assets.articulate.segment.fragments import MeasuredFragments, WeldedMesh, measure_fragments, render_sides
from casa_assets.articulate.segment.orthographic import BACK, FRONT, LEFT, RIGHT, TOP, measure_relief
from casa_assets.articulate.segment.shell_segments import MIN_BOXINESS, boxiness
from casa_assets.core.numeric import Floats
from casa_assets.model.registry.category import split_words

# Kinds of KIND_TRAITS that are also made without any moving part.
OFTEN_STILL = frozenset({"table"})
# Words that name a moving part. `handle` and `lid` are left out: mugs and jars have them.
PART_WORDS = frozenset(
    {"door", "drawer", "knob", "hinge", "lever", "switch", "flap", "button", "dial", "faucet", "tap", "valve"}
    | {"slider", "sash", "crank"}
)
# Least probability of a front; uneven sides of a mesh of one piece, such as a scan, show lines that bound nothing.
MIN_FRONT_PROBABILITY, MIN_FRONT_PROBABILITY_OF_ONE_PIECE = 0.5, 0.8
# What is thinner is a sheet or a picture, diagonals.
MIN_THICKNESS = 0.01
# Least protrusion of a control, diagonals: less is a label or a printed mark.
MIN_CONTROL_PROTRUSION = 0.004
# A lever is so much longer than wide, stands out at right angles within 20 degrees, and is so long by the radius of
# what it turns about; that has a round post below it which is longer than wide. Pans have no post.
MIN_STICK_RATIO, MAX_AXIS_COS, MIN_LEVER_BY_RADIUS, MIN_POST_RATIO = 2.0, 0.35, 1.5, 1.2
# Lines of two round pieces are one where they are this parallel and this near, by the smaller radius.
SAME_AXIS_COS, SAME_LINE_BY_RADIUS = 0.99, 0.3
# A panel in a frame is no thicker than this share of the frame's width, and covers this share of its outline; two that
# overlap by less than this share of the smaller one are two sashes, not a pane in its rim.
MAX_PANEL_DEPTH, MIN_SASH_SHARE, MAX_SASH_SHARE, MAX_SASH_OVERLAP = 0.3, 0.15, 0.65, 0.3
# More pieces than this are not compared with each other.
MAX_PIECES = 200
SIDE_NAMES = {FRONT: "front", BACK: "back", LEFT: "left side", RIGHT: "right side", TOP: "top"}


def signs_of_parts(mesh: WeldedMesh, stated: str, names: Sequence[str], models: Models) -> tuple[str, ...]:
    """Return what speaks for moving parts of a mesh in which none was found, in words; empty for nothing.

    Args:
        mesh: in the frame. stated: id of the kind that the user or a name states, or empty.
        names: of the nodes and parts of the file.
    """
    if float(np.ptp(mesh.points, axis=0).min()) < MIN_THICKNESS:
        return ()
    found = []
    if stated in KIND_TRAITS and stated not in OFTEN_STILL:
        found.append(f"it is called a {stated.replace('_', ' ')}, and such things have moving parts")
    words = {word.removesuffix("s") for name in names for word in split_words(name)} & PART_WORDS
    if words:
        found.append(f"names in its file say {', '.join(sorted(words))}")
    views = render_sides(mesh)
    measured = measure_fragments(mesh, mesh.fragment_labels, images=views)
    found += _signs_of_pieces(measured)
    # Fruit, bottles and mugs have creases and handles too; what has doors, drawers or keys has flat walls.
    if boxiness(mesh, views) >= MIN_BOXINESS:
        for side in SIDE_NAMES:
            found += _signs_of_side(mesh, measured, side, models)
    return tuple(found)


def _signs_of_side(mesh: WeldedMesh, measured: MeasuredFragments, side: int, models: Models) -> list[str]:
    relief = measure_relief(mesh, side)
    where = f"on its {SIDE_NAMES[side]}"
    if any(is_handle(relief, blob) for blob in relief.blobs):
        return [f"something {where} stands out like a handle"]
    if measured.count > 1 and any(c.protrusion >= MIN_CONTROL_PROTRUSION for c in find_controls(measured, side, [])):
        return [f"something {where} stands out like a knob, a key or a lever"]
    least = MIN_FRONT_PROBABILITY if measured.count > 1 else MIN_FRONT_PROBABILITY_OF_ONE_PIECE
    fronts = [] if side == TOP else find_fronts(mesh, relief, side, (models.fronts_alone, models.fronts))
    if any(chance > least for _, chance in fronts):
        return [f"lines {where} run round what looks like a door or a drawer"]
    return []


def _signs_of_pieces(measured: MeasuredFragments) -> list[str]:
    """Return the signs that pieces give by how they sit on and in each other."""
    if not 2 <= measured.count <= MAX_PIECES:
        return []
    graph = piece_graph(measured)
    found = ["a lever stands out from the end of a round post"] if _has_lever(graph) else []
    if _has_sashes(graph.pieces):
        found.append("panels lie side by side in a frame, as the sashes of a window do")
    return found


def _has_lever(graph: PieceGraph) -> bool:
    """Return whether a long piece protrudes from a round one that sits on the end of a round post."""
    for i, hub in enumerate(graph.pieces):
        if hub.turned is None:
            continue
        beside = graph.neighbours(i)
        is_on_post = any(_is_post(graph.pieces[j], hub.turned) for j in beside)
        if is_on_post and any(_stands_out(graph.pieces[j], hub.turned) for j in beside):
            return True
    return False


def _is_post(piece: Piece, axis: Axis) -> bool:
    """Return whether a piece is round about an axis and longer along it than wide."""
    own = piece.turned
    if own is None or abs(float(own.direction @ axis.direction)) < SAME_AXIS_COS:
        return False
    if float(axis.distance(own.origin[None])[0]) > SAME_LINE_BY_RADIUS * min(own.radius, axis.radius):
        return False
    return float(np.ptp(own.along(piece.points))) > MIN_POST_RATIO * own.radius


def _stands_out(piece: Piece, axis: Axis) -> bool:
    """Return whether a piece is long and points away from an axis at right angles."""
    away = piece.points - piece.middle
    spread, directions = np.linalg.eigh(away.T @ away)
    ratio = float(np.sqrt(spread[2] / max(float(spread[1]), 1e-12)))
    length = float(np.ptp(away @ directions[:, 2]))
    level = abs(float(directions[:, 2] @ axis.direction)) < MAX_AXIS_COS
    return ratio > MIN_STICK_RATIO and level and length > MIN_LEVER_BY_RADIUS * axis.radius


def _has_sashes(pieces: Sequence[Piece]) -> bool:
    """Return whether two flat pieces lie in the outline of a third that is flat the same way."""
    boxes = [np.array([p.lower, p.upper]) for p in pieces]
    for outer in boxes:
        depth = int(np.argmin(np.ptp(outer, axis=0)))
        across = [k for k in range(3) if k != depth]
        width = float(np.ptp(outer, axis=0)[across].min())
        inside = [b for b in boxes if b is not outer and _is_sash(b, outer, depth, across, width)]
        if any(_share_of_overlap(a, b, across) < MAX_SASH_OVERLAP for a, b in combinations(inside, 2)):
            return True
    return False


def _is_sash(box: Floats, outer: Floats, depth: int, across: Sequence[int], width: float) -> bool:
    """Return whether a box is flat, lies in the outline of another one and covers a fair share of it."""
    thickness = max(float(np.ptp(b[:, depth])) for b in (box, outer))
    if thickness > MAX_PANEL_DEPTH * width or int(np.argmin(np.ptp(box, axis=0))) != depth:
        return False
    is_inside = (box[0] > outer[0])[across].all() and (box[1] < outer[1])[across].all()
    meets = box[0, depth] <= outer[1, depth] and outer[0, depth] <= box[1, depth]
    share = float(np.prod(np.ptp(box, axis=0)[across]) / max(float(np.prod(np.ptp(outer, axis=0)[across])), 1e-12))
    return bool(is_inside and meets and MIN_SASH_SHARE <= share <= MAX_SASH_SHARE)


def _share_of_overlap(a: Floats, b: Floats, across: Sequence[int]) -> float:
    """Return the part of the smaller of two outlines that lies in the other."""
    shared = (np.minimum(a[1], b[1]) - np.maximum(a[0], b[0]))[across].clip(min=0.0)
    least = min(float(np.prod(np.ptp(box, axis=0)[across])) for box in (a, b))
    return float(np.prod(shared)) / max(least, 1e-12)
