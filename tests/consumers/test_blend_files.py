"""`.blend` files through Blender: unit, axis and packed pictures are kept; nothing of the file runs or is fetched."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from casa_assets.core.system import BLENDER_VARIABLE
from casa_assets.errors import Rejected
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Up
from tests.support.mesh.mesh_files import QUARTERS, codes_of, load_path, png
from tests.support.program.environments import printed, python_of

pytestmark = pytest.mark.consumers


@pytest.fixture(scope="module")
def blends(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("blends")
    (folder / "outside").mkdir()
    (folder / "outside" / "secret.png").write_bytes(png(QUARTERS))
    (folder / "in").mkdir()
    printed("blender", "make_blends.py", folder / "in", folder / "outside" / "secret.png", folder / "canary")
    return folder


@pytest.fixture(autouse=True)
def blender(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(BLENDER_VARIABLE, str(python_of("blender")))


def test_a_blend_is_read_with_its_unit_axis_and_packed_picture(blends: Path) -> None:
    model = load_path(blends / "in" / "sound.blend")
    assert model.up is Up.Z
    assert model.metres_per_unit == pytest.approx(0.01)
    points = model.parts[0].mesh.vertices
    assert np.allclose(points.min(axis=0), (-5, -5, 15), atol=1e-5)
    assert np.allclose(points.max(axis=0), (5, 5, 25), atol=1e-5)
    assert model.parts[0].material.base_color_texture is not None


def test_nothing_of_a_blend_is_run_and_no_picture_of_the_machine_is_taken_in(blends: Path) -> None:
    model = load_path(blends / "in" / "hostile.blend")
    assert not (blends / "canary").exists()
    assert model.parts[0].material.base_color_texture is None
    assert codes.FEATURE_IGNORED in codes_of(model)


def test_a_broken_blend_is_rejected(blends: Path) -> None:
    data = (blends / "in" / "hostile.blend").read_bytes()
    for name, broken in (("cut", data[: len(data) // 2]), ("noise", data[:12] + b"\xff" * 5000)):
        (blends / "in" / f"{name}.blend").write_bytes(broken)
        with pytest.raises(Rejected) as error:
            load_path(blends / "in" / f"{name}.blend")
        assert error.value.code in (codes.BLENDER_FAILED, codes.NO_GEOMETRY)
