"""Faces that were modelled twice do not lie in each other in what is written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from casa_assets.articulate.assemble import SHEET_GAP_M, drawn_faces
from casa_assets.articulate.run.build import ArticulateRequest, build
from tests.unit.articulate.blocks import microwave
from tests.unit.articulate.test_assemble import GIVEN, obj


def test_the_second_side_is_told_and_a_copy_is_left_out() -> None:
    sheet = np.array([[0, 1, 2], [0, 2, 3]])
    faces = np.concatenate([sheet, sheet[:, ::-1], sheet[:, [1, 2, 0]]])
    front, second = drawn_faces(faces)
    assert front.tolist() == [True, True, False, False, False, False]
    assert second.tolist() == [False, False, True, True, False, False]


def test_no_two_faces_of_a_link_coincide(tmp_path: Path) -> None:
    vertices, faces, _ = microwave()
    mesh = obj(tmp_path / "double.obj", vertices, np.concatenate([faces, faces[:, ::-1], faces[:4]]))
    asset = build(ArticulateRequest(mesh, tmp_path, category="microwave", up=GIVEN["up"], front=GIVEN["front"])).asset
    count = 0
    for link in asset.links:
        middles = np.concatenate([v.mesh.vertices[v.mesh.faces].mean(axis=1) for v in link.visuals])
        gap, _ = cKDTree(middles).query(middles, k=2)
        assert gap[:, 1].min() > 0.7 * SHEET_GAP_M
        count += len(middles)
    assert count >= 2 * len(faces), "both sides stay"
    assert np.abs(np.ptp(asset.bounds, axis=0) - [0.5, 0.43, 0.3]).max() <= 2 * SHEET_GAP_M + 1e-6
