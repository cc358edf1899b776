"""MJCF and USD of one asset or scene are one fact table, whoever reads them, and a single edit of either is found."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import pytest
from pxr import Usd

from casa_assets.checks.readers import mujoco_facts, usd_facts
from casa_assets.checks.readers.facts import Cells, asset_facts, compare
from casa_assets.checks.scene.formats import SCENE_LENGTH_TOLERANCE_M, SCENE_TOLERANCE, SceneFiles, formats_agree
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.mesh.inertia import adjacent_links
from casa_assets.model.asset.asset import Asset
from tests.support.asset.articulated_assets import grill
from tests.support.asset.assets import EVERY, drawer_unit, microwave
from tests.support.asset.packages import edit, not_run_here, tamper, tripped, written
from tests.support.kitchen import scenes
from tests.support.kitchen.scenes import body, corner, expected

RELATIVE, LENGTH = 1e-5, 1e-6
# MuJoCo's reader of USD is not there for every Python.
USD_READERS = (usd_facts.pxr_facts, *([] if usd_facts.missing_importer() else [usd_facts.mujoco_facts]))

STEEL = "</cabinet_0123456789/physicsMaterials/steel>"
CARDBOARD = "</cabinet_0123456789/physicsMaterials/cardboard>"


# Code -> what it is silent on, and an edit of its USD layer; tests/unit/checks/test_table.py reads it.
# Only MuJoCo reads the binding for all purposes, only UsdPhysics that for physics.
EXAMPLES = {
    "PAR001": (drawer_unit, f"{{rel material:binding = {STEEL}|}}"),
    "PAR002": (drawer_unit, f"rel material:binding:physics = {{{STEEL}|{CARDBOARD}}}"),
    "PAR003": (drawer_unit, "mjc:condim = {4|3}"),
    "PAR004": (drawer_unit, "xformOp:translate = (0, 0, {0.01|0.0101})"),
}


@pytest.mark.parametrize("code", EXAMPLES)
def test_bad_example_trips_its_code_alone(code: str, tmp_path: Path) -> None:
    make, text = EXAMPLES[code]
    package = written(make(), tmp_path)
    assert tripped(package, ("USD", "PAR")) == set()
    other = written(make(), tmp_path / "bad")
    tamper(other.usd, edit(text))
    assert tripped(other, ("USD", "PAR")) == {code} - not_run_here()


def test_both_sides_of_a_joint_are_read(tmp_path: Path) -> None:
    """MuJoCo reads the child's side and where the bodies stand, UsdPhysics the parent's side."""
    package = written(microwave(), tmp_path)
    head, tail = package.usd.read_text().split('PhysicsRevoluteJoint "microjoint"')
    tail = tail.replace("localRot0 = (1, 0, 0, 0)", "localRot0 = (0.9999995, 0.001, 0, 0)")
    package.usd.write_text(f'{head}PhysicsRevoluteJoint "microjoint"{tail}')
    assert tripped(package, ("USD", "PAR")) == {"PAR002", "PAR004"}


@pytest.mark.parametrize("make", [*EVERY, grill])
def test_every_reader_of_every_file_says_what_the_asset_says(make: Callable[[], Asset], tmp_path: Path) -> None:
    asset = make()
    package = written(asset, tmp_path)
    truth = asset_facts(asset)
    assert len(package.usd_files) == (2 if len(asset.links) > 1 else 1)
    readings = [read(path) for path in package.usd_files for read in USD_READERS]
    for found in (mujoco_facts.facts(package.mjcf), *readings):
        assert compare(truth, found, RELATIVE, LENGTH) == []


def test_what_the_nested_layer_alone_says_otherwise_is_found(tmp_path: Path) -> None:
    package = written(drawer_unit(), tmp_path)
    tamper(package.usd_files[1], ("xformOp:translate = (-0.22, 0, 0)", "xformOp:translate = (-0.23, 0, 0)"))
    assert tripped(package, ("USD", "PAR")) == {"PAR004"} - not_run_here(on_good=True)  # MuJoCo finds it
    over = '            over "knob"\n            {\n'
    other = written(drawer_unit(), tmp_path / "other")
    tamper(other.usd_files[1], (over, f"{over}                float physics:mass = 9\n"))
    assert tripped(other, ("USD", "PAR")) == {"PAR001", "PAR002"} - not_run_here()


def test_travel_of_a_slide_is_a_length() -> None:
    facts = asset_facts(drawer_unit())
    changed = copy.deepcopy(facts)
    changed["bodies"]["drawer"]["joint"]["range"] = (0.0, 0.280005)
    assert [where for where, _ in compare(facts, changed, RELATIVE, LENGTH)] == ["bodies/drawer/joint/range"]


# Edits of model.xml, and the cell of the table that differs.
IN_MJCF = [
    ('name="label__handle" data="{handle_0|door_1} ', "labels"),
    ('name="grip__microjoint" data="{handle_0|door_0}"', "grips"),
    ('name="behind__rack_joint" data="{microjoint|knob_joint}"', "behind"),
    ('data="microjoint open {0.9|0.8} 1"', "states/door_open/interval"),
    ('data="microjoint {open|ajar} 0.9 1"', "states/door_open/value"),
    ("[{0.5|0.6},2.4]", "behavior"),
    ('name="contract" data="{microwave|oven}"', "contract"),
    ('key name="{on|hot}"', "poses"),
    ('key name="on" qpos="0 {0|0.1} 1.2"', "poses/on/rack/position"),
    ('name="display" type="box" {pos="0 0 0" size="0.01|size="0.02} ', "places/display/size"),
    ('name="heat_glow" type="{cylinder|box}"', "places/heat_glow/kind"),
    ('name="reg_tray" type="cylinder" pos="{-0.04|-0.05} ', "places/tray/position"),
    ('emission="{0.7|0.6}"', "looks/lamp_main/light"),
    ('rgba="{0.24|0.34}', "looks/door_main/color"),
    ('stiffness="{0.02|0.021}"', "bodies/knob/joint/resistance"),
]


# The same of the USD layer, as OpenUSD reads it.
IN_USD = [
    ('semantics:labels:part = ["{handle|pull}"]', "labels"),
    ('casa:grip = "{handle_0|door_0}"', "grips"),
    ('casa:behind = "{microjoint|nothing}"', "behind"),
    ('string value = "{open|ajar}"', "states/door_open/value"),
    ("[{0.5|0.6},2.4]", "behavior"),
    ('casa:contract = "{microwave|oven}"', "contract"),
    ("double3 xformOp:translate = (-0.04, {-0.15|-0.14}, 0.1)", "poses/open/rack/position"),
    ("xformOp:scale = (0.02, {0.04|0.05}, 0.001)", "places/display/size"),
    ("primvars:displayOpacity = [{0|0.5}]", "places/heat_glow/color"),
    ("inputs:emissiveColor = ({0.7|0.6}, ", "looks/lamp_main/light"),
    ("inputs:opacity = {0.5|0.6}", "looks/door_main/color"),
    ("newton:friction = {0.5|0.6}", "bodies/rack/joint/resistance"),
    ("newton:armature = {0.0001|0.0002}", "bodies/knob/joint/resistance"),
]


@pytest.mark.parametrize(
    ("is_usd", "text", "cell"), [*((False, *row) for row in IN_MJCF), *((True, *row) for row in IN_USD)]
)
def test_what_one_file_of_an_asset_says_otherwise_is_found(is_usd: bool, text: str, cell: str, tmp_path: Path) -> None:
    package = written(grill(), tmp_path)
    tamper(package.usd if is_usd else package.mjcf, edit(text))
    found = usd_facts.pxr_facts(package.usd) if is_usd else mujoco_facts.facts(package.mjcf)
    differing = [where for where, _ in compare(asset_facts(grill()), found, RELATIVE, LENGTH)]
    assert differing == [cell] if is_usd else cell in differing


def test_a_pose_that_one_format_alone_has_trips_parity(tmp_path: Path) -> None:
    package = written(grill(), tmp_path)
    tamper(package.usd, ('string pose = "closed"', 'string pose = "open"'))
    # MuJoCo reads the bodies where they stand: another selection is another zero.
    assert tripped(package, ("PAR",)) >= {"PAR001", "PAR004"} - not_run_here(on_good=True)
    other = written(grill(), tmp_path / "other")
    tamper(other.mjcf, ('key name="on"', 'key name="hot"'))
    assert tripped(other, ("PAR",)) == {"PAR001", "PAR002"} - not_run_here()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return scenes.written(corner(), tmp_path)


def pointers(folder: Path) -> list[str]:
    files = SceneFiles(SceneSubject(corner(), folder))
    return list(dict.fromkeys(where for where, _ in formats_agree(files, 0.0).problems))


# Edits of scene_nested.usda, and a cell that then differs.
IN_NESTED = [
    ("double3 xformOp:translate = (-0.04, {-0.1|-0.2}, 0.1)", "poses/start"),
    ('over "door"\n{|            (active = false)\n}', "bodies"),
]


@pytest.mark.parametrize(("text", "cell"), IN_NESTED)
def test_what_the_nested_layer_of_a_scene_says_otherwise_is_found(text: str, cell: str, folder: Path) -> None:
    assert pointers(folder) == []
    tamper(folder / "scene_nested.usda", edit(text))
    scene, nested = by_mujoco(folder / "scene.xml"), by_openusd(folder / "scene_nested.usda")
    found = [where for where, _ in compare(scene, nested, SCENE_TOLERANCE, SCENE_LENGTH_TOLERANCE_M)]
    assert any(where.startswith(cell) for where in found), found


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
    pairs = ((p.name, pair) for p in scene.placements for pair in scene.asset_of[p.name].exclusions)
    own = {tuple(sorted((body(name, pair.first), body(name, pair.second)))) for name, pair in pairs}
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
IN_SCENE_XML = [
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
IN_SCENE_USD = [
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
    *(("scene.xml", *case) for case in IN_SCENE_XML),
    *(("scene.usda", *case) for case in IN_SCENE_USD),
    *(pytest.param(*case, marks=BY_MUJOCO) for case in ONLY_BY_MUJOCO),
]


@pytest.mark.parametrize(("file", "text", "cell"), EDITS)
def test_what_one_file_says_otherwise_is_found(file: str, text: str, cell: str, folder: Path) -> None:
    tamper(folder / file, edit(text))
    found = pointers(folder)
    assert cell in found
    assert not cell.endswith("contacts") or found == [cell]
