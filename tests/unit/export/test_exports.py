"""Exports: a library or a kitchen becomes files whole or not at all; those that fail are told, the others written."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from casa_assets import export
from casa_assets.addons.robocasa import run as robocasa
from casa_assets.addons.robocasa.parts import box_region
from casa_assets.checks.readers.urdf_facts import asset_differences
from casa_assets.errors import BatchFault, CasaError, OutputError
from casa_assets.export import URDF, export_assets, export_scenes
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.run import resolve as resolving
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import resolve
from casa_assets.layouts.run.state_file import digest_of_file, read_states, write_states
from casa_assets.library.entry_files import write_files
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import Placement, Scene
from casa_assets.model.pose import Pose
from casa_assets.runs import engine
from casa_assets.runs.limits import WorkerFailure
from tests.support.asset.assets import rigid_mug
from tests.support.asset.packages import tamper
from tests.support.kitchen.scenes import corner, start_states
from tests.support.library.built_libraries import keep, loose_and_fixed
from tests.support.library.libraries import differences


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return keep(tmp_path_factory.mktemp("library") / "lib", loose_and_fixed())


def test_every_asset_is_there_and_listed_and_the_same_again(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = list(export_assets(URDF, library, out))
    list(export_assets(URDF, library, tmp_path / "again"))
    assert differences(out, tmp_path / "again") == []
    assert sorted(one.id for one in done) == sorted(asset.id for asset in loose_and_fixed())
    assert all(one.total == len(done) for one in done)
    rows = {row["id"]: row for row in json.loads((out / "urdf_export.json").read_text())["assets"]}
    for asset in loose_and_fixed():
        assert asset_differences(out / rows[asset.id]["urdf"], asset) == []
        assert rows[asset.id]["mass_kg"] == pytest.approx(asset.mass)
    assert {path.name for path in out.iterdir()} == {"assets", "urdf_export.json", "README.md", "ATTRIBUTION.md"}
    assert all(asset.id in (out / "ATTRIBUTION.md").read_text() for asset in loose_and_fixed())
    # Checks that all exports share: more of them in tests/unit/addons/test_robocasa_objects.py.
    for source, target, message in (
        (library, tmp_path, "neither empty nor an earlier export"),
        (library, library / "urdf", "one inside the other"),
        (tmp_path, tmp_path / "new", "holds no accepted asset"),
    ):
        with pytest.raises(OutputError, match=message):
            list(export_assets(URDF, source, target))


def test_an_asset_that_reads_back_otherwise_is_refused(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A writer that puts the door elsewhere: that asset is left out, and why is told."""

    def spoil(folder: Path, files: Files) -> None:
        write_files(folder, files)
        for path in folder.glob("microwave*.urdf"):
            tamper(path, ('xyz="-0.24 ', 'xyz="-0.25 '))

    monkeypatch.setattr(export, "write_files", spoil)
    done = list(export_assets(URDF, library, tmp_path / "out"))
    (refused,) = (one for one in done if not one.file)
    assert (refused.id, "bodies/door/position" in refused.message) == ("microwave_0123456789", True)
    assert not (tmp_path / "out" / "assets" / refused.id).exists()


def test_who_made_the_assets_of_kitchens_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = corner()
    monkeypatch.setattr(
        resolving, "build_scene", lambda recipe, _: (resolve(recipe), scene.replace(id=recipe.scene_id))
    )
    monkeypatch.setattr(engine, "run_batch", in_this_process)
    ids = ["l_small__coastal", "l_small__rustic"]
    assert [one.id for one in export_scenes(URDF, ids, tmp_path / "out", 1)] == ids
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["ATTRIBUTION.md", "README.md", "scenes", "urdf_export.json"]
    lines = (tmp_path / "out" / "ATTRIBUTION.md").read_text().splitlines()
    assert all(f"`{name}`" in lines[2] for name in ids)
    told = {line.split("`")[1]: line for line in lines if line.startswith("- ")}
    assert told.keys() == {asset.id for asset in corner().assets}
    assert sum(line.startswith("- ") for line in lines) == len(told)
    for asset in corner().assets:
        assert f"## {asset.provenance.licence}" in lines
        assert asset.provenance.title in told[asset.id]
        assert f"by {asset.provenance.author}" in told[asset.id] or not asset.provenance.author


GOOD, BAD, LOST = (SceneRecipe(plan, "rustic") for plan in ("l_small", "galley", "u_small"))
# Where each form looks up what builds a kitchen.
MODULES = {"urdf": resolving, "glb": resolving, "robocasa": robocasa}


def built(recipe: SceneRecipe, cache: Path, errors: dict[SceneRecipe, Exception]) -> tuple[KitchenRequest, Scene]:
    if recipe in errors:
        raise errors[recipe]
    mug = rigid_mug()
    main = box_region("main", *mug.bounds)
    place = Placement(name="mug", asset=mug.id, pose=Pose())
    return resolve(recipe), Scene(id=recipe.scene_id, assets=(mug.replace(regions=(main,)),), placements=(place,))


def in_this_process(work: Any, recipes: list[SceneRecipe], *_: Any) -> Iterator[tuple[int, Any]]:
    """In place of the worker pool; one job is lost with its worker."""
    for number, recipe in enumerate(recipes):
        yield number, WorkerFailure("signal", "ended by signal 11") if recipe == LOST else work(recipe)


def run(kind: str, recipes: list[SceneRecipe], out: Path) -> list[Any]:
    if kind != "robocasa":
        chosen = export.URDF if kind == "urdf" else export.glb_form()
        return list(export.export_scenes(chosen, [recipe.scene_id for recipe in recipes], out))
    return list(robocasa.export(None, out, recipes=recipes))


@pytest.fixture(params=sorted(MODULES))
def kind(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(engine, "run_batch", in_this_process)
    monkeypatch.setattr(robocasa, "afforded_tasks", lambda *_: ("OpenDrawer",))
    return str(request.param)


def fail_with(kind: str, error: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(MODULES[kind], "build_scene", partial(built, errors={BAD: error}))


def test_one_that_cannot_be_built_does_not_stop_the_others(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fail_with(kind, CasaError("does not fit"), monkeypatch)
    done = {one.id: (one.message, one.is_fault, one.total) for one in run(kind, [BAD, GOOD], tmp_path / "out")}
    assert done == {BAD.scene_id: ("does not fit", False, 2), GOOD.scene_id: ("", False, 2)}
    assert list((tmp_path / "out").glob(f"*/{GOOD.scene_id}*"))
    assert not list((tmp_path / "out").glob(f"*/{BAD.scene_id}*"))


def test_a_fault_of_the_program_is_raised_once_all_are_done(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fail_with(kind, KeyError("a bug"), monkeypatch)
    with pytest.raises(BatchFault) as fault:
        run(kind, [BAD, LOST, GOOD], tmp_path / "out")
    assert fault.value.items == (BAD.scene_id, LOST.scene_id)
    assert all(part in fault.value.traces for part in ("a bug", "signal 11"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["robocasa"], indirect=True)
def test_start_states_of_a_scene_are_beside_its_kitchen(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robocasa, "build_scene", partial(built, errors={}))
    monkeypatch.setattr(robocasa, "is_whole", lambda *_: True)
    monkeypatch.setattr(robocasa, "scene_key", lambda recipe: recipe.scene_id)
    folder = tmp_path / "scenes" / GOOD.scene_id
    folder.mkdir(parents=True)
    (folder / "scene.xml").write_text("<mujoco/>", encoding="ascii")
    joints = [{"name": "mug__free", "address": 0, "width": 7}]
    digest = digest_of_file(folder / "scene.xml")
    write_states(folder, start_states(GOOD.scene_id, joints, [[0, 0, 1, 1, 0, 0, 0]] * 2, scene_xml=digest))
    (result,) = robocasa.export(None, tmp_path / "out", recipes=[GOOD], states=tmp_path / "scenes")
    assert result.message == ""
    found = read_states(tmp_path / "out" / "kitchens" / GOOD.scene_id)
    assert ([joint.name for joint in found.joints], len(found)) == (["the_mug_joint0"], 2)
