"""Checks of a scene's other forms, of its previews and its speed: silent on what is right, alone where one is wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from casa_assets.addons.batch.merged_form import BatchForms
from casa_assets.asset.lightweight import light_scene
from casa_assets.checks.check import run
from casa_assets.checks.scene import engine_sizes
from casa_assets.checks.scene import subject as scene_subject
from casa_assets.checks.scene.formats import SceneFiles
from casa_assets.checks.scene.light_forms import BATCH_FILE, BatchSubject
from casa_assets.checks.scene.placement import PreviewImages
from casa_assets.checks.scene.rest import MeasuredSpeed
from casa_assets.formats.mjcf import batch
from casa_assets.model.asset.asset import Base
from casa_assets.model.issue import Report, Status
from casa_assets.model.kitchen.scene import EngineSizes
from tests.support.asset.assets import textured_box
from tests.support.asset.cupboard import cupboard
from tests.support.asset.examples import LIMITS, check_examples
from tests.support.asset.packages import not_run_here, tamper
from tests.support.kitchen.rooms import at, block, in_all_forms, room

# Makes what is judged, below a folder.
Make = Callable[[Path], object]
LIGHT_BOX = 'name="thing_0__shape_0" type="box" size="0.1 0.1 0.1" pos="0 0 0.1"'
WORLD, STATIC = "<worldbody>", "float physics:static"


CRATE = block("crate", (0.2, 0.2, 0.2), Base.FREE)


def forms(folder: Path) -> SceneFiles:
    return in_all_forms(room((CRATE, at(0.0, 0.0, 0.0)), (textured_box(), at(0.5, 0.0, 0.0))), folder)


def tampered(name: str, old: str, new: str) -> Make:
    """The same with a text of one file replaced; `name`: of the file, or the beginning of an asset's."""

    def make(folder: Path) -> SceneFiles:
        files = forms(folder)
        own = files.scene_subject.root / name
        (path,) = [own] if own.is_file() else folder.glob(f"assets/usd/{name}*/{name}*.usda")
        tamper(path, (old, new))
        return files

    return make


def picture(*, black: float = 0.0, white: float = 0.0) -> Make:
    shot = np.full((50, 50, 3), 128, dtype=np.uint8)
    flat = shot.reshape(-1, 3)
    flat[: round(black * len(flat))] = 4
    flat[len(flat) - round(white * len(flat)) :] = 255
    return lambda _: PreviewImages({"overview": np.full((4, 4, 3), 90, dtype=np.uint8), "at_sink": shot})


def speed(load_ms: float = 900.0, steps_per_s: float = 5000.0) -> Make:
    return lambda _: MeasuredSpeed(load_ms, steps_per_s, 0.002)


def batched(folder: Path) -> BatchSubject:
    scene = room((CRATE, at(1.0, -1.0, 0.0)), (cupboard(), at(0.0, 0.0, 0.0)))
    root = in_all_forms(scene, folder).scene_subject.root
    form = BatchForms(light_scene(scene)).form()
    (root / BATCH_FILE).write_bytes(batch.write(form).entries[BATCH_FILE])
    return BatchSubject(form, root)


def batch_tampered(*changes: tuple[str, str]) -> Callable[[Path], BatchSubject]:
    def make(folder: Path) -> BatchSubject:
        subject = batched(folder)
        tamper(subject.root / BATCH_FILE, *changes)
        return subject

    return make


def batch_with(*geoms: str) -> Make:
    """The same with more in the world."""
    return batch_tampered((WORLD, WORLD + "".join(geoms)))


def raised(height: str) -> tuple[str, str]:
    """The crate's box at another height."""
    return LIGHT_BOX, LIGHT_BOX.replace("0 0 0.1", f"0 0 {height}")


def geom(size: str, pos: str, bits: tuple[int, int] = (3, 0)) -> str:
    contype, conaffinity = bits
    return f'<geom type="box" size="{size}" pos="{pos}" contype="{contype}" conaffinity="{conaffinity}" group="2"/>'


def far(count: int) -> str:
    """Small boxes where no ray gets."""
    return "".join(geom("0.01 0.01 0.01", f"{50 + i} 50 1") for i in range(count))


def sizes(awake_in_use: int) -> Make:
    numbers = {"nconmax": 8, "njmax": 8, "nccdmax": 8, "nvmax": 8, "contacts": 1, "rows": 1, "convex_pairs": 1}
    return lambda _: EngineSizes(**numbers, awake=56, awake_in_use=awake_in_use, fixtures=1, mujoco_bytes=1)


# In the crate, touching what it touches.
SMALL = '<geom type="box" size="0.01 0.01 0.01" pos="0 0 0.1" contype="3" conaffinity="2" group="2" mass="0"/>'
MANY_PAIRS = (f"<geom {LIGHT_BOX}", f"{SMALL * 140}<geom {LIGHT_BOX}")
# Code -> what it is silent on, and what trips it alone.
EXAMPLES: dict[str, tuple[Make, Make]] = {
    "SCN017": (forms, tampered("scene.xml", 'data="wall_cabinet object"', 'data="drawer object"')),
    "SCN018": (forms, tampered("crate", STATIC, f"float physics:restitution = 0.5\n            {STATIC}")),
    "SCN019": (forms, tampered("carton", "inputs:bias = (-1, -1, -1, 0)", "inputs:bias = (0, 0, 0, 0)")),
    "SCN020": (forms, tampered("scene.usda", "metersPerUnit = 1", "metersPerUnit = 0.01")),
    "SCN021": (forms, tampered("scene_light.xml", 'pos="0 0 0.1" mass="1"', 'pos="0 0 0.1" mass="2"')),
    "SCN022": (forms, tampered("scene_light.xml", *raised("0.098"))),
    "SCN024": (picture(black=0.04), picture(black=0.06)),
    "SCN025": (picture(white=0.04), picture(white=0.06)),
    "SCN026": (speed(load_ms=4900.0), speed(load_ms=5100.0)),
    "SCN027": (speed(steps_per_s=520.0), speed(steps_per_s=480.0)),
    "SCN028": (forms, tampered("scene_light.xml", *raised("0.106"))),
    "BAT001": (batched, batch_tampered(('frictionloss="2.5"', 'frictionloss="2.4"'))),
    "BAT002": (batched, batch_with(far(300))),
    "BAT003": (batched, batch_tampered(MANY_PAIRS, (WORLD, WORLD + far(138)))),
    "BAT004": (batched, batch_tampered(('sleep="enable"', 'sleep="disable"'))),
    "BAT005": (batched, batch_tampered(raised("0.098"))),
    "BAT006": (batched, batch_tampered(raised("0.106"))),
    "BAT007": (batched, batch_with(geom("1.9 0.05 1.9", "0 -1.5 1.9"))),
    "BAT008": (batched, batch_with(geom("0.27 0.17 0.1", "0 0 0.15"))),
    "BAT009": (batched, batch_with(geom("0.05 0.01 0.05", "0.2 -0.3 0.2", (1, 1)))),
    "BAT010": (sizes(56), sizes(57)),
}


@pytest.fixture(scope="module")
def silent(tmp_path_factory: pytest.TempPathFactory) -> dict[Make, Report]:
    made = {good for good, _ in EXAMPLES.values()}
    return {good: run(good(tmp_path_factory.mktemp("good")), "room", LIMITS) for good in made}


@pytest.mark.parametrize("code", EXAMPLES)
def test_each_code_is_tripped_by_its_fault_alone(code: str, tmp_path: Path, silent: dict[Make, Report]) -> None:
    good, bad = EXAMPLES[code]
    report = run(bad(tmp_path), "room", LIMITS)
    if code in not_run_here():
        assert (silent[good].issues, report.issues) == ((), ())
    else:
        check_examples(code, silent[good], report)


class TestForms:
    def test_what_is_not_there_is_said_once(self, tmp_path: Path) -> None:
        files = forms(tmp_path)
        files.usd.unlink()
        files.light.unlink()
        report = run(files, "room", LIMITS)
        assert [i.code for i in report.issues] == ["SCN018", "SCN021"]
        assert all(i.pointer in (files.usd.name, files.light.name) for i in report.issues)

    def test_each_cell_counts_and_so_does_what_the_nested_layer_alone_says(self, tmp_path: Path) -> None:
        files = in_all_forms(room((cupboard(), at(0.0, 0.0, 0.0))), tmp_path / "nested")
        over = 'over "object"\n        {\n'
        tamper(files.nested, (over, f"{over}            float physics:mass = 77\n"))
        (issue,) = run(files, "room", LIMITS).issues
        assert (issue.code, issue.pointer) == ("SCN017", "nested/bodies/thing_0/mass")
        files = forms(tmp_path)
        changes = ('gravity="0 0 -9.81"', 'gravity="0 0 -9.7"'), ('data="wall_cabinet object"', 'data="drawer"')
        tamper(files.scene_subject.mjcf, *changes)
        report = run(files, "room", LIMITS)
        assert {i.pointer for i in report.issues} == {"gravity", "placements/thing_0/classes"}
        assert [r.number for r in report.results if r.code == "SCN017"] == [2.0]

    def test_light_form_that_lacks_a_joint(self, tmp_path: Path) -> None:
        files = in_all_forms(room((cupboard(), at(0.0, 0.0, 0.0))), tmp_path)
        text = files.light.read_text()
        joint = next(line for line in text.splitlines() if 'name="thing_0__door_hinge"' in line and "<joint" in line)
        # Its numbers in the keys go with it, which the check is not about.
        head, _, _ = text.replace(joint, "").partition("<keyframe>")
        files.light.write_text(head + "</mujoco>")
        (issue,) = run(files, "room", LIMITS).issues
        assert (issue.code, issue.pointer) == ("SCN021", "joints")
        assert "thing_0__door_hinge" in issue.message

    def test_a_meshed_light_form_and_no_picture_are_no_pass(self, tmp_path: Path) -> None:
        files = forms(tmp_path)
        files.light.write_bytes(files.scene_subject.mjcf.read_bytes())
        message = [i.message for i in run(files, "room", LIMITS).issues if i.code == "SCN021"]
        assert [s.split(";")[0] for s in message] == ["has 3 meshes", "has 1 materials with pictures"]
        report = run(PreviewImages({}), "room", LIMITS)
        assert {(r.code, r.status) for r in report.results} == {(c, Status.NOT_RUN) for c in ("SCN024", "SCN025")}
        assert not report.passed


def test_stopwatch_does_not_count_the_time_that_a_process_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, processor = iter([10.0, 40.0, 50.0, 50.5]), iter([2.0, 3.5, 4.0, 6.0])
    monkeypatch.setattr(scene_subject.time, "perf_counter", lambda: next(clock))
    monkeypatch.setattr(scene_subject.time, "process_time", lambda: next(processor))
    assert scene_subject.timed(list)[1] == 1.5, "of 30 s of the clock"
    assert scene_subject.timed(list)[1] == 0.5, "two threads have used 2 s of the processor"


def test_a_large_picture_is_told_by_its_name_and_a_file_that_is_not_there_once(tmp_path: Path) -> None:
    large = '<texture name="oak" type="2d" builtin="flat" rgb1="1 1 1" width="512" height="256"/>'
    shown = f'{large}<material name="oak" texture="oak"/></asset>'
    subject = batch_tampered(("</asset>", shown))(tmp_path)
    found = run(subject, "room", LIMITS).issues
    assert [(issue.code, issue.pointer) for issue in found] == [("BAT001", "textures/oak")]
    (subject.root / BATCH_FILE).unlink()
    lost = run(BatchSubject(subject.form, subject.root), "room", LIMITS)
    assert [issue.code for issue in lost.issues] == ["BAT001"]


def test_sizes_for_engines_are_found_with_a_margin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("TRIAL_S", "IN_USE_S"):
        monkeypatch.setattr(engine_sizes, name, 1.0)
    found = engine_sizes.engine_sizes(batched(tmp_path))
    assert found.fixtures == 1
    # Ten things of six degrees of freedom, a robot of nine, and the cupboard's own four.
    assert 60 < found.awake <= 60 + 9 + 4 + 6
    assert 9 < found.awake_in_use <= 9 + 4 + 6
    assert 100_000 < found.mujoco_bytes < 20_000_000
    told_sizes = (found.nconmax, found.njmax, found.nccdmax, found.nvmax)
    counts = (found.contacts, found.rows, found.convex_pairs, found.awake)
    for told, counted in zip(told_sizes, counts, strict=True):
        assert counted * 1.5 <= told <= counted * 1.5 + 8
