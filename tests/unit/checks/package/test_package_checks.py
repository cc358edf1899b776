"""Checks of packages, MJCF and USD: silent on good ones, and each code is tripped by a fault of its own."""

from __future__ import annotations

import io
import multiprocessing
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

from casa_assets.checks.check import Package, run
from casa_assets.checks.readers import mujoco_facts
from casa_assets.checks.simready import warm
from casa_assets.checks.table import TABLE
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.parts import Box
from tests.support.asset.articulated_assets import grill
from tests.support.asset.asset_parts import box_inertial
from tests.support.asset.assets import EVERY, ball, microwave, rigid_mug, textured_box
from tests.support.asset.packages import LIMITS, Tampering, edit, not_run_here, packed, tamper, tripped, written

ROWS = [check for check in TABLE if check.code.startswith("MJC")]
FILES = ("USD", "PAR")
Build = Callable[[], Asset]


@pytest.mark.parametrize("build", [*EVERY, lambda: microwave(Base.FREE), grill])
def test_good_is_silent(build: Build, tmp_path: Path) -> None:
    package = written(build(), tmp_path)
    assert tripped(package, FILES) == set()
    found = run(package, package.asset.id, LIMITS, table=ROWS)
    assert found.issues == ()
    assert [result.code for result in found.results] == [check.code for check in ROWS]


# Code -> asset, file, what stands there, what is put there instead.
TAMPERED = [
    ("MJC001", ball, "model.xml", '<geom name="peel_0"', '<geom colour="red" name="peel_0"'),
    ("MJC001", ball, "scene.xml", "</worldbody>", "</worldbudy>"),
    ("MJC002", ball, "model.xml", "<asset>", '<statistic meaninertia="1"/><asset>'),
    ("MJC002", ball, "scene.xml", "<statistic ", '<statistic meaninertia="1" '),
    ("MJC003", ball, "model.xml", 'type="sphere" size="0.036 0.036 0.036"', 'type="sphere" size="0.036"'),
    ("MJC003", ball, "model.xml", 'group="0" ', ""),
    ("MJC003", ball, "model.xml", ' rgba="0 1 0 0"', ""),
    ("MJC003", rigid_mug, "model.xml", 'specular="0.32"', 'specular="-3"'),
    ("MJC003", microwave, "model.xml", '<material name="enamel', '<material name="plain"/><material name="enamel'),
    ("MJC003", microwave, "model.xml", 'limited="true"', ""),
    ("MJC004", rigid_mug, "model.xml", 'conaffinity="0" mass="0"/>', 'conaffinity="0" mass="1"/>'),
    ("MJC004", rigid_mug, "scene.xml", 'conaffinity="0" mass="0"/>', 'conaffinity="0" mass="1"/>'),
    ("MJC005", rigid_mug, "model.xml", 'mass="0.3"', 'mass="0.301"'),
    ("MJC005", rigid_mug, "scene.xml", 'fullinertia="0.0004 0.00043 ', 'fullinertia="0.0004 0.00044 '),
    ("MJC005", microwave, "model.xml", 'range="-1.57079633 0"', 'range="-1.5 0"'),
    ("MJC005", microwave, "model.xml", 'body name="door" pos="-0.24 ', 'body name="door" pos="-0.241 '),
    ("MJC005", microwave, "model.xml", 'friction="0.4 0.004 0.0001"', 'friction="0.5 0.004 0.0001"'),
    ("MJC005", microwave, "model.xml", '"microwave appliance"', '"microwave"'),
    ("MJC005", microwave, "model.xml", 'text name="base" data="fixed"', 'text name="base" data="free"'),
    ("MJC005", microwave, "model.xml", 'text name="base" data="fixed"', 'text name="base" data="loose"'),
    ("MJC005", microwave, "model.xml", 'body2="door"', 'body2="object"'),
    ("MJC005", microwave, "model.xml", 'frictionloss="0.3"', 'frictionloss="0.31"'),
    ("MJC005", microwave, "scene.xml", '"plate_place" type="sphere" pos="-0.04 ', '"plate_place" pos="-0.05 '),
    ("MJC005", grill, "scene.xml", '<key name="open" qpos="-1.3 ', '<key name="open" qpos="-1.2 '),
    ("MJC005", grill, "model.xml", 'text name="contract" data="microwave"', 'text name="contract" data="oven"'),
    ("MJC006", ball, "scene.xml", 'pos="0 0 -10"', 'pos="0 0 -500"'),
    ("MJC006", ball, "scene.xml", 'integrator="implicitfast"', 'integrator="implicitfast" gravity="5 0 -9.81"'),
    ("MJC008", ball, "scene.xml", 'margin="0.00001"', 'margin="0.00001" solref="0.4 1" solimp="0.1 0.1 0.01"'),
]  # fmt: skip


def lopsided_carton() -> Asset:
    """Its mass is beside its footprint."""
    carton = textured_box()
    return carton.replace(
        links=(carton.root.replace(inertial=box_inertial(0.5, (0.2, 0.06, 0.12), (0.14, 0.0, 0.06))),)
    )


def jammed_microwave() -> Asset:
    """Its door is so thick that it runs into the frame."""
    oven = microwave()
    door = oven.link("door")
    thick = door.colliders[0].replace(shape=Box(size=(0.38, 0.08, 0.28)))
    return oven.replace(links=(oven.root, door.replace(colliders=(thick,))), exclusions=())


@pytest.mark.parametrize(("code", "build", "file", "old", "new"), TAMPERED)
def test_a_changed_file_trips_one_code(code: str, build: Build, file: str, old: str, new: str, tmp_path: Path) -> None:
    package = packed(build(), tmp_path)
    tamper(package.root / file, (old, new))
    assert tripped(package, ("MJC",)) == {code}


def test_a_free_joint_in_the_model(tmp_path: Path) -> None:
    package = packed(ball(), tmp_path)
    # The loaders find `object` one body deep; a free joint is only legal at the top.
    text = package.mjcf.read_text().replace("<body>", "", 1).replace("</body>\n  </worldbody>", "</worldbody>")
    package.mjcf.write_text(text.replace("<inertial", "<freejoint/><inertial", 1))
    assert tripped(package, ("MJC",)) == {"MJC003"}


def test_a_lopsided_carton_and_a_door_that_runs_into_its_frame(tmp_path: Path) -> None:
    assert tripped(packed(lopsided_carton(), tmp_path), ("MJC",)) == {"MJC007"}
    jammed = jammed_microwave()
    (issue,) = run(packed(jammed, tmp_path), jammed.id, LIMITS, table=ROWS).issues
    assert (issue.code, issue.pointer) == ("MJC009", "joints/microjoint")
    assert tripped(packed(jammed.replace(exclusions=microwave().exclusions), tmp_path), ("MJC",)) == set()


def test_a_model_is_remembered_until_its_file_changes(tmp_path: Path) -> None:
    package = packed(ball(), tmp_path)
    first = mujoco_facts.load_mjcf(package.mjcf)
    assert mujoco_facts.load_mjcf(package.mjcf) is first
    tamper(package.mjcf, ('mass="0.17"', 'mass="0.175"'))
    assert mujoco_facts.load_mjcf(package.mjcf) is not first


def cut_in_half(package: Package) -> None:
    text = package.usd.read_text()
    package.usd.write_text(text[: len(text) // 2])


def corrupt_normal_map(package: Package) -> None:
    (picture,) = package.usd.parent.glob("textures/print_normal_*.png")
    out = io.BytesIO()
    Image.open(picture).convert("RGB").save(out, "JPEG")
    picture.write_bytes(out.getvalue())


# Code -> what is done to the USD of a carton: by a function, or by an edit.
IN_USD: dict[str, Tampering | str] = {
    "USD001": cut_in_half,
    "USD002": 'string author = "{Casa|}"',
    "USD003": "inputs:bias = {(-1, -1, -1, 0)|(0, 0, 0, 0)}",
    "USD004": "{|float physics:restitution = 0.5\n            }float physics:staticFriction",
    "USD005": corrupt_normal_map,
}
# Code -> what it is silent on, and what trips it: an asset, or what is changed in a file.
EXAMPLES: dict[str, tuple[Build, Build | Tampering | str]] = {
    **{code: (build, f"{old} -> {new}") for code, build, _, old, new in TAMPERED},
    "MJC007": (textured_box, lopsided_carton),
    "MJC009": (microwave, jammed_microwave),
    **{code: (textured_box, change) for code, change in IN_USD.items()},
}


@pytest.mark.parametrize("code", IN_USD)
def test_a_changed_layer_trips_its_code_alone(code: str, tmp_path: Path) -> None:
    package, change = written(textured_box(), tmp_path), IN_USD[code]
    if isinstance(change, str):
        tamper(package.usd, edit(change))
    else:
        change(package)
    assert tripped(package, FILES) == {code} - not_run_here()


def test_checks_say_nothing_in_the_terminal(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    good, bad = written(textured_box(), tmp_path / "good"), written(textured_box(), tmp_path / "bad")
    cut_in_half(bad)
    for package in (good, bad):
        tripped(package, FILES)
    assert capfd.readouterr() == ("", "")


def test_checks_run_in_a_forked_child(tmp_path: Path) -> None:
    """Twenty children of one warm parent: a lock or thread lost in the fork would hang some of them."""
    package = written(textured_box(), tmp_path)
    warm()
    tripped(package, FILES)
    context = multiprocessing.get_context("fork")
    children = [context.Process(target=lambda: sys.exit(len(tripped(package, FILES)))) for _ in range(20)]
    for child in children:
        child.start()
    for child in children:
        child.join(timeout=60)
    assert [child.exitcode for child in children] == [0] * len(children)
