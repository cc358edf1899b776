"""The surface of a draft: one for as long as the parts stay the same, over vertices and over welded points."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from casa_assets.geometry.mesh.topology import weld
from casa_assets.ingest.draft import Draft, merge_parts
from tests.meshes import box_mesh
from tests.raw_models import MUG, draft, moved, turned

TWO = draft(turned(MUG), box_mesh((0.1, 0.1, 0.1), (0.3, 0.0, 0.0)))


def test_the_parts_follow_one_another() -> None:
    first, second = (p.mesh for p in TWO.parts)
    surface = TWO.surface
    assert surface.vertices.tobytes() == np.concatenate([first.vertices, second.vertices]).tobytes()
    assert np.array_equal(surface.faces, np.concatenate([first.faces, second.faces + len(first.vertices)]))


def test_it_is_welded() -> None:
    surface = TWO.surface
    points, place = weld(surface.vertices)
    assert len(points) < len(surface.vertices)
    assert surface.points.tobytes() == points.tobytes()
    assert np.array_equal(surface.point_of_vertex, place)
    assert np.array_equal(surface.welded_faces, place[surface.faces])


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
