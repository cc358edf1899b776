"""Shells of voxels: the size of their cubes, and the knobs that stand out of them."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.controls.controls import find_controls, group_controls
from casa_assets.articulate.frame import given_frame
from casa_assets.articulate.fronts.front_hypotheses import find_fronts
from casa_assets.articulate.run.build import load_models
from casa_assets.articulate.segment.fragments import measure_fragments
from casa_assets.articulate.segment.orthographic import FRONT, measure_relief
from casa_assets.articulate.segment.shell_segments import fragment_mesh
from casa_assets.articulate.segment.welded_mesh import WeldedMesh, weld_triangles
from casa_assets.mesh.grid.voxels import boundary, voxelise
from tests.unit.articulate.blocks import Part, box, disc, together


def shell_of(*parts: Part) -> WeldedMesh:
    """The skin of a grid of cubes around solids."""
    return weld_triangles(*boundary(voxelise(*together(*parts)[:2], 112)))


def test_the_skin_of_a_grid_tells_the_edge_of_its_cubes() -> None:
    assert shell_of(box((0, 0, 0), (0.56, 0.3, 0.4))).cell == pytest.approx(0.56 / 112)


def test_knobs_on_the_wall_behind_a_range_are_round_and_one_group() -> None:
    body = [box((0, 0, 0), (0.76, 0.65, 0.9)), box((0, 0.58, 0.9), (0.76, 0.65, 1.1))]
    knobs = [disc((x, 0.555, 1.01), 0.024, 0.03) for x in (0.1, 0.193, 0.555, 0.65)]
    mesh = shell_of(*body, *knobs)
    mesh = mesh.in_frame(given_frame(mesh, (0, 0, 1), (0, -1, 0)))
    controls = find_controls(measure_fragments(mesh, fragment_mesh(mesh).labels), FRONT, [])
    assert [c.is_round for c in controls] == [True] * 4
    assert [len(g.members) for g in group_controls(controls, mesh.cell)] == [4]


def test_knobs_between_slots_stand_out_of_their_ground() -> None:
    strips = [(0.0, 0.10), (0.112, 0.20), (0.212, 0.312)]
    plate = [box((a, 0, 0), (b, 0.03, 0.2)) for a, b in strips]
    body = box((0, 0.03, -0.02), (0.312, 0.3, 0.22))
    rims = [box((0, 0, -0.02), (0.312, 0.03, 0.0)), box((0, 0, 0.2), (0.312, 0.03, 0.22))]
    knobs = [disc((x, -0.02, 0.05), 0.018, 0.02) for x in (0.05, 0.156, 0.262)]
    mesh = weld_triangles(*together(*plate, body, *rims, *knobs)[:2])
    relief = measure_relief(mesh.in_frame(given_frame(mesh, (0, 0, 1), (0, -1, 0))), FRONT)
    width = 0.036 / mesh.diagonal
    assert [b for b in relief.blobs if np.allclose(b.upper - b.lower, width, atol=0.004)] == list(relief.blobs)
    assert len(relief.blobs) == 3


def test_a_drawer_over_doors_is_a_front_by_its_pull_alone() -> None:
    body = [box((0, 0, 0.1), (0.6, 0.55, 0.87)), box((0, 0.06, 0), (0.6, 0.55, 0.1))]
    frames = [box((a, -0.012, 0.1), (a + 0.3, 0, 0.16)) for a in (0.0, 0.3)]
    frames += [box((a, -0.012, 0.68), (a + 0.3, 0, 0.71)) for a in (0.0, 0.3)]
    frames += [box((a, -0.012, 0.1), (a + 0.045, 0, 0.71)) for a in (0.0, 0.255, 0.3, 0.555)]
    drawer = box((0, -0.012, 0.71), (0.6, 0, 0.87))
    pulls = [disc((x, -0.037, z), 0.014, 0.025) for x, z in ((0.3, 0.79), (0.275, 0.65), (0.325, 0.65))]
    mesh = shell_of(*body, *frames, drawer, *pulls)
    mesh = mesh.in_frame(given_frame(mesh, (0, 0, 1), (0, -1, 0)))
    forests = load_models().front_forests
    assert forests is not None
    found = find_fronts(mesh, measure_relief(mesh, FRONT), FRONT, forests)
    assert len(found) == 3
    assert found[0][0].columns[0] < 10
    assert found[0][0].rows[1] == found[1][0].rows[0]
