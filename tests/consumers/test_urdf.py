"""URDF of assets and of a whole kitchen in yourdfpy and SAPIEN: the same masses, joints, poses and bounds as ours."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from casa_assets.checks.readers import urdf_facts
from casa_assets.checks.readers.facts import asset_facts
from casa_assets.core.numeric import Floats
from casa_assets.core.system import cache_dir
from casa_assets.export import SCENES
from casa_assets.formats import urdf
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import build_scene
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.parts import JointValue, Keyframe
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.pose import Pose
from tests.support.asset.assets import EVERY, microwave, write_to
from tests.support.kitchen.scenes import corner
from tests.support.program.documents import blocks
from tests.support.program.environments import found_by, printed

# SAPIEN holds float32, and adds up poses along chains of links several metres from the origin.
LENGTH_M, RATIO = 5e-6, 1e-5

pytestmark = pytest.mark.consumers


class Expected:
    """What a URDF should hold by the record, in the frames that URDF has, named as in the file."""

    def __init__(self) -> None:
        self.bodies: dict[str, Any] = {}
        self.joints: dict[str, Any] = {}
        self.poses: dict[str, dict[str, Floats]] = {"zero": {}, "middle": {}}
        self.pictures = 0
        self.seen: dict[str, list[Floats]] = {"zero": [], "middle": []}

    def add(self, asset: Asset, placement: str = "", world_from_root: Pose | None = None) -> Expected:
        """Add an asset, or a placement of it; its root stands at the origin unless it is placed."""
        middle = tuple(JointValue(joint=j.name, value=sum(j.range) / 2) for j in asset.joints)
        posed = asset.replace(keyframes=(Keyframe(name="middle", joints=middle),))
        facts = urdf_facts.on_joint_axes(asset_facts(posed))
        for name, body in facts["bodies"].items():
            self.bodies[_link_name(name, placement)] = body
            if body["joint"] is not None:
                self.joints[_prefixed(body["joint"]["name"], placement)] = body["joint"]
        self.pictures += sum(look["picture"] != "" for look in facts["looks"].values())
        base = world_from_root or Pose()
        moved_by = {link.name: asset.joint_of(link.name) for link in asset.links}
        for pose, frames in facts["poses"].items():
            word = "zero" if pose == "closed" else "middle"
            for name, frame in frames.items():
                link = base @ Pose(**frame)
                self.poses[word][_link_name(name, placement)] = link.matrix
                joint = moved_by[name]
                anchor = np.array(joint.anchor if joint else (0.0, 0.0, 0.0))
                for visual in asset.link(name).visuals:
                    used = visual.mesh.vertices[np.unique(visual.mesh.faces)]
                    self.seen[word].append(link.apply(used - anchor))
        return self

    def bounds(self, word: str) -> Floats:
        """(2, 3) corners of all that is seen, metres."""
        points = np.concatenate(self.seen[word])
        return np.array([points.min(axis=0), points.max(axis=0)])


def _prefixed(name: str, placement: str) -> str:
    return f"{placement}__{name}" if placement else name


def _link_name(name: str, placement: str) -> str:
    return placement if placement and name == "object" else _prefixed(name, placement)


def of_scene(scene: Scene) -> Expected:
    """All that stands fixed in a scene."""
    expected = Expected()
    for place in scene.placements:
        asset = scene.asset_of[place.name]
        if asset.base is Base.FIXED:
            expected.add(asset, place.name, place.pose @ asset.root.pose)
    return expected


def told(*paths: Path) -> dict[str, Any]:
    """What both programs say of URDF files."""
    return dict(found_by("urdf", "urdf_readers.py", *paths, timeout_s=500))


ASSETS = {build.__name__: build for build in EVERY} | {"free_microwave": partial(microwave, Base.FREE)}


@pytest.fixture(scope="module")
def assets(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What both programs say of each small asset, by the name of the function that builds it."""
    folder = tmp_path_factory.mktemp("urdf")
    made = {name: build() for name, build in ASSETS.items()}
    paths = {n: write_to(urdf.write(asset), folder / n) / f"{asset.id}.urdf" for n, asset in made.items()}
    found = told(*paths.values())
    return {name: found[str(path)] for name, path in paths.items()}


@pytest.mark.parametrize("program", ["yourdfpy", "sapien"])
@pytest.mark.parametrize("name", ASSETS)
def test_an_asset_means_the_same(name: str, program: str, assets: dict[str, Any]) -> None:
    compare(program, assets[name][program], Expected().add(ASSETS[name]()))


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Scene, Path]]:
    """A small scene and a whole kitchen with the paths of their URDFs, as an export lays them down."""
    _, whole = build_scene(SceneRecipe("l_small", "coastal"), cache_dir())
    root = tmp_path_factory.mktemp("out") / "out" / "urdf_kitchens" / SCENES
    found = {}
    for scene in (corner(), whole):
        found[scene.id] = scene, write_to(urdf.write_scene(scene), root / scene.id) / urdf.FILE
    return found


@pytest.fixture(scope="module", params=["corner", "l_small__coastal"])
def scene(request: pytest.FixtureRequest, scenes: dict[str, tuple[Scene, Path]]) -> tuple[Expected, Any]:
    made, path = scenes[request.param]
    return of_scene(made), told(path)[str(path)]


@pytest.mark.parametrize("program", ["yourdfpy", "sapien"])
def test_a_scene_means_the_same(program: str, scene: tuple[Expected, Any]) -> None:
    expected, found = scene
    assert len(expected.joints) >= 5
    compare(program, found[program], expected)


# Before what the page says of SAPIEN: its physics without its renderer, which needs a graphics driver.
WITHOUT_PICTURES = """
import functools, sapien
from sapien.wrapper.urdf_loader import URDFLoader

def build_link(self, link, builder, build=URDFLoader._build_link):
    link.visuals = []
    build(self, link, builder)

URDFLoader._build_link = build_link
sapien.Scene = functools.partial(sapien.Scene, [sapien.physx.PhysxCpuSystem()])
"""


# After it: a second passes; prints how many parts there are and how far each joint and each loose thing went.
A_SECOND = """
import numpy as np
loose = [one for one in scene.entities if one not in [link.entity for link in kitchen.links]]
before, stood = kitchen.get_qpos(), [one.pose.p for one in loose]
scene.set_timestep(0.002)
for _ in range(500):
    scene.step()
went = np.abs(kitchen.get_qpos() - before)
ways = {joint.name: float(way) for joint, way in zip(kitchen.active_joints, went)}
ways |= {f"{i} {one.name}": float(np.linalg.norm(one.pose.p - at)) for i, (one, at) in enumerate(zip(loose, stood))}
print(json.dumps({"parts": len(scene.entities), "ways": ways}))
"""
CREEP = 0.001  # rad or m in a second; what is loose sinks onto what it stands on


def test_what_the_page_says_runs_and_the_kitchen_stands(scenes: dict[str, tuple[Scene, Path]], tmp_path: Path) -> None:
    whole, path = scenes["l_small__coastal"]
    of_page = [block for block in blocks("docs/howto/use/urdf.md") if block.reason == "needs yourdfpy or SAPIEN"]
    assert len(of_page) == 2
    for block in of_page:
        code = WITHOUT_PICTURES + block.code + A_SECOND if "import sapien" in block.code else block.code
        (tmp_path / "page.py").write_text(code, encoding="utf-8")
        text = printed("urdf", str(tmp_path / "page.py"), folder=path.parents[4])
    found = json.loads(text.splitlines()[-1])
    loose = [place for place in whole.placements if whole.asset_of[place.name].base is Base.FREE]
    links = sum(len(whole.asset_of[place.name].links) for place in loose)
    assert loose
    assert found["parts"] == 1 + len(of_scene(whole).bodies) + links
    assert {name: way for name, way in found["ways"].items() if not way < CREEP} == {}


def compare(program: str, found: Any, expected: Expected) -> None:
    """What a program found is what the record holds."""
    links = dict(found["links"])
    links.pop("world", None)
    assert sorted(links) == sorted(expected.bodies)
    for name, body in expected.bodies.items():
        compare_body(name, links[name], body)
    assert sorted(found["joints"]) == sorted(expected.joints)
    for name, joint in expected.joints.items():
        said = found["joints"][name]
        kind = {"hinge": "revolute", "slide": "prismatic"}[joint["kind"].value]
        assert said["type"].removesuffix("_unwrapped") == kind
        assert said["axis"] == pytest.approx(joint["axis"], abs=RATIO), name
        assert said["range"] == pytest.approx(joint["range"], abs=LENGTH_M), name
        assert said["damping"] == pytest.approx(joint["resistance"][2], rel=RATIO), name
        if program == "yourdfpy":  # SAPIEN passes over the friction of joints
            assert said["friction"] == pytest.approx(joint["resistance"][3], rel=RATIO), name
    for word, poses in expected.poses.items():
        for name, matrix in poses.items():
            assert np.abs(np.array(found["poses"][word]["links"][name]) - matrix).max() < LENGTH_M, (word, name)
    if program == "yourdfpy":
        assert found["valid"]
        assert found["said"] == []
        assert found["pictures"] == expected.pictures
        for word in expected.poses:
            assert np.abs(np.array(found["poses"][word]["seen"]) - expected.bounds(word)).max() < LENGTH_M, word


def compare_body(name: str, said: Any, body: Any) -> None:
    """Mass, centre of mass, inertia, and, where the program tells it of each link, the bounds of its colliders."""
    assert said["mass"] == pytest.approx(body["mass"], rel=RATIO), name
    assert said["center"] == pytest.approx(body["center_of_mass"], abs=LENGTH_M), name
    xx, yy, zz, xy, xz, yz = body["inertia"]
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    assert np.abs(np.array(said["inertia"]) - tensor).max() < RATIO * np.trace(tensor), name
    if "touched" in said:
        assert np.abs(np.array(said["touched"]) - np.array([body["lower"], body["upper"]])).max() < LENGTH_M, name
