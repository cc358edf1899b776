"""MJCF and USD of one asset are one fact table, whoever reads them."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path

import pytest

from casa_assets.checks.readers import mujoco_facts, usd_facts
from casa_assets.checks.readers.facts import Cells, asset_facts, compare
from casa_assets.model.asset.asset import Asset
from tests.support.asset.articulated_assets import grill
from tests.support.asset.assets import EVERY, drawer_unit, microwave
from tests.support.asset.packages import Tampering, edit, not_run_here, tamper, tripped, written

RELATIVE, LENGTH = 1e-5, 1e-6
# MuJoCo's reader of USD is not there for every Python.
USD_READERS = (usd_facts.pxr_facts, *([] if usd_facts.missing_importer() else [usd_facts.mujoco_facts]))

STEEL = "</cabinet_0123456789/physicsMaterials/steel>"
CARDBOARD = "</cabinet_0123456789/physicsMaterials/cardboard>"


def edited(text: str) -> Tampering:
    """An edit of the USD layer."""
    return lambda package: tamper(package.usd, edit(text))


# Only MuJoCo reads the binding for all purposes, only UsdPhysics that for physics.
BAD: dict[str, Tampering] = {
    "PAR001": edited(f"{{rel material:binding = {STEEL}|}}"),
    "PAR002": edited(f"rel material:binding:physics = {{{STEEL}|{CARDBOARD}}}"),
    "PAR003": edited("mjc:condim = {4|3}"),
    "PAR004": edited("xformOp:translate = (0, 0, {0.01|0.0101})"),
}

# Code -> what it is silent on, and what is done to the package of it; tests/unit/checks/test_table.py reads it.
EXAMPLES = {code: (drawer_unit, corrupt) for code, corrupt in BAD.items()}


@pytest.mark.parametrize("code", BAD)
def test_bad_example_trips_its_code_alone(code: str, tmp_path: Path) -> None:
    package = written(drawer_unit(), tmp_path)
    assert tripped(package, ("USD", "PAR")) == set()
    other = written(drawer_unit(), tmp_path / "bad")
    BAD[code](other)
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


@pytest.mark.parametrize(("text", "cell"), IN_MJCF)
def test_what_model_xml_says_otherwise_is_found(text: str, cell: str, tmp_path: Path) -> None:
    package = written(grill(), tmp_path)
    tamper(package.mjcf, edit(text))
    assert cell in _cells(mujoco_facts.facts(package.mjcf))


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


@pytest.mark.parametrize(("text", "cell"), IN_USD)
def test_what_the_layer_says_otherwise_is_found(text: str, cell: str, tmp_path: Path) -> None:
    package = written(grill(), tmp_path)
    tamper(package.usd, edit(text))
    assert _cells(usd_facts.pxr_facts(package.usd)) == [cell]


def test_a_pose_that_one_format_alone_has_trips_parity(tmp_path: Path) -> None:
    package = written(grill(), tmp_path)
    tamper(package.usd, ('string pose = "closed"', 'string pose = "open"'))
    # MuJoCo reads the bodies where they stand: another selection is another zero.
    assert tripped(package, ("PAR",)) >= {"PAR001", "PAR004"} - not_run_here(on_good=True)
    other = written(grill(), tmp_path / "other")
    tamper(other.mjcf, ('key name="on"', 'key name="hot"'))
    assert tripped(other, ("PAR",)) == {"PAR001", "PAR002"} - not_run_here()


def _cells(found: Cells) -> list[str]:
    return [where for where, _ in compare(asset_facts(grill()), found, RELATIVE, LENGTH)]
