"""What we write loads without a word in the oldest versions of MuJoCo that we support, and means the same there."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import mujoco
import pytest

from casa_assets.export.mjcf import write
from casa_assets.export.mjcf.scene import kitchen
from casa_assets.model.asset.asset import Asset, Base
from tests.assets import EVERY, microwave, write_to
from tests.scenes import Weight, corner, expected, in_form, put

ROOT = Path(__file__).parents[2]
SCRIPT = Path(__file__).with_name("old_mujoco_load.py")
VERSIONS = ("3.3.1", "3.3.7")
REST_M_S = 2e-5  # what stands on a floor is slower than that

pytestmark = pytest.mark.consumers


def interpreter(version: str) -> Path:
    """That of the environment of a version of MuJoCo; the one that runs this for its own."""
    if version == mujoco.__version__:
        return Path(sys.executable)
    name = f"mujoco{version.replace('.', '')}"
    python = ROOT / os.environ.get(f"CASA_{name.upper()}", f".venv-{name}/bin/python")
    assert python.is_file(), f"{python} is missing; './dev consumers' makes it, or name one with CASA_{name.upper()}"
    return python


def told(version: str, files: Sequence[Path], settle: int = 0, watch: int = 0) -> list[dict[str, Any]]:
    """What old_mujoco_load.py says of each file there; it says nothing else."""
    command = [interpreter(version), SCRIPT, settle, watch, *files]
    done = subprocess.run(list(map(str, command)), check=False, capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert [item["mujoco"] for item in found] == [version] * len(files)
    return found


def free_microwave() -> Asset:
    """Not fixed to anything."""
    return microwave(Base.FREE)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("build", [*EVERY, free_microwave])
def test_loads_in_silence_and_rests(build: Callable[[], Asset], version: str, tmp_path: Path) -> None:
    asset = build()
    folder = write_to(write(asset), tmp_path)
    for item in told(version, [folder / "model.xml", folder / "scene.xml"], settle=1000, watch=1000):
        assert item.get("error") is None
        assert (item["warnings"], item["troubles"]) == ([], 0)
        assert item["masses"] == pytest.approx({link.name: link.inertial.mass for link in asset.links})
        assert item["moved"]["object"] < 1e-4
        assert max(item["outside"].values(), default=0.0) <= 1e-5


@pytest.mark.parametrize("version", [*VERSIONS, mujoco.__version__])
def test_what_ingest_made_stands_still(version: str, samples: Path) -> None:
    """Hulls of real meshes creep or rock where a floor gives them one contact, or contacts that are not level."""
    files = sorted(samples.glob("out/library/*/*/scene.xml"))
    assert len(files) == 11
    for item in told(version, files, settle=1500, watch=1000):
        assert item.get("error") is None
        assert (item["warnings"], item["troubles"]) == ([], 0)
        assert item["moved"]["object"] < 1000 * 0.002 * REST_M_S, item["file"]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("weight", list(Weight))
def test_a_whole_scene_loads_in_silence(weight: Weight, version: str, tmp_path: Path) -> None:
    """A scene is not stepped: things hang in the air there."""
    folder = put(kitchen.write(in_form(corner(), weight)), tmp_path, corner())
    (found,) = told(version, [folder / "scene.xml"])
    assert found.get("error") is None
    assert found["warnings"] == []
    bodies = expected(corner(), "closed")
    if weight is Weight.LIGHT:  # what is fixed may be merged into what it is fixed to, what moves may not
        here = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
        kept = {here.body(i).name for i in range(1, here.nbody)}
        # 3.3.1 merges less.
        assert kept == set(found["bodies"]) if version != "3.3.1" else kept <= set(found["bodies"])
        full = mujoco.MjModel.from_xml_path(
            str(put(kitchen.write(corner()), tmp_path / "full", corner()) / "scene.xml")
        )
        moving = {name for name in bodies if full.body(name).jntnum[0]}
        assert moving
        assert moving <= set(found["bodies"]) <= set(bodies)
    else:
        assert sorted(found["bodies"]) == sorted(bodies)
    assert found["keys"] == ["start", "closed", "open"]
    assert found["parallel_lights"] == ["sun"]
