"""Evidence for poses and fronts: rain, feet, handles; and things that are handed in the wrong way up."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from casa_assets.errors import Rejected
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.orient import facing, orient, straightened
from casa_assets.ingest.up_axis import (
    UP_ROTATIONS,
    candidates,
    outline_score,
    priors,
    rain_volume,
    rotation_to_z,
    sample_surface,
    smallest_rectangle,
    stance,
)
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import Up, UpAxis, UserOverride
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import BOTTLE, MUG, PLATE, category, draft, joined, knife, moved, turned

pytestmark = pytest.mark.content("code", "ingest.pose", keep=0)

Floats = npt.NDArray[np.float64]

HANDLE = box_mesh((0.03, 0.01, 0.06), (0.055, 0.0, 0.05), shared=True)
CUP = joined(turned(MUG), HANDLE)
# Its rim is far wider than its foot.
BOWL = [(0.0, 0.006), (0.02, 0.006), (0.072, 0.07), (0.075, 0.07), (0.022, 0.0), (0.0, 0.0)]
THINGS = {"mug": CUP, "bottle": turned(BOTTLE), "plate": turned(PLATE), "bowl": turned(BOWL)}


def spin(axis: int, degrees: float) -> Floats:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.eye(3)
    out[i, i], out[i, j], out[j, i], out[j, j] = c, -s, s, c
    return out


def posed(mesh: Mesh, turn: Floats, name: str, up: Up | None = Up.Z) -> Draft:
    return orient(draft(moved(mesh, matrix=turn), up=up, form="glb" if up else "obj"), category(name))


def up_of(before: Mesh, after: Draft) -> Floats:
    """Where the z axis of the mesh went."""
    a, b = before.vertices, after.surface.vertices
    left, _, right = np.linalg.svd((b - b.mean(axis=0)).T @ (a - a.mean(axis=0)))
    flip = np.diag([1, 1, np.sign(np.linalg.det(left @ right))])
    result: Floats = (left @ flip @ right)[:, 2]
    return result


def test_what_lies_or_stands_on_its_head_is_righted_against_the_files_word(subtests: pytest.Subtests) -> None:
    for turn in [spin(0, 180), spin(0, 90), spin(1, 90), spin(1, -90)]:
        for name in list(THINGS):
            with subtests.test(name=name, turn=turn):
                out = posed(THINGS[name], turn, name)
                assert up_of(THINGS[name], out) == pytest.approx([0, 0, 1], abs=1e-6)


def test_what_somebody_let_fall_is_righted(subtests: pytest.Subtests) -> None:
    for name in list(THINGS):
        with subtests.test(name=name):
            turn = spin(0, 37) @ spin(2, 52) @ spin(1, 20)
            out = posed(THINGS[name], turn, name, up=None)
            assert up_of(THINGS[name], out)[2] > np.cos(np.radians(3))


def test_the_handle_points_to_x(subtests: pytest.Subtests) -> None:
    for degrees in [0, 30, 90, 145, 180, 270]:
        with subtests.test(degrees=degrees):
            out = posed(CUP, spin(2, degrees), "mug")
            handle = out.surface.vertices[-8:].mean(axis=0) - out.surface.vertices[:-8].mean(axis=0)
            assert handle[0] > 0.03
            assert abs(handle[1]) < 0.006
            assert next(g for g in out.guesses if g.subject == "front").confidence > 0.6


def test_without_a_handle_nothing_is_turned_and_nobody_is_sure() -> None:
    found = facing(
        sample_surface(turned(MUG).vertices, turned(MUG).faces).samples, category("mug"), is_front_stated=True
    )
    assert found.angle == 0
    assert found.confidence < 0.5


def test_a_knife_lies_along_x(subtests: pytest.Subtests) -> None:
    for degrees in [0, 20, 90, 130]:
        with subtests.test(degrees=degrees):
            x, y, z = np.ptp(posed(knife(), spin(2, degrees), "knife").surface.vertices, axis=0)
            assert x > 0.3
            assert y < 0.04
            assert z < y


def test_the_wide_side_of_a_box_is_its_face() -> None:
    box = box_mesh((0.06, 0.19, 0.3), (0, 0, 0), shared=True)
    x, y, z = np.ptp(posed(box, np.eye(3), "cereal", up=None).surface.vertices, axis=0)
    assert (x, y, z) == pytest.approx((0.19, 0.06, 0.3))


def test_a_ruling_is_obeyed_exactly() -> None:
    given = draft(moved(CUP, matrix=spin(0, 180)), up=Up.Z, form="glb")
    out = orient(given, category("mug"), override=UserOverride(up=UpAxis.Z, turn_deg=90))
    assert out.surface.vertices == pytest.approx(moved(CUP, matrix=spin(2, 90) @ spin(0, 180)).vertices)
    assert [g.confidence for g in out.guesses] == [1.0, 1.0]


def test_what_nobody_knows_rests_on_a_side_that_it_can_rest_on() -> None:
    brick = box_mesh((0.05, 0.08, 0.1), (0, 0, 0), shared=True)
    out = orient(draft(moved(brick, matrix=spin(0, 35)), up=None, form="obj"), category("object"))
    height = np.ptp(out.surface.vertices, axis=0)[2]
    assert np.isclose(height, [0.05, 0.08, 0.1], atol=1e-6).any()


def test_a_body_alike_on_all_sides_is_not_sure() -> None:
    out = orient(draft(box_mesh((0.1, 0.1, 0.1), (0, 0, 0), True), up=None, form="unknown"), category("object"))
    assert next(g for g in out.guesses if g.subject == "up_axis").confidence < 0.5


def test_a_sheet_is_refused() -> None:
    flat = Mesh(vertices=[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], faces=[[0, 1, 2], [0, 2, 3]])
    with pytest.raises(Rejected) as error:
        orient(draft(flat), category("plate"))
    assert error.value.code == "MSH002"


class TestRain:
    def test_a_mug_holds_what_it_should_and_nothing_upside_down(self) -> None:
        samples = sample_surface(CUP.vertices, CUP.faces).samples
        unit = float(np.ptp(CUP.vertices, axis=0).max()) ** 3
        room = np.pi * 0.036**2 * 0.089
        assert rain_volume(samples) * unit == pytest.approx(room, rel=0.2)
        assert rain_volume(samples * [1, 1, -1]) * unit < 0.05 * room

    def test_a_block_holds_nothing(self) -> None:
        block = box_mesh((0.1, 0.2, 0.3), (0, 0, 0), shared=True)
        assert rain_volume(sample_surface(block.vertices, block.faces).samples) < 1e-3

    def test_a_stance_says_where_the_room_and_the_foot_are(self) -> None:
        cloud = sample_surface(THINGS["bottle"].vertices, THINGS["bottle"].faces)
        up, down = (stance(cloud, UP_ROTATIONS[axis], with_rain=True) for axis in ("z", "minus_z"))
        assert (up.foot_area, up.crown_area, up.rain_volume) == pytest.approx(
            (down.crown_area, down.foot_area, down.rain_volume_inverted), rel=0.05, abs=0.01
        )
        assert up.taper > 0.5 > down.taper
        assert up.is_stable
        assert up.center_below_middle > 0.02


class TestCandidates:
    def test_they_are_rotations_and_differ(self) -> None:
        tilted = moved(THINGS["bottle"], matrix=spin(0, 30) @ spin(1, 20))
        found = candidates(sample_surface(tilted.vertices, tilted.faces))
        ups = [turn[2] for _, turn in found]
        for _, turn in found:
            assert turn @ turn.T == pytest.approx(np.eye(3), abs=1e-9)
            assert np.linalg.det(turn) == pytest.approx(1)
        assert max(float(a @ b) for i, a in enumerate(ups) for b in ups[:i]) < np.cos(np.radians(5.9))
        assert max(float(u @ spin(0, 30) @ spin(1, 20) @ [0, 0, 1]) for u in ups) > np.cos(np.radians(1))

    def test_the_axes_keep_their_usual_conversions(self) -> None:
        for turn in UP_ROTATIONS.values():
            assert rotation_to_z(turn[2]) == pytest.approx(turn)

    def test_priors_fall_from_the_stated_axis_to_what_is_no_axis(self) -> None:
        stated, other, askew = priors("declared_y", ["y", "x", "foot_0"])
        assert stated > other > askew


def test_the_smallest_rectangle_is_found() -> None:
    corners = np.array([[1, 0.4], [1, -0.4], [-1, 0.4], [-1, -0.4]]) @ spin(2, 25)[:2, :2].T
    angle, long, wide = smallest_rectangle(corners)
    assert (np.degrees(angle), long, wide) == pytest.approx((25, 2, 0.8))
    assert straightened(np.column_stack([corners, np.zeros(4)])) == pytest.approx(np.radians(-25))


def test_an_outline_fits_best_as_it_usually_is() -> None:
    usual = np.array([side.typical for side in category("bottle").extents])
    assert outline_score(usual, category("bottle")) == pytest.approx(0)
    assert outline_score(usual[[2, 0, 1]], category("bottle")) == -6.0
    assert outline_score(7 * usual[[1, 0, 2]], category("bottle")) == pytest.approx(0)
