"""Ways to split a mesh: what a file keeps apart is not lost where positions coincide."""

from __future__ import annotations

import numpy as np

from casa_assets.articulate.segment.segmentations import Segmentation, segmentations
from casa_assets.articulate.segment.welded_mesh import weld_model, weld_triangles
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import RawModel, RawPart
from tests.support.mesh.meshes import box_mesh
from tests.unit.articulate.blocks import box, drawers, together


def open_box(lower: tuple[float, float, float], upper: tuple[float, float, float], side: int, sign: int) -> tuple:
    """A box without the faces that look along `sign` times the axis `side`."""
    vertices, faces = box(lower, upper)[:2]
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return vertices, faces[normals[:, side] * sign <= 0.0]


def test_pieces_that_were_pulled_out_of_the_body_stay_apart() -> None:
    body = open_box((0, 0, 0), (1, 1, 1), 1, -1)
    door = open_box((0, -0.1, 0), (1, 0, 1), 1, 1)
    vertices, faces, owner = together(body, door)
    mesh = weld_triangles(vertices, faces)
    found = segmentations(mesh)
    assert int(found[Segmentation.WELDED].max()) == 0
    assert found[Segmentation.PIECES].tolist() == owner.tolist()


def test_a_file_whose_pieces_are_its_welded_fragments_has_one_way() -> None:
    assert list(segmentations(weld_triangles(*drawers()[:2]))) == [Segmentation.WELDED]


def test_creases_of_solids_that_are_there_on_both_sides_are_those_of_one_side() -> None:
    parts = [box((k / 3, 0.1 * k, 0.07), (k / 3 + 0.21, 0.1 * k + 0.33, 0.7)) for k in range(9)]
    vertices, faces, owner = together(*parts)
    vertices = vertices @ np.linalg.qr(np.arange(9.0).reshape(3, 3) ** 2 + np.eye(3))[0]
    doubled = np.concatenate([faces, faces[:, ::-1]])
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
    parts = tuple(
        RawPart(
            name=f"p{i}", mesh=box_mesh((1, 1, 1), (i // 2, 0, i)), material=Material(id="m"), nodes=(f"n{i // 2}",)
        )
        for i in range(6)
    )
    found = segmentations(weld_model(RawModel(parts=parts, format="glb")))
    assert int(found[Segmentation.NODES].max()) == 2
