"""One fused shell: its fronts and controls are found, cut out with clean edges, and closed."""

from __future__ import annotations

from functools import cache

import manifold3d
import numpy as np
import pytest

from casa_assets.articulate.plan import Articulation, HingeEdge, PartKind, PartPlan
from casa_assets.articulate.segment.segmentations import cut_shell_parts
from casa_assets.articulate.segment.shell_segments import Fragmentation, fragment_mesh
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import JointKind, Mesh
from casa_assets.model.source import RawModel, RawPart
from tests.unit.articulate.blocks import box, disc
from tests.unit.articulate.fragmented import articulate_fragmentation, in_its_frame

pytestmark = pytest.mark.content("code", "articulate.segment", keep=0)

Shape = tuple[np.ndarray, np.ndarray]


def fused(*parts: Shape) -> Shape:
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
def oven() -> Shape:
    """A body; before it a panel with a knob, and below it a door with a level bar; all one surface."""
    return fused(
        box((0.0, 0.0, 0.0), (0.6, 0.55, 0.8)),
        box((0.0, -0.03, 0.0), (0.6, 0.01, 0.64)),
        box((0.05, -0.075, 0.55), (0.55, -0.055, 0.575)),
        box((0.08, -0.06, 0.555), (0.1, -0.02, 0.57)),
        box((0.5, -0.06, 0.555), (0.52, -0.02, 0.57)),
        box((0.0, -0.03, 0.655), (0.6, 0.01, 0.8)),
        disc((0.3, -0.06, 0.73), 0.03, 0.04),
    )


def placed_of(shape: Shape) -> tuple[Fragmentation, Articulation]:
    """The fragments of a shape with z up and its front to -y, in the frame; and what is found on them."""
    placed, frame = in_its_frame(*shape)
    fragments = fragment_mesh(placed)
    return fragments, articulate_fragmentation(fragments, frame)


def model_of(shape: Shape) -> RawModel:
    """A file with one part, whose texture coordinates are x and z."""
    points, faces = shape
    mesh = Mesh(vertices=points, faces=faces.astype(np.int32), uv=points[:, [0, 2]].copy())
    return RawModel(parts=(RawPart(name="all", mesh=mesh, material=Material(id="paint")),), format="obj")


def test_a_fused_oven_has_a_door_that_folds_down_and_a_knob() -> None:
    _, found = placed_of(oven())
    assert sorted(p.kind for p in found.parts) == [PartKind.DOOR, PartKind.KNOB]
    door = next(p for p in found.parts if p.kind is PartKind.DOOR)
    assert door.joint.kind is JointKind.HINGE
    assert door.joint.edge is HingeEdge.BOTTOM
    assert len(door.grip)


def test_a_drawer_over_two_doors_without_a_seam_ends_as_far_below_its_handle_as_it_begins_above() -> None:
    bars = [((0.2, -0.075, 0.69), (0.4, -0.055, 0.71)), ((0.25, -0.075, 0.25), (0.27, -0.055, 0.4))]
    bars += [((0.33, -0.075, 0.25), (0.35, -0.055, 0.4))]
    feet = [
        ((x - 0.006, -0.06, z - 0.006), (x + 0.006, -0.02, z + 0.006))
        for x, z in ((0.22, 0.7), (0.38, 0.7), (0.26, 0.27), (0.26, 0.38), (0.34, 0.27), (0.34, 0.38))
    ]
    solids = [((0.0, 0.0, 0.0), (0.6, 0.55, 0.8)), ((0.0, -0.03, 0.0), (0.6, 0.01, 0.8)), *bars, *feet]
    placed, found = placed_of(fused(*(box(a, b) for a, b in solids)))
    assert len(found.parts) == 3
    unit = float(np.linalg.norm([0.6, 0.625, 0.8]))
    drawer = max(found.parts, key=lambda p: float(placed.mesh.points[placed.mesh.faces[p.faces]][..., 2].mean()))
    middles = placed.mesh.points[placed.mesh.faces[drawer.faces]].mean(axis=1)
    assert float(middles[:, 2].min()) * unit + 0.4 == pytest.approx(0.6, abs=0.04)


def knobbed(*places: tuple[float, float]) -> list[PartPlan]:
    """What is found on a plain body with a plain front before it, and knobs at some places (x, z) of that."""
    body = [box((0.0, 0.0, 0.0), (0.6, 0.55, 0.8)), box((0.0, -0.03, 0.0), (0.6, 0.01, 0.8))]
    placed, found = placed_of(fused(*body, *(disc((x, -0.06, z), 0.02, 0.04) for x, z in places)))
    return sorted(found.parts, key=lambda p: float(np.mean(placed.mesh.points[placed.mesh.faces[p.faces]][..., 2])))


def test_knobs_in_a_row_are_controls_and_split_nothing() -> None:
    parts = knobbed((0.15, 0.7), (0.3, 0.7), (0.45, 0.7))
    assert not [p for p in parts if p.kind in (PartKind.DOOR, PartKind.DRAWER)]


def test_cut_parts_are_closed_and_so_is_the_body() -> None:
    placed, found = placed_of(oven())
    _, mesh, parts = cut_shell_parts(model_of(oven()), placed, found)
    owner = np.full(len(mesh.faces), -1)
    for i, part in enumerate(parts.parts):
        owner[part.faces] = i
    for i in range(-1, len(parts.parts)):
        rows = np.flatnonzero((owner == i) & (mesh.areas > 0))
        corners = mesh.faces[rows]
        ends = np.sort(np.concatenate([corners[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
        # Pockets of two cuts may touch in a line: there four faces meet.
        assert (np.unique(ends, axis=0, return_counts=True)[1] % 2 == 0).all(), i


def test_a_cut_keeps_surface_volume_and_texture() -> None:
    placed, found = placed_of(oven())
    model, mesh, _ = cut_shell_parts(model_of(oven()), placed, found)
    cut_mesh, caps = model.parts[0].mesh, model.parts[1].mesh
    assert cut_mesh.uv is not None
    assert np.allclose(cut_mesh.uv, cut_mesh.vertices[:, [0, 2]], atol=1e-9)
    assert caps.uv is not None
    own = len(cut_mesh.faces)
    assert mesh.areas[:own].sum() == pytest.approx(placed.mesh.areas.sum(), rel=1e-6)
    assert len(mesh.faces) == own + len(caps.faces)
    corners = caps.vertices[caps.faces]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
    assert volume == pytest.approx(0, abs=1e-9)


def test_nothing_is_invented_on_a_plain_body() -> None:
    _, found = placed_of(fused(box((0, 0, 0), (0.6, 0.5, 0.8))))
    assert not found.parts
    _, found = placed_of(fused(box((0, 0, 0), (0.6, 0.5, 0.8)), box((0.1, 0.1, 0.79), (0.5, 0.4, 0.9))))
    assert not found.parts


def test_the_same_shell_is_cut_the_same_way() -> None:
    one, two = placed_of(oven()), placed_of(oven())
    assert one[1].to_json() == two[1].to_json()


def test_a_shell_with_nothing_to_cut_out_of_it_stays_whole() -> None:
    """What moves may stand on it as it is: the stick of a tap."""
    plain = fused(box((0, 0, 0), (0.6, 0.5, 0.8)))
    placed, found = placed_of(plain)
    shell = placed.shell
    assert shell is not None
    assert not (*shell.fronts, *shell.front.blobs, *shell.top.blobs)
    stick = placed_of(oven())[1].parts[0].replace(faces=np.array([0, 1]))
    model = model_of(plain)
    assert cut_shell_parts(model, placed, found.replace(parts=(stick,)))[0] is model
