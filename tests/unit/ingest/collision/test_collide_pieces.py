"""Solids of surfaces that come in pieces: lids where there is matter behind, walls for sheets, and none in the air."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.core.numeric import Floats, Ints
from casa_assets.ingest.collision.collide import collide
from casa_assets.ingest.collision.components import assemble_solid, covers_surface
from casa_assets.ingest.collision.fit import FOOT_M, CollideParams
from casa_assets.ingest.collision.solid_proxy import CELLS
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.mesh.voxels import Grid, voxelise
from casa_assets.model.asset.parts import Hull, Mesh
from tests.support.mesh.raw_models import category, draft, flipped, joined, moved, turned
from tests.support.mesh.solids import box, welded

BOX = box((0.1, 0.06, 0.04), (0.0, 0.0, 0.02))
SHEET = Mesh(vertices=[[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]], faces=[[0, 1, 2], [0, 2, 3]])
# A can as kits model it: a wall without ends, and two ends that touch it and share no point with it.
WALL = turned([(0.03, 0.1), (0.03, 0.0)], 24)


def disc(height: float) -> Mesh:
    around = (np.arange(36) + 0.5) * 2 * np.pi / 36
    rim = np.stack([0.03 * np.cos(around), 0.03 * np.sin(around), np.full(36, height)], axis=1)
    return Mesh(vertices=[*rim.tolist(), [0.0, 0.0, height]], faces=[[36, k, (k + 1) % 36] for k in range(36)])


def surface(*meshes: Mesh) -> tuple[Floats, Ints, Grid]:
    points, faces = welded(joined(*meshes))
    return points, faces, voxelise(points, faces, CELLS)


def test_a_wall_with_loose_ends_is_a_full_can() -> None:
    points, faces, grid = surface(WALL, disc(0.1), flipped(disc(0.0)))
    found = assemble_solid(points, faces, grid)
    assert found is not None
    assert found.solid.volume() == pytest.approx(np.pi * 0.03**2 * 0.1, rel=0.05)
    assert covers_surface(found.solid, points, faces, grid)
    assert "lids on 1" in found.steps


def test_a_whisk_of_flat_wires_is_no_solid_lump() -> None:
    handle = box((0.02, 0.02, 0.1), (0.0, 0.0, 0.05))
    wire = moved(SHEET, (0.0, -0.002, 0.0), matrix=np.diag([0.4, 0.04, 1.0]))
    upright = np.eye(3)[::-1]
    turned_ = [moved(wire, (0.0, 0.0, 0.1 + 0.03 * k), matrix=upright) for k in range(2)]
    out = collide(draft(handle, *(joined(w, flipped(w)) for w in turned_)), category("whisk"), CollideParams())
    assert len(out.colliders) > 1
    assert all(np.ptp(p.shape.mesh.vertices, axis=0).min() > 5e-4 for p in out.colliders if isinstance(p.shape, Hull))


@pytest.mark.parametrize(("depth", "y", "is_one"), [(0.04, -0.31, True), (0.3, -0.4, False)])
def test_a_fridge_with_a_handle_is_one_hull_only_where_that_is_near(depth: float, y: float, is_one: bool) -> None:
    fridge = joined(box((0.6, 0.6, 1.8), (0.0, 0.0, 0.9)), box((0.02, depth, 0.5), (0.2, y, 1.0)))
    state = collide(draft(fridge), category("refrigerator"), CollideParams())
    # Without the thin box that hulls stand on.
    shapes = [p for p in state.colliders if np.ptp(shape_bounds(p.shape, p.pose)[:, 2]) > 2 * FOOT_M]
    assert (len(shapes) == 1) == is_one
