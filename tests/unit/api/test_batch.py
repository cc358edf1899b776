"""`casa.batch`: worlds in MuJoCo itself, resets, robots, and errors where something is missing."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import casa_assets as casa
from casa_assets.checks.scene import engine_sizes
from casa_assets.layouts.run.state_file import digest_of_file, write_states
from tests.unit.addons.batch.small_kitchens import DRIVING, FIRST, FLOATING, REST, folders, states

pytestmark = pytest.mark.content("code", "addons.batch", keep=0)


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return folders(tmp_path_factory.mktemp("scenes"))


def test_a_kitchen_moves_by_the_names_of_its_joints(scenes: list[Path]) -> None:
    batch = casa.batch(scenes, engine="mujoco")
    first = batch.kitchens[0]
    dof = first.model.jnt_dofadr[first.joints["corner__slide"]]
    batch.engine.data[0].qfrc_applied[dof] = -20.0
    before = batch.qpos
    batch.step(250)
    moved = np.abs(batch.qpos - before)
    assert batch.qpos[0, first.address("corner__slide")] < -0.3
    assert moved[1].max() < 1e-3


def test_worlds_are_copies_of_the_kitchens_in_turn_and_a_reset_touches_no_other(scenes: list[Path]) -> None:
    batch = casa.batch(scenes, engine="mujoco", worlds=5)
    assert len(batch) == 5
    assert [batch.kitchens[number].id for number in batch.kitchen_of_world] == ["first", "second"] * 2 + ["first"]
    begun = batch.qpos
    assert begun.shape == (5, batch.kitchens[0].model.nq)
    assert np.array_equal(begun[0], begun[2])
    assert not np.array_equal(begun[0], begun[1])
    for data in batch.engine.data:
        data.qvel[:] = 0.5
    batch.step(20)
    assert batch.engine.data[0].nbuffer < batch.engine.bytes_per_world
    moved = batch.qpos
    batch.reset([1, 3])
    assert np.array_equal(batch.qpos[[1, 3]], begun[[1, 3]])
    assert np.array_equal(batch.qpos[[0, 2, 4]], moved[[0, 2, 4]])
    assert not batch.qvel[[1, 3]].any()


def test_pictures_of_all_kitchens_are_in_each(tmp_path: Path) -> None:
    batch = casa.batch(folders(tmp_path, has_pictures=True), engine="mujoco", textures=True)
    assert set(batch.fields) >= {"geom_matid", "geom_size"}
    first, second = (kitchen.model for kitchen in batch.kitchens)
    assert first.nmat == second.nmat == 4
    assert {first.tex(i).name for i in range(first.ntex)} == {"sky", "oak", "tiles"}


class TestStartStates:
    @pytest.fixture
    def drawn(self, tmp_path: Path) -> Path:
        """The first kitchen with five start states: a plate farther and farther to the left."""
        folder = folders(tmp_path)[0]
        (folder / "scene.xml").write_text(FIRST)
        rows = [([*REST[:2], 0.7 - 0.02 * number, *REST[3:]], ()) for number in range(5)]
        found = states(*rows).model_copy(update={"scene_xml": digest_of_file(folder / "scene.xml")})
        write_states(folder, found)
        return folder

    def test_a_seed_draws_the_same_for_everybody_and_a_world_is_as_its_state_says(self, drawn: Path) -> None:
        batch = casa.batch([drawn], engine="mujoco", worlds=20)
        assert set(batch.states) == {0}
        batch.reset(seed=3)
        assert len(set(batch.states)) > 2
        again = casa.batch([drawn], engine="mujoco", worlds=20)
        again.reset(seed=3)
        assert np.array_equal(again.states, batch.states)
        assert np.array_equal(again.qpos, batch.qpos)
        at = batch.kitchens[0].address("plate__free")
        assert np.allclose(batch.qpos[:, at], 0.7 - 0.02 * batch.states, atol=1e-3)
        assert np.allclose(batch.base[:, 0], batch.states)

    def test_states_of_another_scene_are_refused(self, drawn: Path) -> None:
        (drawn / "scene.xml").write_text(FIRST + " ")
        with pytest.raises(casa.CasaError, match=r"start_states\.npz: the states were drawn for another scene\.xml"):
            casa.batch([drawn], engine="mujoco")


class TestRobot:
    @pytest.mark.parametrize("text", [DRIVING, FLOATING])
    def test_it_is_where_it_parks(self, text: str, scenes: list[Path]) -> None:
        batch = casa.batch(scenes, engine="mujoco", robot=mujoco.MjSpec.from_string(text))
        for model, data in zip(batch.engine.model, batch.engine.data, strict=True):
            drives = 0.1 if text is DRIVING else 0.0
            base = data.body("robot_base")
            assert base.xpos == pytest.approx([1.0, -1.2 + drives, 0.12 if text is DRIVING else 0.11], abs=1e-6)
            assert base.xmat.reshape(3, 3)[:, 0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-6)
            assert data.qpos[-1] == pytest.approx(-0.4)
            assert data.ctrl == pytest.approx([-0.4])
            assert model.actuator("robot_lift").id == 0

    def test_in_a_kitchen_that_is_nowhere_on_disk(self, tmp_path: Path, monkeypatch: Any) -> None:
        """As on the first day: an id, and no folder of scenes."""
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(engine_sizes, "TRIAL_S", 0.1)  # its sizes are measured with one robot and without
        monkeypatch.setattr(engine_sizes, "IN_USE_S", 0.1)
        batch = casa.batch(["one_wall_small__coastal"], engine="mujoco", robot=mujoco.MjSpec.from_string(DRIVING))
        assert batch.kitchens[0].id == "one_wall_small__coastal"
        assert np.abs(batch.base[0, :2]).max() > 0.1, "it parks before a fixture"

    def test_nobody_knows_where_it_parks(self, tmp_path: Path) -> None:
        found = folders(tmp_path)
        (found[1] / "scene.json").unlink()
        with pytest.raises(casa.CasaError, match=r"second/scene\.json: is missing or names no parking place"):
            casa.batch(found, engine="mujoco", robot=mujoco.MjSpec.from_string(DRIVING))
        assert len(casa.batch(found, engine="mujoco")) == 2


def test_no_engine_and_too_few_worlds_are_refused(scenes: list[Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "casa_assets.addons.batch.mujoco_warp_engine", raising=False)
    monkeypatch.setitem(sys.modules, "mujoco_warp", None)
    with pytest.raises(casa.CasaError, match=r"engine mujoco_warp is not installed .*: pip install mujoco-warp"):
        casa.batch(scenes)
    for worlds, kitchens in [(0, scenes), (1, scenes), (0, [])]:
        with pytest.raises(casa.CasaError, match=f"{worlds} worlds of {len(kitchens)} kitchens"):
            casa.batch(kitchens, engine="mujoco", worlds=worlds)
