"""Checks of the batch form: silent on what is right, alone where one thing is wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from casa_assets.addons.batch.merged_form import BatchForms
from casa_assets.asset.lightweight import light_scene
from casa_assets.checks.check import run
from casa_assets.checks.scene import engine_sizes as sizes_of_engines
from casa_assets.checks.scene.engine_sizes import engine_sizes
from casa_assets.checks.scene.light_forms import BATCH_FILE, BatchSubject
from casa_assets.formats.mjcf import batch
from casa_assets.model.asset.asset import Base
from casa_assets.model.issue import Report
from casa_assets.model.kitchen.scene import EngineSizes, Scene
from tests.support.asset.cupboard import cupboard
from tests.support.asset.examples import LIMITS, check_examples
from tests.support.asset.packages import tamper
from tests.support.kitchen.rooms import at, block, in_all_forms, room

# Makes what is judged, below a folder.
Make = Callable[[Path], object]
CRATE = 'name="thing_0__shape_0" type="box" size="0.1 0.1 0.1" pos="0 0 0.1"'
WORLD = "<worldbody>"


def things() -> Scene:
    return room((block("crate", (0.2, 0.2, 0.2), Base.FREE), at(1.0, -1.0, 0.0)), (cupboard(), at(0.0, 0.0, 0.0)))


def forms(folder: Path) -> BatchSubject:
    scene = things()
    root = in_all_forms(scene, folder).scene_subject.root
    form = BatchForms(light_scene(scene)).form()
    (root / BATCH_FILE).write_bytes(batch.write(form).entries[BATCH_FILE])
    return BatchSubject(form, root)


def tampered(old: str, new: str) -> Make:

    def make(folder: Path) -> BatchSubject:
        subject = forms(folder)
        tamper(subject.root / BATCH_FILE, (old, new))
        return subject

    return make


def geom(size: str, pos: str, bits: tuple[int, int] = (3, 0)) -> str:
    contype, conaffinity = bits
    return f'<geom type="box" size="{size}" pos="{pos}" contype="{contype}" conaffinity="{conaffinity}" group="2"/>'


def far(count: int) -> str:
    """Small boxes where no ray gets."""
    return "".join(geom("0.01 0.01 0.01", f"{50 + i} 50 1") for i in range(count))


def inside_crate(count: int) -> str:
    """Small boxes in the crate that touch what it touches."""
    small = '<geom type="box" size="0.01 0.01 0.01" pos="0 0 0.1" contype="3" conaffinity="2" group="2" mass="0"/>'
    return f"{small * count}<geom {CRATE}"


def sizes(awake_in_use: int) -> Make:
    numbers = {"nconmax": 8, "njmax": 8, "nccdmax": 8, "nvmax": 8, "contacts": 1, "rows": 1, "convex_pairs": 1}
    return lambda _: EngineSizes(**numbers, awake=56, awake_in_use=awake_in_use, fixtures=1, mujoco_bytes=1)


def many_pairs(folder: Path) -> BatchSubject:
    subject = tampered(f"<geom {CRATE}", inside_crate(140))(folder)
    assert isinstance(subject, BatchSubject)
    tamper(subject.root / BATCH_FILE, (WORLD, WORLD + far(138)))
    return subject


# Code -> what it is silent on, and what trips it alone.
EXAMPLES: dict[str, tuple[Make, Make]] = {
    "BAT001": (forms, tampered('frictionloss="2.5"', 'frictionloss="2.4"')),
    "BAT002": (forms, tampered(WORLD, WORLD + far(300))),
    "BAT003": (forms, many_pairs),
    "BAT004": (forms, tampered('sleep="enable"', 'sleep="disable"')),
    "BAT005": (forms, tampered(CRATE, CRATE.replace("0 0 0.1", "0 0 0.098"))),
    "BAT006": (forms, tampered(CRATE, CRATE.replace("0 0 0.1", "0 0 0.106"))),
    "BAT007": (forms, tampered(WORLD, WORLD + geom("1.9 0.05 1.9", "0 -1.5 1.9"))),
    "BAT008": (forms, tampered(WORLD, WORLD + geom("0.27 0.17 0.1", "0 0 0.15"))),
    "BAT009": (forms, tampered(WORLD, WORLD + geom("0.05 0.01 0.05", "0.2 -0.3 0.2", (1, 1)))),
    "BAT010": (sizes(56), sizes(57)),
}


@pytest.mark.parametrize("code", EXAMPLES)
def test_bad_trips_its_code_alone(code: str, tmp_path: Path, silent: dict[Make, Report]) -> None:
    good, bad = EXAMPLES[code]
    check_examples(code, silent[good], run(bad(tmp_path), "room", LIMITS))


@pytest.fixture(scope="module")
def silent(tmp_path_factory: pytest.TempPathFactory) -> dict[Make, Report]:
    made = {good for good, _ in EXAMPLES.values()}
    return {good: run(good(tmp_path_factory.mktemp("good")), "room", LIMITS) for good in made}


def test_a_large_picture_is_told_by_its_name_and_a_file_that_is_not_there_once(tmp_path: Path) -> None:
    large = '<texture name="oak" type="2d" builtin="flat" rgb1="1 1 1" width="512" height="256"/>'
    shown = f'{large}<material name="oak" texture="oak"/></asset>'
    subject = tampered("</asset>", shown)(tmp_path)
    found = run(subject, "room", LIMITS).issues
    assert [(issue.code, issue.pointer) for issue in found] == [("BAT001", "textures/oak")]
    assert isinstance(subject, BatchSubject)
    (subject.root / BATCH_FILE).unlink()
    lost = run(BatchSubject(subject.form, subject.root), "room", LIMITS)
    assert [issue.code for issue in lost.issues] == ["BAT001"]


def test_sizes_for_engines_are_found_with_a_margin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sizes_of_engines, "TRIAL_S", 1.0)
    monkeypatch.setattr(sizes_of_engines, "IN_USE_S", 1.0)
    found = engine_sizes(forms(tmp_path))
    assert found.fixtures == 1
    # Ten things of six degrees of freedom, a robot of nine, and the cupboard's own four.
    assert 60 < found.awake <= 60 + 9 + 4 + 6
    assert 9 < found.awake_in_use <= 9 + 4 + 6
    assert 100_000 < found.mujoco_bytes < 20_000_000
    for told, counted in (
        (found.nconmax, found.contacts),
        (found.njmax, found.rows),
        (found.nccdmax, found.convex_pairs),
        (found.nvmax, found.awake),
    ):
        assert counted * 1.5 <= told <= counted * 1.5 + 8
