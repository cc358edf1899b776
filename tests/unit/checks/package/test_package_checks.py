"""Checks of packages, MJCF and USD: silent on good ones, each code tripped by its fault alone; without validators."""

from __future__ import annotations

import io
import multiprocessing
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

from casa_assets.checks import simready, simready_python
from casa_assets.checks.check import Package, run
from casa_assets.checks.readers import mujoco_facts
from casa_assets.checks.simready import warm
from casa_assets.checks.table import TABLE
from casa_assets.families import build
from casa_assets.ingest.run import steps
from casa_assets.layouts.run import check
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.parts import Box
from casa_assets.model.issue import CheckResult, Report, Status
from tests.support.asset.articulated_assets import grill
from tests.support.asset.asset_parts import box_inertial
from tests.support.asset.assets import EVERY, ball, microwave, rigid_mug, textured_box
from tests.support.asset.packages import LIMITS, Tampering, edit, not_run_here, packed, tamper, tripped, written
from tests.support.kitchen.rooms import at, block, in_all_forms, room

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
    # It still rolls 3 cm in 2 s.
    ("MJC006", ball, "scene.xml", 'integrator="implicitfast"', 'integrator="implicitfast" gravity="0.02 0 -9.81"'),
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


VERSIONS = '{"simready-validate": "1", "simready-foundation-tier-core": "1"}'


@pytest.fixture
def absent(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No Python of this machine has the validator."""
    monkeypatch.delenv(simready_python.VARIABLE, raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.setattr(simready_python, "_versions_here", dict)
    monkeypatch.setattr(simready_python, "_CHECKOUT", tmp_path)


def python_that(does: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Name a program as the validator's Python: it says that it has the packages, and `does` something with files."""
    program = folder / "python"
    program.write_text(f"#!/bin/sh\ncase $4 in simready-validate) echo '{VERSIONS}' ;; *) {does} ;; esac\n")
    program.chmod(0o755)
    monkeypatch.setenv(simready_python.VARIABLE, str(program))


def judged(folder: Path) -> tuple[Report, CheckResult]:
    """The report on a sound mug, and what is said of SimReady in it."""
    report = run(written(rigid_mug(), folder), "mug", LIMITS)
    (result,) = (r for r in report.results if r.code == "USD002")
    return report, result


@pytest.mark.usefixtures("absent")
def test_without_it_an_asset_passes_and_a_check_was_not_run(tmp_path: Path) -> None:
    report, result = judged(tmp_path)
    assert (result.status, result.waived) == (Status.NOT_RUN, True)
    assert "SimReady's validator is not installed" in result.reason
    assert report.passed
    assert report.tally.not_run >= 1


@pytest.mark.usefixtures("absent")
@pytest.mark.parametrize("warm", [steps.warm, build.warm, check.warm])
def test_without_it_workers_start(warm: Callable[[], None], monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("simready", "simready.validate"):
        monkeypatch.setitem(sys.modules, name, None)  # cannot be imported
    simready.load_rules.cache_clear()
    with pytest.raises(ImportError):
        simready.load_rules()
    warm()


@pytest.mark.parametrize(
    ("does", "reason"),
    [
        ("kill -9 $$", "ended with -9"),
        ("echo no module >&2; exit 1", "ended with 1: no module"),
        ("echo nonsense", "ended with 0"),
        ("sleep 60", "did not end within 0.5 s"),
        ("echo '{\"verdict\": null}'", "gave no verdict"),
    ],
)
def test_a_validator_that_fails_on_a_file_keeps_it_out(
    does: str, reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    python_that(does, tmp_path, monkeypatch)
    monkeypatch.setattr(simready, "CHILD_LIMIT_S", 0.5 if "sleep" in does else 60.0)
    report, result = judged(tmp_path)
    assert (result.status, result.waived) == (Status.NOT_RUN, False)
    assert reason in result.reason
    assert [issue.code for issue in report.errors] == ["USD002"]


def test_a_python_that_cannot_import_it_keeps_nothing_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    python_that('echo \'{"missing": "no libusd"}\'', tmp_path, monkeypatch)
    report, result = judged(tmp_path)
    assert (result.status, result.waived) == (Status.NOT_RUN, True)
    assert "no libusd" in result.reason
    assert report.passed


def test_without_mujocos_reader_of_usd_an_asset_and_a_kitchen_pass(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("readers.usd_facts", "package.usd", "scene.formats"):
        monkeypatch.setattr(f"casa_assets.checks.{module}.missing_importer", lambda: "it is not installed")
    asset = run(written(rigid_mug(), tmp_path), "mug", LIMITS)
    kitchen = run(in_all_forms(room((block("crate", (0.2, 0.2, 0.2)), at(0.0, 0.0, 0.0))), tmp_path), "room", LIMITS)
    absent = {r.code for r in (*asset.results, *kitchen.results) if r.reason == "it is not installed" and r.waived}
    assert absent == {"USD004", "PAR001", "PAR003", "PAR004", "SCN017", "SCN018"}
    assert asset.passed
    assert kitchen.passed
