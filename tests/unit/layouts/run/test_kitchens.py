"""Recipes, scenes on disk, and their loader; a kitchen that is there is known by its key until it could change."""

from __future__ import annotations

import itertools
import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

import casa_assets
from casa_assets.cache import store
from casa_assets.errors import CasaError, UnknownId
from casa_assets.layouts.run import kept, resolve, scene_folders
from casa_assets.layouts.run.recipe import SceneRecipe, all_recipes, recipe_of, recipes_matching, recipes_named
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.files import OVERVIEW, SCENE_JSON, WRITTEN
from casa_assets.registry.kitchens import plan_names, style_names
from casa_assets.show.stills import kitchen

PLAN, STYLE = "one_wall_small", "scandinavian"
SCENE = f"{PLAN}__{STYLE}"


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scenes") / "out"
    made = scene_folders.build_one(SceneRecipe(PLAN, STYLE), folder, drawn=False)
    assert made.passed, made.message
    return folder


def test_fault_of_one_scene_is_in_its_result(tmp_path: Path) -> None:
    made = scene_folders.build_one(SceneRecipe(PLAN, "no_such_style"), tmp_path, drawn=False)
    assert not made.passed
    assert "no_such_style" in made.message
    assert not list(tmp_path.glob("*__*"))


class TestScene:
    def test_it_is_kept_while_it_is_whole(self, out: Path) -> None:
        assert {*WRITTEN, SCENE_JSON} == {path.name for path in (out / SCENE).iterdir()}
        before = (out / SCENE / "scene.xml").stat().st_mtime_ns
        assert scene_folders.build_one(SceneRecipe(PLAN, STYLE), out, drawn=False).kept
        assert (out / SCENE / "scene.xml").stat().st_mtime_ns == before
        (out / SCENE / "scene.json").write_text("{", encoding="utf-8")
        assert not scene_folders.build_one(SceneRecipe(PLAN, STYLE), out, drawn=False).kept
        assert json.loads((out / SCENE / "scene.json").read_text(encoding="utf-8"))["id"] == SCENE

    @pytest.mark.content("code", "layouts.run", keep=0)
    def test_another_process_writes_the_same_bytes(self, out: Path, tmp_path: Path) -> None:
        code = (
            "import sys, pathlib; from casa_assets.layouts.run.resolve import SceneRecipe; "
            "from casa_assets.layouts.run.scene_folders import build_one; out = pathlib.Path(sys.argv[1]); "
            f"assert build_one(SceneRecipe({PLAN!r}, {STYLE!r}), out, drawn=False).passed"
        )
        subprocess.run(
            [sys.executable, "-c", code, str(tmp_path / "out")],
            check=True,
            # Nothing that the first one has built is taken from its cache.
            env={"PYTHONHASHSEED": "7", "PATH": "/usr/bin", "CASA_ASSETS_CACHE": str(tmp_path / "cache")},
        )
        for name in ("scene.xml", "scene_light.xml", "scene.usda", "scene_nested.usda"):
            assert str(out) not in (out / SCENE / name).read_text(encoding="utf-8"), "nothing outside is named"
            assert (out / SCENE / name).read_bytes() == (tmp_path / "out" / SCENE / name).read_bytes(), name
        one, other = (json.loads((f / SCENE / "scene.json").read_bytes()) for f in (out, tmp_path / "out"))
        assert one == other

    def test_facts_are_those_of_the_model(self, out: Path) -> None:
        facts = json.loads((out / SCENE / "scene.json").read_text(encoding="utf-8"))
        model = mujoco.MjModel.from_xml_path(str(out / SCENE / "scene.xml"))
        assert {f["name"] for f in facts["fixtures"]} <= {model.body(i).name for i in range(model.nbody)}
        joints = {model.joint(i).name for i in range(model.njnt)}
        stated = {j["name"] for f in facts["fixtures"] for j in f["joints"].values()}
        assert stated == {name for name in joints if not name.endswith("__free")}
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        geoms = {model.geom(i).name: i for i in range(model.ngeom)}
        regions = {
            f"{f['name']}__reg_{name}": region for f in facts["fixtures"] for name, region in f["regions"].items()
        }
        seen = geoms.keys() & regions.keys()
        assert len(seen) > 10
        for name in seen:
            np.testing.assert_allclose(data.geom_xpos[geoms[name]], regions[name]["position"], atol=2e-5)

    def test_the_whole_room_is_on_the_map_of_shadows_of_the_sun(self) -> None:
        """Beyond its edge MuJoCo draws dark specks. A galley is long and narrow, which makes it the hardest case."""
        model = casa_assets.kitchen("galley__coastal", detail="light").to_mjmodel()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        sun = model.light("sun").id
        ahead = model.light_dir[sun] / np.linalg.norm(model.light_dir[sun])
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        half = np.abs(data.geom_xmat.reshape(-1, 3, 3) @ model.geom_aabb[:, 3:, None])[..., 0]
        lower, upper = (data.geom_xpos - half).min(axis=0), (data.geom_xpos + half).max(axis=0)
        corners = np.array(list(itertools.product(*zip(lower, upper, strict=True)))) - model.light_pos[sun]
        across = np.abs(corners @ np.stack([right, np.cross(right, ahead)], axis=1)).max()
        assert across < model.vis.map.shadowclip * model.stat.extent


class TestLoader:
    def test_details(self, out: Path) -> None:
        loaded = casa_assets.load(out / SCENE)
        assert isinstance(loaded, casa_assets.Kitchen)
        full, light = loaded.to_mjmodel(), casa_assets.Kitchen(out / SCENE, "light").to_mjmodel()
        assert light.nmesh == 0
        assert light.ntexdata < full.ntexdata
        assert full.nq == light.nq
        assert loaded.with_detail("light").to_mjmodel().ngeom == light.ngeom
        memory = casa_assets.kitchen(SCENE).to_mjmodel()
        for name in ("body_pos", "body_mass", "geom_pos", "mesh_vert", "tex_data", "key_qpos", "jnt_range"):
            np.testing.assert_array_equal(getattr(full, name), getattr(memory, name), err_msg=name)

    def test_the_batch_form_needs_no_file(self, out: Path) -> None:
        light, model = (casa_assets.kitchen(SCENE, detail=form).to_mjmodel() for form in ("light", "batch"))
        touching, of_light = (int(((m.geom_contype | m.geom_conaffinity) != 0).sum()) for m in (model, light))
        assert touching <= 300 < of_light
        assert {model.key(number).name for number in range(model.nkey)} == {"start", "closed", "open"}
        with pytest.raises(CasaError, match=f"casa-assets scenes batch {SCENE} .* writes it"):
            casa_assets.Kitchen(out / SCENE, "batch").to_mjmodel()

    def test_what_is_at_rest_may_sleep(self, out: Path) -> None:
        sleep, kitchen = int(mujoco.mjtEnableBit.mjENBL_SLEEP), casa_assets.Kitchen(out / SCENE, "light")
        model = kitchen.to_mjmodel(sleep=True)
        assert model.opt.enableflags & sleep
        assert kitchen.to_mjspec(sleep=True).compile().opt.enableflags & sleep
        assert not kitchen.to_mjmodel().opt.enableflags & sleep
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        mujoco.mj_step(model, data, nstep=1000)
        assert data.ntree_awake == 0
        # Who moves a joint wakes it.
        joint = next(j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_SLIDE)
        data.qpos[model.jnt_qposadr[joint]] += 0.5 * np.ptp(model.jnt_range[joint])
        mujoco.mj_step(model, data)
        assert data.ntree_awake > 0

    def test_textures_are_swapped_in_their_true_size(self, out: Path) -> None:
        kitchen = casa_assets.Kitchen(out / SCENE)
        plain, other = kitchen.to_mjmodel(), kitchen.to_mjmodel()
        kitchen.textures_of(other).show({"floor": "checker_marble_black_white"})
        assert plain.nmeshvert == other.nmeshvert
        assert not np.array_equal(plain.tex_data, other.tex_data)
        changed = np.abs(plain.mesh_texcoord - other.mesh_texcoord).max(axis=1) > 1e-9
        bodies = [plain.body("floor").id, plain.body("threshold_door").id]
        own = np.zeros_like(changed)
        for mesh in set(plain.geom_dataid[np.isin(plain.geom_bodyid, bodies)]) - {-1}:
            first, count = int(plain.mesh_texcoordadr[mesh]), int(plain.mesh_texcoordnum[mesh])
            own[first : first + count] = True
        assert changed.any()
        assert not (changed & ~own).any()

    def test_wrong_names(self, out: Path) -> None:
        light = casa_assets.Kitchen(out / SCENE, "light")
        textures = light.textures_of(light.to_mjmodel())
        with pytest.raises(UnknownId, match="wall"):
            textures.show({"walls": "brick_red_running"})
        with pytest.raises(CasaError, match="full"):
            textures.show({"floor": "oak_ebony"})
        with pytest.raises(UnknownId, match="light"):
            casa_assets.kitchen(SCENE, detail="lite")  # type: ignore[arg-type]


class TestIds:
    def test_an_id_brings_its_recipe_back(self) -> None:
        for recipe, expected in (
            (SceneRecipe(PLAN, STYLE), ""),
            (SceneRecipe(PLAN, STYLE, 12, closed=True), "__s12__closed"),
            (SceneRecipe(PLAN, STYLE, 7, resolve.draw_surfaces(7)), "__s7__t[0-9a-f]{8}"),
            (SceneRecipe(PLAN, STYLE, None, resolve.draw_surfaces(0)), "__t[0-9a-f]{8}"),
            (SceneRecipe(PLAN, STYLE, objects=40, objects_seed=3), "__o40s3"),
            (SceneRecipe(PLAN, STYLE, mixed=True, closed=True, objects=4), "__mixed__closed__o4"),
        ):
            assert re.fullmatch(SCENE + expected, recipe.scene_id), recipe
            assert recipe_of(recipe.scene_id) == recipe

    def test_chosen_finishes_and_models_are_found_where_the_scene_is(self, tmp_path: Path) -> None:
        models = resolve.ordered_models([("range", "range/pro_six"), ("fridge", "library:fridge_ab12")])
        assert [role for role, _ in models] == ["fridge", "range"]
        surfaces = resolve.ordered_surfaces([(Surface.FLOOR, "oak_ebony"), (Surface.WALL, "brick_red_running")])
        recipe = SceneRecipe(PLAN, STYLE, 7, surfaces, objects=9, mixed=True, models=models)
        assert re.fullmatch(rf"{SCENE}__s7__t[0-9a-f]{{8}}__m[0-9a-f]{{8}}__mixed__o9", recipe.scene_id)
        assert recipe.scene_id != replace(recipe, models=models[1:]).scene_id
        message = r"'t\w+' is a digest of its finishes and 'm\w+' is a digest of its models; .*models=\{'range'"
        with pytest.raises(CasaError, match=message):
            recipe_of(recipe.scene_id, (tmp_path,))
        (tmp_path / recipe.scene_id).mkdir()
        shown = {"wall": "brick_red_running", "floor": "oak_ebony", "counter": "block_oak", "cabinet": "paint_navy"}
        facts = {"surfaces": shown, "models": dict(models)}
        (tmp_path / recipe.scene_id / "scene.json").write_text(json.dumps(facts), encoding="utf-8")
        assert recipe_of(recipe.scene_id, (tmp_path,)) == recipe

    def test_what_is_no_id(self) -> None:
        for word in ["", PLAN, f"{SCENE}__x", f"{SCENE}__t12", f"{SCENE}__m12", f"{SCENE}__closed__s3", "x__y"]:
            with pytest.raises(UnknownId):
                recipe_of(word)


def test_every_camera_sees_the_kitchen(out: Path) -> None:
    frame = kitchen.PictureSettings(96, 72, 1)
    made = kitchen.open_scene(out / SCENE / "scene.xml", frame)
    assert {"overview", "above", "at_sink", "at_stove"} <= set(made.cameras)
    for name, pixels in kitchen.render_cameras(made, made.cameras, frame):
        assert pixels.shape == (72, 96, 3)
        assert 30 < pixels.mean() < 245, name
        assert pixels.std() > 12, name
    with pytest.raises(CasaError, match="overview"):
        list(kitchen.render_cameras(made, ["overvew"], frame))
    with pytest.raises(CasaError, match="half_open"):
        kitchen.open_scene(out / SCENE / "scene.xml", frame, "half_open")


def test_globs(tmp_path: Path) -> None:
    assert (len(plan_names()), len(style_names()), len(all_recipes())) == (16, 12, 192)
    assert [r.scene_id for r in recipes_matching([SCENE, f"{PLAN}__scand*"])] == [SCENE]
    lived_in = recipes_named([f"{PLAN}__scand*__o40s3", f"{SCENE}__o40s3", SCENE], tmp_path)
    assert [r.scene_id for r in lived_in] == [f"{SCENE}__o40s3", SCENE]
    assert {len(recipes_named([f"*{end}"], tmp_path)) for end in ("", "__o12")} == {192}
    for name in ("no_such__*", "no_such__*__o40", f"{SCENE}__o40s", f"{PLAN}__no_such__o40"):
        with pytest.raises(UnknownId):
            recipes_named([name], tmp_path)


KEPT = SceneRecipe("l_small", "coastal")


@pytest.fixture
def remembered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the files of a kitchen, whose key is remembered in a cache of its own."""
    monkeypatch.setenv("CASA_ASSETS_CACHE", str(tmp_path / "cache"))
    kept.remember_kitchen_key(KEPT, "of a kitchen")
    key = kept.written_key("of a kitchen")
    folder = tmp_path / "scenes" / KEPT.scene_id
    folder.mkdir(parents=True)
    for name in (*WRITTEN, f"{OVERVIEW}.png"):
        (folder / name).touch()
    (folder / SCENE_JSON).write_text(json.dumps({"key": key, "picture_key": kept.picture_key(key)}))
    return tmp_path / "scenes"


def test_a_remembered_one_is_kept_while_its_files_are_there(remembered: Path) -> None:
    found = kept.kept_scene(KEPT, remembered, drawn=True)
    assert (found.kept, found.folder) == (True, str(remembered / KEPT.scene_id))
    (remembered / KEPT.scene_id / f"{OVERVIEW}.png").unlink()
    assert kept.kept_scene(KEPT, remembered, drawn=True) is None
    for name in (WRITTEN[0], SCENE_JSON):
        assert kept.kept_scene(KEPT, remembered, drawn=False) is not None, "a picture is not always wanted"
        file = remembered / KEPT.scene_id / name
        moved = file.rename(remembered / "elsewhere")
        assert kept.kept_scene(KEPT, remembered, drawn=False) is None, name
        moved.rename(file)


def test_a_key_is_not_remembered_beyond_a_change(remembered: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A long run has read the registry at its start; a file that is edited meanwhile must not be taken for read."""
    edited = SceneRecipe("galley", "coastal")
    assert kept.remembered_kitchen_key(replace(KEPT, seed=1)) == ""
    with monkeypatch.context() as patch:
        patch.setattr(store, "last_change_ns", lambda: store.STARTED_NS + 1)
        kept.remember_kitchen_key(edited, "of before the edit")
        assert kept.remembered_kitchen_key(edited) == ""
    monkeypatch.setattr(store, "state_of_everything", lambda: "after an edit")
    assert kept.kept_scene(KEPT, remembered, drawn=True) is None
