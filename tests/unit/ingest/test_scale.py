"""Scale: the unit that makes a usual size, and the usual size where no unit does."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.errors import Rejected
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.scale import UNITS, parse_size_phrases, scale
from casa_assets.model.asset.parts import Mesh
from tests.support.mesh.meshes import box_mesh
from tests.support.mesh.raw_models import category, codes, draft, moved

MUG_SIZE = 0.12
MUG = box_mesh((MUG_SIZE, 0.08, 0.1), (0, 0, 0.05), shared=True)


def measured(mesh: Mesh, name: str = "mug", *words: str, unit: float | None = None, generated: bool = False) -> Draft:
    return scale(draft(mesh, unit=unit), category(name), 1.2, list(words), generated=generated)


def sized(size: float) -> Mesh:
    """The mug, so many units long."""
    return moved(MUG, scale=size / MUG_SIZE)


def longest(state: Draft) -> float:
    return float(np.ptp(state.surface.vertices, axis=0).max())


def test_every_unit_is_found_where_the_file_states_none(subtests: pytest.Subtests) -> None:
    for unit in list(UNITS):
        with subtests.test(unit=unit):
            out = measured(moved(MUG, scale=1 / UNITS[unit]))
            assert longest(out) == pytest.approx(MUG_SIZE)
            assert out.guesses[0].value == f"{UNITS[unit]:g} m per unit ({unit})"
            assert codes(out.notes) == ([] if unit == "metre" else ["MSH014"])


def test_a_stated_unit_that_fits_is_believed(subtests: pytest.Subtests) -> None:
    for stated in [1.0, 0.01, 0.001, 0.0254, 0.3048]:
        with subtests.test(stated=stated):
            out = measured(moved(MUG, scale=1 / stated), unit=stated)
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


def test_no_size_is_refused(subtests: pytest.Subtests) -> None:
    for mesh in [Mesh(vertices=np.zeros((3, 3)), faces=[[0, 1, 2]]), moved(MUG, scale=1e40)]:
        with subtests.test(mesh=mesh):
            with pytest.raises(Rejected) as error:
                measured(mesh, unit=1.0)
            assert error.value.code == "MSH003"


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
            assert longest(measured(sized(1), "mug", words)) == pytest.approx(size, rel=rel)
