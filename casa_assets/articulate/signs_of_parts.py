"""Find signs that a thing has moving parts where none was found: names of the file, and handles, fronts and controls.

A mesh with such a sign is not said to have nothing that moves; a person looks at it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from casa_assets.articulate.controls.controls import find_controls
from casa_assets.articulate.frame.kind import KIND_TRAITS
from casa_assets.articulate.fronts.front_hypotheses import find_fronts
from casa_assets.articulate.fronts.rectangles import is_handle
from casa_assets.articulate.models import Models
from casa_assets.articulate.segment.creases import SideRelief, measure_relief
from casa_assets.articulate.segment.fragment_measures import (
    BACK,
    FRONT,
    LEFT,
    RIGHT,
    TOP,
    MeasuredFragments,
    measure_fragments,
    render_sides,
)
from casa_assets.articulate.segment.shell_segments import MIN_BOXINESS, boxiness
from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.model.registry.vocabulary import split_words

# Kinds of KIND_TRAITS that are also made without any moving part.
OFTEN_STILL = frozenset({"table"})
# Words that name a moving part. `handle` and `lid` are left out: mugs and jars have them.
PART_WORDS = frozenset(
    {"door", "drawer", "knob", "hinge", "lever", "switch", "flap", "button", "dial", "faucet", "tap", "valve"}
)
# A front is seen where it is one with this probability; on a mesh of one piece, such as a scan, uneven sides show lines
# that bound nothing.
MIN_FRONT_PROBABILITY, MIN_FRONT_PROBABILITY_OF_ONE_PIECE = 0.5, 0.8
# What is thinner is a sheet or a picture, diagonals.
MIN_THICKNESS = 0.01
# Least protrusion of a control, diagonals: less is a label or a printed mark.
MIN_CONTROL_PROTRUSION = 0.004
SIDE_NAMES = {FRONT: "front", BACK: "back", LEFT: "left side", RIGHT: "right side", TOP: "top"}


def signs_of_parts(mesh: WeldedMesh, stated: str, names: Sequence[str], models: Models) -> tuple[str, ...]:
    """Return what speaks for moving parts of a mesh in which none was found, in words; empty for nothing.

    Args:
        mesh: in the frame. stated: id of the kind that the user or a name states, or empty.
        names: of the nodes and parts of the file.
    """
    if float(np.ptp(mesh.points, axis=0).min()) < MIN_THICKNESS:
        return ()
    found = _signs_of_names(stated, names)
    views = render_sides(mesh)
    # Fruit, bottles and mugs have creases and handles too; what has doors, drawers or keys has flat walls.
    if boxiness(mesh, views) >= MIN_BOXINESS:
        measured = measure_fragments(mesh, mesh.fragment_labels, images=views)
        for side in SIDE_NAMES:
            found += _signs_of_side(mesh, measured, side, models)
    return tuple(found)


def _signs_of_names(stated: str, names: Sequence[str]) -> list[str]:
    """Return the signs that names give."""
    found = []
    if stated in KIND_TRAITS and stated not in OFTEN_STILL:
        found.append(f"it is called a {stated.replace('_', ' ')}, and such things have moving parts")
    words = {word.removesuffix("s") for name in names for word in split_words(name)} & PART_WORDS
    if words:
        found.append(f"names in its file say {', '.join(sorted(words))}")
    return found


def _signs_of_side(mesh: WeldedMesh, measured: MeasuredFragments, side: int, models: Models) -> list[str]:
    """Return the signs that a side shows."""
    relief = measure_relief(mesh, side)
    where = f"on its {SIDE_NAMES[side]}"
    if any(is_handle(relief, blob) for blob in relief.blobs):
        return [f"something {where} stands out like a handle"]
    if measured.count > 1 and _has_control(measured, side):
        return [f"something {where} stands out like a knob, a key or a lever"]
    least = MIN_FRONT_PROBABILITY if measured.count > 1 else MIN_FRONT_PROBABILITY_OF_ONE_PIECE
    if side != TOP and _has_front(mesh, relief, side, models, least):
        return [f"lines {where} run round what looks like a door or a drawer"]
    return []


def _has_front(mesh: WeldedMesh, relief: SideRelief, side: int, models: Models, least: float) -> bool:
    """Return whether a side has what is a front with a probability of more than `least`."""
    forests = models.front_forests
    fronts = [] if forests is None else find_fronts(mesh, relief, side, forests)
    return any(chance is not None and chance > least for _, chance in fronts)


def _has_control(measured: MeasuredFragments, side: int) -> bool:
    """Return whether a small piece stands out of a side, as knobs, keys and levers do."""
    return any(c.protrusion >= MIN_CONTROL_PROTRUSION for c in find_controls(measured, side, []))
