"""Every code block of README.md and docs/, run page by page in a fresh folder, as a reader would."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Usd, UsdGeom

from tests.documents import ROOT, Block, blocks, pages

pytestmark = pytest.mark.consumers
RUN = [p for p in pages() if any(b.language in ("sh", "python") and not b.reason for b in blocks(p))]
# What the pages after README.md take for granted: the sample meshes as a library.
LIBRARY = "casa-assets ingest examples/meshes --out out/library"


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the examples, and the library of them in `out`."""
    place = _fresh(tmp_path_factory.mktemp("library"))
    assert _shell(LIBRARY, place).returncode == 1  # one sample is broken on purpose
    return place


def _fresh(place: Path) -> Path:
    shutil.copytree(ROOT / "examples", place / "examples")
    return place


@pytest.mark.parametrize("page", RUN)
def test_page(page: str, tmp_path: Path, library: Path) -> None:
    place = _fresh(tmp_path)
    if page != "README.md":
        shutil.copytree(library / "out", place / "out")
    before = {p.name for p in place.iterdir()}
    for block in blocks(page):
        if block.reason:
            continue
        if block.language == "python":
            _python(block, place)
        elif block.language == "sh":
            _lines(block, place)
    assert {p.name for p in place.iterdir()} - before <= {"out", "script.py"}
    if page == "README.md":
        _stands_upright(place / "out" / "table.usda")


def _lines(block: Block, place: Path) -> None:
    """Each command by itself; its comment says so where it ends with another code than 0."""
    for line in block.code.replace("\\\n", " ").splitlines():
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        done = _shell(line, place)
        expected = 1 if "# exit 1" in line else 0
        assert done.returncode == expected, f"{block}: {line}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"


def _shell(line: str, place: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["bash", "-c", line], cwd=place, env=_env(place), capture_output=True, text=True, check=False)


def _python(block: Block, place: Path) -> None:
    script = place / "script.py"
    script.write_text(block.code, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(script)], cwd=place, env=_env(place), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{block}\n{done.stderr[-3000:]}"


def _env(place: Path) -> dict[str, str]:
    """The program of this checkout, and a cache of its own beside the folder."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT), "CASA_ASSETS_CACHE": f"{place}-cache"}


def _stands_upright(path: Path) -> None:
    """The mug of README's USD stage stands on 0.9 m and has the size that its certificate states."""
    stage = Usd.Stage.Open(str(path))
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert str(stage.GetDefaultPrim().GetPath()) == "/World"
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.default_, UsdGeom.Tokens.render])
    box = cache.ComputeWorldBound(stage.GetPrimAtPath("/World/mug")).ComputeAlignedRange()
    size = [box.GetMax()[i] - box.GetMin()[i] for i in range(3)]
    assert abs(box.GetMin()[2] - 0.9) < 1e-3
    (certificate,) = (path.parent / "library" / "mug").glob("*/asset.json")
    stated = json.loads(certificate.read_text(encoding="utf-8"))["certificate"]["summary"]["extents"]
    assert size == pytest.approx(stated, abs=1e-3)
    assert 0.09 < size[2] < 0.11  # 97 mm high: upright, and in metres
