"""Collision shapes: close to the mesh, open where it is, within the budget; feet; decomposers in their process."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.ingest.collision import collide as stage
from casa_assets.ingest.collision.collide import STRATEGIES, collide
from casa_assets.ingest.collision.decompose import Budget, DecompositionFailed, decompose
from casa_assets.ingest.collision.fit import FOOT_M, CollideParams, FitErrors, fit_reference, measure_fit, on_flat_foot
from casa_assets.ingest.collision.solid_proxy import CELLS, assemble_solid, covers_surface, solid_proxy, without_windows
from casa_assets.ingest.components import SurfaceKind
from casa_assets.ingest.draft import Draft, PlacedShape
from casa_assets.mesh.solid.deviation import distances_outside_hulls
from casa_assets.mesh.solid.primitive import shape_bounds, tessellate
from casa_assets.mesh.solid.solids import Solid, convex_hull, hull_volume, intersection_volume, surface_of, union
from casa_assets.mesh.surface import signed_volume
from casa_assets.mesh.voxels import voxelise
from casa_assets.model.asset.parts import Box, Cylinder, Hull, Mesh, Shape, Sphere
from casa_assets.model.issue import REVIEW_CODE
from casa_assets.model.pose import Pose
from tests.support.mesh.meshes import lathe, some
from tests.support.mesh.raw_models import MUG, category, codes, draft, flipped, joined, moved, turned, volume
from tests.support.mesh.solids import block, box, mesh_of, never, solid, welded

pytestmark = pytest.mark.content("code", "ingest.collision", keep=0)

PARAMS = CollideParams()
BOX = box((0.1, 0.06, 0.04), (0.3, 0.0, 0.2))
CUP = turned(MUG, 16)


def clouds(state: Draft) -> list[Floats]:
    return [tessellate(p.shape, p.pose)[0] for p in state.colliders]


def is_touched(state: Draft, spot: tuple[float, float, float]) -> bool:
    return bool(distances_outside_hulls(np.array([spot]), clouds(state))[0] == 0)


class Fake:
    """A decomposer that fails for some methods and answers for the others."""

    def __init__(self, answers: dict[str, list[Floats]]) -> None:
        self.answers, self.asked = answers, []  # type: ignore[var-annotated]

    def __call__(self, method: str, points: Floats, faces: Ints, budget: Budget) -> list[Floats]:
        self.asked.append(method)
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


BALL = [(float(0.04 * np.sin(t)), float(-0.04 * np.cos(t))) for t in np.linspace(0, np.pi, 40)]
CAN = [(0.0, 0.12), (0.033, 0.12), (0.033, 0.0), (0.0, 0.0)]
DEEP_LID = [(0.0, 0.112), (0.025, 0.112), (0.027, 0.122), (0.033, 0.108), (0.033, 0.006), (0.026, 0.0), (0.0, 0.008)]
APPLE = [(0.0, -0.028), (0.012, -0.034), (0.034, -0.02), (0.04, 0.0), (0.036, 0.02), (0.02, 0.032), (0.0, 0.024)]
TILT = Pose(quaternion=(0.9, 0.2, 0.1, 0.3)).rotation
DISH = mesh_of(block((0.3, 0.2, 0.06), (0.0, 0.0, 0.03)) - block((0.288, 0.188, 0.06), (0.0, 0.0, 0.036)))
EGG = turned([(0.02 * np.sin(t), -0.03 * np.cos(t)) for t in np.linspace(0, np.pi, 30)], 32)
DENTED = mesh_of(block((0.1, 0.06, 0.16), (0.0, 0.0, 0.08)) - block((0.09, 0.002, 0.12), (0.0, 0.03, 0.08)))
OPEN_BOX = Mesh(vertices=BOX.vertices, faces=BOX.faces[2:])


class TestExactShapes:
    @pytest.mark.parametrize(
        ("mesh", "name", "kind", "size", "rel"),
        [
            pytest.param(BOX, "can", Box, (0.04, 0.06, 0.1), 1e-6, id="a box"),
            pytest.param(moved(BOX, matrix=TILT), "can", Box, (0.04, 0.06, 0.1), 1e-6, id="a tilted box"),
            pytest.param(turned(BALL, 64), "orange", Sphere, (0.04,), 5e-3, id="a sphere"),
            pytest.param(turned(CAN, 64), "can", Cylinder, (0.033, 0.12), 5e-3, id="a cylinder"),
            pytest.param(turned(DEEP_LID, 64), "can", Cylinder, (0.033, 0.122), 5e-3, id="a can with a deep lid"),
            pytest.param(DENTED, "boxed_food", Box, (0.06, 0.1, 0.16), 0.02, id="a carton with dented sides"),
            pytest.param(OPEN_BOX, "carton", Box, (0.04, 0.06, 0.1), 1e-6, id="full, no side"),
        ],
    )
    def test_one_shape(self, mesh: Mesh, name: str, kind: type[Shape], size: tuple[float, ...], rel: float) -> None:
        [placed] = collide(draft(mesh), category(name), PARAMS, never).colliders
        assert isinstance(placed.shape, kind)
        lengths = [getattr(placed.shape, name, None) for name in ("radius", "height")]
        sides = sorted(placed.shape.size) if isinstance(placed.shape, Box) else [v for v in lengths if v is not None]
        assert sides == pytest.approx(size, rel=rel)
        if mesh is BOX:
            assert placed.pose.position == pytest.approx((0.3, 0.0, 0.2))

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

    def test_an_apple_is_one_shape_stalk_and_all(self) -> None:
        apple = joined(turned(APPLE, 32), box((0.003, 0.003, 0.02), (0.0, 0.0, 0.032)))
        assert len(collide(draft(apple), category("apple"), PARAMS, never).colliders) == 1


def handled() -> Mesh:
    """The mug with a handle of three bars, grown together."""
    return mesh_of(
        solid(turned(MUG, 48))
        + block((0.035, 0.01, 0.01), (0.054, 0.0, 0.02))
        + block((0.035, 0.01, 0.01), (0.054, 0.0, 0.075))
        + block((0.01, 0.01, 0.065), (0.067, 0.0, 0.0475))
    )


def numbers(state: Draft, mesh: Mesh) -> tuple[float, FitErrors]:
    """Intersection over union with a closed mesh, and the verdict."""
    by = fit_reference(*welded(mesh), solid(mesh), is_open=True)
    whole = some(union([convex_hull(c) for c in clouds(state)]))
    both = intersection_volume(whole, welded(mesh))
    return both / (signed_volume(*whole) + volume(mesh) - both), measure_fit(clouds(state), by, PARAMS)


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
        assert some(found.open_share) >= 0.9
        assert not is_touched(out, (0.052, 0.0, 0.05))  # the hole of the handle
        assert is_touched(out, (0.067, 0.0, 0.05))
        assert collide(draft(handled()), category("mug"), PARAMS, never) == out

    def test_a_bowl_a_pan_and_a_square_dish_keep_theirs(self) -> None:
        bends = np.linspace(0.15, 1.2, 8)
        inner = [(0.07 * np.sin(t), 0.074 - 0.07 * np.cos(t)) for t in bends]
        outer = [(0.074 * np.sin(t), 0.074 - 0.074 * np.cos(t)) for t in bends[::-1]]
        bowl = turned([(0.0, inner[0][1]), *inner, *outer, (0.0, outer[-1][1])], 32)
        pan = mesh_of(
            solid(turned([(0.0, 0.004), (0.115, 0.004), (0.13, 0.05), (0.134, 0.05), (0.118, 0.0), (0.0, 0.0)], 32))
            + block((0.2, 0.025, 0.012), (0.225, 0.0, 0.04))
        )
        for mesh, name in ((bowl, "bowl"), (pan, "pan"), (DISH, "bowl")):
            out = collide(draft(mesh), category(name), PARAMS, never)
            _, found = numbers(out, mesh)
            assert len(out.colliders) <= (12 if mesh is DISH else PARAMS.hull_count)
            assert found.normalized_error <= 1.1
            assert some(found.open_share) >= 0.85


def test_an_angle_is_two_boxes() -> None:
    angle = mesh_of(block((0.1, 0.04, 0.02), (0.05, 0.0, 0.01)) + block((0.02, 0.04, 0.1), (0.01, 0.0, 0.05)))
    out = collide(draft(angle), category("object"), PARAMS, never)
    assert len(out.colliders) <= 3
    assert numbers(out, angle)[0] > 0.97


@pytest.mark.parametrize(
    ("mesh", "kind"),
    [
        (EGG, SurfaceKind.SOLID),
        (CUP, SurfaceKind.WALLED),
        (joined(EGG, flipped(moved(EGG, scale=0.9))), SurfaceKind.DOUBLE),
        (turned([(0.07, 0.05), (0.05, 0.01), (0.0, 0.0)], 48), SurfaceKind.SHEET),
    ],
)
def test_what_kind_of_surface_it_is(mesh: Mesh, kind: SurfaceKind) -> None:
    found = some(solid_proxy(*welded(mesh), is_full=False))
    assert found.kind is kind
    if kind is SurfaceKind.DOUBLE:  # filled before anything else
        assert "made solid on a grid" not in found.message
        assert found.solid.volume() == pytest.approx(volume(EGG), rel=1e-6)
        assert "73% of it was sealed off" in found.message


@pytest.fixture
def decomposers_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """As for a mesh that no exact way does justice to."""
    monkeypatch.setattr(stage, "STRATEGIES", STRATEGIES[-2:])


@pytest.mark.usefixtures("decomposers_only")
class TestLadder:
    @pytest.mark.parametrize(("asked", "notes"), [(["coacd"], []), (["coacd", "vhacd"], ["MSH019"])])
    def test_vhacd_follows_where_coacd_fails(self, asked: list[str], notes: list[str]) -> None:
        fake = Fake({asked[-1]: walls(CUP)})
        out = collide(draft(CUP), category("mug"), PARAMS, fake)
        assert fake.asked == asked
        assert Counter(p.shape.kind for p in out.colliders) == {"hull": 17, "box": 1}, "and the box that it stands on"
        assert not is_touched(out, (0.0, 0.0, 0.05))
        assert codes(out.notes) == notes

    def test_one_hull_is_the_last_resort_and_said(self) -> None:
        out = collide(draft(CUP), category("mug"), PARAMS, Fake({}))
        assert len(out.colliders) == 1
        assert is_touched(out, (0.0, 0.0, 0.05))
        assert {n.code for n in out.notes} == {"MSH019", "MSH020", "REV001"}


def test_a_line_is_refused() -> None:
    line = Mesh(vertices=[[0, 0, 0], [1, 0, 0], [2, 0, 0]], faces=[[0, 1, 2]])
    with pytest.raises(Rejected) as error:
        collide(draft(line), category("object"), PARAMS, never)
    assert error.value.code in ("MSH004", "GEO001")


@pytest.mark.parametrize("full", [False, True])
def test_what_is_made_of_an_open_bottle_ends_where_the_mesh_does(full: bool) -> None:
    points, faces = welded(lathe([(0.03, 0.0), (0.037, 0.0), (0.037, 0.2), (0.014, 0.24), (0.014, 0.3)], 32))
    made = some(solid_proxy(points, faces, full))
    assert (made.solid.volume() > 0.5 * hull_volume(points)) == full
    ends = surface_of(made.solid)[0]
    assert ends.min(axis=0) == pytest.approx(points.min(axis=0), abs=0.003)
    assert (ends.min(axis=0) >= points.min(axis=0) - 1e-6).all()
    assert (ends.max(axis=0) <= points.max(axis=0) + 1e-6).all()


@pytest.mark.parametrize("kind", ["object", "bread_roll"])
def test_a_torn_crate_stays_open(kind: str) -> None:
    """What has room to put things into keeps it: its walls are boxes that do not make one closed surface."""
    size, wall = 0.2, 0.012
    sides = [box((size, size, wall), (0.0, 0.0, wall / 2))]
    for turn in range(4):
        along = (wall, size, 0.1) if turn % 2 else (size, wall, 0.1)
        at = (size - wall) / 2 * (1 if turn < 2 else -1)
        sides.append(box(along, (at, 0.0, 0.05) if turn % 2 else (0.0, at, 0.05)))
    whole = joined(*sides)
    torn = Mesh(vertices=whole.vertices, faces=np.delete(whole.faces, [7, 20], axis=0))
    out = collide(draft(torn), category(kind), PARAMS, never)
    assert not is_touched(out, (0.0, 0.0, 0.06))
    assert is_touched(out, (0.0, 0.0, wall / 2))


def test_a_carton_with_rounded_corners_that_stands_askew() -> None:
    """A primitive whose sides would lie too far from those of the mesh gives way to a hull."""
    askew = Pose(quaternion=(np.cos(np.pi / 8), 0.0, 0.0, np.sin(np.pi / 8)))
    crossed = solid(moved(box((0.156, 0.156, 0.2), (0, 0, 0.1)), matrix=askew.rotation))
    mesh = moved(mesh_of(block((0.16, 0.06, 0.2), (0.0, 0.0, 0.1)) ^ crossed), matrix=askew.rotation)
    points = np.concatenate(clouds(collide(draft(mesh), category("boxed_food"), PARAMS, never)))
    gap = np.abs([points.min(axis=0) - mesh.vertices.min(axis=0), points.max(axis=0) - mesh.vertices.max(axis=0)])
    assert gap.max() <= PARAMS.box_bound(0.2)


def disc(height: float) -> Mesh:
    around = (np.arange(36) + 0.5) * 2 * np.pi / 36
    rim = np.stack([0.03 * np.cos(around), 0.03 * np.sin(around), np.full(36, height)], axis=1)
    return Mesh(vertices=[*rim.tolist(), [0.0, 0.0, height]], faces=[[36, k, (k + 1) % 36] for k in range(36)])


def test_a_wall_with_loose_ends_is_a_full_can() -> None:
    """A can as kits model it: a wall without ends, and two ends that touch it and share no point with it."""
    points, faces = welded(joined(turned([(0.03, 0.1), (0.03, 0.0)], 24), disc(0.1), flipped(disc(0.0))))
    grid = voxelise(points, faces, CELLS)
    found = some(assemble_solid(points, faces, grid))
    assert found.solid.volume() == pytest.approx(np.pi * 0.03**2 * 0.1, rel=0.05)
    assert covers_surface(found.solid, points, faces, grid)
    assert "lids on 1" in found.steps


@pytest.mark.parametrize(("depth", "y", "is_one"), [(0.04, -0.31, True), (0.3, -0.4, False)])
def test_a_fridge_with_a_handle_is_one_hull_only_where_that_is_near(depth: float, y: float, is_one: bool) -> None:
    fridge = joined(box((0.6, 0.6, 1.8), (0.0, 0.0, 0.9)), box((0.02, depth, 0.5), (0.2, y, 1.0)))
    state = collide(draft(fridge), category("refrigerator"), CollideParams())
    # Without the thin box that hulls stand on.
    shapes = [p for p in state.colliders if np.ptp(shape_bounds(p.shape, p.pose)[:, 2]) > 2 * FOOT_M]
    assert (len(shapes) == 1) == is_one


def test_a_thin_bowl_stays_within_the_bound_and_on_its_ground() -> None:
    angles = np.linspace(0.0, np.pi / 2.4, 12)
    outer = [(0.08 * float(np.sin(a)), 0.08 - 0.08 * float(np.cos(a))) for a in angles]
    inner = [(r * 0.985, z * 0.985 + 0.0012) for r, z in outer]
    out = collide(draft(turned([*inner, *outer[::-1]], 64)), category("bowl"), PARAMS, never)
    assert [g.confidence for g in out.guesses if g.subject == "collision"] == [1.0]
    assert len(out.colliders) <= 32
    assert min(float(tessellate(p.shape, p.pose)[0][:, 2].min()) for p in out.colliders) > -1e-6


def test_a_carton_that_bulges_is_one_box_between_its_bulges_and_its_edges() -> None:
    bulges = block((0.108, 0.036, 0.1)) + block((0.06, 0.068, 0.1))
    mesh = mesh_of(block((0.1, 0.06, 0.16)) + bulges)
    [placed] = collide(draft(mesh), category("boxed_food"), PARAMS, never).colliders
    assert isinstance(placed.shape, Box)
    x, y, z = sorted(placed.shape.size)
    assert 0.06 < x < 0.0675
    assert 0.1 < y < 0.1075
    assert z == pytest.approx(0.16, abs=1e-3)
    assert float(tessellate(placed.shape, placed.pose)[0][:, 2].min()) == pytest.approx(-0.08, abs=1e-6)


def test_a_vase_without_a_bottom_stays_open() -> None:
    ring = turned([(0.05, 0.0), (0.08, 0.1), (0.04, 0.2), (0.036, 0.2), (0.076, 0.1), (0.046, 0.0), (0.05, 0.0)], 32)
    out = collide(draft(ring), category("object"), PARAMS, Fake({}))
    assert not [n.message for n in out.notes if n.code == REVIEW_CODE]
    middle = np.array([0.0, 0.0, 0.1])
    boxes = [shape_bounds(p.shape, p.pose) for p in out.colliders]
    assert not any((low < middle).all() and (middle < high).all() for low, high in boxes)


def test_windows_that_no_finger_passes_are_closed() -> None:
    places = np.linspace(-0.15, 0.15, 12).tolist()
    bars = [box((0.3, 0.008, 0.008), (0.0, v, 0.0)) for v in places]
    mesh = joined(*bars, *(box((0.008, 0.3, 0.008), (v, 0.0, 0.0)) for v in places))
    proxy = some(without_windows(mesh.vertices, mesh.faces))
    # A plate with one flat face above has no hole: its volume is that of the box around it.
    assert proxy.solid.volume() > 0.8 * 0.3 * 0.3 * 0.008
    assert proxy.solid.genus() == 0


def hull(points: Floats) -> PlacedShape:
    vertices, faces = convex_hull(points)
    return PlacedShape(shape=Hull(mesh=Mesh(vertices=vertices, faces=faces)))


def prism(sides: int, radius: float, height: float, x: float = 0.0) -> Floats:
    """(2 * sides, 3) corners of an upright prism that stands on z = 0."""
    angles = np.arange(sides) * 2 * np.pi / sides
    ring = np.stack([radius * np.cos(angles) + x, radius * np.sin(angles)], axis=1)
    return np.concatenate([np.column_stack([ring, np.full(sides, z)]) for z in (0.0, height)])


def test_a_turned_foot_gets_a_turned_box() -> None:
    turn = Pose(quaternion=(np.cos(np.pi / 12), 0.0, 0.0, np.sin(np.pi / 12))).rotation
    corners = np.array([(x, y, z) for x in (-0.1, 0.1) for y in (-0.02, 0.02) for z in (0.0, 0.05)]) @ turn.T
    _, box = on_flat_foot([hull(corners)], None)
    assert isinstance(box.shape, Box)
    assert sorted(box.shape.size) == pytest.approx([FOOT_M, 0.04, 0.2], rel=1e-3)
    around = np.array([corners.min(axis=0), corners.max(axis=0)])
    np.testing.assert_allclose(shape_bounds(box.shape, box.pose)[:, :2], around[:, :2], atol=1e-4)


def test_what_has_no_flat_foot_stays_as_it_is(subtests: pytest.Subtests) -> None:
    for shapes in [
        # Legs: what is between them is no foot.
        [hull(prism(8, 0.01, 0.1, x)) for x in (-0.1, 0.1)],
        # An edge, and a tip.
        [hull(np.array([(-0.1, 0, 0), (0.1, 0, 0), (0, 0.05, 0.1), (0, -0.05, 0.1)], dtype=np.float64))],
        [hull(np.concatenate([[(0.0, 0.0, 0.0)], prism(12, 0.05, 0.1)[12:]]))],
        # A box stands by itself.
        [PlacedShape(shape=Box(size=(0.1, 0.1, 0.1)))],
    ]:
        with subtests.test(shapes=shapes):
            solids = [solid(placed.shape.mesh) for placed in shapes if isinstance(placed.shape, Hull)]
            whole = sum(solids, Solid()) if solids else None
            assert on_flat_foot(shapes, whole) == tuple(shapes)


THE_CUP = welded(turned(MUG, 8))
BUDGET = Budget(hulls=8, hull_vertices=32, threshold=0.2)


@pytest.mark.parametrize("method", ["coacd", "vhacd"])
def test_two_runs_give_the_same_hulls_within_the_budget(method: str) -> None:
    first, second = (decompose(method, *THE_CUP, BUDGET) for _ in range(2))
    assert 1 < len(first) <= BUDGET.hulls
    assert all(4 <= len(cloud) <= BUDGET.hull_vertices for cloud in first)
    assert [c.tobytes() for c in first] == [c.tobytes() for c in second]
    cloud = np.concatenate(first)
    size = np.ptp(THE_CUP[0], axis=0).max()
    assert cloud.min(axis=0) == pytest.approx(THE_CUP[0].min(axis=0), abs=0.02 * size)
    assert cloud.max(axis=0) == pytest.approx(THE_CUP[0].max(axis=0), abs=0.02 * size)


BOXES = [box((0.05, 0.4, 0.6), (x, y, z)) for x, y, z in np.random.default_rng(0).random((300, 3)).tolist()]
NOT_FINITE = [np.concatenate([THE_CUP[0][:3], [[0.0, bad, 0.0]], THE_CUP[0][4:]]) for bad in (np.nan, np.inf, -np.inf)]


@pytest.mark.parametrize(
    ("method", "mesh", "budget", "said"),
    [
        pytest.param("vhacd", welded(joined(*BOXES)), Budget(hulls=64, cpu_s=1), "vhacd ended with -", id="time"),
        pytest.param("coacd", THE_CUP, Budget(hulls=8, memory_bytes=1_000_000), "coacd ended with", id="memory"),
        pytest.param("magic", THE_CUP, BUDGET, "KeyError", id="no such method"),
        *(pytest.param("coacd", (p, THE_CUP[1]), BUDGET, "not tried", id="no number") for p in NOT_FINITE),
        pytest.param("vhacd", (np.zeros((4, 3)), np.array([[0, 1, 2]])), BUDGET, "not tried", id="no extent"),
        pytest.param("vhacd", (THE_CUP[0], np.empty((0, 3), dtype=np.int64)), BUDGET, "not tried", id="no faces"),
    ],
)
def test_what_goes_wrong(method: str, mesh: tuple[Floats, Ints], budget: Budget, said: str) -> None:
    with pytest.raises(DecompositionFailed, match=said):
        decompose(method, *mesh, budget)
