"""MJCF and USD of one scene are one fact table, and a single edit of either is found."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import pytest
from pxr import Usd

from casa_assets.checks.readers import mujoco_facts, usd_facts
from casa_assets.checks.readers.facts import Cells, compare
from casa_assets.checks.scene.formats import SCENE_LENGTH_TOLERANCE_M, SCENE_TOLERANCE, SceneFiles, formats_agree
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.mesh.inertia import adjacent_links
from casa_assets.model.asset.asset import Exclusion
from casa_assets.model.kitchen.scene import Placement, Scene
from tests.support.asset.packages import edit, tamper
from tests.support.kitchen.scenes import body, corner, expected, written


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return written(corner(), tmp_path)


def pointers(folder: Path) -> list[str]:
    files = SceneFiles(SceneSubject(corner(), folder))
    return list(dict.fromkeys(where for where, _ in formats_agree(files, 0.0).problems))


def test_both_formats_say_the_same(folder: Path) -> None:
    assert pointers(folder) == []


# Edits of scene_nested.usda, and a cell that then differs.
IN_NESTED = [
    ("double3 xformOp:translate = (-0.04, {-0.1|-0.2}, 0.1)", "poses/start"),
    ('over "door"\n{|            (active = false)\n}', "bodies"),
]


@pytest.mark.parametrize(("text", "cell"), IN_NESTED)
def test_what_the_nested_layer_says_otherwise_is_found(text: str, cell: str, folder: Path) -> None:
    tamper(folder / "scene_nested.usda", edit(text))
    scene, nested = by_mujoco(folder / "scene.xml"), by_openusd(folder / "scene_nested.usda")
    found = [where for where, _ in compare(scene, nested, SCENE_TOLERANCE, SCENE_LENGTH_TOLERANCE_M)]
    assert any(where.startswith(cell) for where in found), found


def _exclusions(scene: Scene) -> list[tuple[Placement, Exclusion]]:
    return [(place, pair) for place in scene.placements for pair in scene.asset_of[place.name].exclusions]


def by_openusd(path: Path) -> Cells:
    return usd_facts.facts_of_scene_stage(usd_facts.StageReading(Usd.Stage.Open(str(path)), scene=True))


def by_mujoco(path: Path) -> Cells:
    if path.suffix == ".xml":
        return mujoco_facts.facts_of_scene(mujoco.MjModel.from_xml_path(str(path)))
    return usd_facts.facts_of_scene_import(
        usd_facts.imported(path).model, usd_facts.StageReading(Usd.Stage.Open(str(path)), scene=True)
    )


# MuJoCo's reader of USD is not there for every Python; joints to the world and contacts are compared by it alone.
BY_MUJOCO = pytest.mark.skipif(bool(usd_facts.missing_importer()), reason=usd_facts.missing_importer())
READERS = [
    ("scene.xml", by_mujoco),
    *((name, by_openusd) for name in ("scene.usda", "scene_nested.usda")),
    *(pytest.param(name, by_mujoco, marks=BY_MUJOCO) for name in ("scene.usda", "scene_nested.usda")),
]


@pytest.mark.parametrize(("name", "reader"), READERS)
def test_every_reader_says_what_the_scene_says(name: str, reader: Callable[[Path], Cells], folder: Path) -> None:
    scene, found = corner(), reader(folder / name)
    truth = expected(scene, "closed")
    assert list(found["placements"]) == sorted(p.name for p in scene.placements)
    for place in scene.placements:
        row, asset = found["placements"][place.name], scene.asset_of[place.name]
        assert (row["asset"], row["base"], row["layer"]) == (asset.id, asset.base, place.layer)
        assert row["position"] == pytest.approx(truth[place.name].position, abs=1e-6)
        assert row["classes"] == asset.labels.classes
    bodies = found["bodies"]
    assert set(bodies) == set(truth)
    assert sum(b["mass"] for b in bodies.values()) == pytest.approx(
        sum(scene.asset_of[p.name].mass for p in scene.placements)
    )
    own = {tuple(sorted((body(p.name, e.first), body(p.name, e.second)))) for p, e in _exclusions(scene)}
    near = {tuple(sorted(body(one.placement, one.link) for one in pair)) for pair in adjacent_links(scene)}
    assert set(found["exclusions"]) == own | near
    assert list(found["poses"]) == ["closed", "open", "start"]
    assert found["gravity"] == pytest.approx(scene.gravity, abs=1e-6)
    (camera,) = found["cameras"].values()
    assert camera["fov_y_deg"] == pytest.approx(60.0, abs=1e-4)
    kinds = {name: light["kind"] for name, light in found["lights"].items()}
    assert kinds == {"sun": "directional", "bulb": "point", "spot": "spot"}
    length = math.sqrt(0.2**2 + 0.5**2 + 1)
    assert found["lights"]["sun"]["direction"] == pytest.approx((0.2 / length, 0.5 / length, -1 / length), abs=1e-6)


# Edits of scene.xml, and a cell that then differs.
IN_MJCF = [
    ('body name="second_oven" pos="{-1.25|-1.2501} 2', "placements/second_oven/position"),
    ('name="grill" pos="2 0.5 0.9"{ quat="0.707106781 0 0 0.707106781"|}', "placements/grill/quaternion"),
    ('name="oven__microjoint" type="hinge" pos="0 {-0.02|-0.03} 0"', "bodies/oven__door/joint/anchor"),
    ('name="other_grill__rack_joint" type="{slide|hinge}"', "bodies/other_grill__rack/joint/kind"),
    ('body1="second_oven" body2="{second_oven__door|oven__door}"', "exclusions"),
    ('geom name="mug__floor" type="cylinder" size="{0.04|0.06}', "bodies/mug/lower"),
    ('text name="grill__label__handle" data="{grill__handle_0|other_grill__handle_0}', "placements/grill/labels"),
    (
        'text name="other_grill__grip__microjoint" data="{other_grill__handle_0|grill__handle_0}"',
        "placements/other_grill/grips",
    ),
    (
        'text name="oven__state__door_open" data="{oven__microjoint|second_oven__microjoint}',
        "placements/oven/states/door_open/joint",
    ),
    ('text name="ceiling__layer" data="{ceiling|room}"', "placements/ceiling/layer"),
    ('text name="mug__class" data="{mug|cup} ', "placements/mug/classes"),
    ('key name="open" qpos="0 0 {-1.3|-1.2} ', "poses/open/grill__door/quaternion"),
    ('key name="start" qpos="{-1|-1.01} ', "poses/start/oven__door/quaternion"),
    ('camera name="door" pos="0 {-3|-3.1}', "cameras/door/position"),
    ('fovy="{60|61}"', "cameras/door/fov_y_deg"),
    ('light name="bulb" directional="{false|true}"', "lights/bulb/kind"),
    ('cutoff="{180|60}"', "lights/bulb/kind"),
    ('castshadow="{false|true}"', "lights/spot/castshadow"),
    ('gravity="0 0 {-9.81|-9.8}"', "gravity"),
]


# The same of scene.usda.
IN_USD = [
    ("point3f physics:localPos0 = (2, {1.5|1.51}, 0.9)", "placements/other_grill/position"),
    ('casa:layer = "{room|things}"', "placements/wall/layer"),
    ("{mug_0123456789/mug_0123456789.usda|orange_0123456789/orange_0123456789.usda}", "placements/mug/asset"),
    ('string pose = "{open|on}"', "poses/open/grill__door/quaternion"),
    ("double3 xformOp:translate = (-0.04, {-0.1|-0.2}, 0.1)", "poses/start/grill__rack/position"),
    ("gravityMagnitude = {9.81|9.8}", "gravity"),
    ("inputs:color = (0.6, {0.58|0.5}, 0.5)", "lights/sun/tint"),
    ("cone:angle = {30|40}", "lights/spot/cone_deg"),
    ("{focalLength|focusDistance}", "cameras/door/fov_y_deg"),
    ('def Xform "{orange|apple}" (', "placements"),
    ("def {PhysicsScene|Scope}", "scene.usda"),
]

ONLY_BY_MUJOCO = [
    ("scene.usda", "double3 xformOp:translate = ({-1.25|-1.2501}, 2, 0.9)", "placements/second_oven/position"),
    ("scene.usda", "rel physics:body0 = </{World|World/oven}>", "placements/second_oven/base"),
    ("scene.xml", 'condim="{6|3}"', "bodies/orange/contacts"),
]
EDITS = [
    *(("scene.xml", *case) for case in IN_MJCF),
    *(("scene.usda", *case) for case in IN_USD),
    *(pytest.param(*case, marks=BY_MUJOCO) for case in ONLY_BY_MUJOCO),
]


@pytest.mark.parametrize(("file", "text", "cell"), EDITS)
def test_what_one_file_says_otherwise_is_found(file: str, text: str, cell: str, folder: Path) -> None:
    tamper(folder / file, edit(text))
    found = pointers(folder)
    assert cell in found
    assert not cell.endswith("contacts") or found == [cell]
