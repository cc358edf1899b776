"""What a drawer would run into as it opens goes with it, and what it passes stays."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.interior.pieces_in_the_way import with_pieces_in_the_way
from casa_assets.articulate.plan import Articulation, Frame, JointPlan, PartKind, PartPlan
from casa_assets.articulate.segment.welded_mesh import weld_triangles
from casa_assets.model.asset.joint import JointKind
from tests.unit.articulate.blocks import Ints, Part, box, carcass, together

FRONT, BACK = box((0.01, -0.02, 0.01), (0.49, 0.0, 0.29)), box((0.03, 0.4, 0.04), (0.47, 0.42, 0.2))
SIDES = [box((x, 0.01, 0.04), (x + 0.02, 0.39, 0.2)) for x in (0.03, 0.45)]
HANDLE = box((0.2, -0.06, 0.14), (0.3, -0.021, 0.16))
# Between the two side walls, over the back of the drawer and under the edge of its front.
RAIL = box((0.02, 0.005, 0.25), (0.48, 0.06, 0.27))


def _goes_with_a_drawer(*loose: Part, kind: PartKind = PartKind.DRAWER) -> list[bool]:
    """Build a drawer of a front and a back in a carcass, and return which of some pieces of the body it carries."""
    vertices, faces, owner = together(*carcass(0.5, 0.5, 0.3), FRONT, BACK, *loose)
    mesh = weld_triangles(vertices, faces)
    own: Ints = np.flatnonzero((owner == 5) | (owner == 6))
    joint = JointPlan(kind=JointKind.SLIDE, axis=(0.0, -1.0, 0.0), anchor=(0.25, 0.0, 0.15), range=(0.0, 0.3))
    part = PartPlan(name="drawer_0", kind=kind, faces=own, grip=own[:0], joint=joint)
    frame = Frame(rotation=np.eye(3), origin=(0.0, 0.0, 0.0), scale=1.0, metres=1.0)
    (found,) = with_pieces_in_the_way(Articulation(frame=frame, parts=(part,)), mesh).parts
    carried = np.isin(np.arange(len(faces)), found.faces)
    assert carried[own].all()
    assert not carried[owner < 5].any(), "walls of the body stay"
    return [bool(carried[owner == 7 + i].all()) for i in range(len(loose))]


def test_sides_of_a_box_and_a_handle_go_with_their_drawer() -> None:
    assert _goes_with_a_drawer(*SIDES, HANDLE) == [True, True, True]


def test_a_rail_that_the_box_passes_under_stays() -> None:
    assert _goes_with_a_drawer(RAIL) == [False]


def test_a_door_takes_nothing_from_the_room_behind_it() -> None:
    assert _goes_with_a_drawer(*SIDES, kind=PartKind.DOOR) == [False, False]
