"""Each MJC code: silent on what is right, and alone in speaking where one thing is wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from casa_assets import registry
from casa_assets.checks.check import Package, run
from casa_assets.checks.readers import mujoco_facts
from casa_assets.checks.table import TABLE
from casa_assets.formats.mjcf import write
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.parts import Box
from casa_assets.model.issue import Report
from tests.support.asset.articulated_assets import grill
from tests.support.asset.asset_parts import box_inertial
from tests.support.asset.assets import EVERY, ball, category, microwave, rigid_mug, textured_box, write_to

ROWS = [check for check in TABLE if check.code.startswith("MJC")]
LIMITS = registry.load().limits


def packed(asset: Asset, folder: Path) -> Package:
    return Package(asset, category(asset), write_to(write(asset), folder / asset.id))


def report(package: Package) -> Report:
    return run(package, package.asset.id, LIMITS, table=ROWS)


def tamper(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def codes(found: Report) -> set[str]:
    return {issue.code for issue in found.issues}


@pytest.mark.parametrize("build", [*EVERY, lambda: microwave(Base.FREE), grill])
def test_good_is_silent(build: Callable[[], Asset], tmp_path: Path) -> None:
    found = report(packed(build(), tmp_path))
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
    ("MJC003", microwave, "model.xml", '<material name="', '<material name="plain"/><material name="'),
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


# Code -> what it is silent on, and what trips it: an asset, or a file of the package and what is changed in it.
EXAMPLES: dict[str, tuple[Callable[[], Asset], Callable[[], Asset] | tuple[str, str, str]]] = {
    **{code: (build, (file, old, new)) for code, build, file, old, new in TAMPERED},
    "MJC007": (textured_box, lopsided_carton),
    "MJC009": (microwave, jammed_microwave),
}


class TestBad:
    @pytest.mark.parametrize(("code", "build", "file", "old", "new"), TAMPERED)
    def test_trips_one_code(
        self, code: str, build: Callable[[], Asset], file: str, old: str, new: str, tmp_path: Path
    ) -> None:
        package = packed(build(), tmp_path)
        tamper(package.root / file, old, new)
        assert codes(report(package)) == {code}

    def test_a_free_joint_in_the_model(self, tmp_path: Path) -> None:
        package = packed(ball(), tmp_path)
        # The loaders find `object` one body deep; a free joint is only legal at the top.
        text = package.mjcf.read_text().replace("<body>", "", 1).replace("</body>\n  </worldbody>", "</worldbody>")
        package.mjcf.write_text(text.replace("<inertial", "<freejoint/><inertial", 1))
        assert codes(report(package)) == {"MJC003"}

    def test_a_door_that_runs_into_its_frame(self, tmp_path: Path) -> None:
        jammed = jammed_microwave()
        found = report(packed(jammed, tmp_path))
        assert codes(found) == {"MJC009"}
        assert found.issues[0].pointer == "joints/microjoint"
        excluded = jammed.replace(exclusions=microwave().exclusions)
        assert codes(report(packed(excluded, tmp_path / "excluded"))) == set()


def test_a_model_is_remembered_until_its_file_changes(tmp_path: Path) -> None:
    package = packed(ball(), tmp_path)
    first = mujoco_facts.load_mjcf(package.mjcf)
    assert mujoco_facts.load_mjcf(package.mjcf) is first
    tamper(package.mjcf, 'mass="0.17"', 'mass="0.175"')
    assert mujoco_facts.load_mjcf(package.mjcf) is not first
