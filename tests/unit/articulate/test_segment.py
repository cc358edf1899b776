"""Meshes are welded, turned to their front, drawn, split into fragments, and cut where all is one shell."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import product

import manifold3d
import numpy as np
import pytest

from casa_assets.articulate.controls.controls import find_controls, group_controls
from casa_assets.articulate.frame import given_frame, guess_frame
from casa_assets.articulate.plan import Articulation, HingeEdge, PartKind
from casa_assets.articulate.segment import orthographic
from casa_assets.articulate.segment.cutting import CutPlane, cut_triangles
from casa_assets.articulate.segment.fragments import WeldedMesh, measure_fragments, weld_model, weld_triangles
from casa_assets.articulate.segment.orthographic import FRONT, SIDES, TOP, measure_relief, render_depth
from casa_assets.articulate.segment.segmentations import (
    Segmentation,
    cut_shell_parts,
    find_flat_sheets,
    segmentations,
    split_at_holes,
)
from casa_assets.articulate.segment.shell_segments import Fragmentation
from casa_assets.mesh.surface import face_normals, is_closed
from casa_assets.mesh.voxels import boundary, voxelise
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import JointKind, Mesh
from casa_assets.model.source import RawModel, RawPart
from tests.support.mesh.meshes import box_mesh
from tests.unit.articulate.blocks import (
    Floats,
    Ints,
    Part,
    articulate_fragmentation,
    box,
    carcass,
    disc,
    drawers,
    fragments_of,
    in_its_frame,
    microwave,
    together,
)

pytestmark = pytest.mark.content("code", "articulate", keep=0)


def test_boxes_that_share_a_face_stay_two_fragments() -> None:
    vertices, faces, owner = together(box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 1)))
    mesh = weld_triangles(vertices, faces)
    assert len(mesh.points) == 12
    assert mesh.fragment_labels.tolist() == owner.tolist()


@pytest.mark.parametrize("make", [microwave, drawers])
def test_each_part_is_a_fragment_in_any_order(make: Callable[[], tuple[Floats, Ints, Ints]]) -> None:
    vertices, faces, owner = make()
    order = np.random.default_rng(1).permutation(len(faces))
    twice = np.concatenate([faces, faces[:, [0, 2, 1]]])
    for rows, own in ((faces, owner), (faces[order], owner[order]), (twice, np.tile(owner, 2))):
        label = weld_triangles(vertices, rows).fragment_labels
        pairs = set(zip(label.tolist(), own.tolist(), strict=True))
        assert len(pairs) == int(label.max()) + 1 == int(owner.max()) + 1


def test_pieces_that_were_pulled_out_of_the_body_stay_apart() -> None:
    """Boxes without the faces in which they meet."""
    parts = []
    for points, rows in (box((0, 0, 0), (1, 1, 1)), box((0, -0.1, 0), (1, 0, 1))):
        parts.append((points, rows[(points[rows][..., 1] != 0.0).any(axis=1)]))
    vertices, faces, owner = together(*parts)
    found = segmentations(weld_triangles(vertices, faces))
    assert int(found[Segmentation.WELDED].max()) == 0
    assert found[Segmentation.PIECES].tolist() == owner.tolist()


def test_creases_of_solids_that_are_there_on_both_sides_are_those_of_one_side() -> None:
    parts = [box((k / 3, 0.1 * k, 0.07), (k / 3 + 0.21, 0.1 * k + 0.33, 0.7)) for k in range(9)]
    vertices, faces, owner = together(*parts)
    vertices = vertices @ np.linalg.qr(np.arange(9.0).reshape(3, 3) ** 2 + np.eye(3))[0]
    doubled = np.concatenate([faces, faces[:, ::-1]])
    assert list(segmentations(weld_triangles(*drawers()[:2]))) == [Segmentation.WELDED]
    found = segmentations(weld_triangles(vertices, doubled))
    assert Segmentation.CREASES not in found
    assert found[Segmentation.WELDED].tolist() == [*owner.tolist(), *owner.tolist()]


def test_vertices_that_are_copied_for_their_normals_join_a_piece() -> None:
    one, two = box_mesh((1, 1, 1), (0, 0, 0)), box_mesh((1, 1, 1), (3, 0, 0))
    both = Mesh(
        vertices=np.concatenate([one.vertices, two.vertices]),
        faces=np.concatenate([one.faces, two.faces + len(one.vertices)]),
        uv=np.concatenate([one.uv, two.uv]),
        normals=np.concatenate([one.normals, two.normals]),
    )
    model = RawModel(parts=(RawPart(name="a", mesh=both, material=Material(id="m")),), format="glb")
    assert np.unique(weld_model(model).piece_index).tolist() == [0, 1]


def test_nodes_of_a_file_are_a_way_to_split_it() -> None:
    parts, look = [], Material(id="m")
    for i in range(6):
        mesh = box_mesh((1, 1, 1), (i // 2, 0, i))
        parts.append(RawPart(name=f"p{i}", mesh=mesh, material=look, nodes=(f"n{i // 2}",)))
    found = segmentations(weld_model(RawModel(parts=tuple(parts), format="glb")))
    assert int(found[Segmentation.NODES].max()) == 2


# The corners of a square hole in the sheet that looks along -y, and those of the sheet.
INNER = [(0.3, 0.0, 0.3), (0.7, 0.0, 0.3), (0.7, 0.0, 0.7), (0.3, 0.0, 0.7)]
OUTER = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.0, 1.0), (0.0, 0.0, 1.0)]


def pulled_out(height: float) -> tuple[WeldedMesh, np.ndarray[tuple[int], np.dtype[np.bool_]]]:
    """A box whose front has a hole, out of which a block stands; and which faces are those of the block."""
    points, faces = box((0, 0, 0), (1, 1, 1))[:2]
    corners = points[faces]
    body = [c for c in corners if not (c[:, 1] == 0.0).all()]
    outer, inner = np.array(OUTER), np.array(INNER)
    raised = inner - (0.0, height, 0.0)
    ring = [(outer[k], outer[(k + 1) % 4], inner[(k + 1) % 4]) for k in range(4)]
    ring += [(outer[k], inner[(k + 1) % 4], inner[k]) for k in range(4)]
    wall = [(inner[k], inner[(k + 1) % 4], raised[(k + 1) % 4]) for k in range(4)]
    wall += [(inner[k], raised[(k + 1) % 4], raised[k]) for k in range(4)]
    block = [*wall, (raised[0], raised[1], raised[2]), (raised[0], raised[2], raised[3])]
    triangles = np.array([*body, *ring, *block])
    is_block = np.arange(len(triangles)) >= len(body) + len(ring)
    return weld_triangles(triangles.reshape(-1, 3), np.arange(triangles.size // 3).reshape(-1, 3)), is_block


def test_what_stands_out_of_a_hole_of_a_flat_sheet_or_at_a_concave_crease_is_a_fragment() -> None:
    mesh, is_block = pulled_out(0.1)
    assert int(mesh.fragment_labels.max()) == 0
    sheets = find_flat_sheets(mesh)
    assert np.flatnonzero(sheets.has_hole[sheets.sheet]).tolist() == list(range(10, 18))
    split = split_at_holes(mesh, sheets)
    assert len(np.unique(split)) == 2
    assert len(np.unique(split[is_block])) == 1
    labels = segmentations(mesh)[Segmentation.CREASES]
    assert len(set(labels[is_block].tolist())) == 1
    assert set(labels[is_block].tolist()).isdisjoint(labels[~is_block].tolist())
    inset, is_block = pulled_out(-0.1)  # its rim is convex, and only its floor meets its walls at a concave crease
    assert len(set(segmentations(inset)[Segmentation.CREASES][is_block].tolist())) == 2


def test_the_picture_does_not_depend_on_how_much_is_written_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, faces, _ = together(box((0, 0, 0), (2, 1, 4)), box((0.3, -0.4, 1.1), (1.1, 0.2, 2.7)))
    turn = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    whole = render_depth(vertices @ turn.T, faces, SIDES[FRONT], 64)
    monkeypatch.setattr(orthographic, "CHUNK", 150)
    parted = render_depth(vertices @ turn.T, faces, SIDES[FRONT], 64)
    assert (whole.face == parted.face).all()
    assert (whole.depth == parted.depth).all()


def shell_of(*parts: Part) -> WeldedMesh:
    """The skin of a grid of cubes around solids, in its frame."""
    return in_its_frame(*boundary(voxelise(*together(*parts)[:2], 112)))[0]


def test_knobs_on_the_wall_behind_a_range_are_round_and_one_group() -> None:
    body = [box((0, 0, 0), (0.76, 0.65, 0.9)), box((0, 0.58, 0.9), (0.76, 0.65, 1.1))]
    knobs = [disc((x, 0.555, 1.01), 0.024, 0.03) for x in (0.1, 0.193, 0.555, 0.65)]
    mesh = shell_of(*body, *knobs)
    controls = find_controls(measure_fragments(mesh, fragments_of(mesh).labels), FRONT, [])
    assert [c.is_round for c in controls] == [True] * 4
    assert [len(g.members) for g in group_controls(controls, mesh.cell)] == [4]


def test_knobs_between_slots_stand_out_of_their_ground() -> None:
    strips = [(0.0, 0.10), (0.112, 0.20), (0.212, 0.312)]
    plate = [box((a, 0, 0), (b, 0.03, 0.2)) for a, b in strips]
    body = box((0, 0.03, -0.02), (0.312, 0.3, 0.22))
    rims = [box((0, 0, -0.02), (0.312, 0.03, 0.0)), box((0, 0, 0.2), (0.312, 0.03, 0.22))]
    knobs = [disc((x, -0.02, 0.05), 0.018, 0.02) for x in (0.05, 0.156, 0.262)]
    mesh, frame = in_its_frame(*together(*plate, body, *rims, *knobs)[:2])
    relief = measure_relief(mesh, FRONT)
    width = 0.036 * frame.scale
    assert [b for b in relief.blobs if np.allclose(b.upper - b.lower, width, atol=0.004)] == list(relief.blobs)
    assert len(relief.blobs) == 3


def test_a_box_cut_across_stays_closed_and_keeps_its_surface_and_a_blade_cuts_within_its_limits_alone() -> None:
    points, faces = box((0, 0, 0), (1, 1, 1))
    wide = np.full(3, 10.0)
    done = cut_triangles(points, faces, [CutPlane(FRONT, 0, 0.3, -wide, wide), CutPlane(TOP, 1, 0.6, -wide, wide)])
    after = done.interpolate(points)
    assert is_closed(done.faces)
    assert face_normals(after, done.faces)[1].sum() == pytest.approx(6.0)
    for axis, at in ((0, 0.3), (1, 0.6)):
        along = after[done.faces][:, :, axis]
        assert ((along.max(axis=1) <= at + 1e-12) | (along.min(axis=1) >= at - 1e-12)).all()
    low, high = np.array([0.0, 0.0, -0.1]), np.array([1.0, 1.0, 0.1])
    done = cut_triangles(points, faces, [CutPlane(FRONT, 0, 0.5, low, high)])
    fresh = done.interpolate(points)[len(points) :]
    assert len(fresh)
    assert (fresh[:, 1] <= 0.1 + 1e-5).all()
    assert is_closed(done.faces)


def fused(*parts: Part) -> Part:
    """The outer surface of solids, as one."""
    solids = []
    for points, faces in parts:
        mesh = manifold3d.Mesh(vert_properties=points.astype(np.float32), tri_verts=faces.astype(np.uint32))
        mesh.merge()
        solids.append(manifold3d.Manifold(mesh))
    solid = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add).refine_to_length(0.03)
    out = solid.to_mesh()
    return np.asarray(out.vert_properties, dtype=np.float64)[:, :3], np.asarray(out.tri_verts, dtype=np.int64)


@cache
def oven() -> Part:
    """A body; before it a panel with four knobs, and below it a door with a level bar; all one surface."""
    return fused(
        box((0.0, 0.0, 0.0), (0.6, 0.55, 0.8)),
        box((0.0, -0.03, 0.0), (0.6, 0.01, 0.64)),
        box((0.05, -0.075, 0.55), (0.55, -0.055, 0.575)),
        box((0.08, -0.06, 0.555), (0.1, -0.02, 0.57)),
        box((0.5, -0.06, 0.555), (0.52, -0.02, 0.57)),
        box((0.0, -0.03, 0.655), (0.6, 0.01, 0.8)),
        *(disc((x, -0.06, 0.73), 0.03, 0.04) for x in (0.1, 0.2, 0.4, 0.5)),
    )


def placed_of(shape: Part) -> tuple[Fragmentation, Articulation]:
    """The fragments of a shape with z up and its front to -y, in the frame; and what is found on them."""
    placed, frame = in_its_frame(*shape)
    fragments = fragments_of(placed)
    return fragments, articulate_fragmentation(fragments, frame)


def model_of(shape: Part) -> RawModel:
    """A file with one part, whose texture coordinates are x and z."""
    points, faces = shape
    mesh = Mesh(vertices=points, faces=faces.astype(np.int32), uv=points[:, [0, 2]].copy())
    return RawModel(parts=(RawPart(name="all", mesh=mesh, material=Material(id="paint")),), format="obj")


def test_a_fused_oven_has_a_door_that_folds_down_and_knobs() -> None:
    _, found = placed_of(oven())
    assert sorted(p.kind for p in found.parts) == [PartKind.DOOR, *[PartKind.KNOB] * 4]
    door = next(p for p in found.parts if p.kind is PartKind.DOOR)
    assert door.joint.kind is JointKind.HINGE
    assert door.joint.edge is HingeEdge.BOTTOM
    assert len(door.grip)


def test_a_drawer_over_two_doors_without_a_seam_ends_as_far_below_its_handle_as_it_begins_above() -> None:
    solids = [box((0.0, 0.0, 0.0), (0.6, 0.55, 0.8)), box((0.0, -0.03, 0.0), (0.6, 0.01, 0.8))]
    solids += [box((0.2, -0.075, 0.69), (0.4, -0.055, 0.71))]
    solids += [box((x, -0.075, 0.25), (x + 0.02, -0.055, 0.4)) for x in (0.25, 0.33)]
    feet = ((0.22, 0.7), (0.38, 0.7), (0.26, 0.27), (0.26, 0.38), (0.34, 0.27), (0.34, 0.38))
    solids += [box((x - 0.006, -0.06, z - 0.006), (x + 0.006, -0.02, z + 0.006)) for x, z in feet]
    placed, found = placed_of(fused(*solids))
    assert len(found.parts) == 3
    unit = float(np.linalg.norm([0.6, 0.625, 0.8]))
    drawer = max(found.parts, key=lambda p: float(placed.mesh.points[placed.mesh.faces[p.faces]][..., 2].mean()))
    middles = placed.mesh.points[placed.mesh.faces[drawer.faces]].mean(axis=1)
    assert float(middles[:, 2].min()) * unit + 0.4 == pytest.approx(0.6, abs=0.04)


def test_knobs_in_a_row_split_nothing_and_nothing_is_invented_on_a_plain_body() -> None:
    body = [box((0.0, 0.0, 0.0), (0.6, 0.55, 0.8)), box((0.0, -0.03, 0.0), (0.6, 0.01, 0.8))]
    _, found = placed_of(fused(*body, *(disc((x, -0.06, 0.7), 0.02, 0.04) for x in (0.15, 0.3, 0.45))))
    assert not [p for p in found.parts if p.kind in (PartKind.DOOR, PartKind.DRAWER)]
    plain = box((0, 0, 0), (0.6, 0.5, 0.8))
    for solids in ([plain], [plain, box((0.1, 0.1, 0.79), (0.5, 0.4, 0.9))]):
        assert not placed_of(fused(*solids))[1].parts


def test_cut_parts_and_the_body_are_closed_and_keep_surface_volume_and_texture() -> None:
    placed, found = placed_of(oven())
    model, mesh, parts = cut_shell_parts(model_of(oven()), placed, found)
    owner = np.full(len(mesh.faces), -1)
    for i, part in enumerate(parts.parts):
        owner[part.faces] = i
    for i in range(-1, len(parts.parts)):
        rows = np.flatnonzero((owner == i) & (mesh.areas > 0))
        corners = mesh.faces[rows]
        ends = np.sort(np.concatenate([corners[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
        # Pockets of two cuts may touch in a line: there four faces meet.
        assert (np.unique(ends, axis=0, return_counts=True)[1] % 2 == 0).all(), i
    cut_mesh, caps = model.parts[0].mesh, model.parts[1].mesh
    assert np.allclose(cut_mesh.uv, cut_mesh.vertices[:, [0, 2]], atol=1e-9)
    assert caps.uv is not None
    own = len(cut_mesh.faces)
    assert mesh.areas[:own].sum() == pytest.approx(placed.mesh.areas.sum(), rel=1e-6)
    assert len(mesh.faces) == own + len(caps.faces)
    corners = caps.vertices[caps.faces]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
    assert volume == pytest.approx(0, abs=1e-9)


def test_a_shell_with_nothing_to_cut_out_of_it_stays_whole() -> None:
    """What moves may stand on it as it is: the stick of a tap."""
    plain = fused(box((0, 0, 0), (0.6, 0.5, 0.8)))
    placed, found = placed_of(plain)
    shell = placed.shell
    assert not (*shell.fronts, *shell.front.blobs, *shell.top.blobs)
    stick = placed_of(oven())[1].parts[0].replace(faces=np.array([0, 1]))
    model = model_of(plain)
    assert cut_shell_parts(model, placed, found.replace(parts=(stick,)))[0] is model


UP, FACING = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])
Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def yaw(degrees: float) -> Floats:
    """A turn about z."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def standing_range() -> tuple[Floats, Ints, Ints]:
    """A range: a door with a level bar at its top, four knobs above it, and feet."""
    return together(
        *carcass(0.6, 0.6, 0.85),
        box((0.01, -0.03, 0.12), (0.59, 0.0, 0.66)),
        box((0.06, -0.08, 0.6), (0.54, -0.06, 0.62)),
        box((0.06, -0.06, 0.6), (0.08, -0.03, 0.62)),
        box((0.52, -0.06, 0.6), (0.54, -0.03, 0.62)),
        *(disc((x, -0.04, 0.75), 0.025, 0.04) for x in (0.12, 0.24, 0.36, 0.48)),
        *(box((x, y, -0.03), (x + 0.04, y + 0.04, 0.0)) for x in (0.02, 0.54) for y in (0.02, 0.54)),
    )


THINGS = {"drawers": drawers, "microwave": microwave, "range": standing_range}


def turned(name: str, rotation: Floats, scale: float = 1.0) -> WeldedMesh:
    """One of THINGS in another pose, with other units, moved."""
    vertices, faces, _ = THINGS[name]()
    return weld_triangles(vertices @ rotation.T * scale + np.array([3.0, -2.0, 7.0]) * scale, faces)


def test_the_front_is_found_from_any_side() -> None:
    poses = ((0.0, np.eye(3)), (90.0, Y_UP), (180.0, np.eye(3)), (-27.0, Y_UP), (33.3, np.eye(3)))
    for name, (degrees, stands) in product(("drawers", "range"), poses):
        rotation = stands @ yaw(degrees)
        found = guess_frame(turned(name, rotation, 100.0))
        assert found.rotation[2] == pytest.approx(rotation @ UP, abs=2e-3), (name, degrees)
        assert found.rotation[1] == pytest.approx(-rotation @ FACING, abs=2e-3), (name, degrees)
        assert 0.0 < found.confidence <= 1.0
        assert found.runner_up


@pytest.mark.parametrize("degrees", [0.0, 2.0, 41.0])
def test_the_thing_fills_its_box(degrees: float) -> None:
    mesh = turned("microwave", yaw(degrees), 10.0)
    # A user says only roughly where its front is.
    frame = guess_frame(mesh, up=UP.tolist(), front=(yaw(degrees + 10.0) @ FACING).tolist())
    placed, size = mesh.in_frame(frame), np.array([0.5, 0.43, 0.3])
    low, high = placed.points.min(axis=0), placed.points.max(axis=0)
    assert np.linalg.norm(high - low) == pytest.approx(1.0)
    assert (low + high) / 2 == pytest.approx(np.zeros(3), abs=1e-9)
    assert high - low == pytest.approx(size / np.linalg.norm(size), abs=2e-3)
    assert frame.to_file(placed.points) == pytest.approx(mesh.points, abs=1e-9)


@pytest.mark.representatives(2)
@pytest.mark.parametrize("face", [3, 4, 0, 1, 2, 5])
def test_what_the_user_says_holds_and_the_word_of_the_file_counts(face: int) -> None:
    cube = weld_triangles(*box((0, 0, 0), (1, 1, 1)))
    assert guess_frame(cube, stated=face).rotation[2] == pytest.approx(-SIDES[face][2])
    mesh = turned("drawers", np.eye(3))
    front = -SIDES[face][2]
    for up in (-SIDES[k][2] for k in range(6) if k // 2 != face // 2):
        found = guess_frame(mesh, up=up.tolist(), front=front.tolist())
        assert found.rotation == pytest.approx(given_frame(mesh, up.tolist(), front.tolist()).rotation)
        assert found.reason == "given"
    assert guess_frame(mesh, front=front.tolist()).rotation[1] == pytest.approx(-front)
    assert guess_frame(mesh, up=front.tolist()).rotation[2] == pytest.approx(front)


PIXELS = 128
