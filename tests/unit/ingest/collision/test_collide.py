"""Collision shapes: exact ones where there are such, openings that stay open, and the ladder of decomposers."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.geometry.mesh.surface import signed_volume
from casa_assets.geometry.mesh.topology import weld
from casa_assets.geometry.solid.deviation import distances_outside_hulls, reference_surface
from casa_assets.geometry.solid.primitive import tessellate
from casa_assets.geometry.solid.solids import (
    convex_hull,
    hull_volume,
    intersection_volume,
    solid_of,
    split_by_plane,
    surface_of,
    union,
)
from casa_assets.ingest.collision import collide as stage
from casa_assets.ingest.collision.collide import collide
from casa_assets.ingest.collision.convex_decomposition import Budget, DecompositionFailed
from casa_assets.ingest.collision.fit import CollideParams, FitErrors, fit_reference, measure_fit
from casa_assets.ingest.collision.plane_splits import ErrorBound
from casa_assets.ingest.collision.plane_splits import merge_within_bound as joined_up
from casa_assets.ingest.collision.solid_proxy import SurfaceKind, solid_proxy
from casa_assets.ingest.collision.strategies import STRATEGIES
from casa_assets.ingest.draft import Draft
from casa_assets.model.asset.parts import Box, Cylinder, Hull, Mesh, Sphere
from casa_assets.model.pose import Pose
from tests.meshes import box_mesh
from tests.raw_models import MUG, category, codes, draft, flipped, joined, moved, turned, volume

pytestmark = pytest.mark.content("code", "ingest.collision", keep=0)

PARAMS = CollideParams()
BOX = box_mesh((0.1, 0.06, 0.04), (0.3, 0.0, 0.2), shared=True)
CUP = turned(MUG, 16)


def clouds(state: Draft) -> list[Floats]:
    return [tessellate(p.shape, p.pose)[0] for p in state.colliders]


def is_touched(state: Draft, spot: tuple[float, float, float]) -> bool:
    return bool(distances_outside_hulls(np.array([spot]), clouds(state))[0] == 0)


def kinds(state: Draft) -> Counter[str]:
    """How many shapes there are of each kind."""
    return Counter(p.shape.kind for p in state.colliders)


def never(method: str, points: Floats, faces: Ints, budget: Budget) -> list[Floats]:
    raise AssertionError(f"{method} was not needed")


class Fake:
    """A decomposer that fails for some methods and answers for the others."""

    def __init__(self, answers: dict[str, list[Floats]]) -> None:
        self.answers, self.asked, self.budgets = answers, [], []  # type: ignore[var-annotated]

    def __call__(self, method: str, points: Floats, faces: Ints, budget: Budget) -> list[Floats]:
        self.asked.append(method)
        self.budgets.append(budget)
        if method not in self.answers:
            raise DecompositionFailed(f"{method} ended with -11: no words")
        return self.answers[method]


def walls(mesh: Mesh, count: int = 16) -> list[Floats]:
    """Hulls of an open cup: its bottom, and its wall in pieces."""
    points = mesh.vertices
    around = np.arctan2(points[:, 1], points[:, 0])
    out = [points[points[:, 2] < 0.01]]
    for k in range(count):
        middle = (2 * k + 1) * np.pi / count - np.pi
        near = np.abs(np.angle(np.exp(1j * (around - middle)))) < np.pi / count + 1e-6
        out.append(points[near & (np.hypot(points[:, 0], points[:, 1]) > 0.03)])
    return out


class TestExactShapes:
    def test_a_box(self) -> None:
        out = collide(draft(BOX), category("can"), PARAMS, never)
        [placed] = out.colliders
        assert isinstance(placed.shape, Box)
        assert sorted(placed.shape.size) == pytest.approx([0.04, 0.06, 0.1])
        assert placed.pose.position == pytest.approx((0.3, 0.0, 0.2))

    def test_a_tilted_box(self) -> None:
        tilt = Pose(quaternion=(0.9, 0.2, 0.1, 0.3))
        out = collide(draft(moved(BOX, matrix=tilt.rotation)), category("can"), PARAMS, never)
        [placed] = out.colliders
        assert isinstance(placed.shape, Box)
        assert sorted(placed.shape.size) == pytest.approx([0.04, 0.06, 0.1])

    def test_a_sphere(self) -> None:
        profile = [(0.04 * np.sin(t), -0.04 * np.cos(t)) for t in np.linspace(0, np.pi, 40)]
        out = collide(draft(turned([(float(r), float(z)) for r, z in profile], 64)), category("orange"), PARAMS, never)
        [placed] = out.colliders
        assert isinstance(placed.shape, Sphere)
        assert placed.shape.radius == pytest.approx(0.04, rel=5e-3)

    def test_a_cylinder(self) -> None:
        can = turned([(0.0, 0.12), (0.033, 0.12), (0.033, 0.0), (0.0, 0.0)], 64)
        out = collide(draft(can), category("can"), PARAMS, never)
        [placed] = out.colliders
        assert isinstance(placed.shape, Cylinder)
        assert (placed.shape.radius, placed.shape.height) == pytest.approx((0.033, 0.12), rel=5e-3)

    def test_a_convex_lump_is_one_hull_of_its_own_points(self) -> None:
        wedge = Mesh(vertices=BOX.vertices[[0, 1, 2, 4]], faces=[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
        wedge = wedge if volume(wedge) > 0 else Mesh(vertices=wedge.vertices, faces=wedge.faces[:, ::-1])
        [placed] = collide(draft(wedge), category("cheese"), PARAMS, never).colliders
        assert isinstance(placed.shape, Hull)
        assert {tuple(p) for p in placed.shape.mesh.vertices} == {tuple(p) for p in wedge.vertices}

    def test_two_boxes_apart_are_two_shapes(self) -> None:
        out = collide(draft(joined(BOX, moved(BOX, (0.0, 0.0, 0.1)))), category("object"), PARAMS, never)
        assert [p.shape.kind for p in out.colliders] == ["box", "box"]
        assert not is_touched(out, (0.3, 0.0, 0.25))

    def test_the_thinnest_sheets_get_a_thickness(self) -> None:
        sheet = Mesh(vertices=[[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]], faces=[[0, 1, 2], [0, 2, 3]])
        out = collide(draft(BOX, moved(sheet, (0.25, 0, 0.3))), category("object"), PARAMS, never)
        assert len(out.colliders) == 2
        thin = clouds(out)[int(np.argmin([np.ptp(c[:, 2]) for c in clouds(out)]))]
        assert np.ptp(thin[:, 2]) == pytest.approx(0.001, rel=0.05)

    def test_an_apple_is_one_shape_stalk_and_all(self) -> None:
        profile = [
            (0.0, -0.028),
            (0.012, -0.034),
            (0.034, -0.02),
            (0.04, 0.0),
            (0.036, 0.02),
            (0.02, 0.032),
            (0.0, 0.024),
        ]
        stalk = box_mesh((0.003, 0.003, 0.02), (0.0, 0.0, 0.032), shared=True)
        out = collide(draft(joined(turned(profile, 32), stalk)), category("apple"), PARAMS, never)
        assert len(out.colliders) == 1

    def test_a_can_with_a_rim_is_one_cylinder(self) -> None:
        can = [(0.0, 0.119), (0.029, 0.119), (0.029, 0.122), (0.033, 0.117), (0.033, 0.004), (0.03, 0.0), (0.0, 0.002)]
        [placed] = collide(draft(turned(can, 64)), category("can"), PARAMS, never).colliders
        assert isinstance(placed.shape, Cylinder)

    def test_a_carton_with_dented_sides_is_one_box(self) -> None:
        box = box_mesh((0.1, 0.06, 0.16), (0.0, 0.0, 0.08), shared=True)
        dent = box_mesh((0.09, 0.002, 0.12), (0.0, 0.03, 0.08), shared=True)
        dented = cut(box, dent)
        [placed] = collide(draft(dented), category("boxed_food"), PARAMS, never).colliders
        assert isinstance(placed.shape, Box)


def cut(mesh: Mesh, away: Mesh) -> Mesh:
    one, other = (solid_of(*welded(m)) for m in (mesh, away))
    assert one is not None
    assert other is not None
    points, faces = surface_of(one - other)
    return Mesh(vertices=points, faces=faces)


def fused(*meshes: Mesh) -> Mesh:
    points, faces = union([welded(m) for m in meshes]) or (None, None)
    return Mesh(vertices=points, faces=faces)


def welded(mesh: Mesh) -> tuple[Floats, Ints]:
    points, place = weld(mesh.vertices)
    return points, place[mesh.faces]


def handled() -> Mesh:
    """The mug with a handle of three bars, grown together."""
    bars = [
        box_mesh((0.035, 0.01, 0.01), (0.054, 0.0, 0.02), shared=True),
        box_mesh((0.035, 0.01, 0.01), (0.054, 0.0, 0.075), shared=True),
        box_mesh((0.01, 0.01, 0.065), (0.067, 0.0, 0.0475), shared=True),
    ]
    return fused(turned(MUG, 48), *bars)


def numbers(state: Draft, mesh: Mesh) -> tuple[float, FitErrors]:
    """Intersection over union with a closed mesh, and the verdict."""
    solid = solid_of(*welded(mesh))
    assert solid is not None
    by = fit_reference(*welded(mesh), solid, is_open=True)
    whole = union([convex_hull(c) for c in clouds(state)])
    assert whole is not None
    both = intersection_volume(whole, welded(mesh))
    size = signed_volume(*whole) + volume(mesh) - both
    return both / size, measure_fit(clouds(state), by, PARAMS)


class TestOpenings:
    def test_a_mug_keeps_its_opening(self) -> None:
        out = collide(draft(CUP), category("mug"), PARAMS, never)
        for height in (0.02, 0.05, 0.09):
            assert not is_touched(out, (0.0, 0.0, height))
        assert is_touched(out, (0.0, 0.0, 0.003))
        assert is_touched(out, (0.038 * np.cos(0.2), 0.038 * np.sin(0.2), 0.05))
        assert len(out.colliders) <= PARAMS.hull_count
        assert codes(out.notes) == []
        [guess] = [g for g in out.guesses if g.subject == "collision"]
        share = volume(CUP) / hull_volume(CUP.vertices)
        assert f"fills {share:.0%} of its hull" in guess.reason
        assert "of the opening is open" in guess.reason
        assert "turns about one axis" in guess.value

    def test_a_mug_with_a_handle_is_close_with_few_hulls_and_the_same_twice(self) -> None:
        mug = handled()
        out = collide(draft(mug), category("mug"), PARAMS, never)
        overlap, found = numbers(out, mug)
        assert len(out.colliders) <= 24
        assert overlap >= 0.85
        assert found.normalized_error <= 1
        assert found.open_share is not None
        assert found.open_share >= 0.9
        assert not is_touched(out, (0.052, 0.0, 0.05))  # the hole of the handle
        assert is_touched(out, (0.067, 0.0, 0.05))
        assert collide(draft(handled()), category("mug"), PARAMS, never) == out

    def test_a_bowl_a_pan_and_a_square_dish_keep_theirs(self) -> None:
        bends = np.linspace(0.15, 1.2, 8)
        inner = [(0.07 * np.sin(t), 0.074 - 0.07 * np.cos(t)) for t in bends]
        outer = [(0.074 * np.sin(t), 0.074 - 0.074 * np.cos(t)) for t in bends[::-1]]
        bowl = turned([(0.0, inner[0][1]), *inner, *outer, (0.0, outer[-1][1])], 32)
        pan = fused(
            turned([(0.0, 0.004), (0.115, 0.004), (0.13, 0.05), (0.134, 0.05), (0.118, 0.0), (0.0, 0.0)], 32),
            box_mesh((0.2, 0.025, 0.012), (0.225, 0.0, 0.04), shared=True),
        )
        dish = cut(
            box_mesh((0.3, 0.2, 0.06), (0.0, 0.0, 0.03), shared=True),
            box_mesh((0.288, 0.188, 0.06), (0.0, 0.0, 0.036), shared=True),
        )
        for mesh, name in ((bowl, "bowl"), (pan, "pan"), (dish, "bowl")):
            out = collide(draft(mesh), category(name), PARAMS, never)
            _, found = numbers(out, mesh)
            assert len(out.colliders) <= PARAMS.hull_count
            assert found.normalized_error <= 1.1
            assert found.open_share is not None
            assert found.open_share >= 0.85

    def test_a_square_dish_takes_few_hulls(self) -> None:
        dish = cut(
            box_mesh((0.3, 0.2, 0.06), (0.0, 0.0, 0.03), shared=True),
            box_mesh((0.288, 0.188, 0.06), (0.0, 0.0, 0.036), shared=True),
        )
        assert len(collide(draft(dish), category("bowl"), PARAMS, never).colliders) <= 12

    def test_a_bowl_that_is_a_sheet_keeps_its_opening(self) -> None:
        sheet = turned([(0.07, 0.05), (0.05, 0.01), (0.04, 0.0), (0.0, 0.0)], 24)
        out = collide(draft(sheet), category("bowl"), PARAMS, Fake({}))
        assert len(out.colliders) > 4
        assert not is_touched(out, (0.0, 0.0, 0.03))
        assert is_touched(out, (0.0, 0.0, 0.0))
        [guess] = [g for g in out.guesses if g.subject == "collision"]
        assert "open sheet" in guess.reason

    def test_a_bowl_with_a_small_hole_is_fixed_first(self) -> None:
        bends = np.linspace(0.0, 1.3, 20)
        inner = [(0.05 * np.sin(t), 0.056 - 0.05 * np.cos(t)) for t in bends]
        bowl = turned([*inner, *((r * 1.12, (z - 0.056) * 1.12 + 0.056) for r, z in inner[::-1])], 48)
        middle = np.abs(bowl.vertices[bowl.faces].mean(axis=1)[:, 2] - 0.008)
        torn = Mesh(vertices=bowl.vertices, faces=np.delete(bowl.faces, int(middle.argmin()), axis=0))
        out = collide(draft(torn), category("bowl"), PARAMS, never)
        assert len(out.colliders) > 4
        assert not is_touched(out, (0.0, 0.0, 0.03))
        [guess] = [g for g in out.guesses if g.subject == "collision"]
        assert "small holes were closed" in guess.reason

    def test_an_open_carton_that_is_known_to_be_full_is_one_box(self) -> None:
        open_box = Mesh(vertices=BOX.vertices, faces=BOX.faces[2:])
        [placed] = collide(draft(open_box), category("carton"), PARAMS, never).colliders
        assert isinstance(placed.shape, Box)


class TestCuts:
    def test_an_angle_is_two_boxes(self) -> None:
        angle = fused(
            box_mesh((0.1, 0.04, 0.02), (0.05, 0.0, 0.01), shared=True),
            box_mesh((0.02, 0.04, 0.1), (0.01, 0.0, 0.05), shared=True),
        )
        out = collide(draft(angle), category("object"), PARAMS, never)
        assert len(out.colliders) <= 3
        assert numbers(out, angle)[0] > 0.97

    def test_parts_that_make_one_shape_are_joined(self) -> None:
        of = reference_surface(*welded(BOX))
        whole = solid_of(*welded(BOX))
        assert whole is not None
        quarters = [
            q
            for half in split_by_plane(whole, np.array([1.0, 0, 0]), 0.3)
            for q in split_by_plane(half, np.eye(3)[1], 0.0)
        ]
        groups = joined_up(quarters, of, ErrorBound(0.002, 0.005), np.zeros((0, 3)))
        assert [len(g) for g in groups] == [4]
        kept = joined_up(quarters, of, ErrorBound(0.002, 0.005), np.array([[0.3, 0.0, 0.2]]))
        assert len(kept) > 1


class TestMatter:
    def kind(self, mesh: Mesh, full: bool = False) -> SurfaceKind:
        found = solid_proxy(*welded(mesh), full)
        assert found is not None
        return found.kind

    def test_what_kind_of_surface_it_is(self) -> None:
        egg = turned([(0.02 * np.sin(t), -0.03 * np.cos(t)) for t in np.linspace(0, np.pi, 30)], 32)
        lining = flipped(moved(egg, scale=0.9))
        assert self.kind(egg) is SurfaceKind.SOLID
        assert self.kind(CUP) is SurfaceKind.WALLED
        assert self.kind(joined(egg, lining)) is SurfaceKind.DOUBLE
        assert self.kind(turned([(0.07, 0.05), (0.05, 0.01), (0.0, 0.0)], 48)) is SurfaceKind.SHEET

    def test_a_double_wall_is_filled_before_anything_else(self) -> None:
        egg = turned([(0.02 * np.sin(t), -0.03 * np.cos(t)) for t in np.linspace(0, np.pi, 30)], 32)
        found = solid_proxy(*welded(joined(egg, flipped(moved(egg, scale=0.9)))), is_full=False)
        assert found is not None
        assert found.is_exact
        assert found.solid.volume() == pytest.approx(volume(egg), rel=1e-6)
        assert "73% of it was sealed off" in found.message

    def test_a_full_thing_that_is_a_leaky_shell_is_filled(self) -> None:
        shell = cut(
            box_mesh((0.1, 0.06, 0.12), (0.0, 0.0, 0.06), shared=True),
            box_mesh((0.09, 0.05, 0.11), (0.0, 0.0, 0.06), shared=True),
        )
        leaky = cut(shell, box_mesh((0.004, 0.004, 0.02), (0.0, 0.0, 0.12), shared=True))
        found = solid_proxy(*welded(leaky), is_full=True)
        assert found is not None
        assert found.solid.volume() == pytest.approx(0.1 * 0.06 * 0.12, rel=0.05)
        open_ = solid_proxy(*welded(leaky), is_full=False)
        assert open_ is not None
        assert open_.solid.volume() == pytest.approx(volume(leaky), rel=1e-6)


@pytest.fixture
def decomposers_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """As for a mesh that no exact way does justice to."""
    monkeypatch.setattr(stage, "STRATEGIES", STRATEGIES[-2:])


@pytest.mark.usefixtures("decomposers_only")
class TestLadder:
    def test_coacd_is_asked_first_and_its_answer_taken(self) -> None:
        fake = Fake({"coacd": walls(CUP)})
        out = collide(draft(CUP), category("mug"), PARAMS, fake)
        assert fake.asked == ["coacd"]
        assert kinds(out) == {"hull": 17, "box": 1}, "and the box that it stands on"
        assert not is_touched(out, (0.0, 0.0, 0.05))
        assert out.notes == ()

    def test_vhacd_follows_where_coacd_fails(self) -> None:
        fake = Fake({"vhacd": walls(CUP)})
        out = collide(draft(CUP), category("mug"), PARAMS, fake)
        assert fake.asked == ["coacd", "vhacd"]
        assert not is_touched(out, (0.0, 0.0, 0.05))
        assert codes(out.notes) == ["MSH019"]

    def test_one_hull_is_the_last_resort_and_said(self) -> None:
        out = collide(draft(CUP), category("mug"), PARAMS, Fake({}))
        assert len(out.colliders) == 1
        assert is_touched(out, (0.0, 0.0, 0.05))
        assert {n.code for n in out.notes} == {"MSH019", "MSH020", "REV001"}

    def test_an_answer_that_covers_little_is_not_taken(self) -> None:
        crumb = walls(CUP)[:1]
        out = collide(draft(CUP), category("mug"), PARAMS, Fake({"coacd": crumb, "vhacd": crumb}))
        assert len(out.colliders) == 1
        assert codes(out.notes) == ["MSH020", "REV001"]

    def test_an_answer_of_too_many_hulls_is_not_taken(self) -> None:
        many = walls(CUP) * 3
        out = collide(draft(CUP), category("mug"), PARAMS, Fake({"coacd": many, "vhacd": many}))
        assert len(out.colliders) == 1

    def test_flat_and_splintered_hulls_are_left_out(self) -> None:
        flat = np.column_stack([np.random.default_rng(0).random((9, 2)) * 0.05, np.full(9, 0.05)])
        splinter = np.concatenate([flat, flat + np.array([0, 0, 1e-7])])
        fake = Fake({"coacd": [*walls(CUP), flat, splinter, flat[:2]]})
        assert kinds(collide(draft(CUP), category("mug"), PARAMS, fake))["hull"] == 17

    def test_hulls_are_brought_down_to_the_budget_of_vertices(self) -> None:
        ball = np.random.default_rng(0).normal(size=(800, 3))
        ball = ball / np.linalg.norm(ball, axis=1)[:, None] * [0.05, 0.02, 0.01] + [0, 0, 0.05]
        params = PARAMS.replace(hull_vertices=32)
        out = collide(draft(CUP), category("mug"), params, Fake({"coacd": [*walls(CUP), ball]}))
        assert all(len(p.shape.mesh.vertices) <= 32 for p in out.colliders if isinstance(p.shape, Hull))

    def test_the_budget_is_handed_on(self) -> None:
        fake = Fake({"coacd": walls(CUP)})
        collide(draft(CUP), category("mug"), PARAMS.replace(hull_count=20, hull_vertices=40), fake)
        assert (fake.budgets[0].hulls, fake.budgets[0].hull_vertices) == (19, 40), "one is kept for a box to stand on"


def test_many_pieces_stay_within_the_budget() -> None:
    draw = np.random.default_rng(0)
    crumbs = joined(*(moved(BOX, tuple(o), 0.3) for o in draw.random((60, 3)).tolist()))
    out = collide(draft(crumbs), category("object"), PARAMS, Fake({}))
    assert 1 <= len(out.colliders) <= PARAMS.hull_count


def test_a_line_is_refused() -> None:
    line = Mesh(vertices=[[0, 0, 0], [1, 0, 0], [2, 0, 0]], faces=[[0, 1, 2]])
    with pytest.raises(Rejected) as error:
        collide(draft(line), category("object"), PARAMS, never)
    assert error.value.code in ("MSH004", "GEO001")


@pytest.mark.parametrize("full", [False, True])
def test_what_is_made_of_an_open_bottle_ends_where_the_mesh_does(full: bool) -> None:
    angles = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    rings = [(0.0, 0.03), (0.0, 0.037), (0.2, 0.037), (0.24, 0.014), (0.3, 0.014)]
    points = np.concatenate(
        [np.stack([r * np.cos(angles), r * np.sin(angles), 0 * angles + z], axis=1) for z, r in rings]
    )
    ids = np.arange(32)
    after = (ids + 1) % 32
    faces = np.concatenate(
        [
            part
            for k in range(4)
            for part in (
                np.stack([32 * k + ids, 32 * k + after, 32 * k + 32 + ids], axis=1),
                np.stack([32 * k + after, 32 * k + 32 + after, 32 * k + 32 + ids], axis=1),
            )
        ]
    )
    made = solid_proxy(points, faces, full)
    assert made is not None
    assert (made.solid.volume() > 0.5 * hull_volume(points)) == full
    ends = surface_of(made.solid)[0]
    assert ends.min(axis=0) == pytest.approx(points.min(axis=0), abs=0.003)
    assert (ends.min(axis=0) >= points.min(axis=0) - 1e-6).all()
    assert (ends.max(axis=0) <= points.max(axis=0) + 1e-6).all()


class TestOpenRooms:
    """What has room to put things into keeps it, whatever it is taken for."""

    @pytest.mark.parametrize("kind", ["object", "bread_roll"])
    def test_a_cup_stays_open(self, kind: str) -> None:
        out = collide(draft(CUP), category(kind), PARAMS, never)
        assert not is_touched(out, (0.0, 0.0, 0.05))
        assert is_touched(out, (0.0, 0.0, 0.003))

    @pytest.mark.parametrize("kind", ["object", "bread_roll"])
    def test_a_torn_crate_stays_open(self, kind: str) -> None:
        """Its walls are boxes that do not make one closed surface."""
        size, wall = 0.2, 0.012
        sides = [box_mesh((size, size, wall), (0.0, 0.0, wall / 2), shared=True)]
        for turn in range(4):
            along = (wall, size, 0.1) if turn % 2 else (size, wall, 0.1)
            at = (size - wall) / 2 * (1 if turn < 2 else -1)
            sides.append(box_mesh(along, (at, 0.0, 0.05) if turn % 2 else (0.0, at, 0.05), shared=True))
        whole = joined(*sides)
        torn = Mesh(vertices=whole.vertices, faces=np.delete(whole.faces, [7, 20], axis=0))
        out = collide(draft(torn), category(kind), PARAMS, never)
        assert not is_touched(out, (0.0, 0.0, 0.06))
        assert is_touched(out, (0.0, 0.0, wall / 2))

    def test_a_missing_lid_of_a_full_carton_is_closed(self) -> None:
        top = (BOX.vertices[BOX.faces][:, :, 2] > BOX.vertices[:, 2].max() - 1e-9).all(axis=1)
        lidless = Mesh(vertices=BOX.vertices, faces=BOX.faces[~top])
        out = collide(draft(lidless), category("boxed_food"), PARAMS, never)
        assert is_touched(out, (0.3, 0.0, 0.2))


class TestBounds:
    """A primitive whose sides would lie too far from those of the mesh gives way to a hull."""

    def test_a_carton_with_rounded_corners_that_stands_askew(self) -> None:
        askew = Pose(quaternion=(np.cos(np.pi / 8), 0.0, 0.0, np.sin(np.pi / 8)))
        block = surface_of(
            solid_of(*welded(box_mesh((0.16, 0.06, 0.2), (0.0, 0.0, 0.1), shared=True)))
            ^ solid_of(*welded(moved(box_mesh((0.156, 0.156, 0.2), (0, 0, 0.1), shared=True), matrix=askew.rotation)))
        )
        mesh = moved(Mesh(vertices=block[0], faces=block[1]), matrix=askew.rotation)
        out = collide(draft(mesh), category("boxed_food"), PARAMS, never)
        points = np.concatenate(clouds(out))
        gap = np.abs([points.min(axis=0) - mesh.vertices.min(axis=0), points.max(axis=0) - mesh.vertices.max(axis=0)])
        assert gap.max() <= PARAMS.box_bound(0.2)
