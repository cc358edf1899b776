"""The file of start states, its loader, and the verb that draws them for a whole kitchen."""

from __future__ import annotations

import json
import shutil
import warnings
import zipfile
from pathlib import Path

import mujoco
import numpy as np
import pytest
from typer.testing import CliRunner

import casa_assets as casa
from casa_assets.checks.start_states.draw import draw_states
from casa_assets.checks.start_states.stage import Stage
from casa_assets.cli.verbs.scenes import app
from casa_assets.errors import CasaError
from casa_assets.layouts.run import state_file
from casa_assets.layouts.run.pack import members_of
from casa_assets.layouts.run.recipe import SceneResult
from casa_assets.layouts.run.state_file import read_states, write_states
from casa_assets.model.kitchen.files import START_STATES
from casa_assets.model.kitchen.scene import StartStates
from tests.support.kitchen.start_stages import scene_folder, wanted

pytestmark = pytest.mark.content("code", "layouts.run", keep=0)

SCENE = "one_wall_small__coastal"
Checked = tuple[Path, SceneResult]
ROBOT = """<mujoco model="robot"><worldbody><body name="base" pos="0 0 0.4">
<joint name="lift" type="slide" axis="0 0 1"/><geom type="box" size="0.2 0.2 0.1"/></body></worldbody></mujoco>"""


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, StartStates]:
    folder = scene_folder(tmp_path_factory.mktemp("drawn"))
    states = draw_states(Stage(folder), wanted(count=3))
    write_states(folder, states)
    return folder, states


@pytest.fixture
def copy(drawn: tuple[Path, StartStates], tmp_path: Path) -> Path:
    return Path(shutil.copytree(drawn[0].parent, tmp_path / "scenes")) / "room"


def test_reads_back_what_was_written(drawn: tuple[Path, StartStates], tmp_path: Path) -> None:
    folder, states = drawn
    assert read_states(folder) == states
    with np.load(folder / START_STATES, allow_pickle=False) as found:  # as others read it
        assert found["qpos"].tobytes() == states.qpos.tobytes()
    assert write_states(tmp_path, states).read_bytes() == (folder / START_STATES).read_bytes()
    with zipfile.ZipFile(folder / START_STATES) as archive:
        assert {member.date_time for member in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_what_is_damaged_or_huge_is_refused(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, data = copy / START_STATES, (copy / START_STATES).read_bytes()
    for damaged, message in (
        (b"", "cannot be read"),
        (b"no archive at all", "cannot be read"),
        (data[: len(data) // 2], "cannot be read"),
        (data.replace(b"base.npy", b"bass.npy"), "base"),
    ):
        path.write_bytes(damaged)
        with pytest.raises(CasaError, match=message):
            read_states(copy)
    path.write_bytes(data)
    with monkeypatch.context() as patch:
        patch.setattr(state_file, "LARGEST_BYTES", 100)
        with pytest.raises(CasaError, match="more than 100"):
            read_states(copy)
    with np.load(path) as found:
        arrays = {name: found[name] for name in found.files}
    for changed, message in (
        ({"notes": []}, "as many rows"),
        ({"joints": []}, "joints follow each other"),
        ({"format": 2}, "format"),
    ):
        header = json.dumps({**json.loads(bytes(arrays["header"])), **changed})
        np.savez(path, **{**arrays, "header": np.frombuffer(header.encode(), dtype=np.uint8)})
        with pytest.raises(CasaError, match=message):
            read_states(copy)


class TestLoader:
    def test_a_reset_puts_every_joint_and_stops_everything(self, drawn: tuple[Path, StartStates]) -> None:
        folder, written = drawn
        model = casa.Kitchen(folder).to_mjmodel()
        data = mujoco.MjData(model)
        states = casa.Kitchen(folder).start_states(model)
        data.qvel[:] = 3.0
        states.reset(data, 2)
        assert len(states) == 3
        assert data.qpos.tolist() == pytest.approx(written.qpos[2].tolist())
        assert not data.qvel.any()
        mujoco.mj_step(model, data, nstep=200)
        assert data.qpos.tolist() == pytest.approx(written.qpos[2].tolist(), abs=0.005)

    def test_rows_find_their_place_beside_a_robot(self, drawn: tuple[Path, StartStates]) -> None:
        folder, written = drawn
        kitchen, spec = casa.Kitchen(folder).to_mjspec(), mujoco.MjSpec()
        for prefix in ("first_", "second_"):
            spec.attach(mujoco.MjSpec.from_string(ROBOT), prefix=prefix, frame=spec.worldbody.add_frame())
            if prefix == "first_":
                spec.attach(kitchen, prefix="", frame=spec.worldbody.add_frame())
        with warnings.catch_warnings(action="ignore"):  # options of the kitchen that the empty spec overrules
            model = spec.compile()
        data = mujoco.MjData(model)
        data.joint("first_lift").qpos[0] = data.joint("second_lift").qpos[0] = 0.7
        states = casa.Kitchen(folder).start_states(model)
        states.reset(data, 1)
        for joint in written.joints:
            row = written.qpos[1, joint.address : joint.address + joint.width]
            assert data.joint(joint.name).qpos.tolist() == pytest.approx(row.tolist())
        assert data.joint("first_lift").qpos[0] == data.joint("second_lift").qpos[0] == 0.7

    def test_a_scene_that_they_are_not_of_or_that_was_changed_is_refused(self, copy: Path) -> None:
        kitchen = casa.Kitchen(copy)
        model = kitchen.to_mjmodel()
        with pytest.raises(CasaError, match=r"the model has no joint .* they are of the kitchen room"):
            kitchen.start_states(mujoco.MjModel.from_xml_string(ROBOT))
        (copy / "scene.xml").write_text((copy / "scene.xml").read_text() + "\n")
        with pytest.raises(CasaError, match=r"for another scene\.xml .* draw them again"):
            casa.Kitchen(copy).start_states(model)
        (copy / "scene.xml").unlink()
        with pytest.raises(CasaError, match=r"scene\.xml: is missing"):
            casa.Kitchen(copy).start_states(model)


def test_the_verb_draws_checks_and_keeps_or_says_what_a_kitchen_lacks(checked_kitchen: Checked) -> None:
    out, _ = checked_kitchen
    command = ["states", SCENE, "--objects", "0", "--count", "2", "--out", str(out), "--jobs", "1"]
    first = CliRunner().invoke(app, command)
    assert first.exit_code == 0, first.output
    written = (out / SCENE / START_STATES).read_bytes()
    report = json.loads((out / SCENE / "report.json").read_text(encoding="utf-8"))
    judged = {r["code"]: r["status"] for r in report["results"] if r["code"].startswith("STA")}
    assert judged == dict.fromkeys(("STA001", "STA002", "STA003", "STA004", "STA005"), "passed")
    assert START_STATES in members_of(out / SCENE)
    kitchen = casa.Kitchen(out / SCENE, "light")
    assert len(kitchen.start_states(kitchen.to_mjmodel())) == 2
    again = CliRunner().invoke(app, [*command, "--json"])
    assert json.loads(again.stdout.splitlines()[0])["kept"] is True
    forced = CliRunner().invoke(app, [*command, "--force"])
    assert forced.exit_code == 0, forced.output
    assert (out / SCENE / START_STATES).read_bytes() == written
    done = CliRunner().invoke(app, ["states", SCENE, "--doors", "900", "--objects", "0", "--out", str(out), "--json"])
    assert done.exit_code == 1
    assert "900 doors were to stand open" in json.loads(done.stdout.splitlines()[0])["message"]
    assert CliRunner().invoke(app, ["states"]).exit_code == 2
