"""What planes would make of a solid is what they make of it; hollow edges, buried surfaces, holes that touch."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import OpType

from casa_assets.ingest.collision.plane_splits import Plane, concave_edge_planes, edge_graph, split_hull_volume
from casa_assets.mesh.solid.deviation import burial_depths, protrusion, reference_surface, signed_distances
from casa_assets.mesh.solid.solids import Solid, connected_parts, split_by_plane, surface_of, volume_of_hull
from casa_assets.mesh.surface import signed_volume
from casa_assets.mesh.topology import fill_holes, is_closed
from tests.support.mesh.solids import block

UP = np.array([0.0, 0.0, 1.0])


def table() -> Solid:
    top = block((1.0, 0.6, 0.05), (0.0, 0.0, 0.7))
    legs = [block((0.05, 0.05, 0.7), (x, y, 0.35)) for x in (-0.4, 0.4) for y in (-0.2, 0.2)]
    return Solid.batch_boolean([top, *legs], OpType.Add)


ANGLE = block((0.1, 0.1, 0.02), (0.05, 0.05, 0.01)) + block((0.02, 0.1, 0.1), (0.01, 0.05, 0.05))


class TestHullsSize:
    @pytest.mark.parametrize("height", [0.1, 0.4, 0.66])
    def test_legs_below_a_table_are_pieces_of_their_own(self, height: float) -> None:
        size, count = split_hull_volume(edge_graph(*surface_of(table())), Plane(UP, height))
        halves = split_by_plane(table(), UP, height)
        exact = sum(volume_of_hull([p]) for half in halves for p in connected_parts(half, 0.0))
        assert count == 5
        assert size == pytest.approx(exact, rel=1e-6)

    def test_the_two_walls_of_a_pipe_are_one_piece(self) -> None:
        pipe = block((0.1, 0.1, 0.2)) - block((0.08, 0.08, 0.3))
        size, count = split_hull_volume(edge_graph(*surface_of(pipe)), Plane(UP, 0.03))
        assert count == 2
        assert size == pytest.approx(0.1 * 0.1 * 0.2, rel=1e-6)

    def test_a_plane_beside_the_solid_makes_nothing(self) -> None:
        assert split_hull_volume(edge_graph(*surface_of(ANGLE)), Plane(UP, 0.5)) == (np.inf, 1)


class TestHollowPlanes:
    def test_an_angle_parts_along_its_inner_edge(self) -> None:
        found = concave_edge_planes(*surface_of(ANGLE), 8)
        known = sorted((tuple(np.abs(p.normal).round(6).tolist()), round(abs(p.offset), 5)) for p in found)
        assert known == [((0.0, 0.0, 1.0), 0.02), ((1.0, 0.0, 0.0), 0.02)]
        for plane in found:
            size, count = split_hull_volume(edge_graph(*surface_of(ANGLE)), plane)
            assert count == 2
            assert size == pytest.approx(float(ANGLE.volume()), rel=1e-3)

    def test_a_convex_thing_has_none(self) -> None:
        assert concave_edge_planes(*surface_of(block((0.1, 0.2, 0.3))), 8) == []


class TestBuried:
    def test_a_slit_that_a_hull_fills_is_as_deep_as_it_is(self) -> None:
        slit = block((0.1, 0.1, 0.1), (0.0, 0.0, 0.05)) - block((0.004, 0.2, 0.06), (0.0, 0.0, 0.1))
        of = reference_surface(*surface_of(slit))
        cloud = surface_of(block((0.1, 0.1, 0.1), (0.0, 0.0, 0.05)))[0]
        assert burial_depths(cloud, of).max() == pytest.approx(0.03, abs=0.002)
        assert protrusion(cloud, of).max() < 0.003  # the lid over the slit is never far from its rims

    def test_the_hull_of_a_convex_part_buries_and_adds_nothing(self) -> None:
        of = reference_surface(*surface_of(ANGLE))
        planes = concave_edge_planes(*surface_of(ANGLE), 8)
        [level] = [p for p in planes if abs(p.normal[2]) > 0.9]
        cloud = surface_of(split_by_plane(ANGLE, level.normal, level.offset)[0])[0]
        assert burial_depths(cloud, of).max() < 1e-5
        assert protrusion(cloud, of).max() < 1e-5

    def test_what_is_deep_within_is_not_outside(self) -> None:
        of = reference_surface(*surface_of(block((0.2, 0.2, 0.2))), count=300)
        places = np.random.default_rng(1).uniform(-0.09, 0.09, size=(200, 3))
        assert (signed_distances(places, of) < 0).all()


def test_two_holes_that_meet_in_a_point_are_both_closed() -> None:
    points, faces = surface_of(block((0.1, 0.1, 0.1)).refine(8))
    spot = int(np.argmin(np.linalg.norm(points - np.array([0.0, 0.0, 0.05]), axis=1)))
    fan = np.flatnonzero((faces == spot).any(axis=1))
    first = fan[0]
    apart = [f for f in fan if len(set(faces[f]) & set(faces[first])) == 1]
    found = fill_holes(points, np.delete(faces, [first, apart[0]], axis=0), 0.1)
    assert found is not None
    assert is_closed(found[1])
    assert signed_volume(*found) == pytest.approx(1e-3, rel=1e-6)
