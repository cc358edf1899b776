"""Objects of other people are read from URDF, SDF, MJCF and USD, merged at their closed pose, and scored against."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.articulate.outside.cases import build_case, read_truth
from benchmarks.articulate.outside.metrics import joint_distance, score_case, totals
from benchmarks.articulate.outside.model import Model, Unreadable, subtree
from benchmarks.articulate.outside.read import mjcf, sdf, urdf, usd
from benchmarks.articulate.outside.sources import checkout, objects

# A cabinet whose door is hinged at its left edge (+y, seen from +x) and whose drawer is 0.1 m open at 0.
URDF = """<robot name="cabinet">
<link name="body"><visual><geometry><box size=".4 .6 .8"/></geometry></visual></link>
<link name="door"><visual><origin xyz="0 -.3 0"/><geometry><box size=".02 .6 .4"/></geometry></visual></link>
<link name="knob"><visual><geometry><cylinder radius=".02" length=".04"/></geometry></visual></link>
<link name="box"><visual><geometry><box size=".3 .5 .2"/></geometry></visual></link>
<joint name="hinge" type="revolute"><parent link="body"/><child link="door"/><origin xyz=".21 .3 .2"/>
<axis xyz="0 0 1"/><limit lower="0" upper="1.5"/></joint>
<joint name="fixed" type="fixed"><parent link="door"/><child link="knob"/>
<origin xyz=".03 -.55 0" rpy="0 1.5708 0"/></joint>
<joint name="slide" type="prismatic"><parent link="body"/><child link="box"/><origin xyz=".16 0 -.2"/>
<axis xyz="1 0 0"/><limit lower="-.1" upper=".2"/></joint></robot>"""
SDF = """<sdf version="1.7"><model name="m"><link name="body"><visual name="v"><geometry><box><size>.4 .6 .8</size>
</box></geometry></visual></link><link name="door"><pose>.21 0 .2 0 0 0</pose><visual name="v"><geometry><box>
<size>.02 .6 .4</size></box></geometry></visual><visual name="knob"><pose>.03 -.25 0 0 1.5708 0</pose><geometry>
<cylinder><radius>.02</radius><length>.04</length></cylinder></geometry></visual></link><link name="box">
<pose>.06 0 -.2 0 0 0</pose><visual name="v"><geometry><box><size>.3 .5 .2</size></box></geometry></visual></link>
<joint name="hinge" type="revolute"><pose>0 .3 0 0 0 0</pose><parent>body</parent><child>door</child><axis>
<xyz>0 0 1</xyz><limit><lower>0</lower><upper>1.5</upper></limit></axis></joint><joint name="slide" type="prismatic">
<parent>body</parent><child>box</child><axis><xyz>1 0 0</xyz><limit><lower>0</lower><upper>.3</upper></limit></axis>
</joint></model></sdf>"""
MJCF = """<mujoco><compiler angle="radian"/><worldbody><geom type="plane" size="1 1 1"/><body name="body">
<geom type="box" size=".2 .3 .4"/><body name="door" pos=".21 .3 .2"><joint name="hinge" axis="0 0 1" range="0 1.5"/>
<geom type="box" size=".01 .3 .2" pos="0 -.3 0"/>
<geom type="cylinder" size=".02 .02" pos=".03 -.55 0" euler="0 1.5708 0"/>
<geom type="box" size=".2 .3 .2" pos="0 -.3 0" group="3"/></body><body name="box" pos=".06 0 -.2">
<joint name="slide" type="slide" axis="1 0 0" range="0 .3"/><geom type="box" size=".15 .25 .1"/></body></body>
</worldbody></mujoco>"""
USD = """#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Z"
)
def Xform "body" (prepend apiSchemas = ["PhysicsRigidBodyAPI"])
{
    def Cube "c" { double size = 1
        double3 xformOp:scale = (40, 60, 80)
        uniform token[] xformOpOrder = ["xformOp:scale"]
    }
}
def Xform "door" (prepend apiSchemas = ["PhysicsRigidBodyAPI"])
{
    double3 xformOp:translate = (21, 0, 20)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Cube "c" { double size = 1
        double3 xformOp:scale = (2, 60, 40)
        uniform token[] xformOpOrder = ["xformOp:scale"]
    }
    def Cylinder "k" { double radius = 2
        double height = 4
        uniform token axis = "X"
        double3 xformOp:translate = (3, -25, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
def Xform "box" (prepend apiSchemas = ["PhysicsRigidBodyAPI"])
{
    double3 xformOp:translate = (6, 0, -20)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Cube "c" { double size = 1
        double3 xformOp:scale = (30, 50, 20)
        uniform token[] xformOpOrder = ["xformOp:scale"]
    }
}
def PhysicsRevoluteJoint "hinge"
{
    rel physics:body0 = </door>
    rel physics:body1 = </body>
    point3f physics:localPos1 = (21, 30, 20)
    uniform token physics:axis = "Z"
    float physics:lowerLimit = -86
    float physics:upperLimit = 0
}
def PhysicsPrismaticJoint "slide"
{
    rel physics:body0 = </body>
    rel physics:body1 = </box>
    uniform token physics:axis = "X"
    float physics:lowerLimit = 0
    float physics:upperLimit = 30
}
"""
POSE = {"slide": -0.1}


@pytest.mark.parametrize(
    ("name", "text", "read"),
    [("a.urdf", URDF, urdf.read), ("a.sdf", SDF, sdf.read), ("a.xml", MJCF, mjcf.read), ("a.usda", USD, usd.read)],
)
def test_each_format_gives_the_same_case(name: str, text: str, read: Callable[..., Model], tmp_path: Path) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    model = read(tmp_path / name, tmp_path, POSE if name == "a.urdf" else {})
    truth = build_case(tmp_path / "case", model, {"category": "cabinet"}, {})
    door, drawer = sorted(truth["parts"], key=lambda p: str(p["type"]))
    assert (door["type"], drawer["type"]) == ("door", "drawer")
    assert truth["front"] == [1.0, 0.0, 0.0]
    assert np.ptp([door["bbox"]], axis=1)[0] == pytest.approx([0.06, 0.6, 0.4], abs=1e-3)
    assert np.mean(drawer["bbox"], axis=0) == pytest.approx([0.06, 0.0, -0.2], abs=1e-6)
    assert door["joint"]["type"] == "revolute"
    assert np.multiply(door["joint"]["axis"], np.sign(sum(door["joint"]["range"]))) == pytest.approx([0, 0, 1])
    assert door["joint"]["origin"][:2] == pytest.approx([0.21, 0.3], abs=1e-6)
    assert drawer["joint"]["range"] == pytest.approx([0.0, 0.3])
    # The truth, told as a prediction on each variant, is right in everything.
    for variant in ("input", "welded", "fused"):
        runs = {p["id"]: truth_runs(tmp_path / "case", variant, p["id"]) for p in truth["parts"]}
        told = {"parts": [{"type": p["type"], "joint": p["joint"], "face_runs": runs[p["id"]]} for p in truth["parts"]]}
        score = score_case(tmp_path / "case", variant, told)
        assert score.is_perfect
        assert totals([score])["E"] == pytest.approx(0.0)


def truth_runs(case: Path, variant: str, number: int) -> Any:
    truth = read_truth(case)
    if variant == "fused":
        return truth["fused"]["parts"][str(number)]
    return next(p["faces"] for p in truth["parts"] if p["id"] == number)


def test_what_is_wrong_with_a_prediction_is_counted(tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text(URDF, encoding="utf-8")
    truth = build_case(tmp_path / "case", urdf.read(tmp_path / "a.urdf", tmp_path, POSE), {"category": "cabinet"}, {})
    door, drawer = (
        {
            "name": p["name"],
            "type": p["type"],
            "joint": dict(p["joint"]),
            "face_runs": truth_runs(tmp_path / "case", "input", p["id"]),
        }
        for p in sorted(truth["parts"], key=lambda p: str(p["type"]))
    )
    right_hinge = {**door, "joint": {**door["joint"], "origin": [0.21, -0.3, 0.2], "axis": [0, 0, -1]}}
    slides = {**door, "joint": {**drawer["joint"]}}
    twice = {**door, "name": "again"}
    figures = {}
    for name, parts in {
        "all": [door, drawer],
        "edge": [right_hinge, drawer],
        "slides": [slides, drawer],
        "missed": [door],
        "extra": [door, drawer, twice],
    }.items():
        score = score_case(tmp_path / "case", "input", {"parts": parts})
        row = totals([score])
        figures[name] = (row["F1"], row["MAO"], score.faults)
        assert (row["E"] > 0.01) == (name != "all")
    assert figures == {
        "all": (1.0, 1.0, 0),
        "edge": (1.0, 0.5, 1),
        "slides": (1.0, 0.5, 1),
        "missed": (pytest.approx(2 / 3), pytest.approx(2 / 3), 1),
        "extra": (pytest.approx(0.8), pytest.approx(0.8), 1),
    }


def test_a_joint_told_backwards_is_no_farther_from_the_truth() -> None:
    joint = {"type": "revolute", "axis": [0, 0, 1], "origin": [1, 0, 0], "range": [0.0, 1.5]}
    turned = {**joint, "axis": [0, 0, -1], "range": [-1.5, 0.0]}
    assert joint_distance(turned, joint, np.zeros(3), 2.0) == pytest.approx(0.0)
    assert joint_distance({**joint, "range": [-1.5, 0.0]}, joint, np.zeros(3), 2.0) > 0.1


def test_a_scene_is_cut_down_to_one_thing_and_a_missing_mesh_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text(URDF, encoding="utf-8")
    model = urdf.read(tmp_path / "a.urdf", tmp_path, {})
    assert set(subtree(model, "door").links) == {"door", "knob"}
    with pytest.raises(Unreadable, match="it has no link 'lid'"):
        subtree(model, "lid")
    (tmp_path / "b.urdf").write_text(URDF.replace('<box size=".3 .5 .2"/>', '<mesh filename="package://a/box.stl"/>'))
    with pytest.raises(Unreadable, match=r"'box\.stl' is missing"):
        urdf.read(tmp_path / "b.urdf", tmp_path, {})


def test_no_object_is_of_a_reserved_repository_and_both_halves_are_about_as_large() -> None:
    every = objects()
    sealed = [o for o in every if o.is_sealed]
    assert 0.4 < len(sealed) / len(every) < 0.6
    assert not {o.origin for o in sealed} & {o.origin for o in every if not o.is_sealed}
    assert len({o.name for o in every}) == len(every)


def test_a_repository_that_is_taken_at_two_commits_is_kept_twice(tmp_path: Path) -> None:
    git = tmp_path / "mirror" / "owner+name"
    git.mkdir(parents=True)

    def run(*words: str) -> str:
        command = ["git", "-C", str(git), "-c", "user.name=a", "-c", "user.email=a@b", *words]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()

    run("init", "-q")
    commits = []
    for text in ("first", "second"):
        (git / "a.urdf").write_text(text, encoding="utf-8")
        run("add", "a.urdf")
        run("commit", "-q", "-m", text)
        commits.append(run("rev-parse", "HEAD"))
    places = [checkout("owner/name", commit, tmp_path / "out", tmp_path / "mirror") for commit in commits]
    assert [(place / "a.urdf").read_text(encoding="utf-8") for place in places] == ["first", "second"]
