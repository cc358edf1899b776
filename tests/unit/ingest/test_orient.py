"""Orientation: the file's word, usual poses, what lies or stands on its head, handles and fronts.

Scale: the unit that makes a usual size, and the usual size where no unit does.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from casa_assets.core.numeric import Floats
from casa_assets.errors import Rejected
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.orient import orient
from casa_assets.ingest.scale import UNITS, parse_size_phrases, scale
from casa_assets.ingest.up_axis import UP_ROTATIONS
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.source import Up, UpAxis, UserOverride
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import BOTTLE, MUG, PLATE, category, codes, draft, joined, knife, moved, turned

pytestmark = pytest.mark.content("code", "ingest", keep=0)

HANDLE = box_mesh((0.03, 0.01, 0.06), (0.055, 0.0, 0.05), shared=True)
THINGS = {"mug": joined(turned(MUG), HANDLE), "bottle": turned(BOTTLE), "plate": turned(PLATE), "knife": knife()}


def in_file(mesh: Mesh, axis: str) -> Mesh:
    """What a file in which this axis is up makes of a thing that stands."""
    return moved(mesh, matrix=UP_ROTATIONS[axis].T)


def up_axis(state: Draft) -> str:
    return next(g.value for g in state.guesses if g.subject == "up_axis")


def test_the_front_of_gltf_becomes_the_front_of_an_asset() -> None:
    assert UP_ROTATIONS["y"] @ [0, 0, 1] == pytest.approx([0, -1, 0])
    assert UP_ROTATIONS["y"] @ [1, 0, 0] == pytest.approx([1, 0, 0])


UNSTATED = [
    # A mug, a bottle with the usual axes of files. With x up it takes more than an opening: no exporter writes that.
    *((name, up, None, form, True) for form in ("obj", "ply", "unknown") for up in "yz" for name in ("mug", "bottle")),
    *(("mug", axis, None, "obj", True) for axis in ("minus_y", "minus_z")),
    # The height alone is right from any pose; a knife with x up is none of them.
    *((name, axis, None, "obj", False) for name in ("bottle", "plate") for axis in UP_ROTATIONS),
    *(("knife", axis, None, "obj", False) for axis in UP_ROTATIONS if axis[-1] != "x"),
]
STATED = [(name, axis, Up(axis), "glb", True) for axis in "xyz" for name in THINGS]


def test_usual_things_stand_as_they_should(subtests: pytest.Subtests) -> None:
    for name, axis, stated, form, is_exact in [*UNSTATED, *STATED]:
        with subtests.test(name=name, axis=axis, stated=stated, form=form):
            out, usual = orient(draft(in_file(THINGS[name], axis), up=stated, form=form), category(name)), THINGS[name]
            points = out.surface.vertices
            assert np.ptp(points, axis=0)[2] == pytest.approx(np.ptp(usual.vertices, axis=0)[2])
            if is_exact:
                assert points == pytest.approx(usual.vertices)
                assert up_axis(out) == axis
                assert out.up == "z"


def test_the_origin_tells_which_end_of_a_symmetric_body_is_its_foot(subtests: pytest.Subtests) -> None:
    for axis in ["y", "minus_y", "z"]:
        with subtests.test(axis=axis):
            can = box_mesh((0.066, 0.066, 0.12), (0, 0, 0.06), shared=True)
            out = orient(draft(in_file(can, axis), up=Up.Y, form="glb"), category("can"))
            assert up_axis(out) == axis
            assert out.surface.vertices[:, 2].min() == pytest.approx(0, abs=1e-9)


CUP = THINGS["mug"]
# Its rim is far wider than its foot.
BOWL = [(0.0, 0.006), (0.02, 0.006), (0.072, 0.07), (0.075, 0.07), (0.022, 0.0), (0.0, 0.0)]


def spin(axis: int, degrees: float) -> Floats:
    turn: Floats = Rotation.from_euler("xyz"[axis], degrees, degrees=True).as_matrix()
    return turn


def posed(mesh: Mesh, turn: Floats, name: str, up: Up | None = Up.Z) -> Draft:
    return orient(draft(moved(mesh, matrix=turn), up=up, form="glb" if up else "obj"), category(name))


def test_what_lies_or_stands_on_its_head_is_righted_against_the_files_word(subtests: pytest.Subtests) -> None:
    things = {"mug": CUP, "bottle": THINGS["bottle"], "plate": THINGS["plate"], "bowl": turned(BOWL)}
    for turn, name in product([spin(0, 180), spin(0, 90), spin(1, 90), spin(1, -90)], things):
        with subtests.test(name=name, turn=turn):
            a, b = things[name].vertices, posed(things[name], turn, name).surface.vertices
            found, _ = Rotation.align_vectors(b - b.mean(axis=0), a - a.mean(axis=0))
            assert found.as_matrix()[:, 2] == pytest.approx([0, 0, 1], abs=1e-6)


def test_the_handle_points_to_x(subtests: pytest.Subtests) -> None:
    for degrees in [0, 30, 90, 145, 180, 270]:
        with subtests.test(degrees=degrees):
            out = posed(CUP, spin(2, degrees), "mug")
            handle = out.surface.vertices[-8:].mean(axis=0) - out.surface.vertices[:-8].mean(axis=0)
            assert handle[0] > 0.03
            assert abs(handle[1]) < 0.006
            assert next(g for g in out.guesses if g.subject == "front").confidence > 0.6


def test_a_knife_lies_along_x(subtests: pytest.Subtests) -> None:
    for degrees in [0, 20, 90, 130]:
        with subtests.test(degrees=degrees):
            x, y, z = np.ptp(posed(knife(), spin(2, degrees), "knife").surface.vertices, axis=0)
            assert x > 0.3
            assert y < 0.04
            assert z < y


def test_the_wide_side_with_most_relief_is_the_face() -> None:
    knob = box_mesh((0.02, 0.04, 0.04), (0.04, 0.0, 0.05), shared=True)
    box = joined(box_mesh((0.06, 0.19, 0.3), (0, 0, 0), shared=True), knob)
    vertices = posed(box, np.eye(3), "cereal", up=None).surface.vertices
    assert np.ptp(vertices[:-8], axis=0) == pytest.approx((0.19, 0.06, 0.3))
    assert (vertices[-8:].mean(axis=0) - vertices[:-8].mean(axis=0))[1] == pytest.approx(-0.04)


def test_a_ruling_is_obeyed_exactly() -> None:
    given = draft(moved(CUP, matrix=spin(0, 180)), up=Up.Z, form="glb")
    out = orient(given, category("mug"), override=UserOverride(up=UpAxis.Z, turn_deg=90))
    assert out.surface.vertices == pytest.approx(moved(CUP, matrix=spin(2, 90) @ spin(0, 180)).vertices)
    assert [g.confidence for g in out.guesses] == [1.0, 1.0]


def test_what_nobody_knows_rests_on_a_side_that_it_can_rest_on() -> None:
    brick = box_mesh((0.05, 0.08, 0.1), (0, 0, 0), shared=True)
    out = orient(draft(moved(brick, matrix=spin(0, 35)), up=None, form="obj"), category("object"))
    assert np.isclose(np.ptp(out.surface.vertices, axis=0)[2], [0.05, 0.08, 0.1], atol=1e-6).any()


def test_a_sheet_is_refused() -> None:
    flat = Mesh(vertices=[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], faces=[[0, 1, 2], [0, 2, 3]])
    with pytest.raises(Rejected, match="MSH002"):
        orient(draft(flat), category("plate"))


MUG_SIZE = 0.12
MUG_BOX = box_mesh((MUG_SIZE, 0.08, 0.1), (0, 0, 0.05), shared=True)


def measured(mesh: Mesh, *words: str, unit: float | None = None) -> Draft:
    return scale(draft(mesh, unit=unit), category("mug"), 1.2, list(words), generated=False)


def sized(size: float) -> Mesh:
    """The mug, so many units long."""
    return moved(MUG_BOX, scale=size / MUG_SIZE)


def longest(state: Draft) -> float:
    return float(np.ptp(state.surface.vertices, axis=0).max())


def test_every_unit_is_found_where_the_file_states_none(subtests: pytest.Subtests) -> None:
    for unit, metres in UNITS.items():
        with subtests.test(unit=unit):
            out = measured(moved(MUG_BOX, scale=1 / metres))
            assert longest(out) == pytest.approx(MUG_SIZE)
            assert out.guesses[0].value == f"{metres:g} m per unit ({unit})"
            assert codes(out.notes) == ([] if unit == "metre" else ["MSH014"])


def test_a_stated_unit_that_fits_is_believed(subtests: pytest.Subtests) -> None:
    for stated in [1.0, 0.01, 0.001, 0.0254, 0.3048]:
        with subtests.test(stated=stated):
            out = measured(moved(MUG_BOX, scale=1 / stated), unit=stated)
            assert longest(out) == pytest.approx(MUG_SIZE)
            assert out.notes == ()
            assert out.metres_per_unit == 1.0


def test_a_normalised_model_and_one_of_an_absurd_size_get_the_usual_size(subtests: pytest.Subtests) -> None:
    for size, unit in [(1.0, None), (2.0, None), *((s, 1.0) for s in (1e-12, 1e-6, 3e3, 1e9, 1e15))]:
        with subtests.test(size=size):
            out = measured(sized(size), unit=unit)
            assert longest(out) == pytest.approx(category("mug").longest_m.typical, rel=0.05)
            assert "usual_size" in out.guesses[0].value
            assert unit is None or out.guesses[0].confidence <= 0.85


def test_what_has_no_size_is_refused(subtests: pytest.Subtests) -> None:
    for mesh in [Mesh(vertices=np.zeros((3, 3)), faces=[[0, 1, 2]]), moved(MUG_BOX, scale=1e40)]:
        with subtests.test(mesh=mesh), pytest.raises(Rejected, match="MSH003"):
            measured(mesh, unit=1.0)


def test_words_that_name_a_size(subtests: pytest.Subtests) -> None:
    for text, lengths, volumes, shift in [
        ('Chefmate 8" Frypan', (0.2032,), (), 0.0),
        ("a 10-inch plate", (0.254,), (), 0.0),
        ("bowl, 16,5 cm", (0.165,), (), 0.0),
        ("a large 1.5 l pitcher", (), (0.0015,), 0.8),
        ("cola 330ml", (), (0.00033,), 0.0),
        ("a tiny or maybe big cup", (), (), -1.5),
        ("mug v2 in blue, 3 inches tall", (0.0762,), (), 0.0),
        ("model 2in1, 500 polygons, 12 lions", (), (), 0.0),
    ]:
        with subtests.test(text=text, lengths=lengths, volumes=volumes, shift=shift):
            found = parse_size_phrases([text])
            assert found.lengths == pytest.approx(lengths)
            assert found.volumes == pytest.approx(volumes)
            assert found.shift == shift


def test_a_length_or_a_volume_in_the_words_counts_where_it_makes_a_usual_size(subtests: pytest.Subtests) -> None:
    """A box of 0.12 x 0.08 x 0.1 holds 0.7 of its hull, by our rule for vessels: 0.67 litres."""
    plain = longest(measured(sized(1)))
    for words, size, rel in [
        ("a mug, 9 cm tall", 0.09 * 1.2, 1e-3),
        ("a mug of 672 ml", MUG_SIZE, 0.01),
        ("a mug", plain, 1e-3),
        ("a mug, 3 m", plain, 1e-3),
    ]:
        with subtests.test(words=words, size=size):
            assert longest(measured(sized(1), words)) == pytest.approx(size, rel=rel)
