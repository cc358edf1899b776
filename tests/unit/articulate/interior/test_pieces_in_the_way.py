"""What a front would run into as it opens goes with it, and what it passes stays."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.interior.inner_parts import with_pieces_in_the_way
from casa_assets.articulate.plan import Articulation, Frame, HingeEdge, JointPlan, PartKind, PartPlan
from casa_assets.articulate.segment.welded_mesh import weld_triangles
from casa_assets.model.asset.parts import JointKind
from tests.unit.articulate.blocks import Ints, Part, box, carcass, together

FRONT, BACK = box((0.01, -0.02, 0.01), (0.49, 0.0, 0.29)), box((0.03, 0.4, 0.04), (0.47, 0.42, 0.2))
SIDES = [box((x, 0.01, 0.04), (x + 0.02, 0.39, 0.2)) for x in (0.03, 0.45)]
HANDLE = box((0.2, -0.06, 0.14), (0.3, -0.021, 0.16))
# Between the two side walls, over the back of the drawer and under the edge of its front.
RAIL = box((0.02, 0.005, 0.25), (0.48, 0.06, 0.27))


SLIDES = JointPlan(kind=JointKind.SLIDE, axis=(0.0, -1.0, 0.0), anchor=(0.25, 0.0, 0.15), range=(0.0, 0.3))
SWINGS = JointPlan(
    kind=JointKind.HINGE, axis=(0.0, 0.0, -1.0), anchor=(0.01, 0.0, 0.15), range=(0.0, 1.5), edge=HingeEdge.LEFT
)


def _carried(
    *loose: Part, sheets: tuple[Part, Part] = (FRONT, BACK), joint: JointPlan = SLIDES, taken: int = 0
) -> list[bool]:
    """Build a drawer or a door of two sheets in a carcass; return which of some pieces of the body it carries.

    Args:
        taken: faces of the first piece that it has before.
    """
    vertices, faces, owner = together(*carcass(0.5, 0.5, 0.3), *sheets, *loose)
    mesh = weld_triangles(vertices, faces)
    own: Ints = np.flatnonzero((owner == 5) | (owner == 6))
    own = np.concatenate([own, np.flatnonzero(owner == 7)[:taken]])
    kind = PartKind.DRAWER if joint is SLIDES else PartKind.DOOR
    part = PartPlan(name="front_0", kind=kind, faces=own, grip=own[:0], joint=joint)
    frame = Frame(rotation=np.eye(3), origin=(0.0, 0.0, 0.0), scale=1.0, metres=1.0)
    (found,) = with_pieces_in_the_way(Articulation(frame=frame, parts=(part,)), mesh).parts
    carried = np.isin(np.arange(len(faces)), found.faces)
    assert carried[own].all()
    assert not carried[owner < 5].any(), "walls of the body stay"
    return [bool(carried[owner == 7 + i].all()) for i in range(len(loose))]


def test_sides_of_a_box_and_a_handle_go_with_their_drawer() -> None:
    assert _carried(*SIDES, HANDLE) == [True, True, True]


def test_what_a_drawer_has_not_taken_of_a_piece_goes_with_it_too() -> None:
    assert _carried(*SIDES, taken=4) == [True, True]


def test_a_rail_that_the_box_passes_under_stays() -> None:
    assert _carried(RAIL) == [False]


def test_what_is_between_the_sheets_of_a_door_goes_with_it_and_the_room_behind_it_stays() -> None:
    inner = box((0.01, 0.02, 0.01), (0.49, 0.03, 0.29))
    core = box((0.1, 0.005, 0.1), (0.4, 0.015, 0.2))
    assert _carried(core, *SIDES, HANDLE, sheets=(FRONT, inner), joint=SWINGS) == [True, False, False, True]
