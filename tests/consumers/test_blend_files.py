"""`.blend` files through Blender: unit, axis and packed pictures are kept; nothing of the file runs or is fetched."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from casa_assets.core.system import BLENDER_VARIABLE
from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.model.source import Up
from tests.libraries import ROOT
from tests.mesh_files import QUARTERS, codes_of, load_path, png

pytestmark = pytest.mark.consumers
PYTHON = ROOT / os.environ.get(BLENDER_VARIABLE, ".venv-blender/bin/python")


@pytest.fixture(scope="module")
def blends(tmp_path_factory: pytest.TempPathFactory) -> Path:
    assert PYTHON.exists(), f"{PYTHON} is missing; run ./dev consumers"
    folder = tmp_path_factory.mktemp("blends")
    (folder / "outside").mkdir()
    (folder / "outside" / "secret.png").write_bytes(png(QUARTERS))
    (folder / "in").mkdir()
    command = [
        PYTHON,
        ROOT / "tests" / "consumers" / "make_blends.py",
        folder / "in",
        folder / "outside" / "secret.png",
    ]
    subprocess.run([*command, folder / "canary"], check=True, capture_output=True)
    return folder


@pytest.fixture(autouse=True)
def blender(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(BLENDER_VARIABLE, str(PYTHON))


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
