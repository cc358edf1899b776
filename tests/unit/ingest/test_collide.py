"""Collision shapes: exact ones where there are such, openings that stay open, and the ladder of decomposers."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.errors import Rejected
from casa_assets.geometry.coverage import gaps
from casa_assets.geometry.hull import hull_volume
from casa_assets.geometry.tessellate import surface
from casa_assets.ingest.collide import CollideParams, collide
from casa_assets.ingest.decompose import Budget, DecompositionFailed, Floats, Ints
from casa_assets.ingest.draft import Draft
from casa_assets.model.mesh import Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.shape import Box, Cylinder, Hull, Sphere
from tests.meshes import box_mesh
from tests.raw_models import MUG, category, codes, draft, joined, moved, turned, volume

PARAMS = CollideParams()
BOX = box_mesh((0.1, 0.06, 0.04), (0.3, 0.0, 0.2), shared=True)
CUP = turned(MUG, 16)


def clouds(state: Draft) -> list[Floats]:
    return [surface(p.shape, p.pose)[0] for p in state.colliders]


def is_touched(state: Draft, spot: tuple[float, float, float]) -> bool:
    return bool(gaps(np.array([spot]), clouds(state))[0] == 0)


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


class TestOpenings:
    def test_a_mug_keeps_its_opening(self) -> None:
        out = collide(draft(CUP), category("mug"), PARAMS)
        for height in (0.02, 0.05, 0.09):
            assert not is_touched(out, (0.0, 0.0, height))
        assert is_touched(out, (0.0, 0.0, 0.003))
        assert is_touched(out, (0.038 * np.cos(0.2), 0.038 * np.sin(0.2), 0.05))
        assert len(out.colliders) <= PARAMS.hull_count
        assert codes(out.notes) == []
        [guess] = [g for g in out.guesses if g.subject == "collision"]
        share = volume(CUP) / hull_volume(CUP.vertices)
        assert f"fills {share:.0%} of its hull" in guess.because

    def test_an_open_carton_that_is_known_to_be_full_is_one_box(self) -> None:
        open_box = Mesh(vertices=BOX.vertices, faces=BOX.faces[2:])
        [placed] = collide(draft(open_box), category("carton"), PARAMS, never).colliders
        assert isinstance(placed.shape, Box)


class TestLadder:
    def test_coacd_is_asked_first_and_its_answer_taken(self) -> None:
        fake = Fake({"coacd": walls(CUP)})
        out = collide(draft(CUP), category("mug"), PARAMS, fake)
        assert fake.asked == ["coacd"]
        assert len(out.colliders) == 17
        assert not is_touched(out, (0.0, 0.0, 0.05))
        assert out.notes == ()

    def test_vhacd_follows_where_coacd_fails(self) -> None:
        fake = Fake({"vhacd": walls(CUP)})
        out = collide(draft(CUP), category("mug"), PARAMS, fake)
        assert fake.asked[:2] == ["coacd", "vhacd"]
        assert not is_touched(out, (0.0, 0.0, 0.05))
        assert codes(out.notes) == ["MSH019"]

    def test_soup_goes_to_vhacd_at_once(self) -> None:
        torn = Mesh(vertices=CUP.vertices, faces=CUP.faces[3:])
        fake = Fake({"vhacd": walls(CUP)})
        collide(draft(torn), category("mug"), PARAMS, fake)
        assert set(fake.asked) == {"vhacd"}

    def test_one_hull_is_the_last_resort_and_said(self) -> None:
        out = collide(draft(CUP), category("mug"), PARAMS, Fake({}))
        assert len(out.colliders) == 1
        assert is_touched(out, (0.0, 0.0, 0.05))
        assert {n.code for n in out.notes} == {"MSH019", "MSH020"}

    def test_an_answer_that_covers_little_is_not_taken(self) -> None:
        crumb = walls(CUP)[:1]
        out = collide(draft(CUP), category("mug"), PARAMS, Fake({"coacd": crumb, "vhacd": crumb}))
        assert len(out.colliders) == 1
        assert codes(out.notes) == ["MSH020"]

    def test_an_answer_of_too_many_hulls_is_not_taken(self) -> None:
        many = walls(CUP) * 3
        out = collide(draft(CUP), category("mug"), PARAMS, Fake({"coacd": many, "vhacd": many}))
        assert len(out.colliders) == 1

    def test_flat_and_splintered_hulls_are_left_out(self) -> None:
        flat = np.column_stack([np.random.default_rng(0).random((9, 2)) * 0.05, np.full(9, 0.05)])
        splinter = np.concatenate([flat, flat + np.array([0, 0, 1e-7])])
        fake = Fake({"coacd": [*walls(CUP), flat, splinter, flat[:2]]})
        assert len(collide(draft(CUP), category("mug"), PARAMS, fake).colliders) == 17

    def test_hulls_are_brought_down_to_the_budget_of_vertices(self) -> None:
        ball = np.random.default_rng(0).normal(size=(800, 3))
        ball = ball / np.linalg.norm(ball, axis=1)[:, None] * [0.05, 0.02, 0.01] + [0, 0, 0.05]
        params = PARAMS.replace(hull_vertices=32)
        out = collide(draft(CUP), category("mug"), params, Fake({"coacd": [*walls(CUP), ball]}))
        assert all(len(p.shape.mesh.vertices) <= 32 for p in out.colliders if isinstance(p.shape, Hull))

    def test_the_budget_is_handed_on(self) -> None:
        fake = Fake({"coacd": walls(CUP)})
        collide(draft(CUP), category("mug"), PARAMS.replace(hull_count=20, hull_vertices=40), fake)
        assert (fake.budgets[0].hulls, fake.budgets[0].hull_vertices) == (20, 40)


def test_hundreds_of_pieces_are_not_measured_one_by_one() -> None:
    draw = np.random.default_rng(0)
    crumbs = joined(*(moved(BOX, tuple(o), 0.3) for o in draw.random((300, 3)).tolist()))
    fake = Fake({})
    out = collide(draft(crumbs), category("object"), PARAMS, fake)
    assert len(out.colliders) == 1


def test_a_line_is_refused() -> None:
    line = Mesh(vertices=[[0, 0, 0], [1, 0, 0], [2, 0, 0]], faces=[[0, 1, 2]])
    with pytest.raises(Rejected) as error:
        collide(draft(line), category("object"), PARAMS, never)
    assert error.value.code in ("MSH004", "GEO001")
