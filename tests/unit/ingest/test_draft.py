"""The surface of a draft: one for as long as the parts stay the same, over vertices and over welded points."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from casa_assets.ingest.draft import Draft, merge_parts
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import MUG, draft, moved, turned

TWO = draft(turned(MUG), box_mesh((0.1, 0.1, 0.1), (0.3, 0.0, 0.0)))


def test_it_is_all_parts_in_their_order_and_welded() -> None:
    surface = TWO.surface
    corners = np.concatenate([p.mesh.vertices[p.mesh.faces] for p in TWO.parts])
    assert np.array_equal(surface.vertices[surface.faces], corners)
    assert np.allclose(surface.points[surface.welded_faces], corners, rtol=0, atol=1e-9)
    assert np.allclose(surface.points[surface.point_of_vertex], surface.vertices, rtol=0, atol=1e-9)
    assert len(surface.points) < len(surface.vertices)


def test_it_stays_while_the_parts_stay() -> None:
    surface = TWO.surface
    assert TWO.replace(notes=()).replace(up="z").surface is surface
    parts = tuple(p.replace(mesh=moved(p.mesh, (1.0, 0.0, 0.0))) for p in TWO.parts)
    after = TWO.replace(parts=parts)
    assert after.surface.points.tobytes() == merge_parts(parts).points.tobytes()
    assert after.surface.points[0, 0] == pytest.approx(surface.points[0, 0] + 1)


def test_nobody_can_change_it() -> None:
    surface = TWO.surface
    for array in (surface.vertices, surface.faces, surface.points, surface.point_of_vertex, surface.welded_faces):
        assert not array.flags.writeable


def test_it_is_no_part_of_what_is_stored() -> None:
    bare = draft(turned(MUG))
    size, text = len(pickle.dumps(bare)), bare.to_json()
    assert len(bare.surface.points)
    assert len(pickle.dumps(bare)) == size
    assert bare.to_json() == text
    again = pickle.loads(pickle.dumps(bare))
    assert isinstance(again, Draft)
    assert again == bare
