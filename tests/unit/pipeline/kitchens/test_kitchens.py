"""Recipes, scenes on disk, and their loader."""

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
from casa_assets.errors import CasaError, RegistryError, UnknownId
from casa_assets.model.kitchen.choices import Surface
from casa_assets.pipeline.kitchens import resolve, scene_folders
from casa_assets.pipeline.kitchens.recipe import SceneRecipe, all_recipes, recipe_of, recipes_matching, recipes_named
from casa_assets.pipeline.reports import kitchens as book
from casa_assets.preview import kitchen
from casa_assets.registry.kitchens import load_plan, plan_names, read_plan, style_names

PLAN, STYLE = "one_wall_small", "scandinavian"
SCENE = f"{PLAN}__{STYLE}"


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one built scene."""
    folder = tmp_path_factory.mktemp("scenes") / "out"
    made = scene_folders.build_one(SceneRecipe(PLAN, STYLE), folder, drawn=False)
    assert made.passed, made.message
    return folder


class TestRecipe:
    def test_id_names_all_that_differs(self) -> None:
        surfaces = resolve.ordered_surfaces([(Surface.FLOOR, "oak_ebony"), (Surface.WALL, "brick_red_running")])
        plain, drawn = SceneRecipe(PLAN, STYLE), SceneRecipe(PLAN, STYLE, 7, surfaces, closed=True)
        assert plain.scene_id == SCENE
        assert drawn.scene_id.startswith(f"{SCENE}__s7__t")
        assert drawn.scene_id.endswith("__closed")

    def test_order_of_surfaces_does_not_matter(self) -> None:
        pairs = [(Surface.WALL, "brick_red_running"), (Surface.COUNTER, "block_oak")]
        assert resolve.ordered_surfaces(pairs) == resolve.ordered_surfaces(pairs[::-1])

    def test_surfaces_are_drawn_independently(self) -> None:
        draws = [dict(resolve.draw_surfaces(seed)) for seed in range(12)]
        assert resolve.draw_surfaces(3) == resolve.draw_surfaces(3)
        for surface in Surface:
            assert len({d[surface] for d in draws}) > 6

    def test_unknown_texture_is_told_with_near_names(self) -> None:
        with pytest.raises(UnknownId, match="brick_red_running"):
            resolve.ordered_surfaces([(Surface.WALL, "brick_red_runing")])

    def test_drawn_lengths_are_within_their_bounds(self) -> None:
        plan = load_plan(PLAN)[0]
        for seed in range(20):
            for name, value in resolve.draw_lengths(plan, seed).items():
                assert plan.parameters[name].low <= value <= plan.parameters[name].high


class TestFaults:
    def test_unknown_style(self) -> None:
        with pytest.raises(UnknownId, match="scandinavian"):
            resolve.resolve(SceneRecipe(PLAN, "scandanavian"))

    @pytest.mark.parametrize(
        ("old", "new", "message"),
        [
            ("title:", "titel:", "titel"),
            ("heading: right", "heading: rigth", "right"),
        ],
    )
    def test_plan_with_a_fault_tells_its_line(self, tmp_path: Path, old: str, new: str, message: str) -> None:
        text = (casa_root() / "plans" / f"{PLAN}.yaml").read_text(encoding="utf-8")
        assert old in text
        line = text[: text.index(old)].count("\n") + 1
        path = tmp_path / "mine.yaml"
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        with pytest.raises(RegistryError, match=message) as caught:
            read_plan(path)
        assert caught.value.line == line

    def test_fault_of_one_scene_is_told_and_not_raised(self, tmp_path: Path) -> None:
        made = scene_folders.build_one(SceneRecipe(PLAN, "no_such_style"), tmp_path, drawn=False)
        assert not made.passed
        assert "no_such_style" in made.message
        assert not list(tmp_path.glob("*__*"))


def casa_root() -> Path:
    from casa_assets.registry import data_root

    return data_root()


class TestScene:
    def test_folder_holds_what_it_promises(self, out: Path) -> None:
        names = {p.name for p in (out / SCENE).iterdir()}
        assert {"scene.xml", "scene_light.xml", "scene.usda", "scene.json"} <= names

    def test_nothing_outside_the_output_is_named(self, out: Path) -> None:
        for name in ("scene.xml", "scene.usda", "scene.json"):
            assert str(out) not in (out / SCENE / name).read_text(encoding="utf-8")

    def test_second_build_keeps_it(self, out: Path) -> None:
        before = (out / SCENE / "scene.xml").stat().st_mtime_ns
        again = scene_folders.build_one(SceneRecipe(PLAN, STYLE), out, drawn=False)
        assert again.kept
        assert (out / SCENE / "scene.xml").stat().st_mtime_ns == before

    def test_damaged_scene_is_made_anew(self, out: Path) -> None:
        (out / SCENE / "scene.json").write_text("{", encoding="utf-8")
        again = scene_folders.build_one(SceneRecipe(PLAN, STYLE), out, drawn=False)
        assert not again.kept
        assert json.loads((out / SCENE / "scene.json").read_text(encoding="utf-8"))["id"] == SCENE

    @pytest.mark.content("code", "pipeline.kitchens", keep=0)
    def test_another_process_writes_the_same_bytes(self, out: Path, tmp_path: Path) -> None:
        code = (
            "import sys, pathlib; from casa_assets.pipeline.kitchens.resolve import SceneRecipe; "
            "from casa_assets.pipeline.kitchens.scene_folders import build_one; out = pathlib.Path(sys.argv[1]); "
            f"assert build_one(SceneRecipe({PLAN!r}, {STYLE!r}), out, drawn=False).passed"
        )
        subprocess.run(
            [sys.executable, "-c", code, str(tmp_path / "out")],
            check=True,
            # Nothing that the first one has built is taken from its cache.
            env={"PYTHONHASHSEED": "7", "PATH": "/usr/bin", "CASA_ASSETS_CACHE": str(tmp_path / "cache")},
        )
        for name in ("scene.xml", "scene_light.xml", "scene.usda", "scene_nested.usda"):
            assert (out / SCENE / name).read_bytes() == (tmp_path / "out" / SCENE / name).read_bytes(), name
        one, other = (json.loads((f / SCENE / "scene.json").read_bytes()) for f in (out, tmp_path / "out"))
        assert one == other

    def test_facts_name_joints_and_bodies_of_the_model(self, out: Path) -> None:
        facts = json.loads((out / SCENE / "scene.json").read_text(encoding="utf-8"))
        model = mujoco.MjModel.from_xml_path(str(out / SCENE / "scene.xml"))
        bodies = {model.body(i).name for i in range(model.nbody)}
        joints = {model.joint(i).name for i in range(model.njnt)}
        assert {f["name"] for f in facts["fixtures"]} <= bodies
        told = {j["name"] for f in facts["fixtures"] for j in f["joints"].values()}
        free = {n for n in joints if n.endswith("__free")}
        assert told == joints - free

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

    def test_regions_stand_where_the_model_has_them(self, out: Path) -> None:
        facts = json.loads((out / SCENE / "scene.json").read_text(encoding="utf-8"))
        model = mujoco.MjModel.from_xml_path(str(out / SCENE / "scene.xml"))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        names = {model.geom(i).name: i for i in range(model.ngeom)}
        seen = 0
        for fixture in facts["fixtures"]:
            for name, region in fixture["regions"].items():
                geom = names.get(f"{fixture['name']}__reg_{name}")
                if geom is not None:
                    np.testing.assert_allclose(data.geom_xpos[geom], region["position"], atol=2e-5)
                    seen += 1
        assert seen > 10


def in_memory(detail: casa_assets.Detail = "full") -> casa_assets.Kitchen:
    return casa_assets.kitchen(SCENE, detail=detail)


class TestLoader:
    def test_details(self, out: Path) -> None:
        loaded = casa_assets.load(out / SCENE)
        assert isinstance(loaded, casa_assets.Kitchen)
        full, light = loaded.to_mjmodel(), casa_assets.Kitchen(out / SCENE, "light").to_mjmodel()
        assert light.nmesh == 0
        assert light.ntexdata < full.ntexdata
        assert full.nq == light.nq
        assert loaded.with_detail("light").to_mjmodel().ngeom == light.ngeom
        memory = in_memory().to_mjmodel()
        for name in ("body_pos", "body_mass", "geom_pos", "mesh_vert", "tex_data", "key_qpos", "jnt_range"):
            np.testing.assert_array_equal(getattr(full, name), getattr(memory, name), err_msg=name)

    def test_the_batch_form_needs_no_file(self, out: Path) -> None:
        light, model = in_memory("light").to_mjmodel(), in_memory("batch").to_mjmodel()
        touching, of_light = (int(((m.geom_contype | m.geom_conaffinity) != 0).sum()) for m in (model, light))
        assert touching <= 300 < of_light
        assert {model.key(number).name for number in range(model.nkey)} == {"start", "closed", "open"}
        with pytest.raises(CasaError, match=f"casa-assets scenes batch {SCENE} .* writes it"):
            casa_assets.Kitchen(out / SCENE, "batch").to_mjmodel()

    def test_spec_takes_more(self, out: Path) -> None:
        spec = casa_assets.Kitchen(out / SCENE).to_mjspec()
        spec.worldbody.add_body(name="robot").add_geom(size=[0.1, 0.0, 0.0])
        assert spec.compile().body("robot").id > 0

    def test_trimesh_has_everything_where_the_model_has_it(self, out: Path) -> None:
        kitchen = in_memory()
        model = kitchen.to_mjmodel()
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
        mujoco.mj_forward(model, data)
        graph = kitchen.to_trimesh("collision").graph
        for placement in kitchen.scene.placements:
            if kitchen.scene.asset_of[placement.name].joints:
                pose, _ = graph[f"{placement.name}__object"]
                np.testing.assert_allclose(pose[:3, 3], data.body(placement.name).xpos, atol=1e-5)

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
        bodies = [plain.body("floor"), plain.body("threshold_door")]
        geoms = [g for b in bodies for g in range(int(b.geomadr[0]), int(b.geomadr[0]) + int(b.geomnum[0]))]
        meshes = {int(plain.geom_dataid[g]) for g in geoms} - {-1}
        own = np.zeros_like(changed)
        for mesh in meshes:
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
        with pytest.raises(UnknownId, match=SCENE):
            casa_assets.kitchen(SCENE + "x")
        with pytest.raises(CasaError, match="holds neither"):
            casa_assets.load(out / "nowhere")

    def test_nothing_is_written_where_no_folder_is_named(self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
        monkeypatch.chdir(tmp_path)
        assert in_memory("light").to_mjmodel().nbody > 20
        assert list(tmp_path.iterdir()) == []


class TestIds:
    def test_seed_that_drew_the_finishes_brings_them_back(self) -> None:
        for recipe in (
            SceneRecipe(PLAN, STYLE),
            SceneRecipe(PLAN, STYLE, 12, closed=True),
            SceneRecipe(PLAN, STYLE, 7, resolve.draw_surfaces(7)),
            SceneRecipe(PLAN, STYLE, None, resolve.draw_surfaces(0)),
        ):
            assert recipe_of(recipe.scene_id) == recipe

    def test_chosen_finishes_are_found_where_the_scene_stands(self, tmp_path: Path) -> None:
        surfaces = resolve.ordered_surfaces([(Surface.FLOOR, "oak_ebony"), (Surface.WALL, "brick_red_running")])
        recipe = SceneRecipe(PLAN, STYLE, 7, surfaces)
        with pytest.raises(CasaError, match="digest of its finishes"):
            recipe_of(recipe.scene_id, (tmp_path,))
        (tmp_path / recipe.scene_id).mkdir()
        told = {"wall": "brick_red_running", "floor": "oak_ebony", "counter": "block_oak", "cabinet": "paint_navy"}
        (tmp_path / recipe.scene_id / "scene.json").write_text(json.dumps({"surfaces": told}), encoding="utf-8")
        assert recipe_of(recipe.scene_id, (tmp_path,)) == recipe

    def test_chosen_models_are_found_where_the_scene_stands(self, tmp_path: Path) -> None:
        models = resolve.ordered_models([("range", "range/pro_six"), ("fridge", "library:fridge_ab12")])
        assert [role for role, _ in models] == ["fridge", "range"]
        recipe = SceneRecipe(PLAN, STYLE, 7, resolve.draw_surfaces(7), objects=9, mixed=True, models=models)
        assert re.fullmatch(rf"{SCENE}__s7__t[0-9a-f]{{8}}__m[0-9a-f]{{8}}__mixed__o9", recipe.scene_id)
        assert recipe.scene_id != replace(recipe, models=models[1:]).scene_id
        message = r"'t\w+' is a digest of its finishes and 'm\w+' is a digest of its models; .*models=\{'range'"
        with pytest.raises(CasaError, match=message):
            recipe_of(recipe.scene_id, (tmp_path,))
        (tmp_path / recipe.scene_id).mkdir()
        told = {"surfaces": {}, "models": dict(models)}
        (tmp_path / recipe.scene_id / "scene.json").write_text(json.dumps(told), encoding="utf-8")
        assert recipe_of(recipe.scene_id, (tmp_path,)) == recipe

    def test_what_is_no_id(self, subtests: pytest.Subtests) -> None:
        for word in ["", PLAN, f"{SCENE}__x", f"{SCENE}__t12", f"{SCENE}__m12", f"{SCENE}__closed__s3", "x__y"]:
            with subtests.test(word=word), pytest.raises(UnknownId):
                recipe_of(word)


class TestPictures:
    def test_every_camera_sees_the_kitchen(self, out: Path) -> None:
        made = kitchen.open_scene(out / SCENE / "scene.xml", frame=kitchen.PictureSettings(96, 72, 1))
        assert {"overview", "above", "at_sink", "at_stove"} <= set(made.cameras)
        for name, pixels in kitchen.render_cameras(made, made.cameras, kitchen.PictureSettings(96, 72, 1)):
            assert pixels.shape == (72, 96, 3)
            assert 30 < pixels.mean() < 245, name
            assert pixels.std() > 12, name

    def test_unknown_camera_and_pose(self, out: Path) -> None:
        made = kitchen.open_scene(out / SCENE / "scene.xml", frame=kitchen.PictureSettings(64, 48, 1))
        with pytest.raises(CasaError, match="overview"):
            list(kitchen.render_cameras(made, ["overvew"], kitchen.PictureSettings(64, 48, 1)))
        with pytest.raises(CasaError, match="half_open"):
            kitchen.open_scene(out / SCENE / "scene.xml", "half_open")

    def test_book_lists_the_scene(self, out: Path) -> None:
        page, picture = book.write(out)
        assert SCENE in page.read_text(encoding="utf-8")
        assert picture.read_bytes().startswith(b"\x89PNG")


def test_sixteen_plans_in_twelve_styles() -> None:
    assert len(plan_names()) == 16
    assert len(style_names()) == 12
    assert len(all_recipes()) == 192


def test_globs() -> None:
    assert [r.scene_id for r in recipes_matching([SCENE, f"{PLAN}__scand*"])] == [SCENE]
    with pytest.raises(UnknownId):
        recipes_matching(["no_such__*"])


def test_globs_with_objects(tmp_path: Path) -> None:
    lived_in = recipes_named([f"{PLAN}__scand*__o40s3", f"{SCENE}__o40s3", SCENE], tmp_path)
    assert [r.scene_id for r in lived_in] == [f"{SCENE}__o40s3", SCENE]
    assert {len(recipes_named([f"*{end}"], tmp_path)) for end in ("", "__o12")} == {192}
    for name in ("no_such__*__o40", f"{SCENE}__o40s", f"{PLAN}__no_such__o40"):
        with pytest.raises(UnknownId):
            recipes_named([name], tmp_path)
