"""A run of draws goes on where it was stopped, whenever that was, and nobody sees of its bytes that it was.

Kitchens are stand-ins of a few bytes here: all that builds, writes, draws and checks them is replaced in the program
and its workers. What is tested is the run: processes, folders, records.
"""

from __future__ import annotations

import json
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from casa_assets.layouts.run.sample import FOLDER, draw_recipes
from tests.support.library.libraries import hooked

pytestmark = pytest.mark.content("code", "layouts.run", keep=0)

COUNT = 8
# `sitecustomize` of the program and its workers. A stand-in takes a while, notes that it was begun, and about half
# are refused; one that is marked as deadly ends its process, as the system does where the memory runs out.
STAND_INS = """
import hashlib, json, os, pathlib, signal, sys, time, types

if any(word in ("casa_assets.cli.main",) or "runs.server" in word for word in sys.orig_argv):
    from casa_assets.model.issue import Issue, Report, Severity
    from casa_assets.layouts.run import check, scene_folders

    FILES = ("scene.xml", "scene.usda", "scene_nested.usda", "isaac_lab.py", "scene_light.xml")

    def number(scene_id):
        return int(hashlib.sha256(scene_id.encode()).hexdigest(), 16)

    def verdict(scene_id):
        bad = number(scene_id) % 2 == 0
        issue = Issue(code="SCN005", severity=Severity.ERROR, message="two doors meet")
        return Report(subject=scene_id, issues=(issue,) if bad else ())

    def build(recipe, cache):
        with open(os.environ["CASA_TEST_LOG"], "a") as log:
            log.write(recipe.scene_id + "\\n")
        if os.environ.get("CASA_TEST_DEADLY") == recipe.scene_id:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(float(os.environ["CASA_TEST_PAUSE_S"]))
        return None, types.SimpleNamespace(id=recipe.scene_id, placements=(), assets=())

    def write(folder, root, facts, scene, light_form, layer_text):
        for name in FILES:
            (folder / name).write_text(name + scene.id)
        (folder / "scene.json").write_text(json.dumps(facts))
        shared = root / "assets" / "meshes"
        shared.mkdir(parents=True, exist_ok=True)
        for i in range(3):  # which scenes share
            (shared / f"{(number(scene.id) + i) % 7}.obj").write_text("mesh")

    def judge(recipe, scene, design, folder, in_3d=True, passed=None):
        (folder / "report.json").write_text("{}")
        return verdict(recipe.scene_id)

    scene_folders.build_scene = check.build_scene = build
    scene_folders.write_scene = write
    scene_folders.design_of = lambda kitchen, scene: None
    scene_folders.describe = lambda recipe, kitchen, scene, design: {"id": scene.id}
    scene_folders.draw_cameras = lambda folder, cameras=(), *_: (folder / "overview.png").write_text("picture")
    scene_folders.is_drawn = lambda folder, key: (folder / "overview.png").is_file()
    scene_folders.scene_key = check.scene_key = lambda recipe: hashlib.sha256(recipe.scene_id.encode()).hexdigest()
    scene_folders.picture_key = lambda key: key
    scene_folders.warm = check.warm = lambda: None
    check.verdict_key = lambda recipe: hashlib.sha256(b"v" + recipe.scene_id.encode()).hexdigest()
    check.check_and_report = judge
    check.kept_report = lambda folder, key: verdict(folder.name) if (folder / "report.json").is_file() else None
    check._shown_in_place = lambda done, *_: done
    from casa_assets.layouts.run import sample
    possible = sample.Choices(1, 1, 1, dict.fromkeys(("wall", "floor", "counter", "cabinet"), 1), {})
    sample.diversity_of_recipes = lambda recipes: sample.diversity_of([], possible)
    sample.diversity_of_reference = lambda: sample.diversity_of([], possible)
    from casa_assets.show.reports import kitchens
    kitchens.write = lambda out, heading="": (out / "index.html", out / "contact_sheet.png")
    kitchens.read_rows = lambda out: []
"""


@dataclass(frozen=True)
class Runs:
    """Starts the program in a folder of its own."""

    folder: Path

    def start(self, out: str, jobs: int = 2, pause_s: float = 0.1, deadly: str = "") -> subprocess.Popen[str]:
        said = {"CASA_TEST_LOG": str(self.log(out)), "CASA_TEST_PAUSE_S": str(pause_s), "CASA_TEST_DEADLY": deadly}
        words = ("scenes", "sample", COUNT, "--seed", 3, "--jobs", jobs, "--out", self.folder / out)
        return hooked(STAND_INS, self.folder, *words, **said)

    def finish(self, out: str, code: int = 0, jobs: int = 2, pause_s: float = 0.0, deadly: str = "") -> str:
        started = self.start(out, jobs, pause_s, deadly)
        told, errors = started.communicate(timeout=300)
        assert started.returncode == code, errors
        return told + errors

    def log(self, out: str) -> Path:
        """One line for each stand-in that was begun."""
        return self.folder / f"{out}.log"

    def begun(self, out: str) -> list[str]:
        return self.log(out).read_text(encoding="utf-8").splitlines() if self.log(out).exists() else []

    def bytes_of(self, out: str) -> dict[str, bytes]:
        """Every file of a folder of scenes, but for the program's own."""
        root = self.folder / out
        files = (path for path in root.rglob("*") if path.is_file() and ".casa" not in path.parts)
        return {str(path.relative_to(root)): path.read_bytes() for path in files}


@pytest.fixture
def runs(tmp_path: Path) -> Runs:
    return Runs(tmp_path)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    """A run that nobody stopped, by two jobs, in `whole`."""
    made = Runs(tmp_path_factory.mktemp("whole"))
    made.finish("whole")
    return made


@pytest.mark.slow
class TestStopped:
    @pytest.mark.representatives(1)
    @pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
    def test_it_goes_on_and_makes_the_same_bytes(self, runs: Runs, whole: Runs, number: signal.Signals) -> None:
        for after in (2, 5):
            stopped = runs.start("stopped")
            while len(runs.begun("stopped")) < after and stopped.poll() is None:
                time.sleep(0.01)
            stopped.send_signal(number)
            stopped.communicate(timeout=60)
        told = runs.finish("stopped")
        assert runs.bytes_of("stopped") == whole.bytes_of("whole")
        begun = runs.begun("stopped")
        # At most those at work when it was stopped were begun again: two jobs, two times.
        assert len(set(begun)) == COUNT
        assert len(begun) <= COUNT + 4
        assert f"of {COUNT} draws passed" in told

    def test_any_number_of_jobs_makes_the_same_and_a_damaged_record_again(self, runs: Runs, whole: Runs) -> None:
        runs.finish("one", jobs=1)
        record = next((runs.folder / "one" / ".casa" / "cache" / FOLDER).iterdir())
        record.write_text(record.read_text(encoding="utf-8")[:-9], encoding="utf-8")
        (runs.folder / "one" / record.stem / "report.json").unlink(missing_ok=True)
        runs.finish("one", jobs=1)
        assert runs.begun("one").count(record.stem) == 2
        assert runs.bytes_of("one") == whole.bytes_of("whole")
        rejected = json.loads((runs.folder / "one" / "rejected.json").read_text(encoding="utf-8"))
        assert rejected["drawn"] == rejected["tried"] == COUNT
        assert 0 < rejected["passed"] < COUNT
        assert rejected["pass_rate"] == round(rejected["passed"] / COUNT, 4)
        assert {row["reason"] for row in rejected["reasons"]} == {"SCN005"}
        assert {issue["code"] for row in rejected["rejected"] for issue in row["issues"]} == {"SCN005"}
        assert len(rejected["rejected"]) == COUNT - rejected["passed"]

    def test_a_draw_that_kills_its_process_leaves_the_others_alone(self, runs: Runs) -> None:
        deadly = draw_recipes(COUNT, 3)[4].scene_id
        told = runs.finish("out", code=3, deadly=deadly)
        assert f"failed {deadly}" in told
        rejected = json.loads((runs.folder / "out" / "rejected.json").read_text(encoding="utf-8"))
        assert rejected["tried"] == COUNT
        assert [row["reason"] for row in rejected["reasons"]].count("fault of the program") == 1
        runs.finish("out")  # where nothing kills it, it is made, and nothing else is
        assert len(runs.begun("out")) == COUNT + 2, "it was tried twice before"
