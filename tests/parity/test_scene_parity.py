"""MJCF and USD of one scene are one fact table, and a single edit of either is found."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import pytest
from pxr import Usd

from casa_assets.checks.package.parity import compare
from casa_assets.checks.readers import scene_facts, usd_facts
from casa_assets.checks.readers.scene_facts import SceneFacts, SceneReading
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


def by_openusd(path: Path) -> SceneFacts:
    return scene_facts.facts_of_stage(SceneReading(Usd.Stage.Open(str(path))))


def by_mujoco(path: Path) -> SceneFacts:
    if path.suffix == ".xml":
        return scene_facts.facts_of_scene_model(mujoco.MjModel.from_xml_path(str(path)))
    return scene_facts.facts_of_import(usd_facts.imported(path).model, SceneReading(Usd.Stage.Open(str(path))))


# MuJoCo's reader of USD is not there for every Python; joints to the world and contacts are compared by it alone.
BY_MUJOCO = pytest.mark.skipif(bool(usd_facts.missing_importer()), reason=usd_facts.missing_importer())
READERS = [
    ("scene.xml", by_mujoco),
    *((name, by_openusd) for name in ("scene.usda", "scene_nested.usda")),
    *(pytest.param(name, by_mujoco, marks=BY_MUJOCO) for name in ("scene.usda", "scene_nested.usda")),
]


@pytest.mark.parametrize(("name", "reader"), READERS)
def test_every_reader_says_what_the_scene_says(name: str, reader: Callable[[Path], SceneFacts], folder: Path) -> None:
    scene, found = corner(), reader(folder / name)
    truth = expected(scene, "closed")
    assert [p.name for p in found.placements] == sorted(p.name for p in scene.placements)
    for place in scene.placements:
        (row,) = (p for p in found.placements if p.name == place.name)
        asset = scene.asset_of[place.name]
        assert (row.asset, row.base, row.layer) == (asset.id, asset.base, place.layer)
        assert row.position == pytest.approx(truth[place.name].position, abs=1e-6)
        assert row.words.classes == asset.labels.classes
    bodies = {b.name: b for b in found.things.bodies}
    assert set(bodies) == set(truth)
    assert sum(b.mass for b in bodies.values()) == pytest.approx(
        sum(scene.asset_of[p.name].mass for p in scene.placements)
    )
    own = {tuple(sorted((body(p.name, e.first), body(p.name, e.second)))) for p, e in _exclusions(scene)}
    near = {tuple(sorted(body(one.placement, one.link) for one in pair)) for pair in adjacent_links(scene)}
    assert set(found.things.exclusions) == own | near
    assert [p.name for p in found.things.poses] == ["closed", "open", "start"]
    assert found.gravity == pytest.approx(scene.gravity, abs=1e-6)
    (camera,) = found.cameras
    assert camera.fov_y_deg == pytest.approx(60.0, abs=1e-4)
    assert {light.name: light.kind for light in found.lights} == {"sun": "directional", "bulb": "point", "spot": "spot"}
    (sun,) = (light for light in found.lights if light.name == "sun")
    length = math.sqrt(0.2**2 + 0.5**2 + 1)
    assert sun.direction == pytest.approx((0.2 / length, 0.5 / length, -1 / length), abs=1e-6)


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


@pytest.mark.parametrize(("text", "cell"), IN_MJCF)
def test_what_scene_xml_says_otherwise_is_found(text: str, cell: str, folder: Path) -> None:
    tamper(folder / "scene.xml", edit(text))
    assert cell in pointers(folder)


# The same of scene.usda.
IN_USD = [
    pytest.param(
        "double3 xformOp:translate = ({-1.25|-1.2501}, 2, 0.9)", "placements/second_oven/position", marks=BY_MUJOCO
    ),
    ("point3f physics:localPos0 = (2, {1.5|1.51}, 0.9)", "placements/other_grill/position"),
    pytest.param("rel physics:body0 = </{World|World/oven}>", "placements/second_oven/base", marks=BY_MUJOCO),
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


@pytest.mark.parametrize(("text", "cell"), IN_USD)
def test_what_scene_usda_says_otherwise_is_found(text: str, cell: str, folder: Path) -> None:
    tamper(folder / "scene.usda", edit(text))
    assert cell in pointers(folder)


@BY_MUJOCO
def test_contacts_are_compared_too(folder: Path) -> None:
    # Of the one sphere.
    tamper(folder / "scene.xml", ('condim="6"', 'condim="3"'))
    assert pointers(folder) == ["bodies/orange/contacts"]
