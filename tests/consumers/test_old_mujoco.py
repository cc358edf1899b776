"""What we write loads without a word in the oldest versions of MuJoCo that we support, and means the same there."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import pytest
from lxml import etree

from casa_assets.formats.mjcf import write
from casa_assets.kitchenware.catalog import GROUPS
from casa_assets.mesh.solid.primitive import shape_bounds
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.parts import Hull
from casa_assets.registry.families import family
from tests.support.asset.assets import EVERY, microwave, write_to
from tests.support.asset.family_members import preset
from tests.support.library.libraries import ran
from tests.support.program.environments import python_of

SCRIPT = Path(__file__).with_name("old_mujoco_load.py")
VERSIONS = ("3.3.1", "3.3.7")
REST_M_S = 2e-5  # what stands on a floor is slower than that
REST_ON_WORKTOP_M = 3e-4  # in 2 s

pytestmark = pytest.mark.consumers


def told(version: str, files: Sequence[Path], settle: int = 0, watch: int = 0) -> list[dict[str, Any]]:
    """What old_mujoco_load.py says of each file there; it says nothing else."""
    is_own = version == mujoco.__version__
    python = Path(sys.executable) if is_own else python_of(f"mujoco{version.replace('.', '')}")
    done = ran(python, SCRIPT, settle, watch, *files, timeout=300)
    assert done.stderr == ""
    found: list[dict[str, Any]] = [json.loads(line) for line in done.stdout.splitlines()]
    assert [item["mujoco"] for item in found] == [version] * len(files)
    return found


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("build", [*EVERY, pytest.param(partial(microwave, Base.FREE), id="free_microwave")])
def test_loads_in_silence_and_rests(build: Callable[[], Asset], version: str, tmp_path: Path) -> None:
    asset = build()
    folder = write_to(write(asset), tmp_path)
    for item in told(version, [folder / "model.xml", folder / "scene.xml"], settle=1000, watch=1000):
        assert (item.get("error"), item["warnings"], item["troubles"]) == (None, [], 0)
        assert item["masses"] == pytest.approx({link.name: link.inertial.mass for link in asset.links})
        assert item["moved"]["object"] < 1e-4
        assert max(item["outside"].values(), default=0.0) <= 1e-5


@pytest.mark.parametrize("version", [*VERSIONS, mujoco.__version__])
def test_what_ingest_made_stands_still(version: str, samples: Path) -> None:
    """Hulls of real meshes creep or rock where a floor gives them one contact, or contacts that are not level."""
    files = sorted(samples.glob("out/library/*/*/scene.xml"))
    assert len(files) == 11
    for item in told(version, files, settle=1500, watch=1000):
        assert (item.get("error"), item["warnings"], item["troubles"]) == (None, [], 0)
        assert item["moved"]["object"] < 1000 * 0.002 * REST_M_S, item["file"]


def on_a_worktop(folder: Path) -> Path:
    """A copy of an asset's scene.xml in which it stands on a box, as in a kitchen and with a kitchen's options."""
    tree = etree.parse(str(folder / "scene.xml"))
    (flag,) = tree.iter("flag")
    flag.attrib.clear()
    flag.set("multiccd", "enable")
    (top,) = (geom for geom in tree.iter("geom") if geom.get("name") == "scene__floor")
    top.attrib.update({"size": "0.5 0.4 0.02", "pos": "2.304 -0.207401 0.9"})
    del top.attrib["margin"]
    (body,) = (body for body in tree.iter("body") if body.get("name") == "object")
    body.set("pos", "2.304 -0.207401 0.9208")
    tree.write(str(folder / "worktop.xml"))
    return folder / "worktop.xml"


def stands_on_a_hull(asset: Asset) -> bool:
    lowest = {c: shape_bounds(c.shape, c.pose)[0, 2] for c in asset.root.colliders}
    foot = min(lowest.values())
    return any(isinstance(c.shape, Hull) for c, low in lowest.items() if low < foot + 0.005)


@pytest.fixture(scope="module")
def worktops(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    root = tmp_path_factory.mktemp("worktops")
    names = [m.name for group in GROUPS.values() for m in group if m.base is Base.FREE]
    loose = {f"{name}__{p}": preset(name, p) for name in names for p in family(name).presets}
    standing = {name: asset for name, asset in loose.items() if stands_on_a_hull(asset)}
    files = [on_a_worktop(write_to(write(asset), root / name)) for name, asset in standing.items()]
    assert len(files) > 30
    return files


@pytest.mark.parametrize("version", VERSIONS)
def test_what_stands_on_a_hull_stands_still_on_a_worktop(version: str, worktops: list[Path]) -> None:
    """3.3 may find one corner where there are four, and then things wander."""
    found = told(version, worktops, settle=500, watch=1000)
    assert [item["file"] for item in found if item["moved"]["object"] > REST_ON_WORKTOP_M] == []
