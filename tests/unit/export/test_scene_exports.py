"""Kitchens that fail while several are exported: each is told, the others are written, and faults end with exit 3."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from casa_assets import export
from casa_assets.addons.robocasa import run as robocasa
from casa_assets.addons.robocasa import run as robocasa_kitchens
from casa_assets.addons.robocasa.writers.kitchens.parts import box_region
from casa_assets.errors import BatchFault, CasaError
from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import resolve
from casa_assets.layouts.run.state_file import digest_of_file, read_states, write_states
from casa_assets.model.kitchen.scene import Placement, Scene, StartStates
from casa_assets.model.pose import Pose
from casa_assets.runs.limits import WorkerFailure
from tests.support.asset.assets import rigid_mug

GOOD, BAD, LOST = (SceneRecipe(plan, "rustic") for plan in ("l_small", "galley", "u_small"))
# Where each form looks up what builds a kitchen.
MODULES = {"urdf": export, "glb": export, "robocasa": robocasa_kitchens}


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
    monkeypatch.setattr(export, "run_batch", in_this_process)
    monkeypatch.setattr(robocasa_kitchens, "afforded_tasks", lambda *_: ("OpenDrawer",))
    return str(request.param)


def fail_with(kind: str, error: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(MODULES[kind], "build_scene", partial(built, errors={BAD: error}))


def test_one_that_cannot_be_built_does_not_stop_the_others(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fail_with(kind, CasaError("does not fit"), monkeypatch)
    done = {one.id: one for one in run(kind, [BAD, GOOD], tmp_path / "out")}
    assert done[BAD.scene_id].message == "does not fit"
    assert not done[BAD.scene_id].is_fault
    assert not done[GOOD.scene_id].message
    assert all(one.total == 2 for one in done.values())
    assert list((tmp_path / "out").glob(f"*/{GOOD.scene_id}*"))
    assert not list((tmp_path / "out").glob(f"*/{BAD.scene_id}*"))


def test_a_fault_of_the_program_is_raised_once_all_are_done(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fail_with(kind, KeyError("a bug"), monkeypatch)
    with pytest.raises(BatchFault) as fault:
        run(kind, [BAD, LOST, GOOD], tmp_path / "out")
    assert fault.value.items == (BAD.scene_id, LOST.scene_id)
    assert "a bug" in fault.value.traces
    assert "signal 11" in fault.value.traces
    assert list(tmp_path.iterdir()) == []


def test_two_kitchens_of_one_number_are_not_written_into_one_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(export, "run_batch", in_this_process)
    monkeypatch.setattr(robocasa_kitchens, "build_scene", partial(built, errors={}))
    monkeypatch.setattr(robocasa_kitchens, "afforded_tasks", lambda *_: ("OpenDrawer",))
    monkeypatch.setattr(robocasa_kitchens.description, "number_of", lambda scene_id: 1_000_000_007)
    first, second = run("robocasa", [GOOD, BAD], tmp_path / "out")
    assert not first.message
    assert f"same number as {GOOD.scene_id}" in second.message
    kept = json.loads((tmp_path / "out" / "kitchens.json").read_text())["kitchens"]
    assert kept == {GOOD.scene_id: 1_000_000_007}


class TestStartStates:
    """`--states`: what was drawn for the scene that is exported goes along, and nothing else."""

    @pytest.fixture(autouse=True)
    def _quick(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(export, "run_batch", in_this_process)
        monkeypatch.setattr(robocasa_kitchens, "afforded_tasks", lambda *_: ("OpenDrawer",))
        monkeypatch.setattr(robocasa_kitchens, "build_scene", partial(built, errors={}))
        monkeypatch.setattr(robocasa_kitchens, "is_whole", lambda *_: True)
        monkeypatch.setattr(robocasa_kitchens, "scene_key", lambda recipe: recipe.scene_id)

    def drawn(self, folder: Path, text: str) -> None:
        """Two states of the kitchen with a mug, drawn for a scene.xml of this text."""
        folder.mkdir(parents=True)
        (folder / "scene.xml").write_text(text, encoding="ascii")
        digest = digest_of_file(folder / "scene.xml")
        joint = {"name": "mug__free", "address": 0, "width": 7}
        states = {
            "key": "k",
            "scene": GOOD.scene_id,
            "scene_xml": digest,
            "mujoco": "4.0.0",
            "seed": 0,
            "limits": (0.001, 0.005),
            "envelope": [],
            "joints": [joint],
            "notes": [{"placed": {}, "parked": "mug"}] * 2,
            "qpos": [[0, 0, 1, 1, 0, 0, 0]] * 2,
            "base": [[0, 0, 0]] * 2,
            "depth": [0, 0],
            "motion": [0, 0],
        }
        write_states(folder, StartStates.model_validate(states))

    def export(self, tmp_path: Path) -> Any:
        recipes, states = [GOOD], tmp_path / "scenes"
        (result,) = robocasa.export(None, tmp_path / "out", recipes=recipes, states=states)
        return result

    def test_they_stand_beside_the_kitchen(self, tmp_path: Path) -> None:
        self.drawn(tmp_path / "scenes" / GOOD.scene_id, "<mujoco/>")
        assert self.export(tmp_path).message == ""
        found = read_states(tmp_path / "out" / "kitchens" / GOOD.scene_id)
        assert [joint.name for joint in found.joints] == ["the_mug_joint0"]
        assert len(found) == 2

    def test_a_kitchen_without_them_is_refused(self, tmp_path: Path) -> None:
        assert "there are no start states" in self.export(tmp_path).message
