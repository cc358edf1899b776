"""A kitchen's certificate of robots: PandaOmron with mink, and the models of robosuite, on one whole kitchen."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.consumers.robots.page import ASKED, KITCHENS, PLANS, rows
from tests.support.library.libraries import ROOT, command, ran
from tests.support.program.environments import packages_of, with_packages_of

SCENE = "l_small__coastal"
OTHERS = ("GR1", "SpotWithArm", "Tiago")
# A drawer low down, one under the worktop, doors below and above it, a knob, a key.
FEW = (
    "main_drawers__drawer0_*",
    "main_drawers__drawer2_*",
    "main_doors__leftdoorhinge",
    "main_upper_doors__doorhinge",
    "main_range__knob_front_left_*",
    "right_dishwasher__start_button_*",
)

pytestmark = pytest.mark.consumers


def casa(*arguments: object, code: int = 0) -> subprocess.CompletedProcess[str]:
    """The command line, with what the extra `robots` adds in front of our packages."""
    return ran(*command(*arguments), code=code, env=with_packages_of("robots"))


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scenes")
    casa("scenes", "robots", SCENE, "--robot", "PandaOmron", "--out", folder, "--jobs", 1)
    return folder


def certificate(out: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads((out / SCENE / "robots.json").read_text(encoding="utf-8"))
    return data


def test_panda_omron_reaches_nearly_all_and_each_joint_says_how(out: Path) -> None:
    found = certificate(out)
    (result,) = found["results"]
    assert (result["code"], result["status"]) == ("ROB001", "passed")
    counts = found["counts"]["PandaOmron"]
    assert counts["joints"] >= 20
    assert counts["reached"] >= 0.95 * counts["joints"]
    assert counts["followed"] >= 0.6 * counts["joints"]
    facts = json.loads((out / SCENE / "scene.json").read_text(encoding="utf-8"))
    ranges = {j["name"] for f in facts["fixtures"] for j in f["joints"].values()}
    joints = found["robots"][0]["joints"]
    assert {j["joint"] for j in joints} <= ranges
    for joint in joints:
        assert joint["reached"] == (joint["base"] is not None) == (joint["margin"] is not None)
        assert (joint["share"] == 1.0) == (joint["followed"] != "no")


def test_what_is_unchanged_is_kept_and_stands_in_the_report(out: Path) -> None:
    before = (out / SCENE / "robots.json").read_bytes()
    done = casa("scenes", "robots", SCENE, "--robot", "PandaOmron", "--out", out, "--jobs", 1)
    assert f"kept {SCENE}" in done.stdout
    assert (out / SCENE / "robots.json").read_bytes() == before
    casa("scenes", "check", SCENE, "--out", out, "--jobs", 1, "--no-pictures")
    report = json.loads((out / SCENE / "report.json").read_text(encoding="utf-8"))
    assert [r["status"] for r in report["results"] if r["code"] == "ROB001"] == ["passed"]
    assert "PandaOmron" in (out / SCENE / "report.html").read_text(encoding="utf-8")


def test_without_its_models_it_says_what_is_missing(tmp_path: Path) -> None:
    done = casa("scenes", "robots", SCENE, "--out", tmp_path, "--models", tmp_path, code=2)
    assert "--models" in done.stderr
    assert "robosuite 1.5.2" in " ".join(done.stderr.split())


def test_a_panda_opens_a_drawer_in_plain_mujoco(tmp_path: Path) -> None:
    panda = packages_of("robots") / "robosuite" / "models" / "assets" / "robots" / "panda" / "robot.xml"
    picture = tmp_path / "drawer.png"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "MUJOCO_GL": "egl"}
    done = ran(sys.executable, ROOT / "examples" / "open_drawer_panda.py", panda, picture, env=environment)
    assert "is open by 0.2" in done.stdout
    assert picture.stat().st_size > 50_000


def test_a_humanoid_a_quadruped_and_another_mobile_arm_reach_a_few_joints(out: Path, tmp_path: Path) -> None:
    scenes = shutil.copytree(out, tmp_path / "scenes", symlinks=True)
    robots = [part for name in OTHERS for part in ("--robot", name)]
    joints = [part for glob in FEW for part in ("--joint", glob)]
    casa("scenes", "robots", SCENE, *robots, *joints, "--out", scenes, "--jobs", 1, code=1)
    found = certificate(scenes)
    assert set(found["counts"]) == set(OTHERS)
    for robot, counts in found["counts"].items():
        assert counts["joints"] == counts["reached"] == len(FEW), robot
        assert counts["followed"] >= len(FEW) - 1, robot
    (result,) = found["results"]
    assert result["status"] == "not_run"
    assert result["reason"].startswith("PandaOmron is not among the robots that were tried")


@pytest.mark.certify
def test_the_page_of_numbers_says_what_robots_reach(tmp_path: Path) -> None:
    for arguments in (KITCHENS, (*PLANS, "--robot", ASKED)):
        casa("scenes", "robots", *arguments, "--out", tmp_path)
    lines = (ROOT / "docs" / "numbers.md").read_text(encoding="utf-8").splitlines()
    assert [row for row in rows(tmp_path) if row not in lines] == []
