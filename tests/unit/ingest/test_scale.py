"""Scale: the unit that makes a usual size, and the usual size where no unit does."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.errors import Rejected
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.scale import UNITS, scale
from casa_assets.model.mesh import Mesh
from tests.meshes import box_mesh
from tests.raw_models import category, codes, draft, moved

MUG_SIZE = 0.12
MUG = box_mesh((MUG_SIZE, 0.08, 0.1), (0, 0, 0.05), shared=True)


def longest(state: Draft) -> float:
    return float(np.ptp(state.soup()[0], axis=0).max())


@pytest.mark.parametrize("unit", list(UNITS))
def test_every_unit_is_found_where_the_file_states_none(unit: str) -> None:
    out = scale(draft(moved(MUG, scale=1 / UNITS[unit]), unit=None), category("mug"), 1.2)
    assert longest(out) == pytest.approx(MUG_SIZE)
    assert out.guesses[0].value == f"{UNITS[unit]:g} m per unit ({unit})"
    assert codes(out.notes) == ([] if unit == "metre" else ["MSH014"])


@pytest.mark.parametrize("stated", [1.0, 0.01, 0.001, 0.0254, 0.3048])
def test_a_stated_unit_that_fits_is_believed(stated: float) -> None:
    out = scale(draft(moved(MUG, scale=1 / stated), unit=stated), category("mug"), 1.2)
    assert longest(out) == pytest.approx(MUG_SIZE)
    assert out.notes == ()
    assert out.metres_per_unit == 1.0


def test_a_stated_metre_that_makes_a_house_of_a_mug_is_not_believed() -> None:
    out = scale(draft(moved(MUG, scale=100), unit=1.0), category("mug"), 1.2)
    assert longest(out) == pytest.approx(MUG_SIZE)
    assert codes(out.notes) == ["MSH014"]


@pytest.mark.parametrize("size", [1.0, 2.0])
def test_a_normalised_model_gets_the_usual_size(size: float) -> None:
    out = scale(draft(moved(MUG, scale=size / MUG_SIZE), unit=None), category("mug"), 1.2)
    assert longest(out) == pytest.approx(category("mug").longest_m.typical)
    assert "usual_size" in out.guesses[0].value


@pytest.mark.parametrize("size", [1e-12, 1e-6, 3e3, 1e9, 1e15])
def test_an_absurd_size_gets_the_usual_one(size: float) -> None:
    out = scale(draft(moved(MUG, scale=size / MUG_SIZE), unit=1.0), category("mug"), 1.2)
    assert longest(out) == pytest.approx(category("mug").longest_m.typical)
    assert out.guesses[0].confidence < 0.75


@pytest.mark.parametrize("name", ["mug", "knife", "object", "refrigerator", "strawberry"])
@pytest.mark.parametrize("size", [1e-3, 0.05, 0.3, 1.0, 7.0, 40.0, 180.0, 2000.0])
def test_the_result_is_within_the_range_of_the_category(name: str, size: float) -> None:
    span = category(name).longest_m
    for unit in (None, 1.0):
        out = scale(draft(moved(MUG, scale=size / MUG_SIZE), unit=unit), category(name), 1.2)
        assert span.low / 1.2001 <= longest(out) <= span.high * 1.2001


def test_all_parts_are_scaled_alike_and_normals_stay() -> None:
    split = moved(box_mesh((12, 8, 10), (0, 0, 5)))
    given = box_mesh((12, 8, 10), (0, 0, 5))
    out = scale(draft(given, moved(split, (1, 0, 0))), category("mug"), 1.2)
    assert out.parts[0].mesh.normals == pytest.approx(given.normals)
    assert out.parts[1].mesh.vertices - out.parts[0].mesh.vertices == pytest.approx(
        np.broadcast_to([0.01, 0, 0], (24, 3)), abs=1e-12
    )


@pytest.mark.parametrize("mesh", [Mesh(vertices=np.zeros((3, 3)), faces=[[0, 1, 2]]), moved(MUG, scale=1e40)])
def test_no_size_is_refused(mesh: Mesh) -> None:
    with pytest.raises(Rejected) as error:
        scale(draft(mesh), category("mug"), 1.2)
    assert error.value.code == "MSH003"
