"""Which cavities doors close, and how large they may be: pairs of doors, round ones, bodies that taper."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.interior.cavities import find_cavities
from casa_assets.articulate.plan import Articulation, HingeEdge, JointPlan, PartKind, PartPlan
from casa_assets.articulate.segment.orthographic import cross_rays
from casa_assets.articulate.segment.shell_segments import fragment_mesh
from casa_assets.articulate.segment.welded_mesh import WeldedMesh
from casa_assets.model.asset.parts import JointKind
from tests.unit.articulate.blocks import Floats, Ints, Part, box, carcass, disc, together
from tests.unit.articulate.fragmented import articulate_fragmentation, in_its_frame
from tests.unit.articulate.interior.test_complete import block, door


def turned_in(part: Part) -> Part:
    """A box that is seen from inside."""
    return part[0], part[1][:, ::-1]


def test_two_doors_that_meet_close_one_room() -> None:
    left = [box((0.0, -0.03, 0.0), (0.298, -0.001, 0.8)), box((0.26, -0.07, 0.3), (0.275, -0.03, 0.5))]
    right = [box((0.302, -0.03, 0.0), (0.6, -0.001, 0.8)), box((0.325, -0.07, 0.3), (0.34, -0.03, 0.5))]
    mesh, found = _inferred(*block(*left, *right)[:2])
    (room,) = find_cavities(mesh, found, "base_cabinet")
    assert len(room.parts) == 2
    cavities = find_cavities(mesh, found, "refrigerator")
    assert [len(r.parts) for r in cavities] == [1, 1]


def _inferred(vertices: Floats, faces: Ints) -> tuple[WeldedMesh, Articulation]:
    placed, frame = in_its_frame(vertices, faces)
    return placed, articulate_fragmentation(fragment_mesh(placed), frame.replace(metres=1.0))


def test_an_inside_out_mesh_is_measured_as_the_same() -> None:
    parts = [*carcass(0.6, 0.6, 0.8), *door()]
    right, wrong = (
        find_cavities(*_inferred(*together(*p)[:2]), "base_cabinet") for p in (parts, map(turned_in, parts))
    )
    assert [r.built for r in right] == [r.built for r in wrong] == [False]


def by_hand(edges: dict[int, HingeEdge], *parts: Part) -> tuple[WeldedMesh, Articulation]:
    """Solids of which some are doors, without anything being guessed: place in `parts` -> edge of its hinge."""
    vertices, faces, owner = together(*parts)
    placed, frame = in_its_frame(vertices, faces)
    joint = JointPlan(kind=JointKind.HINGE, axis=(0.0, 0.0, 1.0), anchor=(0.0, 0.0, 0.0), range=(0.0, 1.5))
    doors = [
        PartPlan(
            name=f"door_{i}",
            kind=PartKind.DOOR,
            faces=np.flatnonzero(owner == i),
            grip=np.empty(0, dtype=np.int64),
            joint=joint.replace(edge=edge),
        )
        for i, edge in edges.items()
    ]
    return placed, Articulation(frame=frame.replace(metres=1.0), parts=tuple(doors))


BLOCK = box((0.0, 0.0, 0.0), (0.6, 0.6, 0.8))


def test_behind_a_round_door_the_front_stays_whole() -> None:
    mesh, found = by_hand({1: HingeEdge.LEFT}, BLOCK, disc((0.3, -0.03, 0.4), 0.25, 0.029, 48))
    (room,) = find_cavities(mesh, found, "washing_machine")
    assert room.cut is not None
    assert room.fronts == ()
    scale, middle = found.frame.scale, np.array(found.frame.origin)
    corners = [np.array([room.cut[i][0], room.cut[j][2]]) / scale + middle[[0, 2]] for i in (0, 1) for j in (0, 1)]
    assert all(float(np.linalg.norm(c - (0.3, 0.4))) < 0.25 for c in corners)


def test_a_room_keeps_off_what_tapers_towards_the_back() -> None:
    points, faces = BLOCK
    tapered = points.copy()
    back = tapered[:, 1] > 0.5
    tapered[back, 2] = 0.2 + 0.5 * tapered[back, 2]
    mesh, found = by_hand({1: HingeEdge.LEFT}, (tapered, faces), box((0.0, -0.03, 0.0), (0.6, -0.001, 0.8)))
    (room,) = find_cavities(mesh, found, "")
    skin = mesh.faces[: len(faces)]
    for x, z in ((room.outer[i][0], room.outer[k][2]) for i in (0, 1) for k in (0, 1)):
        up = cross_rays(mesh.points, skin, 2, np.array([[x, room.outer[1][1]]]))
        assert float(up.first()[0]) < z < float(up.last()[0])
