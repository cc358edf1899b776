"""What `import casa_assets` offers: names, types, what it costs; poses in which assets rest."""

from __future__ import annotations

import math
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import mujoco
import numpy as np
import pytest

import casa_assets as casa
from casa_assets.core.system import cache_dir, max_cache_bytes
from casa_assets.formats import mjcf
from casa_assets.model.asset.parts import Cylinder
from tests.support.asset.assets import rigid_mug, write_to
from tests.support.asset.box_assets import plain_box
from tests.support.library.libraries import ROOT

EVERY_NAME = Path(__file__).with_name("every_name.py")


COMPLETION = "from casa_assets.cli import options as o; o.complete_categories('m'); o.complete_textures('o')"
PLAN_CHECK = """
from casa_assets.layouts.check_plan.check import check_plan
from casa_assets.registry.kitchens import load_style
assert check_plan(open("registry/plans/u_large.yaml").read(), "u_large.yaml", load_style("modern_1")[0]).fits
"""
# What is begun often, and what would take longer to load than it takes itself.
LIGHT = {
    "import casa_assets": "numpy mujoco pydantic typer",
    "import casa_assets.cli.main": "numpy pydantic yaml scipy mujoco PIL pxr",
    f"{COMPLETION}; o.complete_plans('')": "numpy pydantic yaml scipy mujoco casa_assets.registry",
    PLAN_CHECK: "scipy mujoco pxr trimesh casa_assets.families",
}


def test_what_is_begun_often_is_light() -> None:
    for code, heavy in LIGHT.items():
        code = f"import sys\n{code}\nprint({set(heavy.split())} & set(sys.modules))"
        done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
        assert done.stdout == "set()\n", code


def test_every_name_is_there() -> None:
    text = EVERY_NAME.read_text(encoding="utf-8")
    for name in casa.__all__:
        assert not isinstance(getattr(casa, name), ModuleType), name
        assert name in dir(casa)
        assert f"casa.{name}" in text, "in the script whose types are checked"
    with pytest.raises(AttributeError, match="kitchn"):
        casa.kitchn  # noqa: B018  # type: ignore[attr-defined]


EXT = [import_module(f"casa_assets.ext.{path.stem}") for path in (ROOT / "casa_assets/ext").glob("[!_]*.py")]


def test_every_public_name_has_one_path() -> None:
    names = [(package, name) for package in (casa, *EXT) for name in package.__all__ if name != "__version__"]
    assert len({name for _, name in names}) == len(names)
    defined = [value for package, name in names if callable(value := getattr(package, name))]
    assert len({id(value) for value in defined}) == len(defined), "two names of one thing"
    assert set(casa.SOURCES) == set(casa.__all__) - {"__version__"}


@pytest.mark.representatives(1)
@pytest.mark.parametrize("name", ["ingest", "articulate", "families"])
def test_functions_stay_where_folders_have_their_names(name: str) -> None:
    code = f"""
import casa_assets.{name}
import casa_assets.ingest.run, casa_assets.articulate.run, casa_assets.kitchenware.catalog
import casa_assets as casa
from casa_assets import {name}
print(casa.{name}.__name__, {name} is casa.{name}, sys.modules["casa_assets.{name}"].__path__ != [])
"""
    words = [sys.executable, "-c", "import sys" + code]
    told = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    assert told.stdout == f"{name} True True\n"


@pytest.mark.certify
def test_types_are_real(tmp_path: Path) -> None:
    sample = tmp_path / "sample.py"
    sample.write_text(
        """
import casa_assets as casa

for entry in casa.Library("lib"):
    reveal_type(entry.id)
reveal_type(casa.batch(["galley__rustic"], engine="mujoco").engine)
reveal_type(casa.Project("ours").kitchen("galley", "rustic").check())
reveal_type(casa.families()["range"].bounds)
casa.kitchen("galley", seed="1")
casa.load(3)
casa.ingest("mug.obj").asset.id
casa.nothing
""",
        encoding="utf-8",
    )
    words = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", ".mypy_cache", str(sample), str(EVERY_NAME)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    lines = [line.partition("sample.py:")[2] for line in done.stdout.splitlines() if "sample.py:" in line]
    found = [line.split(": ", 1)[1] for line in lines]
    assert EVERY_NAME.name not in done.stdout
    for kind, expected in (
        ("note: Revealed", ('"str"', "MujocoEngine", "Report", "Bounds")),
        ("error", ('"seed"', '"load"', '"None"', "nothing")),
    ):
        mine = [line for line in found if line.startswith(kind)]
        assert [word in line for word, line in zip(expected, mine, strict=True)] == [True] * 4, done.stdout


def test_the_cache_is_where_and_as_large_as_variables_say(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("CASA_ASSETS_CACHE", str(tmp_path / "mine"))
    assert cache_dir() == tmp_path / "mine"
    assert not cache_dir().exists()
    monkeypatch.setenv("CASA_ASSETS_CACHE_GB", "0.5")
    assert max_cache_bytes() == 500_000_000
    for word in ("much", "-1", "nan", "inf"):
        monkeypatch.setenv("CASA_ASSETS_CACHE_GB", word)
        with pytest.raises(casa.CasaError, match="CASA_ASSETS_CACHE_GB"):
            max_cache_bytes()


def test_what_there_is_to_choose_from() -> None:
    assert casa.plans()["galley"].bounds["width"] == casa.Bounds(3.0, 3.6)
    assert casa.families()["microwave"].bounds["width"] == casa.Bounds(0.44, 0.77)
    assert "brick_red_running" in casa.surfaces()["wall"]
    plain = "one_wall_small__coastal"
    assert casa.kitchen(plain, seed=3).id == casa.kitchen(f"{plain}__s3", seed=3).id == f"{plain}__s3"
    assert casa.kitchen(f"{plain}__closed__o40", seed=0).id == f"{plain}__s0__closed__o40"


def test_wrong_words() -> None:
    wall = {"wal": "brick_red_running"}
    for function, words, options, kind, told in [
        (casa.kitchen, ("galley", "rustik"), {}, casa.UnknownId, "rustic"),
        (casa.kitchen, ("galley", "rustic"), {"surfaces": wall}, casa.UnknownId, "wall"),
        (casa.build, ("microwave", "stel"), {}, casa.UnknownId, "steel"),
        (casa.build, ("microwave", "steel"), {"width": 5.0}, casa.CasaError, "width"),
        (casa.build, ("microwave",), {"seed": 3, "width": 5.0}, casa.CasaError, "width"),
        (casa.build, ("microwave", "steel"), {"seed": 3}, casa.CasaError, "seed"),
        (casa.build, ("mug", "red"), {}, casa.CasaError, "objects have no presets"),
        (casa.build, ("microwav",), {}, casa.UnknownId, "microwave"),
        (casa.kitchen, ("one_wall_small__coastal__s3",), {"seed": 4}, casa.CasaError, "has the seed 3"),
        (casa.ingest, ("nowhere.obj",), {}, casa.OutputError, "no such"),
        (casa.load, (".",), {}, casa.OutputError, "neither"),
    ]:
        with pytest.raises(kind, match=told):
            function(*words, **options)


def test_a_box_rests_on_its_six_sides_mostly_on_the_largest() -> None:
    found = casa.stable_poses(plain_box((0.1, 0.2, 0.3)), least=0.0)
    assert len(found) == 6
    assert sum(one.probability for one in found) == pytest.approx(1.0, abs=1e-3)
    lying = [one for one in found if abs(one.pose.rotation[2, 0]) > 0.99]  # x, the shortest side, is up or down
    assert {round(one.probability, 6) for one in lying} == {round(found[0].probability, 6)}
    for one in found:
        corners = one.pose.apply(np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.1, 0.1) for z in (0.0, 0.3)]))
        assert corners[:, 2].min() == pytest.approx(0.0, abs=1e-9)
        assert corners[:, :2].mean(axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)


def test_the_round_side_of_a_can_is_a_few_poses_and_rare_ones_are_left_out() -> None:
    box = plain_box((0.06, 0.06, 0.1))
    (body,) = box.root.colliders
    can = box.replace(links=(box.root.replace(colliders=(body.replace(shape=Cylinder(radius=0.03, height=0.1)),)),))
    ends = [one for one in casa.stable_poses(can, least=0.0) if abs(one.pose.rotation[2, 2]) > 0.99]
    assert len(ends) == 2
    assert len(casa.stable_poses(can, least=0.0)) <= 2 + math.ceil(2 * math.pi / np.radians(10.0))
    assert all(one.probability >= 0.1 for one in casa.stable_poses(can, least=0.1))


def test_a_mug_stays_in_each_of_its_poses(tmp_path: Path) -> None:
    mug = rigid_mug()
    model = mujoco.MjModel.from_xml_path(str(write_to(mjcf.write(mug), tmp_path) / "scene.xml"))
    data = mujoco.MjData(model)
    poses = casa.stable_poses(mug, least=0.1)
    assert poses
    for one in poses:
        mujoco.mj_resetData(model, data)
        data.qpos[:3], data.qpos[3:7] = one.pose.position, one.pose.quaternion
        mujoco.mj_forward(model, data)
        before = data.xmat[model.body("object").id].reshape(3, 3)[2].copy()
        mujoco.mj_step(model, data, nstep=round(2.0 / model.opt.timestep))
        after = data.xmat[model.body("object").id].reshape(3, 3)[2]
        assert math.degrees(math.acos(min(1.0, float(before @ after)))) < 12.0, one
